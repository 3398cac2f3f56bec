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
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
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

ZERO = "a zero offset of a few percent looks like the pressure error that is sought"
WARM_DAY = (
    "a day so much warmer or colder than standard exists, and a probe may be off by as "
    "much in any log"
)
MACH_SMALL = "the two formulas differ by 1.5 % at this speed"
ONE_RECEIVER = "nothing else in a log measures the ground speed to a few percent"


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
    return {
        "total_pressure_pa" if k == IMPACT else k: total if k == IMPACT else v for k, v in t.items()
    }


def reduced_to_sea_level(t: Columns) -> Columns:
    """Static pressure as a weather service reports it (QNH)."""
    factor = air.SEA_LEVEL_PRESSURE / air.standard_pressure(t["altitude_m"])
    return {**t, STATIC: t[STATIC] * factor}


def incompressible(t: Columns) -> Columns:
    mach = air.mach_from_impact_pressure(t[IMPACT], t[STATIC])
    return {**t, IMPACT: 0.7 * t[STATIC] * mach**2}


def air_as_probe(t: Columns) -> Columns:
    mach = air.mach_from_impact_pressure(t[IMPACT], t[STATIC])
    return {**t, PROBE: air.air_temperature(t[PROBE], mach)}


def speed_and_track(t: Columns) -> Columns:
    """Ground speed [m/s] and track [deg] in the columns of north and east."""
    track = np.degrees(np.arctan2(t[EAST], t[NORTH])) % 360.0
    return {**t, NORTH: np.hypot(t[NORTH], t[EAST]), EAST: track}


