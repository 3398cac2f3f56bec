"""Standard atmosphere and airspeed relations, as pure functions on arrays.

The air is a calorically perfect gas and the flow subsonic (Gracey, NASA RP-1046, 1980; ICAO Doc
7488; U.S. Standard Atmosphere 1976). Arguments and results are SI and broadcast: scalars and arrays
of any shape are allowed. The impact pressure q_c is the total minus the static pressure.
"""

import numpy as np

from pitotbench.units import Array, Kelvin, Meters, MetersPerSecond, Pascal

SEA_LEVEL_PRESSURE = 101325.0  # Pa
SEA_LEVEL_TEMPERATURE = 288.15  # K
GAS_CONSTANT = 287.053  # J/(kg K)
HEAT_RATIO = 1.4  # of the specific heats of air
GRAVITY = 9.80665  # m/s²
LAPSE_RATE = 0.0065  # K/m, below the tropopause
TROPOPAUSE = 11000.0  # m, geopotential
STRATOSPHERE_RATE = 0.001  # K/m, by which it grows warmer
STRATOSPHERE_WARMS = 20000.0  # m, geopotential, above which it does
SEA_LEVEL_SOUND_SPEED = float(np.sqrt(HEAT_RATIO * GAS_CONSTANT * SEA_LEVEL_TEMPERATURE))  # m/s

_EXPONENT = GRAVITY / (GAS_CONSTANT * LAPSE_RATE)
_COLDEST = SEA_LEVEL_TEMPERATURE - LAPSE_RATE * TROPOPAUSE  # K
_SCALE_HEIGHT = GAS_CONSTANT * _COLDEST / GRAVITY  # m, between the two
_UPPER_EXPONENT = GRAVITY / (GAS_CONSTANT * STRATOSPHERE_RATE)


def standard_temperature(pressure_altitude: Meters | float) -> Kelvin:
    """Return the standard-day temperature [K] at a pressure altitude [m] up to 32 km."""
    h = np.asarray(pressure_altitude, dtype=np.float64)
    below, above = np.minimum(h, TROPOPAUSE), np.maximum(h - STRATOSPHERE_WARMS, 0.0)
    return np.asarray(SEA_LEVEL_TEMPERATURE - LAPSE_RATE * below + STRATOSPHERE_RATE * above)


def standard_pressure(pressure_altitude: Meters | float) -> Pascal:
    """Return the standard-day pressure [Pa] at a pressure altitude [m] up to 32 km.

    Three layers: the temperature falls with height, is constant from 11 to 20 km, and rises (U.S.
    Standard Atmosphere 1976, equations 33a and 33b).
    """
    # Each factor is that of one layer: it is 1 below the layer and stops changing above it.
    h = np.asarray(pressure_altitude, dtype=np.float64)
    fallen = standard_temperature(np.minimum(h, TROPOPAUSE)) / SEA_LEVEL_TEMPERATURE
    in_cold = np.clip(h - TROPOPAUSE, 0.0, STRATOSPHERE_WARMS - TROPOPAUSE)
    risen = standard_temperature(h) / _COLDEST
    upper = np.where(h > STRATOSPHERE_WARMS, risen**-_UPPER_EXPONENT, 1.0)
    return np.asarray(
        SEA_LEVEL_PRESSURE * fallen**_EXPONENT * np.exp(-in_cold / _SCALE_HEIGHT) * upper
    )


def pressure_altitude(static_pressure: Pascal | float) -> Meters:
    """Return the pressure altitude [m] of a static pressure [Pa], NaN for zero and less.

    The inverse of `standard_pressure`.
    """
    p = np.asarray(static_pressure, dtype=np.float64)
    p = np.where(p > 0.0, p, np.nan)
    edge, top = (float(standard_pressure(h)) for h in (TROPOPAUSE, STRATOSPHERE_WARMS))
    low = SEA_LEVEL_TEMPERATURE / LAPSE_RATE * (1.0 - (p / SEA_LEVEL_PRESSURE) ** (1.0 / _EXPONENT))
    cold = TROPOPAUSE - _SCALE_HEIGHT * np.log(p / edge)
    high = STRATOSPHERE_WARMS + _COLDEST / STRATOSPHERE_RATE * (
        (p / top) ** (-1.0 / _UPPER_EXPONENT) - 1.0
    )
    return np.where(p >= edge, low, np.where(p >= top, cold, high))


def mach_from_true_airspeed(
    true_airspeed: MetersPerSecond | float,
    total_temperature: Kelvin | float,
    recovery_factor: float = 1.0,
) -> Array:
    """Return the Mach number of a true airspeed [m/s] at a total temperature [K] of a probe."""
    v = np.asarray(true_airspeed, dtype=np.float64)
    air = np.asarray(total_temperature) * HEAT_RATIO * GAS_CONSTANT - 0.2 * recovery_factor * v * v
    return v / np.sqrt(air)


