"""The heights of a flight for the candidate: the product's altitude rows, with their climb rate."""

from dataclasses import dataclass, replace

import numpy as np

from pitotbench.calibration.altitude import (
    NOISE_COUNT as NOISE_COUNT,
)
from pitotbench.calibration.altitude import (
    AltitudeNoise,
    AltitudeRows,
    altitude_log_prior,
    altitude_rows,
    carried_height,
)
from pitotbench.calibration.altitude import (
    altitude_guess as altitude_guess,
)
from pitotbench.calibration.observations import Observations
from pitotbench.estimation.point_noise import PointNoise, UnknownColumns
from pitotbench.records.log import FlightLog
from pitotbench.units import Array, MetersPerSecond


@dataclass(frozen=True, slots=True)
class HeightRows:
    """The altitude rows without unknowns of their own, their climb rate (n,) [m/s], and those
    unknowns as columns (rows, u) with standard deviations (u,), infinite for a flat prior."""

    rows: AltitudeRows
    climb: MetersPerSecond
    columns: Array
    deviations: Array


def height_rows(log: FlightLog, obs: Observations, wind: Array) -> HeightRows | None:
    """Return the heights of a log's used rows; None where its height is of no use.

    `wind` (2,) [m/s], roughly, gives the size of the horizontal pressure gradient.
    """
    rows = altitude_rows(log, obs, 0.0, wind, 0.0)
    if rows is None:
        return None
    carried = carried_height(log, 0.0, obs.has_down)
    known = np.isfinite(carried.height)
    height = np.interp(rows.time, log.time[known], carried.height[known])
    rate = np.gradient(height, rows.time)
    edge = np.flatnonzero(rows.first[1:])
    rate[edge] = rate[edge + 1] = 0.0
    padded = np.concatenate([rate[:1], rate, rate[-1:]])
    climb = 0.25 * padded[:-2] + 0.5 * padded[1:-1] + 0.25 * padded[2:]
    with np.errstate(divide="ignore"):
        deviations = rows.unknown.precision**-0.5
    none = UnknownColumns(np.zeros((rows.count, 0)), np.zeros(0))
    return HeightRows(replace(rows, unknown=none), climb, rows.unknown.columns, deviations)


@dataclass(frozen=True, slots=True)
class HeightNoise:
    """The map from φ (3,) to the covariance of the rows; see `AltitudeNoise`."""

    rows: AltitudeRows

    def stack(self, phis: Array) -> PointNoise:
        """Return the covariances for many φ, (b, 3)."""
        return AltitudeNoise(self.rows).stack(phis)


def height_log_prior(rows: AltitudeRows, phis: Array) -> Array:
    """The logarithm of the prior density of φ (b, 3), (b,)."""
    return np.array([altitude_log_prior(rows, phi) for phi in phis])
