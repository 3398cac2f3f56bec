"""The mistakes of units and columns that people make in flight logs, each as a change to one good
log.

    python -m tests.lab.mistakes [--each] [--faults] [--maneuver circle]

spoils the log of a simulated flight (maneuver `circle`, air data at 20 Hz, GPS at 1 Hz) in every
way of `MISTAKES`, calibrates what can be read, holds the answer against the truth and prints how
many mistakes are refused, warned of, harmless, or accepted with a wrong answer. `--each` prints one
line a mistake as well. `--faults` takes those of `FAULTS` instead: sensors that fail in flight,
which a log often cannot show.
"""

import argparse
import sys
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pitotbench import air
from pitotbench.calibration import calibrate
from pitotbench.calibration.options import CalibrationOptions
from pitotbench.campaigns.flights import compare_curve, compare_wind, wind_toward
from pitotbench.channels import CHANNELS
from pitotbench.logbook.columns import Table
from pitotbench.logbook.reading import log_of
from pitotbench.records import BadInputError, NoAnswerError
from pitotbench.records.case import Case
from pitotbench.records.flight import Flight
from pitotbench.records.log import FlightLog
from pitotbench.sensing.recorder import record
from pitotbench.sensing.sampling import data_system
from pitotbench.simulation.sortie import fly
from pitotbench.units import KNOT

Columns = dict[str, NDArray[Any]]
Change = Callable[[Columns], Columns]
Rows = Iterator[tuple[tuple[str, ...], str, Change]]  # what a message may name, mistake, change

OUTCOMES = ("refused", "warned", "hidden", "silent", "unharmed", "no log can show it", "crashed")
_WRONG = 2.0  # times 2σ: an error of curve or wind above it makes the answer wrong
_ABSURD = 20.0  # kt: an answer so wrong must be refused; a warning above it hides it

# The size of each unit [SI]: written down again here, so that a wrong factor in the product shows.
PRESSURES = {
    "pa": 1.0, "hpa": 100.0, "kpa": 1000.0, "psi": 6894.757, "psf": 47.88026, "inhg": 3386.389, "mmhg": 133.3224,
    "inh2o": 249.0889, "mmh2o": 9.80665,
}  # fmt: skip
SPEEDS = {
    "mps": 1.0, "kt": 0.514444, "mph": 0.44704, "kmh": 1.0 / 3.6, "fps": 0.3048, "fpm": 0.00508, "cmps": 0.01,
    "mmps": 0.001,
}  # fmt: skip
FREEZING, RANKINE = 273.15, 1.8
NORTH, EAST = "velocity_north_mps", "velocity_east_mps"
IMPACT, STATIC, PROBE = "impact_pressure_pa", "static_pressure_pa", "total_temperature_k"
TOTAL = "total_pressure_pa"

ZERO = "a zero offset of a few percent looks like the pressure error that is sought"
WARM_DAY = "a day so much off the standard exists, and a probe may be off by as much in any log"
UNKNOWABLE = {  # by the name of the mistake: why no log can show it
    "impact +50 Pa": ZERO,
    "impact +200 Pa": ZERO,
    "impact as ½ρV²": "the two formulas differ by 1.5 % at this speed",
    "temperature +10 K": WARM_DAY,
    "temperature -20 K": WARM_DAY,
    "velocity x 1.02": "nothing else in a log measures the ground speed to a few percent",
}
UNUSED = "no reduction of speeds uses it"
FEW_ROWS = "the calibration refuses it: too few rows are usable"
PASSES = {  # by the name of the mistake: why reading lets it through, though the log could show it
    "clock: row number as s": "the curve uses the clock for the noise alone",
    "clock: x 2": "the curve uses the clock for the noise alone",
    "clock: min as s": "the calibration refuses it: the answer is not determined",
    "clock: every tenth row": FEW_ROWS,
    "clock: gps_fresh never true": FEW_ROWS,
    "angle_of_attack: rad written as °": UNUSED,
    "angle_of_attack with the wrong sign": UNUSED,
    "sideslip: ° written as rad": UNUSED,
    "sideslip: rad written as °": UNUSED,
    "mass lb as kg": UNUSED,
}


