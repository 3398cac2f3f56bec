"""Flights from formulas with the error at the static source and a receiver's height: for the
altitude equation.

Nothing here is the project's but the relations of air and the record of a log.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.signal import lfilter

from pitotbench import FlightLog, air
from pitotbench.units import DEGREE, KNOT, Array

RATE = 20
HEIGHT = 1829.0  # m, 6,000 ft
WIND = (5.0, -6.0)  # m/s toward north, east
CURVE = (-0.060, 0.006, 0.060)  # Inverse+, q_ref 1630.28 Pa
REFERENCE = 1630.28
EARTH = 6.357e6  # m: the atmosphere's height is geopotential, the receiver's is not
EXACT = {
    "temperature_k": 0.0,
    "recovery_factor": 0.0,
    "static_pressure_pa": 0.0,
    "velocity_mps": 0.0,
    "total_source": 0.0,
}
COLUMNS = {"receiver_smoothing_s2": 0.0, "turn_lift": 0.0}  # nor a filter, nor an error in turns


@dataclass(frozen=True, slots=True)
class Receiver:
    """A GPS: white and slow height error [m], the slow one's memory [s], velocity error a fix
    [m/s], rate [Hz], whether it gives the vertical velocity."""

    white: float = 0.3
    slow: float = 2.0
    memory: float = 90.0
    velocity: float = 0.05
    rate: int = 1
    down: bool = True


@dataclass(frozen=True, slots=True)
class Conditions:
    """Gusts [m/s] of 300 m, sensor noise [Pa], where the error sits, wander of the height [m]."""

    gust: float = 0.5
    length: float = 300.0
    impact: float = 12.0
    static: float = 10.0
    location: str = "static"
    wander: float = 5.0


PERFECT = Receiver(white=0.0, slow=0.0, velocity=0.0, rate=RATE)
CALM = Conditions(gust=0.0, impact=0.0, static=0.0)


def path(maneuver: str) -> tuple[Array, Array]:
    """Calibrated airspeed [m/s] and heading [rad] of a maneuver at `RATE`, speeds changed at 1
    kt/s.
    """
    legs = _LEGS[maneuver]
    speed = np.concatenate(
        [np.linspace(v0, v1, int(s * RATE), endpoint=False) for s, v0, v1, *_ in legs]
    )
    heading = np.concatenate(
        [np.linspace(h0, h1, int(s * RATE), endpoint=False) for s, _, _, h0, h1 in legs]
    )
    smooth = gaussian_filter1d(
        np.stack([speed * KNOT, heading * DEGREE]), 2.0 * RATE, axis=1, mode="nearest"
    )
    return smooth[0], smooth[1]


def _race_track() -> list[tuple[float, ...]]:
    legs: list[tuple[float, ...]] = []
    for lap, v in enumerate((160, 140, 120, 100)):
        out = 360 * lap
        legs += [(60, v, v, out, out), (45, v, v, out, out + 180), (65, v, v, out + 180, out + 180)]
        legs += [(45, v, v, out + 180, out + 360)]
        legs += [(20, v, v - 20, out + 360, out + 360)] if v > 100 else []
    return legs


def _circle() -> list[tuple[float, ...]]:
    legs: list[tuple[float, ...]] = []
    start = 0.0
    for v in (160, 140, 120, 100):
        turn = 360 * 9.81 * np.tan(30 * DEGREE) / (1.1 * v * KNOT) / (2 * np.pi)
        seconds = 360 / turn
        legs.append((seconds, v, v, start, start + 360))
        start += 360
        if v > 100:
            legs.append((20, v, v - 20, start, start + 20 * turn))
            start += 20 * turn
    return legs


_LEGS = {
    "rapid_decel": [
        (50, 160, 160, 0, 0), (60, 160, 100, 0, 0), (60, 100, 100, 0, 180), (60, 100, 160, 180, 180),
        (80, 160, 160, 180, 180), (60, 160, 100, 180, 180),
    ],
    "step_decrease": [
        (40, 160, 160, 0, 0), (96, 160, 130, 0, 0), (60, 130, 130, 0, 180), (70, 130, 130, 180, 180),
        (90, 130, 100, 180, 180),
    ],
    "circle": _circle(),
    "race_track": _race_track(),
}  # fmt: skip


def fly(
    maneuver: str,
    seed: int = 1,
    receiver: Receiver | None = None,
    conditions: Conditions | None = None,
) -> FlightLog:
    """Sense a maneuver."""
    gps, given, rng = (
        receiver or Receiver(),
        conditions or Conditions(),
        np.random.default_rng(seed),
    )
    speed, heading = path(maneuver)
    n, time = len(speed), np.arange(len(speed)) / RATE
    wander = (
        given.wander
        * gaussian_filter1d(rng.standard_normal(n), 10.0 * RATE, mode="wrap")
        * np.sqrt(10.0 * RATE * 3.5)
    )
    height = HEIGHT + wander
    climb = np.gradient(wander, time)
    temperature = 288.15 - 0.0065 * height
    static = air.standard_pressure(height)
    level = air.standard_pressure(np.array(HEIGHT))
    still = air.true_airspeed(air.impact_pressure(speed), level, 288.15 - 0.0065 * HEIGHT)
    decay = float(np.exp(-np.mean(still) / RATE / given.length))
    gusts = lfilter(
        [np.sqrt(1 - decay**2)], [1, -decay], rng.standard_normal((3, n + 200 * RATE)), axis=1
    )
    gusts = given.gust * gusts[:, 200 * RATE :]
    velocity = np.stack(
        [still * np.cos(heading) + WIND[0], still * np.sin(heading) + WIND[1], -climb]
    )
    through = velocity - np.array([[WIND[0]], [WIND[1]], [0.0]]) - gusts
    mach = np.linalg.norm(through, axis=0) / air.sound_speed(temperature)
    impact = air.impact_pressure_from_mach(mach, static)
    indicated = _indicated(impact)
    error = impact - indicated
    fix = (np.arange(n) // (RATE // gps.rate)) * (RATE // gps.rate)
    keep = float(np.exp(-1.0 / RATE / gps.memory))
    slow = lfilter([np.sqrt(1 - keep**2)], [1, -keep], rng.standard_normal(n + 500 * RATE))[
        500 * RATE :
    ]
    altitude = (
        height / (1.0 - height / EARTH) + gps.slow * slow + gps.white * rng.standard_normal(n)
    )
    sensed = velocity + gps.velocity * rng.standard_normal((3, n))
    return FlightLog(
        time=time,
        impact_pressure=indicated + given.impact * rng.standard_normal(n),
        static_pressure=static
        + (error if given.location == "static" else 0.0)
        + given.static * rng.standard_normal(n),
        velocity_north=sensed[0, fix],
        velocity_east=sensed[1, fix],
        velocity_down=sensed[2, fix] if gps.down else None,
        gps_fresh=np.arange(n) == fix,
        total_temperature=np.asarray(air.total_temperature(temperature, mach)),
        altitude=altitude[fix],
        header={"accuracy": EXACT, "priors": COLUMNS},
    )


def _indicated(impact: Array) -> Array:
    q = impact.copy()
    for _ in range(60):
        x = q / REFERENCE
        q = impact * (1.0 - (CURVE[0] + CURVE[1] * x + CURVE[2] / x))
    return q


def true_correction(indicated_airspeed: Array) -> Array:
    """Calibrated minus indicated airspeed [m/s]."""
    q = air.impact_pressure(indicated_airspeed)
    return air.calibrated_airspeed(q + true_error(q)) - indicated_airspeed


def true_error(indicated: Array) -> Array:
    """Δp [Pa] at an indicated impact pressure [Pa]."""
    x = indicated / REFERENCE
    f = CURVE[0] + CURVE[1] * x + CURVE[2] / x
    return indicated * f / (1.0 - f)


def without_height(log: FlightLog) -> FlightLog:
    """The same log without the receiver's height."""
    return replace(log, altitude=None)


