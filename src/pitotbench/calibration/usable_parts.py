"""Find the parts of a flight that serve a calibration: in the air, away from take-off and landing, not steep."""

from dataclasses import dataclass

import numpy as np

from pitotbench import air
from pitotbench.records.log import FlightLog
from pitotbench.units import DEGREE, KNOT, Array, Booleans, Seconds

# On the ground and in ground effect the air data have errors of their own. After take-off and before landing the
# airplane flies with flaps or gear, through the shear of the lowest air. In steep flight the wind changes with
# height faster than turns can show it.

_FLYING = 0.45  # of the fast airspeed of the log: below it an airplane rolls, or stalls
_FAST = 0.9  # quantile of the airspeeds above 20 kt
_LEAST_AIRSPEED = 20.0 * KNOT
_AT_REST = 5.0 * KNOT  # over the ground and through the air: a log with such rows holds a take-off or a landing
_AFTER_TAKE_OFF, _BEFORE_LANDING = 60.0, 120.0  # s
_MOST_CUT = 0.25  # of a time in the air, at either end
_STEEP = 6.0 * DEGREE  # of the path, twice that of a usual approach
_OVER = 20.0  # s, over which the angle of the path is taken
_BRIEF = 30.0  # s: a shorter part between two others is of no use
GROUND, ENDS, STEEP = "taxi and roll", "take-off and landing", "steep climb or descent"


@dataclass(frozen=True, slots=True)
class UsableParts:
    """The usable rows of a log, (n,), and of each reason for leaving others out, its rows, (n,)."""

    rows: Booleans
    left_out: tuple[tuple[str, Booleans], ...]

    @property
    def reasons(self) -> tuple[str, ...]:
        """Why rows are left out."""
        return tuple(why for why, rows in self.left_out if rows.any())


def usable_parts(log: FlightLog) -> UsableParts:
    """Return the parts of a log that serve a calibration."""
    speed = air.calibrated_airspeed(np.maximum(log.impact_pressure, 0.0))
    flying = speed > _flying_airspeed(speed)
    grounded = bool(np.any((speed < _AT_REST) & (np.hypot(log.velocity_north, log.velocity_east) < _AT_REST)))
    ends = np.zeros(len(log), dtype=np.bool_)
    if grounded:
        for first, end in _runs(flying):
            time = log.time[first:end]
            most = _MOST_CUT * (time[-1] - time[0])
            ends[first:end] |= (time < time[0] + min(_AFTER_TAKE_OFF, most)) & (first > 0)
            ends[first:end] |= (time > time[-1] - min(_BEFORE_LANDING, most)) & (end < len(log))
    ground = ~flying if grounded else np.zeros(len(log), dtype=np.bool_)
    steep = ~ground & ~ends & (np.abs(path_angle(log)) > _STEEP)
    rows = ~(ground | ends | steep)
    for first, end in _runs(rows):
        if (first > 0 or end < len(log)) and log.time[end - 1] - log.time[first] < _BRIEF:
            rows[first:end] = False
    return UsableParts(rows, tuple((why, out) for why, out in ((GROUND, ground), (ENDS, ends), (STEEP, steep))))


def path_angle(log: FlightLog) -> Array:
    """Return the angle of the path through the air above the horizon, over 20 s about each row, (n,) [rad]."""
    pressure = np.maximum(log.static_pressure, 1.0)
    second = np.floor(log.time - log.time[0])
    edges = np.flatnonzero(np.diff(second, prepend=-1.0))
    middles = np.array([np.median(part) for part in np.split(pressure, edges[1:])])  # no spike is a climb
    height = air.pressure_altitude(np.interp(log.time, log.time[edges], middles))
    before, after = (np.clip(log.time + half, log.time[0], log.time[-1]) for half in (-0.5 * _OVER, 0.5 * _OVER))
    climb = (np.interp(after, log.time, height) - np.interp(before, log.time, height)) / (after - before)
    mach = air.mach_from_impact_pressure(np.maximum(log.impact_pressure, 0.0), pressure)
    airspeed = mach * np.sqrt(air.HEAT_RATIO * air.GAS_CONSTANT * air.standard_temperature(height))
    return np.arctan2(climb, np.maximum(airspeed, _LEAST_AIRSPEED))


def spans(time: Seconds, rows: Booleans) -> tuple[tuple[float, float], ...]:
    """Return the first and the last time of each part of marked rows [s]."""
    return tuple((float(time[first]), float(time[end - 1])) for first, end in _runs(rows))


def _flying_airspeed(speed: Array) -> float:
    fast = speed[speed > _LEAST_AIRSPEED]
    return _FLYING * float(np.quantile(fast, _FAST)) if len(fast) else 0.0


def _runs(rows: Booleans) -> list[tuple[int, int]]:
    """The first row of each run of marked rows, and the one after its last."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], rows, [False]])))
    return [(int(first), int(end)) for first, end in edges.reshape(-1, 2)]