def turned(degrees: float) -> Change:
    """Axes turned, as by the magnetic variation."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return lambda t: {**t, NORTH: c * t[NORTH] + s * t[EAST], EAST: c * t[EAST] - s * t[NORTH]}


def second_half(column: str, factor: float) -> Change:
    return of(column, lambda v: v * np.where(np.arange(len(v)) < len(v) // 2, 1.0, factor))


def rows(choose: Callable[[int], NDArray[Any]]) -> Change:
    return lambda t: {k: v[choose(len(v))] for k, v in t.items()}


def _pressures() -> list[Mistake]:
    """Pressures in one unit under the suffix of another that a log has long known."""
    found = []
    exchanges = [(unit, "pa") for unit in PRESSURES if unit != "pa"]
    exchanges += [
        ("pa", "hpa"),
        ("pa", "psf"),
        ("pa", "inhg"),
        ("pa", "psi"),
        ("hpa", "psf"),
        ("psf", "hpa"),
    ]
    exchanges += [("inhg", "psi"), ("psi", "inhg"), ("mmhg", "hpa"), ("inh2o", "hpa")]
    for column in (IMPACT, STATIC, "total_pressure_pa"):
        first: tuple[Change, ...] = (with_total,) if column.startswith("total") else ()
        for unit, suffix in exchanges:
            change = both(
                *first, scaled(column, 1.0 / PRESSURES[unit], column.replace("_pa", f"_{suffix}"))
            )
            quantity = column.removesuffix("_pa")
            found.append(Mistake(f"{quantity}: {unit} written as {suffix}", change, (quantity,)))
    return found


def _pressure_columns() -> list[Mistake]:
    impact, static, total = ("impact_pressure",), ("static_pressure",), ("total_pressure",)
    return [
        Mistake("impact x 0.5", scaled(IMPACT, 0.5), impact),
        Mistake("impact x 2", scaled(IMPACT, 2.0), impact),
        Mistake("impact x 1.1", scaled(IMPACT, 1.1), impact),
        Mistake("impact +50 Pa", shifted(IMPACT, 50.0), impact, ZERO),
        Mistake("impact +200 Pa", shifted(IMPACT, 200.0), impact, ZERO),
        Mistake("impact x 1.2 in the second half", second_half(IMPACT, 1.2), impact),
        Mistake("impact in 12-bit counts", of(IMPACT, lambda v: np.round(v / 3.3665)), impact),
        Mistake("impact as ½ρV²", incompressible, impact, MACH_SMALL),
        Mistake("impact with the wrong sign", scaled(IMPACT, -1.0), impact),
        Mistake(
            "total in the impact column", lambda t: {**t, IMPACT: t[IMPACT] + t[STATIC]}, impact
        ),
        Mistake(
            "airspeed (kt) in the impact column",
            of(IMPACT, lambda v: air.calibrated_airspeed(v) / KNOT),
            impact,
        ),
        Mistake("impact and static exchanged", swapped(IMPACT, STATIC), impact + static),
        Mistake(
            "total and static exchanged",
            both(with_total, swapped("total_pressure_pa", STATIC)),
            total,
        ),
        Mistake("total +5 hPa", both(with_total, shifted("total_pressure_pa", 500.0)), total),
        Mistake("static as total", lambda t: {**t, STATIC: t[STATIC] + t[IMPACT]}, static),
        Mistake("static x 1.05", scaled(STATIC, 1.05), static),
        Mistake("static reduced to sea level", reduced_to_sea_level, static),
        Mistake(
            "static constant, 1013.25 hPa", of(STATIC, lambda v: np.full_like(v, 101325.0)), static
        ),
        Mistake(
            "altitude (m) in the static column", lambda t: {**t, STATIC: t["altitude_m"]}, static
        ),
        Mistake(
            "altitude (ft) in the static column",
            lambda t: {**t, STATIC: t["altitude_m"] / 0.3048},
            static,
        ),
    ]


def _temperatures() -> list[Mistake]:
    from_kelvin = partial(rewrite, PROBE)
    degc, degf, degr = "total_temperature_degc", "total_temperature_degf", "total_temperature_degr"

    def celsius(v: NDArray[Any]) -> NDArray[Any]:
        return v - FREEZING

    def fahrenheit(v: NDArray[Any]) -> NDArray[Any]:
        return celsius(v) * 1.8 + 32.0

    table: list[tuple[str, Change, str]] = [
        ("°C as K", from_kelvin(PROBE, celsius), ""),
        ("°F as K", from_kelvin(PROBE, fahrenheit), ""),
        ("°R as K", scaled(PROBE, RANKINE), ""),
        ("K as °C", scaled(PROBE, 1.0, degc), ""),
        ("K as °R", scaled(PROBE, 1.0, degr), ""),
        ("K as °F", scaled(PROBE, 1.0, degf), ""),
        ("°C as °R", from_kelvin(degr, celsius), ""),
        ("°F as °R", from_kelvin(degr, fahrenheit), ""),
        ("°F as °C", from_kelvin(degc, fahrenheit), ""),
        ("°C as °F", from_kelvin(degf, celsius), ""),
        ("+10 K", shifted(PROBE, 10.0), WARM_DAY),
        ("-20 K", shifted(PROBE, -20.0), WARM_DAY),
        ("constant 288.15 K", from_kelvin(PROBE, lambda v: np.full_like(v, 288.15)), ""),
        ("constant 250 K", from_kelvin(PROBE, lambda v: np.full_like(v, 250.0)), ""),
        ("of the air as total", air_as_probe, ""),
        ("total as of the air", rewrite(PROBE, "air_temperature_k", lambda v: v), ""),
    ]
    names = ("total_temperature", "air_temperature")
    return [Mistake(f"temperature {name}", change, names, why) for name, change, why in table]


def _velocities() -> list[Mistake]:
    units = [(unit, "mps") for unit in SPEEDS if unit not in ("mps", "fpm")]
    units += [(unit, "kt") for unit in ("mps", "mph", "kmh", "fps")]
    units += [(unit, "fps") for unit in ("mps", "kt", "kmh")]
    found = [(f"velocity {a} as {b}", velocity(a, b), "") for a, b in units]
    found += [
        ("north alone in kt", scaled(NORTH, 1.0 / SPEEDS["kt"]), ""),
        ("east alone in kt", scaled(EAST, 1.0 / SPEEDS["kt"]), ""),
        ("velocity in kt from the middle on", level(second_half, 1.0 / SPEEDS["kt"]), ""),
        ("ground speed and track in north and east", speed_and_track, ""),
        ("velocity x 1.02", level(scaled, 1.02), ONE_RECEIVER),
        ("north without sign", of(NORTH, np.abs), ""),
        ("north with the wrong sign", scaled(NORTH, -1.0), ""),
        ("east with the wrong sign", scaled(EAST, -1.0), ""),
        ("north and east with the wrong sign", level(scaled, -1.0), ""),
        ("north and east exchanged", swapped(NORTH, EAST), ""),
        ("axes turned by 12°", turned(12.0), ""),
        ("east 0 in every row", scaled(EAST, 0.0), ""),
        ("altitude in velocity down", lambda t: {**t, "velocity_down_mps": t["altitude_m"]}, ""),
    ]
    names = ("velocity_north", "velocity_east", "velocity_down", "heading")
    return [Mistake(name, change, names, why) for name, change, why in found]


def _clocks() -> list[Mistake]:
    clock = "time_s"

    def restarted(v: NDArray[Any]) -> NDArray[Any]:
        return np.where(np.arange(len(v)) < len(v) // 2, v, v - v[len(v) // 2])

    shuffle = np.random.default_rng(5)
    table: list[tuple[str, Change]] = [
        ("row number as s", of(clock, lambda v: np.arange(1.0, len(v) + 1.0))),
        ("min as s", scaled(clock, 1.0 / 60.0)),
        ("h as s", scaled(clock, 1.0 / 3600.0)),
        ("s as ms", scaled(clock, 1.0, "time_ms")),
        ("ms as s", scaled(clock, 1e3)),
        ("µs as s", scaled(clock, 1e6)),
        ("x 2", scaled(clock, 2.0)),
        ("rounded to 1 s", of(clock, np.round)),
        ("epoch in single precision", of(clock, lambda v: np.float64(np.float32(v + 1.7e9)))),
        ("restarted in the middle", of(clock, restarted)),
        ("rows reversed", rows(lambda n: np.arange(n)[::-1])),
        ("rows doubled", rows(lambda n: np.repeat(np.arange(n), 2))),
        ("rows shuffled", rows(shuffle.permutation)),
        ("every tenth row", rows(lambda n: np.arange(0, n, 10))),
        (
            "gps_fresh never true",
            lambda t: {**t, "gps_fresh": np.zeros(len(t[clock]), dtype=np.bool_)},
        ),
    ]
    return [Mistake(f"clock: {name}", change, ("time", "gps_fresh")) for name, change in table]


def _others() -> list[Mistake]:
    """What the calibration does not use: harmless to its curve."""
    found: list[Mistake] = []
    for name in ("roll", "pitch", "heading", "angle_of_attack", "sideslip"):
        column = f"{name}_rad"
        degrees = 180.0 / np.pi
        found.append(Mistake(f"{name}: ° written as rad", scaled(column, degrees), (name,)))
        found.append(
            Mistake(f"{name}: rad written as °", scaled(column, 1.0, f"{name}_deg"), (name,))
        )
    for name in ("roll", "pitch", "angle_of_attack"):
        found.append(Mistake(f"{name} with the wrong sign", scaled(f"{name}_rad", -1.0), (name,)))
    magnetic = of("heading_rad", lambda v: (v - np.radians(12.0)) % (2.0 * np.pi))
    found.append(Mistake("heading magnetic, 12° off", magnetic, ("heading",)))
    found.append(
        Mistake(
            "heading is the track",
            lambda t: {**t, "heading_rad": np.arctan2(t[EAST], t[NORTH]) % (2.0 * np.pi)},
            ("heading",),
        )
    )
    found.append(Mistake("altitude ft as m", scaled("altitude_m", 1.0 / 0.3048), ("altitude",)))
    found.append(
        Mistake("altitude m as ft", scaled("altitude_m", 1.0, "altitude_ft"), ("altitude",))
    )
    found.append(Mistake("mass lb as kg", scaled("mass_kg", 2.20462), ("mass",)))
    return found


MISTAKES: Mapping[str, Mistake] = {
    m.name: m
    for m in (
        *_pressures(),
        *_pressure_columns(),
        *_temperatures(),
        *_velocities(),
        *_clocks(),
        *_others(),
    )
}


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
        mach = air.mach_from_impact_pressure(t[IMPACT], t[STATIC])
        speed = mach * air.sound_speed(air.air_temperature(t[PROBE], mach))
        return {
            **t,
            NORTH: speed * np.cos(t["heading_rad"]) + north,
            EAST: speed * np.sin(t["heading_rad"]) + east,
        }

    return run


def in_body_axes(t: Columns) -> Columns:
    c, s = np.cos(t["heading_rad"]), np.sin(t["heading_rad"])
    return {**t, NORTH: c * t[NORTH] + s * t[EAST], EAST: c * t[EAST] - s * t[NORTH]}


def in_turns(column: str, factor: float) -> Change:
    return lambda t: {**t, column: t[column] * np.where(np.abs(t["roll_rad"]) > 0.25, factor, 1.0)}


def pasted_twice(t: Columns) -> Columns:
    clock = "time_s"
    lasting = t[clock][-1] - t[clock][0] + 1.0
    both = {k: np.concatenate([v, v]) for k, v in t.items()}
    both[clock] = np.concatenate([t[clock], t[clock] + lasting])
    return both


Q_WORDS = ("impact_pressure", "impact pressure", "samples near")
S_WORDS = ("static_pressure", "static pressure", "height", "altitude")
T_WORDS = ("temperature", "recovery")
V_WORDS = ("velocity", "GPS", "latency", "wind", "axes", "heading", "ground")
C_WORDS = ("clock", "time", "latency", "trail", *V_WORDS)

LEVEL_SCALE = (
    "in level flight a factor of the airspeed is a factor of q_c, which is the pressure "
    "error that is sought"
)
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
    ("axes turned by 7°", turned(7.0), V_WORDS, ""),
    ("east drifts by 4 m/s", ramp(EAST, 4.0), V_WORDS, A_WIND),
    (
        "velocity x 0.97 from the middle on", level(gain, 0.97, 0.97, 0.5),
        (*V_WORDS, *Q_WORDS), AT_A_CHANGE,
    ),
    ("velocity of airspeed and heading", from_heading(0.0, 0.0), V_WORDS, ""),
    ("velocity of airspeed, heading and a typed wind", from_heading(5.0, -3.0), V_WORDS, ""),
    ("velocity in body axes", in_body_axes, V_WORDS, ""),
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
    said = dict.fromkeys(
        [*headlines, *map(str, spoiled.header.get("warnings", ())), *map(str, found.warnings)]
    )
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
    parser = argparse.ArgumentParser(
        prog="python -m tests.lab.mistakes", description=__doc__.split("\n")[0]
    )
    parser.add_argument("--each", action="store_true", help="one line a mistake")
    parser.add_argument(
        "--faults",
        action="store_true",
        help="sensors that fail in flight, as the command calibrates",
    )
    parser.add_argument(
        "--maneuver", default="circle", help="of the good log (default: %(default)s)"
    )
    choice = parser.parse_args(arguments)
    found = []
    for mistake in (FAULTS if choice.faults else MISTAKES).values():
        begun = time.perf_counter()
        outcome = judge(mistake, choice.maneuver, "checked" if choice.faults else "constant")
        found.append(outcome)
        if choice.each:
            numbers = f"{outcome.error_kt:8.2f} kt {outcome.ratio:8.1f} {outcome.wind_ratio:8.1f}"
            lasted = time.perf_counter() - begun
            print(
                f"{outcome.kind:<18} {numbers} {lasted:5.1f} s  {mistake.name}: {outcome.says}",
                flush=True,
            )
    count = Counter(outcome.kind for outcome in found)
    print(f"{len(found)} mistakes: " + ", ".join(f"{kind} {count[kind]}" for kind in OUTCOMES))
    return 1 if count["silent"] or count["hidden"] or count["crashed"] else 0


if __name__ == "__main__":
    sys.exit(main())