def after_rest(log: FlightLog, seconds: float) -> FlightLog:
    """The log with so much time at rest before it, at the height at which it begins."""
    rng, n = np.random.default_rng(99), int(seconds * RATE)
    fix = (np.arange(n) // RATE) * RATE
    begins = float(np.mean(log.altitude[: 5 * RATE]))
    error = true_error(log.impact_pressure[: 5 * RATE]).mean()
    static = float(np.mean(log.static_pressure[: 5 * RATE])) - error
    rest = {
        "time": np.arange(n) / RATE,
        "impact_pressure": 2.0 + 12.0 * np.abs(rng.standard_normal(n)) * 0.1,
        "static_pressure": static + 10.0 * rng.standard_normal(n),
        "velocity_north": 0.02 * rng.standard_normal(n)[fix],
        "velocity_east": 0.02 * rng.standard_normal(n)[fix],
        "velocity_down": 0.05 * rng.standard_normal(n)[fix],
        "gps_fresh": np.arange(n) == fix,
        "total_temperature": np.full(n, 288.15 - 0.0065 * HEIGHT),
        "altitude": begins + 0.3 * rng.standard_normal(n)[fix],
    }
    channels = {
        name: np.concatenate([rest[name], values]) for name, values in log.channels().items()
    }
    channels["time"] = np.arange(len(channels["time"])) / RATE
    return FlightLog(**channels)


def one_heading(log):
    """The part of a flight that holds its first heading."""
    track = np.unwrap(np.arctan2(log.velocity_east, log.velocity_north))
    return log.select(np.arange(int(np.argmax(np.abs(track - track[0]) > 0.2))))
