"""The air of a group of legs: it converts a true airspeed to a calibrated one, with the stated accuracies."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from pitotbench import air
from pitotbench.calibrate.accuracy import WITHOUT_TEMPERATURE, Accuracies
from pitotbench.calibrate.gps_legs.legs import SteadyGroup
from pitotbench.calibrate.rows.observations import Observations

_PART = 1e-3  # of a stated accuracy, the step of the difference: the whole zero offset may exceed the pressure


@dataclass(frozen=True, slots=True)
class LegAir:
    """Means over the legs of a group.

    `impact_pressure` and `static_pressure` [Pa] are indicated. `probe_heating` [-] is 0.2 r for a probe of total
    temperature [K] and 0 for air temperature. `static_error` states whether the pressure error is the static
    source's, and `standard_day` whether the temperature is that of a standard day.
    """

    impact_pressure: float
    static_pressure: float
    probe_temperature: float
    probe_heating: float
    static_error: bool
    standard_day: bool

    @property
    def indicated_airspeed(self) -> float:
        """Indicated airspeed [m/s]."""
        return float(air.calibrated_airspeed(self.impact_pressure))

    def calibrated_airspeed(self, true_airspeed: float) -> float:
        """Calibrated airspeed [m/s] for a true airspeed [m/s].

        Where the error is the static source's, the total pressure has none: p (1 + q/p) = p_i + q_i.
        """
        ratio = _ratio(true_airspeed, self.probe_temperature, self.probe_heating)
        pressure = self.static_pressure
        if self.static_error:
            pressure = (self.static_pressure + self.impact_pressure) / (1.0 + ratio)
        return float(air.calibrated_airspeed(pressure * ratio))

    def correction(self, true_airspeed: float) -> float:
        """Calibrated minus indicated airspeed [m/s] for a true airspeed [m/s]."""
        return self.calibrated_airspeed(true_airspeed) - self.indicated_airspeed

    def stated_two_sigma(self, true_airspeed: float, stated: Accuracies) -> float:
        """2σ of the correction [m/s] at a true airspeed [m/s] from the stated accuracies of the air data.

        The errors are independent. Those of GPS velocity change the wind alone, and a latency changes nothing at
        constant airspeed. A zero offset belongs to the correction, which is added to the raw reading: it only moves
        the total pressure, from which the true static pressure is found.
        """
        here = self.calibrated_airspeed(true_airspeed)
        parts = [(moved.calibrated_airspeed(true_airspeed) - here) / _PART for moved in self._each_moved(stated)]
        return float(np.linalg.norm(parts))

    def _each_moved(self, stated: Accuracies) -> Iterator["LegAir"]:
        """Yield this air with one quantity at a time changed by a small part of its accuracy."""
        temperature = max(stated.temperature_k, WITHOUT_TEMPERATURE if self.standard_day else 0.0)
        recovery = 0.2 * stated.recovery_factor if self.probe_heating > 0.0 else 0.0
        yield replace(self, probe_temperature=self.probe_temperature + _PART * temperature)
        yield replace(self, probe_heating=self.probe_heating + _PART * recovery)
        yield replace(self, static_pressure=self.static_pressure + _PART * stated.static_pressure_pa)
        yield replace(self, impact_pressure=self.impact_pressure + _PART * stated.impact_pressure_zero_pa)


def leg_air(group: SteadyGroup, obs: Observations, static_error: bool) -> LegAir:
    """Average the air of a group. Every leg has the same weight, as in the methods' airspeed."""
    blocks = group.blocks
    indicated_true, pressure, probe = (
        float(group.leg_means(channel).mean())
        for channel in (blocks.indicated_true_airspeed, blocks.static_pressure, blocks.probe_temperature)
    )
    impact = pressure * _ratio(indicated_true, probe, obs.probe_heating)
    return LegAir(impact, pressure, probe, obs.probe_heating, static_error, obs.standard_day)


def _ratio(true_airspeed: float, probe_temperature: float, probe_heating: float) -> float:
    """q_c/p for a true airspeed [m/s] and a probe temperature [K], with T = T_t − 0.2 r V²/(γR)."""
    heating = probe_heating * true_airspeed**2 / (air.HEAT_RATIO * air.GAS_CONSTANT)
    return float(air.impact_pressure_from_true_airspeed(true_airspeed, 1.0, probe_temperature - heating))
