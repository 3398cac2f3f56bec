"""The wind across the heading in straight flight, which needs no airspeed.

Without sideslip the velocity through the air points along the heading, so the ground velocity across the heading is
the wind across it. A heading is a few degrees off, which at 60 m/s are meters a second. But most of this error is
the same over a log, follows the speed (the trim in sideslip) or drifts slowly (a gyro), so the rows show whether
the wind changed. Gusts hardly count: they turn the airplane's path over the ground slowly.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pitotbench.calibrate.rows.blocks import Blocks
from pitotbench.calibrate.rows.observations import Observations
from pitotbench.estimate.point_noise import PointNoise, UnknownColumns, ornstein_uhlenbeck
from pitotbench.estimate.robust_scale import deviation_of_sizes
from pitotbench.units import Array, MetersPerSecond, Seconds

# Degrees (1σ) of the heading's error: constant, with 1/q over the log, and in ten minutes.
DIRECTION_DEVIATIONS = np.array([5.0, 2.0, 0.5])
_TEN_MINUTES = 600.0  # s
_STRAIGHT = np.radians(1.0)  # rad/s: in a faster turn a heading lags, and a sideslip comes with the bank
_FEWEST = 10  # straight blocks
_WANDER, _WANDER_TIME = 0.2, 20.0  # m/s, least level of the wander of heading and path; its correlation time [s]
_LAG = 10.0  # s between rows whose differences show the level
_WHITE = 0.05  # m/s, least white noise of a block


@dataclass(frozen=True, slots=True)
class HeadingRows:
    """Means over the straight blocks, (n,), of the ground velocity to the right of the heading.

    `straight` (n,) are the numbers of these blocks and `right` (n, 2) their unit vectors to the right, toward north
    and east. `directions` (n, 3) [m/s per degree] are the effects of the errors of the heading.
    """

    straight: NDArray[np.intp]
    response: MetersPerSecond
    right: Array
    directions: Array
    noise: PointNoise


def heading_rows(obs: Observations, blocks: Blocks, airspeed: MetersPerSecond) -> HeadingRows | None:
    """Compute the rows; None for a log without heading or straight flight. `airspeed` (blocks,) is the true one."""
    if obs.heading is None:
        return None
    right = np.stack([-np.sin(obs.heading), np.cos(obs.heading)], axis=1)
    ground = np.stack([obs.velocity_north, obs.velocity_east], axis=1)
    east, north = (blocks.mean(right) * [-1.0, 1.0]).T
    turn = np.abs(np.gradient(np.unwrap(np.arctan2(east, north)), blocks.length)) > _STRAIGHT
    beside = turn | np.append(turn[1:], False) | np.append(False, turn[:-1])
    straight = np.flatnonzero(~beside)
    if len(straight) < _FEWEST:
        return None
    time = blocks.intervals.edges[blocks.intervals.left[straight]]
    pressure, middle = blocks.mean(obs.impact_pressure)[straight], 0.5 * (time[0] + time[-1])
    response, right = blocks.mean(np.sum(ground * right, axis=1))[straight], blocks.mean(right)[straight]
    shapes = [np.ones(len(time)), float(np.median(pressure)) / pressure - 1.0, (time - middle) / _TEN_MINUTES]
    per_degree = np.radians(1.0) * airspeed[straight, None]
    return HeadingRows(straight, response, right, per_degree * np.stack(shapes, axis=1), _noise(time, response))


def _noise(time: Seconds, response: MetersPerSecond) -> PointNoise:
    """White noise and a slow wander, by the usual difference of neighbors and of rows some time apart.

    Medians of differences do not see a single change of the wind.
    """
    step = float(np.median(np.diff(time)))
    white = max(deviation_of_sizes(np.abs(np.diff(response, 2)) / np.sqrt(6.0)), _WHITE)
    lag = max(round(_LAG / step), 1)
    together = time[lag:] - time[:-lag] < 1.5 * lag * step
    apart = deviation_of_sizes(np.abs(response[lag:] - response[:-lag])[together]) if together.any() else 0.0
    wander = max(apart / float(np.sqrt(2.0 * (1.0 - np.exp(-lag * step / _WANDER_TIME)))), _WANDER)
    slow = ornstein_uhlenbeck(time, wander, _WANDER_TIME, (1.0,))
    return PointNoise(
        np.full((1, len(time)), white**2), [slow], UnknownColumns(np.zeros((len(time), 0)), np.zeros(0))
    )