@dataclass(frozen=True, slots=True)
class Mistake:
    """A mistake: what it does to the columns, and the quantities that a message about it may name.

    `unknowable` says why no log can show it; `passes` why reading lets it through.
    """

    name: str
    change: Change
    names: tuple[str, ...]
    unknowable: str = ""

    @property
    def passes(self) -> str:
        return self.unknowable or PASSES.get(self.name, "")


@dataclass(frozen=True, slots=True)
class Outcome:
    """What became of one spoiled log; errors in kt and in times the stated 2σ."""

    mistake: Mistake
    kind: str
    says: str
    error_kt: float = 0.0
    ratio: float = 0.0
    wind_ratio: float = 0.0


def good_columns(log: FlightLog) -> Columns:
    """The columns of a log under their canonical names."""
    return {CHANNELS[name].column: values for name, values in log.channels().items()}


@cache
def flight(maneuver: str = "circle") -> Flight:
    """The good flight, flown once; seeds are those of the case's defaults."""
    return fly(Case(maneuver=maneuver, das=data_system("20/1")))


@cache
def log(maneuver: str = "circle") -> FlightLog:
    """The good log of it."""
    return record(flight(maneuver), data_system("20/1"), flight(maneuver).case.sensor_seed)


def read(columns: Columns) -> FlightLog:
    """The log that the product's reader makes of columns."""
    return log_of(Table(tuple(columns), tuple(columns.values()), {}, ()))


# Changes.


def rewrite(column: str, new: str, values: Callable[[NDArray[Any]], NDArray[Any]]) -> Change:
    """Write other values, perhaps under another name, in the place of a column."""
    return lambda t: {
        new if k == column else k: values(v) if k == column else v for k, v in t.items()
    }


def of(column: str, values: Callable[[NDArray[Any]], NDArray[Any]]) -> Change:
    """Write other values in the place of a column."""
    return rewrite(column, column, values)


def both(*changes: Change) -> Change:
    """One change after the other."""

    def run(table: Columns) -> Columns:
        for change in changes:
            table = change(table)
        return table

    return run


def level(change: Callable[..., Change], *sizes: float) -> Change:
    """A change of both level velocities."""
    return both(*(change(column, *sizes) for column in (NORTH, EAST)))


def scaled(column: str, factor: float, new: str = "") -> Change:
    return rewrite(column, new or column, lambda v: v * factor)


def shifted(column: str, offset: float, new: str = "") -> Change:
    return rewrite(column, new or column, lambda v: v + offset)


def velocity(true_unit: str, suffix: str) -> Change:
    """Both level velocities in one unit under the suffix of another."""
    factor = 1.0 / SPEEDS[true_unit]
    return both(*(scaled(c, factor, c.replace("mps", suffix)) for c in (NORTH, EAST)))


def swapped(one: str, other: str) -> Change:
    return lambda t: {**t, one: t[other], other: t[one]}


def with_total(t: Columns) -> Columns:
    """A log with total pressure in the place of impact pressure."""
    total = t[IMPACT] + t[STATIC]
    return {TOTAL if k == IMPACT else k: total if k == IMPACT else v for k, v in t.items()}


def computed(column: str, value: Callable[[Columns], NDArray[Any]]) -> Change:
    """Write what other columns give in the place of a column."""
    return lambda t: {**t, column: value(t)}


def mach(t: Columns) -> NDArray[Any]:
    return air.mach_from_impact_pressure(t[IMPACT], t[STATIC])


def sea_level(t: Columns) -> NDArray[Any]:
    """Static pressure as a weather service reports it (QNH)."""
    return t[STATIC] * air.SEA_LEVEL_PRESSURE / air.standard_pressure(t["altitude_m"])


def track(t: Columns) -> NDArray[Any]:
    return np.arctan2(t[EAST], t[NORTH])


def turned(angle: Callable[[Columns], Any]) -> Change:
    """Axes turned by an angle [rad]."""

    def run(t: Columns) -> Columns:
        c, s = np.cos(angle(t)), np.sin(angle(t))
        return {**t, NORTH: c * t[NORTH] + s * t[EAST], EAST: c * t[EAST] - s * t[NORTH]}

    return run


