"""Logs from formulas, not from the simulator: straight legs and turns in gusty air with a known
answer.
"""

from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from pitotbench import FlightLog, air
from pitotbench.pressure_error import MODELS, REFERENCE_PRESSURE
from pitotbench.pressure_error.models import PressureErrorCurve, TableCurve
from pitotbench.units import DEGREE, KNOT, Array

TRUTH = PressureErrorCurve(MODELS["inverse+"], (-0.13, 0.01, 0.14), REFERENCE_PRESSURE)
STATIC_PRESSURE = 81200.0  # Pa, 6,000 ft
AIR_TEMPERATURE = 276.3  # K
WIND = (5.0, -6.0)  # m/s toward north, east
GUST_LENGTH = 533.0  # m
EXACT = {
    "temperature_k": 0.0,
    "recovery_factor": 0.0,
    "static_pressure_pa": 0.0,
    "velocity_mps": 0.0,
    "total_source": 0.0,
}
# Nor is the receiver filtered, or the error another in turns.
COLUMNS = {"receiver_smoothing_s2": 0.0, "turn_lift": 0.0}


@dataclass(frozen=True, slots=True)
class Air:
    """Noise levels: gust and GPS [m/s], impact pressure [Pa]."""

    gust: float = 0.3
    gps: float = 0.05
    pressure: float = 12.0


CALM = Air(gust=0.0, gps=0.0, pressure=0.0)


def step_decrease(rate: int) -> tuple[Array, Array]:
    """Calibrated airspeed [m/s] and heading [rad]: 160 to 130 kt north, a turn, 130 to 100 kt
    south.
    """
    speed = np.concatenate(
        [
            np.linspace(160, 130, 96 * rate),
            np.full(60 * rate, 130),
            np.linspace(130, 100, 80 * rate),
        ]
    )
    turn = np.linspace(0, 180, 60 * rate)
    heading = np.concatenate([np.zeros(96 * rate), turn, np.full(80 * rate, 180)])
    return speed * KNOT, heading * DEGREE


def circles(rate: int, speeds_kt: tuple[float, ...] = (100, 120, 140, 160)) -> tuple[Array, Array]:
    """A full turn of 100 s at each speed."""
    turn = np.linspace(0.0, 2.0 * np.pi, 100 * rate)
    return np.repeat(np.array(speeds_kt), len(turn)) * KNOT, np.tile(turn, len(speeds_kt))


def straight(rate: int, low_kt: float = 100.0, high_kt: float = 160.0) -> tuple[Array, Array]:
    """One heading, one sweep of speed."""
    return np.linspace(high_kt, low_kt, 120 * rate) * KNOT, np.zeros(120 * rate)


def fly(
    path: tuple[Array, Array],
    rate: int,
    gps_rate: int,
    noise: Air,
    seed: int = 1,
    truth: PressureErrorCurve | TableCurve = TRUTH,
) -> FlightLog:
    """Sense a path: an Ornstein-Uhlenbeck gust along it, white sensor noise, a held GPS."""
    rng = np.random.default_rng(seed)
    speed, heading = path
    n = len(speed)
    still = air.true_airspeed(air.impact_pressure(speed), STATIC_PRESSURE, AIR_TEMPERATURE)
    decay = float(np.exp(-np.mean(still) / rate / GUST_LENGTH))
    gust = lfilter([np.sqrt(1 - decay**2)], [1, -decay], rng.standard_normal(n + 100 * rate))[
        100 * rate :
    ]
    airspeed = still + noise.gust * gust
    mach = airspeed / air.sound_speed(AIR_TEMPERATURE)
    impact = air.impact_pressure_from_mach(mach, STATIC_PRESSURE)
    indicated = truth.indicated_impact_pressure(impact) + noise.pressure * rng.standard_normal(n)
    fix = (np.arange(n) // (rate // gps_rate)) * (rate // gps_rate)
    north = still * np.cos(heading) + WIND[0] + noise.gps * rng.standard_normal(n)
    east = still * np.sin(heading) + WIND[1] + noise.gps * rng.standard_normal(n)
    return FlightLog(
        time=np.arange(n) / rate,
        impact_pressure=indicated,
        static_pressure=np.full(n, STATIC_PRESSURE),
        velocity_north=north[fix],
        velocity_east=east[fix],
        velocity_down=np.zeros(n),
        gps_fresh=np.arange(n) == fix,
        total_temperature=np.asarray(air.total_temperature(AIR_TEMPERATURE, mach)),
        roll=np.zeros(n),
        pitch=np.zeros(n),
        heading=heading.copy(),
        angle_of_attack=np.zeros(n),
        sideslip=np.zeros(n),
        # Synthetic: the error corrupts the impact pressure alone, and the sensors have no constant
        # error.
        header={"format": "pitotbench flight log 1", "accuracy": EXACT, "priors": COLUMNS},
    )


def true_correction(
    indicated_airspeed: Array, truth: PressureErrorCurve | TableCurve = TRUTH
) -> Array:
    """Calibrated minus indicated airspeed [m/s] of the truth."""
    impact = truth.impact_pressure(air.impact_pressure(indicated_airspeed))
    return air.calibrated_airspeed(impact) - indicated_airspeed
