"""The standard atmosphere and the compressible airspeed relations, written for the outside judge alone.

Pressures in Pa, speeds in m/s, temperatures in K, heights in m. Sources: ICAO Doc 7488 (constants) and the
isentropic relations with γ = 1.4, as in NACA report 1135, equations 44 and 45.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]

KNOT: Final = 1852.0 / 3600.0  # m/s
FOOT: Final = 0.3048  # m
GRAVITY: Final = 9.80665  # m/s²
GAS_CONSTANT: Final = 287.053  # J/(kg K)
GAMMA: Final = 1.4
SEA_LEVEL_PRESSURE: Final = 101325.0  # Pa
SEA_LEVEL_TEMPERATURE: Final = 288.15  # K
LAPSE: Final = 0.0065  # K/m
SOUND_AT_SEA_LEVEL: Final = float(np.sqrt(GAMMA * GAS_CONSTANT * SEA_LEVEL_TEMPERATURE))  # m/s
CORIOLIS: Final = float(2.0 * 7.292115e-5 * np.sin(np.radians(45.0)))  # rad/s, at 45° N


@dataclass(frozen=True, slots=True)
class Day:
    """The air of one day: how far it is from the standard, the same offset at all heights."""

    warmer: float = 0.0  # K
    sea_level_pressure: float = SEA_LEVEL_PRESSURE  # Pa

    def temperature(self, height: Array) -> Array:
        """Temperature of the air [K] at heights [m]."""
        return SEA_LEVEL_TEMPERATURE + self.warmer - LAPSE * height

    def pressure(self, height: Array) -> Array:
        """Hydrostatic pressure [Pa] at heights [m], closed form for a constant lapse."""
        base = SEA_LEVEL_TEMPERATURE + self.warmer
        exponent = GRAVITY / (GAS_CONSTANT * LAPSE)
        return np.asarray(self.sea_level_pressure * (self.temperature(height) / base) ** exponent)

    def density(self, height: Array) -> Array:
        """Density of the air [kg/m³] at heights [m]."""
        return self.pressure(height) / (GAS_CONSTANT * self.temperature(height))


def speed_of_sound(temperature: Array) -> Array:
    """Speed of sound [m/s] at an air temperature [K]."""
    return np.sqrt(GAMMA * GAS_CONSTANT * temperature)


def impact_over_static(mach: Array) -> Array:
    """Impact pressure over static pressure at a Mach number below 1."""
    # expm1 and log1p: at 30 kt the plain power loses five digits
    return np.asarray(np.expm1(3.5 * np.log1p(0.2 * mach**2)))


def mach_number(impact_over_static_pressure: Array) -> Array:
    """Mach number from impact over static pressure."""
    return np.sqrt(5.0 * np.expm1(np.log1p(impact_over_static_pressure) / 3.5))


def impact_pressure(calibrated_airspeed: Array) -> Array:
    """Impact pressure [Pa] of a calibrated airspeed [m/s]."""
    return SEA_LEVEL_PRESSURE * impact_over_static(calibrated_airspeed / SOUND_AT_SEA_LEVEL)


def calibrated_airspeed(impact: Array) -> Array:
    """Calibrated airspeed [m/s] of an impact pressure [Pa]."""
    return SOUND_AT_SEA_LEVEL * mach_number(impact / SEA_LEVEL_PRESSURE)


def total_temperature(temperature: Array, mach: Array) -> Array:
    """Total temperature [K], all of the rise recovered."""
    return temperature * (1.0 + 0.2 * mach**2)


def pressure_altitude(pressure: Array) -> Array:
    """Height [m] of a pressure [Pa] in the standard atmosphere."""
    exponent = GAS_CONSTANT * LAPSE / GRAVITY
    return np.asarray(SEA_LEVEL_TEMPERATURE / LAPSE * (1.0 - (pressure / SEA_LEVEL_PRESSURE) ** exponent))


def central_difference(function: Callable[[Array], Array], at: Array, steps: Array) -> Array:
    """Slopes of a function of one vector, one column an entry of the vector."""
    columns = []
    for place, step in enumerate(steps):
        shift = np.zeros_like(at)
        shift[place] = step
        columns.append((function(at + shift) - function(at - shift)) / (2.0 * step))
    return np.stack(columns, axis=-1)