def second_half(column: str, factor: float) -> Change:
    return of(column, lambda v: v * np.where(np.arange(len(v)) < len(v) // 2, 1.0, factor))


def constant(column: str, value: float) -> Change:
    return of(column, lambda v: np.full_like(v, value))


def rows(choose: Callable[[int], NDArray[Any]]) -> Change:
    return lambda t: {k: v[choose(len(v))] for k, v in t.items()}


def celsius(v: NDArray[Any]) -> NDArray[Any]:
    return v - FREEZING


def fahrenheit(v: NDArray[Any]) -> NDArray[Any]:
    return celsius(v) * 1.8 + 32.0


def restarted(v: NDArray[Any]) -> NDArray[Any]:
    return np.where(np.arange(len(v)) < len(v) // 2, v, v - v[len(v) // 2])


def _pressures() -> Rows:
    """Pressures in one unit under the suffix of another that a log has long known."""
    exchanges = [(unit, "pa") for unit in PRESSURES if unit != "pa"]
    exchanges += [("pa", unit) for unit in ("hpa", "psf", "inhg", "psi")]
    exchanges += [("hpa", "psf"), ("psf", "hpa"), ("inhg", "psi"), ("psi", "inhg")]
    exchanges += [("mmhg", "hpa"), ("inh2o", "hpa")]
    for column in (IMPACT, STATIC, TOTAL):
        quantity = column.removesuffix("_pa")
        for unit, suffix in exchanges:
            change = scaled(column, 1.0 / PRESSURES[unit], f"{quantity}_{suffix}")
            change = both(with_total, change) if column == TOTAL else change
            yield (quantity,), f"{quantity}: {unit} written as {suffix}", change


def _velocities() -> Rows:
    units = [(unit, "mps") for unit in SPEEDS if unit not in ("mps", "fpm")]
    units += [(unit, "kt") for unit in ("mps", "mph", "kmh", "fps")]
    units += [(unit, "fps") for unit in ("mps", "kt", "kmh")]
    for one, other in units:
        yield V_NAMES, f"velocity {one} as {other}", velocity(one, other)


def _angles() -> Rows:
    """What the calibration does not use: harmless to its curve."""
    for name in ("roll", "pitch", "heading", "angle_of_attack", "sideslip"):
        column = f"{name}_rad"
        yield (name,), f"{name}: ° written as rad", scaled(column, 180.0 / np.pi)
        yield (name,), f"{name}: rad written as °", scaled(column, 1.0, f"{name}_deg")
    for name in ("roll", "pitch", "angle_of_attack"):
        yield (name,), f"{name} with the wrong sign", scaled(f"{name}_rad", -1.0)


Q, S, T = ("impact_pressure",), ("static_pressure",), ("total_temperature", "air_temperature")
V_NAMES = ("velocity_north", "velocity_east", "velocity_down", "heading")
CLOCK, HEIGHT, HEADING = "time_s", "altitude_m", "heading_rad"
DEGC, DEGF, DEGR = (f"total_temperature_deg{scale}" for scale in "cfr")
# By the quantities that a message may name: what people do, and its change.
TABLES: Mapping[tuple[str, ...], Mapping[str, Change]] = {
    Q: {
        "impact x 0.5": scaled(IMPACT, 0.5),
        "impact x 2": scaled(IMPACT, 2.0),
        "impact x 1.1": scaled(IMPACT, 1.1),
        "impact +50 Pa": shifted(IMPACT, 50.0),
        "impact +200 Pa": shifted(IMPACT, 200.0),
        "impact x 1.2 in the second half": second_half(IMPACT, 1.2),
        "impact in 12-bit counts": of(IMPACT, lambda v: np.round(v / 3.3665)),
        "impact as ½ρV²": computed(IMPACT, lambda t: 0.7 * t[STATIC] * mach(t) ** 2),
        "impact with the wrong sign": scaled(IMPACT, -1.0),
        "total in the impact column": computed(IMPACT, lambda t: t[IMPACT] + t[STATIC]),
        "airspeed (kt) in the impact column": of(
            IMPACT, lambda v: air.calibrated_airspeed(v) / KNOT
        ),
    },
    Q + S: {"impact and static exchanged": swapped(IMPACT, STATIC)},
    ("total_pressure",): {
        "total and static exchanged": both(with_total, swapped(TOTAL, STATIC)),
        "total +5 hPa": both(with_total, shifted(TOTAL, 500.0)),
    },
    S: {
        "static as total": computed(STATIC, lambda t: t[STATIC] + t[IMPACT]),
        "static x 1.05": scaled(STATIC, 1.05),
        "static reduced to sea level": computed(STATIC, sea_level),
        "static constant, 1013.25 hPa": constant(STATIC, 101325.0),
        "altitude (m) in the static column": computed(STATIC, lambda t: t[HEIGHT]),
        "altitude (ft) in the static column": computed(STATIC, lambda t: t[HEIGHT] / 0.3048),
    },
    T: {
        "temperature °C as K": of(PROBE, celsius),
        "temperature °F as K": of(PROBE, fahrenheit),
        "temperature °R as K": scaled(PROBE, RANKINE),
        "temperature K as °C": scaled(PROBE, 1.0, DEGC),
        "temperature K as °R": scaled(PROBE, 1.0, DEGR),
        "temperature K as °F": scaled(PROBE, 1.0, DEGF),
        "temperature °C as °R": rewrite(PROBE, DEGR, celsius),
        "temperature °F as °R": rewrite(PROBE, DEGR, fahrenheit),
        "temperature °F as °C": rewrite(PROBE, DEGC, fahrenheit),
        "temperature °C as °F": rewrite(PROBE, DEGF, celsius),
        "temperature +10 K": shifted(PROBE, 10.0),
        "temperature -20 K": shifted(PROBE, -20.0),
        "temperature constant 288.15 K": constant(PROBE, 288.15),
        "temperature constant 250 K": constant(PROBE, 250.0),
        "temperature of the air as total": computed(
            PROBE, lambda t: air.air_temperature(t[PROBE], mach(t))
        ),
        "temperature total as of the air": scaled(PROBE, 1.0, "air_temperature_k"),
    },
    V_NAMES: {
        "north alone in kt": scaled(NORTH, 1.0 / SPEEDS["kt"]),
        "east alone in kt": scaled(EAST, 1.0 / SPEEDS["kt"]),
        "velocity in kt from the middle on": level(second_half, 1.0 / SPEEDS["kt"]),
        "ground speed and track in north and east": lambda t: {
            **t, NORTH: np.hypot(t[NORTH], t[EAST]), EAST: np.degrees(track(t)) % 360.0,
        },
        "velocity x 1.02": level(scaled, 1.02),
        "north without sign": of(NORTH, np.abs),
        "north with the wrong sign": scaled(NORTH, -1.0),
        "east with the wrong sign": scaled(EAST, -1.0),
        "north and east with the wrong sign": level(scaled, -1.0),
        "north and east exchanged": swapped(NORTH, EAST),
        "axes turned by 12°": turned(lambda t: np.radians(12.0)),
        "east 0 in every row": scaled(EAST, 0.0),
        "altitude in velocity down": computed("velocity_down_mps", lambda t: t[HEIGHT]),
    },
    ("time", "gps_fresh"): {
        "clock: row number as s": of(CLOCK, lambda v: np.arange(1.0, len(v) + 1.0)),
        "clock: min as s": scaled(CLOCK, 1.0 / 60.0),
        "clock: h as s": scaled(CLOCK, 1.0 / 3600.0),
        "clock: s as ms": scaled(CLOCK, 1.0, "time_ms"),
        "clock: ms as s": scaled(CLOCK, 1e3),
        "clock: µs as s": scaled(CLOCK, 1e6),
        "clock: x 2": scaled(CLOCK, 2.0),
        "clock: rounded to 1 s": of(CLOCK, np.round),
        "clock: epoch in single precision": of(
            CLOCK, lambda v: np.float64(np.float32(v + 1.7e9))
        ),
        "clock: restarted in the middle": of(CLOCK, restarted),
        "clock: rows reversed": rows(lambda n: np.arange(n)[::-1]),
        "clock: rows doubled": rows(lambda n: np.repeat(np.arange(n), 2)),
        "clock: rows shuffled": rows(np.random.default_rng(5).permutation),
        "clock: every tenth row": rows(lambda n: np.arange(0, n, 10)),
        "clock: gps_fresh never true": computed(
            "gps_fresh", lambda t: np.zeros(len(t[CLOCK]), dtype=np.bool_)
        ),
    },
    ("heading",): {
        "heading magnetic, 12° off": of(
            HEADING, lambda v: (v - np.radians(12.0)) % (2.0 * np.pi)
        ),
        "heading is the track": computed(HEADING, lambda t: track(t) % (2.0 * np.pi)),
    },
    ("altitude",): {
        "altitude ft as m": scaled(HEIGHT, 1.0 / 0.3048),
        "altitude m as ft": scaled(HEIGHT, 1.0, "altitude_ft"),
    },
    ("mass",): {"mass lb as kg": scaled("mass_kg", 2.20462)},
}  # fmt: skip


def _mistakes() -> Iterator[Mistake]:
    written = [(names, *row) for names, table in TABLES.items() for row in table.items()]
    for names, name, change in (*_pressures(), *_velocities(), *_angles(), *written):
        yield Mistake(name, change, names, UNKNOWABLE.get(name, ""))


MISTAKES: Mapping[str, Mistake] = {mistake.name: mistake for mistake in _mistakes()}


# Sensors and recorders that fail in flight, each at a size that harms. What a message may name is a
# stem of words.


def along(v: NDArray[Any]) -> NDArray[Any]:
    """0 in the first row to 1 in the last."""
    return np.linspace(0.0, 1.0, len(v))


def ramp(column: str, size: float) -> Change:
    """An error that grows from nothing to a size at the end."""
    return of(column, lambda v: v + size * along(v))


def gain(column: str, first: float, last: float, begin: float = 0.0, end: float = 1.0) -> Change:
    """A factor that goes from one value to another within a part of the log, and is 1 outside it."""

    def values(v: NDArray[Any]) -> NDArray[Any]:
        share = np.clip((along(v) - begin) / max(end - begin, 1e-9), 0.0, 1.0)
        inside = (along(v) >= begin) & (along(v) <= end)
        return v * np.where(inside, first + (last - first) * share, 1.0)

    return of(column, values)


def step(column: str, size: float) -> Change:
    return of(column, lambda v: v + size * (along(v) > 0.45))


def frozen(column: str, begin: float, seconds: float) -> Change:
    """A value that stands for some time; rows come 20 times a second."""

    def values(v: NDArray[Any]) -> NDArray[Any]:
        first = int(begin * len(v))
        held = v.copy()
        held[first : first + int(20 * seconds)] = v[first]
        return held

    return of(column, values)


def slow(column: str, seconds: float) -> Change:
    """A first-order lag."""

    def values(v: NDArray[Any]) -> NDArray[Any]:
        share, out = 1.0 / (1.0 + 20.0 * seconds), v.copy()
        for row in range(1, len(v)):
            out[row] = out[row - 1] + share * (v[row] - out[row - 1])
        return out

    return of(column, values)


def late(column: str, seconds: float) -> Change:
    """Values that come so much later; earlier where it is negative."""

    def values(v: NDArray[Any]) -> NDArray[Any]:
        rows = np.clip(np.arange(len(v)) - int(20 * seconds), 0, len(v) - 1)
        return v[rows]

    return of(column, values)


def coarse(column: str, size: float) -> Change:
    return of(column, lambda v: np.round(v / size) * size)


def from_heading(north: float, east: float) -> Change:
    """The velocity made of airspeed and heading, with a wind that someone typed."""

    def run(t: Columns) -> Columns:
        speed = mach(t) * air.sound_speed(air.air_temperature(t[PROBE], mach(t)))
        toward = {NORTH: np.cos(t[HEADING]), EAST: np.sin(t[HEADING])}
        return {**t, NORTH: speed * toward[NORTH] + north, EAST: speed * toward[EAST] + east}

    return run


def in_turns(column: str, factor: float) -> Change:
    return lambda t: {**t, column: t[column] * np.where(np.abs(t["roll_rad"]) > 0.25, factor, 1.0)}


def pasted_twice(t: Columns) -> Columns:
    lasting = t[CLOCK][-1] - t[CLOCK][0] + 1.0
    twice = {k: np.concatenate([v, v]) for k, v in t.items()}
    return twice | {CLOCK: np.concatenate([t[CLOCK], t[CLOCK] + lasting])}


Q_WORDS = ("impact_pressure", "impact pressure", "samples near")
S_WORDS = ("static_pressure", "static pressure", "height", "altitude")
T_WORDS = ("temperature", "recovery")
V_WORDS = ("velocity", "GPS", "latency", "wind", "axes", "heading", "ground")
C_WORDS = ("clock", "time", "latency", "trail", *V_WORDS)

LEVEL_SCALE = "in level flight a factor of the airspeed is one of q_c: the error that is sought"
EACH_ONCE = "each speed is flown once: an error that goes with time is one that goes with speed"
A_LEAK = "a share of q_c that goes with time, on a card that goes through its speeds in time"
WEATHER = "the pressure of the day, and the static error that the altitude cannot tell from it"
AT_A_CHANGE = "it falls on a change of the speed flown: a factor for each speed is a curve"
IN_TIME = (EACH_ONCE, A_LEAK, AT_A_CHANGE)  # not on a card that flies a speed twice
A_WIND = "a velocity that drifts is a wind that drifts"
ONE_AXIS = "nothing else in a log measures one component of the ground velocity to a few percent"

_FAULTS: list[tuple[str, Change, tuple[str, ...], str]] = [
    ("pitot ices x 0.85 in the last quarter", gain(IMPACT, 0.85, 0.85, 0.75), Q_WORDS, ""),
    ("pitot ices slowly to x 0.85 in the last "
     "third", gain(IMPACT, 1.0, 0.85, 0.66), Q_WORDS, A_LEAK),
    ("pitot x 0.95 in the first third", gain(IMPACT, 0.95, 0.95, 0.0, 0.33), Q_WORDS, ""),
    ("pitot x 0.92 for 60 s", gain(IMPACT, 0.92, 0.92, 0.5, 0.62), Q_WORDS, ""),
    ("q_c zero drifts by -100 Pa", ramp(IMPACT, -100.0), Q_WORDS, EACH_ONCE),
    ("q_c zero drifts by +60 Pa", ramp(IMPACT, 60.0), Q_WORDS, EACH_ONCE),
    ("q_c zero steps by +60 Pa", step(IMPACT, 60.0), Q_WORDS, EACH_ONCE),
    ("q_c zero steps by -120 Pa", step(IMPACT, -120.0), Q_WORDS, ""),
    (
        "q_c zero follows the temperature",
        lambda t: {**t, IMPACT: t[IMPACT] + 12.0 * (t[PROBE] - np.mean(t[PROBE])) + 40.0 * along(t[PROBE])},
        Q_WORDS, EACH_ONCE,
    ),
    ("total line leaks to -8 %", gain(IMPACT, 1.0, 0.92), Q_WORDS, A_LEAK),
    ("total line leaks to -4 %", gain(IMPACT, 1.0, 0.96), Q_WORDS, A_LEAK),
    ("q_c x 1.04 from the middle on", gain(IMPACT, 1.04, 1.04, 0.5), Q_WORDS, AT_A_CHANGE),
    ("q_c x 0.95 in turns", in_turns(IMPACT, 0.95), Q_WORDS, ""),
    ("q_c frozen for 40 s", frozen(IMPACT, 0.3, 40.0), Q_WORDS, ""),
    ("q_c in steps of 150 Pa", coarse(IMPACT, 150.0), Q_WORDS, ""),
    ("q_c in steps of 400 Pa", coarse(IMPACT, 400.0), Q_WORDS, ""),
    ("q_c lags by 3 s", slow(IMPACT, 3.0), (*Q_WORDS, *C_WORDS), ""),
    ("q_c ends at its 80 % quantile", of(IMPACT, lambda v: np.minimum(v, np.quantile(v, 0.8))), Q_WORDS, ""),
    ("q_c 0 each 30 s", of(IMPACT, lambda v: np.where(np.arange(len(v)) % 600 < 8, 0.0, v)), Q_WORDS, ""),
    ("q_c of the flight backwards", of(IMPACT, lambda v: v[::-1]), (*Q_WORDS, *V_WORDS), ""),
    ("q_c to the power 1.02", of(IMPACT, lambda v: v**1.02 / np.mean(v) ** 0.02), Q_WORDS, LEVEL_SCALE),
    ("static leaks +100 Pa", ramp(STATIC, 100.0), S_WORDS, ""),
    ("static leaks -100 Pa", ramp(STATIC, -100.0), S_WORDS, ""),
    ("static leaks +400 Pa", ramp(STATIC, 400.0), S_WORDS, ""),
    ("static steps by 150 Pa", step(STATIC, 150.0), S_WORDS, ""),
    ("static lags by 8 s", slow(STATIC, 8.0), S_WORDS, ""),
    ("static frozen for 60 s", frozen(STATIC, 0.3, 60.0), S_WORDS, ""),
    ("static in steps of 200 Pa", coarse(STATIC, 200.0), S_WORDS, ""),
    ("static of 1030 hPa", scaled(STATIC, 1030.0 / 1013.25), S_WORDS, WEATHER),
    ("static of 995 hPa", scaled(STATIC, 995.0 / 1013.25), S_WORDS, WEATHER),
    ("static x 0.97", scaled(STATIC, 0.97), S_WORDS, WEATHER),
    ("T -15 K", shifted(PROBE, -15.0), T_WORDS, LEVEL_SCALE),
    ("T +15 K", shifted(PROBE, 15.0), T_WORDS, LEVEL_SCALE),
    ("T drifts by -15 K", ramp(PROBE, -15.0), T_WORDS, EACH_ONCE),
    ("T drifts by +10 K", ramp(PROBE, 10.0), T_WORDS, EACH_ONCE),
    ("T of the cabin", of(PROBE, lambda v: 294.0 + np.sin(4.0 * along(v))), T_WORDS, LEVEL_SCALE),
    ("T frozen", of(PROBE, lambda v: np.full_like(v, v[0])), T_WORDS, ""),
    ("T lags by 60 s", slow(PROBE, 60.0), T_WORDS, ""),
    ("T in steps of 5 K", coarse(PROBE, 5.0), T_WORDS, ""),
    ("T with the wrong sign of °C", of(PROBE, lambda v: 2.0 * FREEZING - v), T_WORDS, ""),
    ("T twice in °C", of(PROBE, lambda v: FREEZING + 2.0 * (v - FREEZING)), T_WORDS, LEVEL_SCALE),
    ("GPS smoothed over 5 s", level(slow, 5.0), C_WORDS, ""),
    ("GPS 1.5 s late", level(late, 1.5), C_WORDS, ""),
    ("GPS 3 s late", level(late, 3.0), C_WORDS, ""),
    ("GPS 1 s early", level(late, -1.0), C_WORDS, ""),
    ("east 2 s later than north", late(EAST, 2.0), C_WORDS, ""),
    ("north x 1.03", scaled(NORTH, 1.03), V_WORDS, ONE_AXIS),
    ("east x 0.94", scaled(EAST, 0.94), V_WORDS, ""),
    ("velocity frozen for 30 s", level(frozen, 0.4, 30.0), V_WORDS, ""),
    ("velocity in steps of 5 m/s", level(coarse, 5.0), V_WORDS, ""),
    ("axes turned by 7°", turned(lambda t: np.radians(7.0)), V_WORDS, ""),
    ("east drifts by 4 m/s", ramp(EAST, 4.0), V_WORDS, A_WIND),
    (
        "velocity x 0.97 from the middle on", level(gain, 0.97, 0.97, 0.5),
        (*V_WORDS, *Q_WORDS), AT_A_CHANGE,
    ),
    ("velocity of airspeed and heading", from_heading(0.0, 0.0), V_WORDS, ""),
    ("velocity of airspeed, heading and a typed wind", from_heading(5.0, -3.0), V_WORDS, ""),
    ("velocity in body axes", turned(lambda t: t[HEADING]), V_WORDS, ""),
    ("east ends at 55 m/s", of(EAST, lambda v: np.clip(v, -55.0, 55.0)), V_WORDS, ""),
    ("the log pasted twice", pasted_twice, C_WORDS, ""),
    (
        "pressure height as geometric "
        "height", lambda t: {**t, "altitude_m": air.pressure_altitude(t[STATIC])},
        S_WORDS, "a height of the static pressure fits it",
    ),
    ("height x 1.03", scaled("altitude_m", 1.03), S_WORDS, ""),
]  # fmt: skip
FAULTS: Mapping[str, Mistake] = {
    name: Mistake(name, change, names, why) for name, change, names, why in _FAULTS
}


def check(mistake: Mistake, maneuver: str = "circle") -> tuple[FlightLog | None, str]:
    """Read the spoiled log: the log, or None where it is refused, and what was said about it."""
    try:
        found = read(mistake.change(good_columns(log(maneuver))))
    except BadInputError as error:
        return None, str(error)
    return found, " | ".join(found.header.get("warnings", ()))


def judge(mistake: Mistake, maneuver: str = "circle", wind: str = "constant") -> Outcome:
    """Read and calibrate the spoiled log, and hold the answer against the truth."""
    try:
        spoiled, says = check(mistake, maneuver)
        if spoiled is None:
            return Outcome(mistake, "refused", says)
        found = calibrate(spoiled, CalibrationOptions(latency="checked", wind=wind))
        if any(each.kind == "scale" for each in found.disagreements):
            return Outcome(mistake, "refused", found.disagreements[0].words)
    except (BadInputError, NoAnswerError) as error:
        return Outcome(mistake, "refused", str(error))
    except Exception as error:  # a traceback is an outcome of its kind
        return Outcome(mistake, "crashed", f"{type(error).__name__}: {error}")
    headlines = (each.words for each in found.disagreements)
    # What the tracks of a flight leave open is no word on its columns.
    told = (str(each) for each in found.warnings if each.code != "turns to one side")
    said = dict.fromkeys([*headlines, *map(str, spoiled.header.get("warnings", ())), *told])
    case = flight(maneuver).case
    curve = compare_curve(found.curve, case.pressure_error)
    of_wind = compare_wind(found.wind, wind_toward(case.wind)[:2])
    size = np.abs(curve.error)
    ratio = float(np.max(size / curve.two_sigma))
    wind_ratio = float(np.linalg.norm(of_wind.error) / np.linalg.norm(of_wind.two_sigma))
    return _kind(mistake, " | ".join(said), float(np.max(size)) / KNOT, ratio, wind_ratio, maneuver)


def _kind(
    mistake: Mistake, says: str, error_kt: float, ratio: float, wind: float, maneuver: str
) -> Outcome:
    warned = any(name in says for name in mistake.names)
    if warned:
        kind = "hidden" if error_kt > _ABSURD else "warned"
    elif ratio <= _WRONG and wind <= _WRONG:
        kind = "unharmed"
    elif mistake.unknowable and (maneuver == "circle" or mistake.unknowable not in IN_TIME):
        kind = "no log can show it"
    else:
        kind = "hidden" if says else "silent"
    return Outcome(mistake, kind, says, error_kt, ratio, wind)


def main(arguments: Sequence[str] | None = None) -> int:
    """Judge; return 0 where nothing is accepted wrong in silence or hidden below a warning."""
    parser = argparse.ArgumentParser(prog="python -m tests.lab.mistakes", description=__doc__)
    add = parser.add_argument
    add("--each", action="store_true", help="one line a mistake")
    add("--faults", action="store_true", help="sensors that fail in flight")
    add("--maneuver", default="circle", help="of the good log (default: %(default)s)")
    choice = parser.parse_args(arguments)
    count: Counter[str] = Counter()
    for mistake in (FAULTS if choice.faults else MISTAKES).values():
        found = judge(mistake, choice.maneuver, "checked" if choice.faults else "constant")
        count[found.kind] += 1
        if choice.each:
            numbers = f"{found.error_kt:8.2f} kt {found.ratio:8.1f} {found.wind_ratio:8.1f}"
            print(f"{found.kind:<18} {numbers}  {mistake.name}: {found.says}", flush=True)
    told = ", ".join(f"{kind} {count[kind]}" for kind in OUTCOMES)
    print(f"{count.total()} mistakes: {told}")
    return 1 if count["silent"] or count["hidden"] or count["crashed"] else 0


if __name__ == "__main__":
    sys.exit(main())
