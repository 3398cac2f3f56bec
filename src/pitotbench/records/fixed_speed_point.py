"""What a fixed-speed GPS method found at one airspeed of a log: a point beside the curve."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class FixedSpeedPoint:
    """One airspeed, one wind [m/s], from legs or a turn at constant airspeed.

    `legs` is 1 for a turn. `indicated_airspeed`, `calibrated_airspeed`, `correction` (calibrated minus indicated)
    and `two_sigma` (its bound) are mean values over the legs; `true_airspeed` belongs to the same mean. `spread`
    is the standard deviation of what the method has too much of: the three-leg answers of four legs, the
    residuals of a regression; None where there is nothing left over. `two_sigma` holds the accuracies stated for
    temperature and pressures, `true_airspeed_two_sigma` what the ground velocities alone leave open. The wind
    blows toward north and east.
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
