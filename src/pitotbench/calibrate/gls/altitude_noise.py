"""The noise of the altitude rows: the slow and the white error of the receiver's height, and their priors."""

from dataclasses import dataclass

import numpy as np

from pitotbench.calibrate.gls.altitude_rows import AltitudeRows
from pitotbench.estimate.point_noise import PointNoise, ornstein_uhlenbeck, random_walk
from pitotbench.units import Array

SLOW_SCALE = 5.0  # m, half-normal prior on the slow height error: 1 to 3 m for a receiver alone
SLOW_TIME, SLOW_TIME_FACTOR = 90.0, 3.0  # s, its correlation time: log-normal prior, 1σ as a factor
WALK_SCALE = 0.2  # m/√s, half-normal prior on the integral of the vertical velocity's error: 0.05 at 1 Hz
WHITE_SCALE = 3.0  # m, half-normal prior on the white height error where there is no vertical velocity
NOISE_COUNT = 3


@dataclass(frozen=True, slots=True)
class AltitudeNoise:
    """The map from φ, (3,), to the covariance of the rows.

    φ = ln(slow height error [m], its correlation time [s], third). The third is the random walk of the integrated
    velocity [m/√s] or, without vertical velocity, the white height error [m].
    """

    rows: AltitudeRows

    def __call__(self, phi: Array, /) -> PointNoise:
        """Return the covariance for φ (3,)."""
        return self.stack(phi)

    def stack(self, phis: Array) -> PointNoise:
        """Return the covariances for many φ, (b, 3)."""
        rows, (deviation, memory, third) = self.rows, np.moveaxis(np.exp(phis), -1, 0)
        if rows.tie is None:
            white = (rows.sensor + third[..., None] ** 2 * rows.fix)[..., None, :]
            return PointNoise(white, [ornstein_uhlenbeck(rows.time, deviation, memory, (1.0,))], rows.unknown)
        walk = random_walk(rows.time, third, rows.first, (1.0, -1.0))
        slow = ornstein_uhlenbeck(rows.time, deviation, memory, (0.0, 1.0))
        white = np.broadcast_to(np.stack([rows.sensor, rows.fix]), (*phis.shape[:-1], 2, len(rows)))
        return PointNoise(white, [walk, slow], rows.unknown)


def altitude_log_prior(rows: AltitudeRows, phi: Array) -> float:
    """The prior of φ (3,): half-normal levels and a log-normal correlation time.

    The φ terms convert the density of a level to that of its logarithm.
    """
    third = WHITE_SCALE if rows.tie is None else WALK_SCALE
    memory = (phi[1] - np.log(SLOW_TIME)) / np.log(SLOW_TIME_FACTOR)
    levels = (np.exp(phi[0]) / SLOW_SCALE) ** 2 + (np.exp(phi[2]) / third) ** 2
    return float(phi[0] + phi[2] - 0.5 * (levels + memory**2))


def altitude_guess(rows: AltitudeRows) -> Array:
    """A start for φ, (3,)."""
    third = 0.3 if rows.tie is None else 0.03
    return np.log([np.clip(rows.spread, 0.1, SLOW_SCALE), SLOW_TIME, third])
