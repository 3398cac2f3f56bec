"""A wind that changes once, as at a front: from one constant wind to another within some twenty seconds."""

from dataclasses import dataclass

import numpy as np

from pitotbench.calibrate.rows.blocks import Blocks
from pitotbench.units import Array, Seconds

JUMP_SCALE = 3.0  # m/s, standard deviation of the prior on each component of the change
_WIDTH = 20.0  # s: a front of a kilometer, crossed at 50 m/s


@dataclass(frozen=True, slots=True)
class WindJump:
    """The middle of the change [s after the first row]."""

    middle: float


def middles(blocks: Blocks) -> Seconds:
    """Middle of each block [s after the first row], (n,)."""
    edges, left = blocks.intervals.edges, blocks.intervals.left
    return np.asarray(0.5 * (edges[left] + edges[left + 1]))


def jump_shape(jump: WindJump, blocks: Blocks) -> Array:
    """Share of the change at each block, (n,) [-], less its mean over all rows: the mean wind is not moved."""
    shape = np.clip((middles(blocks) - jump.middle) / _WIDTH + 0.5, 0.0, 1.0)
    return np.asarray(shape - blocks.count @ shape / blocks.count.sum())


def jump_columns(jump: WindJump, blocks: Blocks, seen: Array) -> Array:
    """What a change of 1 m/s toward north and east does to each residual, (outputs x blocks, 2); `seen`: the
    direction cosines of the residuals, (outputs, blocks, 2)."""
    return np.asarray((seen * jump_shape(jump, blocks)[None, :, None]).reshape(-1, 2))
