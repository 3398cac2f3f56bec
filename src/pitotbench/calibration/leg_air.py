"""The air of level legs: what airspeeds their readings mean, and how accuracies move them."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pitotbench import air
from pitotbench.calibration.options import WITHOUT_TEMPERATURE, Accuracies
from pitotbench.units import Array, Booleans, Kelvin, MetersPerSecond, Pascal

_PART = 1e-3  # of a stated accuracy, the step of the difference: a zero offset may exceed q_c
_LEAST_STATIC = 0.1  # of the indicated pressure: a wild correction leaves the air some
_STEP = 0.05  # m/s, of the difference by which airspeeds are differentiated


@dataclass(frozen=True, slots=True)
class LegAir:
    """The indicated air of legs, (n,), or the means of a group, (1,).

    `impact_pressure` and `static_pressure` [Pa] are indicated. `probe_heating` [-] is 0.2 r for a
    probe of total temperature [K] and 0 for air temperature. `static_error` states whether the
    pressure error is the static source's, and `standard_day` whether the temperature is that of a
    standard day.
    """

    impact_pressure: Pascal
    static_pressure: Pascal
    probe_temperature: Kelvin
    probe_heating: float = 0.0
    static_error: bool = True
    standard_day: bool = False

    def at(self, rows: Booleans | NDArray[np.intp]) -> "LegAir":
        """The chosen rows."""
        return replace(
            self,
            impact_pressure=self.impact_pressure[rows],
            static_pressure=self.static_pressure[rows],
            probe_temperature=self.probe_temperature[rows],
        )

    @property
    def indicated_airspeed(self) -> MetersPerSecond:
        """Indicated airspeed [m/s]."""
        return air.calibrated_airspeed(self.impact_pressure)

    def true_airspeed(self, correction: MetersPerSecond | float = 0.0) -> MetersPerSecond:
        """True airspeed [m/s] with corrections of the indicated airspeed [m/s].

        Where the static source errs the total pressure is right: p = p_i + q_ci − q_c.
        """
        impact = air.impact_pressure(self.indicated_airspeed + correction)
        moved = self.impact_pressure - impact if self.static_error else 0.0
        static = np.maximum(self.static_pressure + moved, _LEAST_STATIC * self.static_pressure)
        mach = air.mach_from_impact_pressure(impact, static)
        heating = 1.0 + self.probe_heating * mach**2
        return np.asarray(mach * air.sound_speed(self.probe_temperature / heating))

    def calibrated_airspeed(self, true_airspeed: MetersPerSecond | float) -> MetersPerSecond:
        """Calibrated airspeed [m/s] for a true airspeed [m/s].

        Where the error is the static source's, the total pressure has none: p (1 + q/p) = p_i +
        q_i.
        """
        ratio = impact_ratio(true_airspeed, self.probe_temperature, self.probe_heating)
        pressure = self.static_pressure
        if self.static_error:
            pressure = (self.static_pressure + self.impact_pressure) / (1.0 + ratio)
        return air.calibrated_airspeed(pressure * ratio)

    def slope(self, correction: MetersPerSecond | float) -> Array:
        """dV_t/dΔV [-], (n,)."""
        up, down = self.true_airspeed(correction + _STEP), self.true_airspeed(correction - _STEP)
        return (up - down) / (2.0 * _STEP)

    def temperature_slope(self, correction: MetersPerSecond | float) -> Array:
        """dV_t/dT [m/s per K], (n,): a true airspeed is proportional to √T."""
        return self.true_airspeed(correction) / (2.0 * self.probe_temperature)

    def corrected(
        self, true_airspeed: float, two_sigma: float, stated: Accuracies
    ) -> tuple[float, float]:
        """Return the correction [m/s] for a true airspeed, and its 2σ from that of the true
        airspeed [m/s] and the stated accuracies.
        """
        here, there = self.calibrated_airspeed(np.array([true_airspeed, true_airspeed + _STEP]))
        of_air = self.stated_two_sigma(true_airspeed, stated)
        bound = float(np.hypot((there - here) / _STEP * two_sigma, of_air))
        return float(here - self.indicated_airspeed), bound

    def stated_two_sigma(self, true_airspeed: float, stated: Accuracies) -> float:
        """2σ of the calibrated airspeed [m/s] at a true airspeed [m/s] from the stated accuracies
        of the air data.

        The errors are independent. Those of GPS velocity change the wind alone, and a latency
        changes nothing at constant airspeed. A zero offset belongs to the correction, which is
        added to the raw reading: it only moves the total pressure, from which the true static
        pressure is found.
        """
        here = self.calibrated_airspeed(true_airspeed)
        parts = [
            (moved.calibrated_airspeed(true_airspeed) - here) / _PART
            for moved in self._each_moved(stated)
        ]
        return float(np.linalg.norm(parts))

    def _each_moved(self, stated: Accuracies) -> Iterator["LegAir"]:
        """Yield this air with one quantity at a time changed by a small part of its accuracy."""
        temperature = max(stated.temperature_k, WITHOUT_TEMPERATURE if self.standard_day else 0.0)
        recovery = 0.2 * stated.recovery_factor if self.probe_heating > 0.0 else 0.0
        for field, accuracy in (
            ("probe_temperature", temperature),
            ("probe_heating", recovery),
            ("static_pressure", stated.static_pressure_pa),
            ("impact_pressure", stated.impact_pressure_zero_pa),
        ):
            yield replace(self, **{field: getattr(self, field) + _PART * accuracy})


def impact_ratio(
    true_airspeed: MetersPerSecond | float,
    probe_temperature: Kelvin | float,
    probe_heating: float,
) -> Array:
    """Return q_c/p for a true airspeed [m/s] and a probe temperature [K].

    The air has T = T_t − 0.2 r V²/(γR).
    """
    heating = probe_heating * np.square(true_airspeed) / (air.HEAT_RATIO * air.GAS_CONSTANT)
    return air.impact_pressure_from_true_airspeed(true_airspeed, 1.0, probe_temperature - heating)
