"""The result of a fixed-speed GPS method at one airspeed of a log: a point to compare with the curve."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class FixedSpeedPoint:
    """One airspeed, one wind [m/s], from legs or a turn at constant airspeed.

    `legs` is 1 for a turn. `indicated_airspeed`, `calibrated_airspeed`, `correction` (calibrated minus indicated)
    and `two_sigma` (its bound) are mean values over the legs; `true_airspeed` belongs to the same mean. `spread`
    is the standard deviation of the redundant solutions: those of three legs out of four, or the residuals of a
    regression; None where nothing is redundant. `two_sigma` contains the stated accuracies of temperature and
    pressures, `true_airspeed_two_sigma` only the scatter of the ground velocities. The wind is the
    velocity of the air toward north and east.
    """

    method: str
    legs: int
    seconds: float
    indicated_airspeed: float
    calibrated_airspeed: float
    correction: float
    two_sigma: float
    true_airspeed: float
    true_airspeed_two_sigma: float
    spread: float | None
    wind_north: float
    wind_east: float
    wind_two_sigma: float  # of the larger component