def sound_speed(air_temperature: Kelvin | float) -> MetersPerSecond:
    """Return the speed of sound [m/s] at an air temperature [K]."""
    return np.sqrt(HEAT_RATIO * GAS_CONSTANT * np.asarray(air_temperature, dtype=np.float64))


def impact_pressure_from_mach(mach: Array | float, static_pressure: Pascal | float) -> Pascal:
    """Return the impact pressure [Pa] p[(1 + 0.2 M²)^3.5 − 1] of a Mach number M.

    `static_pressure` is p [Pa].
    """
    # expm1 and log1p keep all digits where q_c is a small part of p, as it is at 100 kt.
    m = np.asarray(mach, dtype=np.float64)
    return np.asarray(static_pressure * np.expm1(3.5 * np.log1p(0.2 * m * m)))


def mach_from_impact_pressure(
    impact_pressure: Pascal | float, static_pressure: Pascal | float
) -> Array:
    """Return the subsonic Mach number of an impact pressure q_c ≥ 0 at a static pressure [Pa].

    The inverse of `impact_pressure_from_mach`; NaN for a negative impact pressure.
    """
    ratio = np.asarray(impact_pressure, dtype=np.float64) / static_pressure
    with np.errstate(invalid="ignore"):  # a negative impact pressure is no number, as said above
        return np.asarray(np.sqrt(5.0 * np.expm1(np.log1p(ratio) * (2.0 / 7.0))))


def calibrated_airspeed(impact_pressure: Pascal | float) -> MetersPerSecond:
    """Return the calibrated airspeed [m/s] of an impact pressure [Pa].

    Given an indicated impact pressure, the result is the indicated airspeed.
    """
    return np.asarray(
        SEA_LEVEL_SOUND_SPEED * mach_from_impact_pressure(impact_pressure, SEA_LEVEL_PRESSURE)
    )


def impact_pressure(calibrated_airspeed: MetersPerSecond | float) -> Pascal:
    """Return the impact pressure [Pa] of a calibrated airspeed [m/s].

    The inverse of `calibrated_airspeed`.
    """
    return impact_pressure_from_mach(
        np.asarray(calibrated_airspeed, dtype=np.float64) / SEA_LEVEL_SOUND_SPEED,
        SEA_LEVEL_PRESSURE,
    )


def calibrated_airspeed_slope(
    impact_pressure: Pascal | float, speed: MetersPerSecond | None = None
) -> Array:
    """Return dV_c/dq_c [m/s per Pa], which turns a small pressure error into an airspeed error.

    `speed` is the calibrated airspeed at this impact pressure [m/s], where it is known already.
    """
    q = np.asarray(impact_pressure, dtype=np.float64)
    speed = calibrated_airspeed(q) if speed is None else speed
    ratio = 1.0 + q / SEA_LEVEL_PRESSURE
    return np.asarray(
        SEA_LEVEL_SOUND_SPEED**2 * 5.0 / 7.0 * ratio ** (-5.0 / 7.0) / (SEA_LEVEL_PRESSURE * speed)
    )


def total_temperature(
    air_temperature: Kelvin | float, mach: Array | float, recovery_factor: float = 1.0
) -> Kelvin:
    """Return the temperature T(1 + 0.2 r M²) [K] that a probe reads at an air temperature T [K]."""
    m = np.asarray(mach, dtype=np.float64)
    return np.asarray(air_temperature * (1.0 + 0.2 * recovery_factor * m * m))


def air_temperature(
    total_temperature: Kelvin | float, mach: Array | float, recovery_factor: float = 1.0
) -> Kelvin:
    """Return the air (static) temperature [K] of a probe's reading [K].

    The inverse of `total_temperature`.
    """
    m = np.asarray(mach, dtype=np.float64)
    return np.asarray(total_temperature / (1.0 + 0.2 * recovery_factor * m * m))


def true_airspeed(
    impact_pressure: Pascal | float,
    static_pressure: Pascal | float,
    air_temperature: Kelvin | float,
) -> MetersPerSecond:
    """Return the true airspeed [m/s] at impact and static pressure [Pa] and air temperature [K]."""
    return mach_from_impact_pressure(impact_pressure, static_pressure) * sound_speed(
        air_temperature
    )


def impact_pressure_from_true_airspeed(
    true_airspeed: MetersPerSecond | float,
    static_pressure: Pascal | float,
    air_temperature: Kelvin | float,
) -> Pascal:
    """Return the impact pressure [Pa] of a true airspeed [m/s]; the inverse of `true_airspeed`."""
    mach = np.asarray(true_airspeed, dtype=np.float64) / sound_speed(air_temperature)
    return impact_pressure_from_mach(mach, static_pressure)
