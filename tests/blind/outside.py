"""Effects that the table does not hold: written here, on the recorded channels, and known to nobody else."""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from pitotbench.records.log import FlightLog

Fault = Callable[[FlightLog, float], FlightLog]  # a log, the size; 1 is a typical one


def _loose_tube(log: FlightLog, size: float) -> FlightLog:
    """A pitot tube that rocks: 1 % of impact pressure with a period of 23 s."""
    return replace(
        log, impact_pressure=log.impact_pressure * (1.0 + 0.01 * size * np.sin(2.0 * np.pi * log.time / 23.0))
    )


def _deviating_compass(log: FlightLog, size: float) -> FlightLog:
    """Heading with a semicircular deviation of 2°."""
    return replace(log, heading=np.mod(log.heading + 0.035 * size * np.sin(log.heading - 0.7), 2.0 * np.pi))


def _leaning_gyro(log: FlightLog, size: float) -> FlightLog:
    """Attitude that reads 3 % of bank too little, and a pitch that follows its square."""
    return replace(log, roll=log.roll * (1.0 - 0.03 * size), pitch=log.pitch + 0.02 * size * log.roll**2)


def _stretched_accelerometer(log: FlightLog, size: float) -> FlightLog:
    """A vertical accelerometer with a scale error of 1 % that grows with load."""
    felt = log.specific_force_z
    return replace(log, specific_force_z=felt * (1.0 + 0.01 * size * np.abs(felt) / 9.80665))


def _swinging_altitude(log: FlightLog, size: float) -> FlightLog:
    """GPS altitude with multipath: 3 m with a period of 70 s."""
    if log.altitude is None:
        return log
    return replace(log, altitude=log.altitude + 3.0 * size * np.sin(2.0 * np.pi * log.time / 70.0))


def _scaled_velocity(log: FlightLog, size: float) -> FlightLog:
    """A ground velocity whose north part is 1 % too large."""
    return replace(log, velocity_north=log.velocity_north * (1.0 + 0.01 * size))


def _iced_vane(log: FlightLog, size: float) -> FlightLog:
    """An angle-of-attack vane that sticks more and more over the flight: it reads toward its mean."""
    share = np.linspace(0.0, min(1.0, 0.3 * size), len(log.time))
    return replace(
        log, angle_of_attack=log.angle_of_attack + share * (log.angle_of_attack.mean() - log.angle_of_attack)
    )


FAULTS: Mapping[str, Fault] = {
    "loose_tube": _loose_tube,
    "deviating_compass": _deviating_compass,
    "leaning_gyro": _leaning_gyro,
    "stretched_accelerometer": _stretched_accelerometer,
    "swinging_altitude": _swinging_altitude,
    "scaled_velocity": _scaled_velocity,
    "iced_vane": _iced_vane,
}
