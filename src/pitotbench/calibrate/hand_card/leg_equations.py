"""The equation of a leg: the ground velocity less the wind has the size of the true airspeed.

|g − w| = V_t(V_i + ΔV, p, T). It is linear in small changes of the wind w and of the correction ΔV.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pitotbench import air
from pitotbench.records.hand_card import CardLeg, ReadingSteps
from pitotbench.units import Array, MetersPerSecond

_ROUNDING = 1.0 / np.sqrt(12.0)  # standard deviation of an error that is uniform over one step, in steps
_SMALL = 0.05  # m/s and K, steps of the differences


@dataclass(frozen=True, slots=True)
class LegArrays:
    """The legs of a card as arrays (n,) [SI]: what was read, and the ground velocity (n, 2)."""

    indicated_airspeed: Array
    static_pressure: Array
    air_temperature: Array
    velocity: Array

    def true_airspeed(self, correction: MetersPerSecond | float, warmer: float = 0.0) -> MetersPerSecond:
        """Return the true airspeed [m/s], (n,), for corrections [m/s]; `warmer` is added to the temperature [K].

        The static source errs and the total pressure is right: p = p_i + q_ci − q_c.
        """
        calibrated = self.indicated_airspeed + correction
        impact, indicated = air.impact_pressure(calibrated), air.impact_pressure(self.indicated_airspeed)
        static = self.static_pressure + indicated - impact
        return air.true_airspeed(impact, static, self.air_temperature + warmer)

    def slope(self, correction: MetersPerSecond | float) -> Array:
        """Return dV_t/dΔV [-], (n,)."""
        up, down = self.true_airspeed(correction + _SMALL), self.true_airspeed(correction - _SMALL)
        return np.asarray((up - down) / (2.0 * _SMALL))

    def warmth(self, correction: MetersPerSecond | float) -> Array:
        """Return dV_t/dT [m/s per K], (n,)."""
        up, down = self.true_airspeed(correction, _SMALL), self.true_airspeed(correction, -_SMALL)
        return np.asarray((up - down) / (2.0 * _SMALL))


def leg_arrays(legs: Sequence[CardLeg]) -> LegArrays:
    """Return legs as arrays."""
    speed, track = (np.array([getattr(leg, name) for leg in legs]) for name in ("ground_speed", "track"))
    return LegArrays(
        np.array([leg.indicated_airspeed for leg in legs]),
        np.asarray(air.standard_pressure(np.array([leg.pressure_altitude for leg in legs]))),
        np.array([leg.air_temperature for leg in legs]),
        np.stack([speed * np.cos(track), speed * np.sin(track)], axis=1),
    )


def reading_variance(arrays: LegArrays, along: Array, steps: ReadingSteps, correction: Array) -> Array:
    """Return the variance [(m/s)²], (n,), that the steps of the displays leave in the equation of each leg.

    `along` (n, 2) is the unit vector of the flight path through the air. A step of the track moves the tip of the
    ground velocity across itself; only its part along the flight path counts.
    """
    across = np.abs(along[:, 0] * arrays.velocity[:, 1] - along[:, 1] * arrays.velocity[:, 0])
    shares = (
        steps.ground_speed,
        steps.track * across,
        steps.indicated_airspeed * arrays.slope(correction),
        steps.air_temperature * arrays.warmth(correction),
    )
    return np.asarray(_ROUNDING**2 * sum(np.square(share) for share in shares))
