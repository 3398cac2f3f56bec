"""Form error: the directions in which a real effect differs from its entry in the table.

No entry has exactly the form of the real effect, and at 100σ a difference of 5 % stands at 5σ. It does not lie just
anywhere: it is a share of the effect's own signature in one channel, its signature a little earlier or later, one
that grows with airspeed, bank, power, altitude or time, or one that is not linear in its size. These directions are
free parameters of the effect, with a prior in proportion to its size (model discrepancy: Kennedy and O'Hagan 2001).
"""

from collections.abc import Sequence

import numpy as np

from pitotbench.reconcile.residuals.layout import Layout
from pitotbench.reconcile.residuals.whitening import NoiseModel
from pitotbench.units import Array

LEAST_SHARE = 0.02  # of the whitened sum of squares that a channel must hold to have a direction of its own
SHIFT = 1.0  # s; the shift in time that counts like a change by the whole size
TINY = 1e-300  # so that an empty column can be scaled


def form_directions(layout: Layout, noise: NoiseModel, columns: Sequence[Array]) -> list[Array]:
    """Return the directions of form error of each of some signatures (n, c), whitened, (n, c, k).

    Each direction is in units of one size of the effect.
    """
    whiten = noise.whitener(layout.grid, layout.residuals.slack)
    return [whiten(_directions(layout, noise, column)) for column in columns]


def _directions(layout: Layout, noise: NoiseModel, column: Array) -> Array:
    grid, slack = layout.grid, layout.residuals.slack
    power = np.sum(noise.innovations(column, grid, slack) ** 2, axis=0)
    parts = []
    for channel in np.flatnonzero(power > LEAST_SHARE * max(float(power.sum()), TINY)):
        alone = np.zeros_like(column)
        alone[:, channel] = column[:, channel]
        parts.append(alone)
    parts.append(SHIFT * np.gradient(column, grid.step, axis=0))
    parts += [column * shape[:, None] for shape in _variables(layout).T]
    spread = np.sqrt(np.mean(column**2, axis=0)) + TINY
    parts.append(column * (np.abs(column) / spread - 1.0))
    return np.stack(parts, axis=2)


def _variables(layout: Layout) -> Array:
    """The variables of the cells, (n, v), each of mean 0 and deviation 1."""
    count = len({cell.where for cell in layout.cells})
    first = layout.cells[:count]
    chosen = [i for i, cell in enumerate(first) if cell.variable and not cell.variable.startswith("heading")]
    return layout.shapes[:, chosen]
