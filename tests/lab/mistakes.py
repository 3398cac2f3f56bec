"""The mistakes of units and columns that people make in flight logs, each as a change to one good log.

    python -m tests.lab.mistakes [--each]

spoils the log of a simulated flight (maneuver `circle`, air data at 20 Hz, GPS at 1 Hz) in every way of `MISTAKES`,
calibrates what can be read, holds the answer against the truth and prints how many mistakes are refused, warned
of, harmless, or accepted with a wrong answer. `--each` prints one line a mistake as well.
"""

import argparse
import sys
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pitotbench import air
from pitotbench.bench.flights import compare_curve, compare_wind, wind_toward
from pitotbench.calibration import calibrate
from pitotbench.calibration.options import CalibrationOptions
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
WARM_DAY = "a day so much warmer or colder than standard exists, and a probe may be off by as much in any log"
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
def flight() -> Flight:
    """The good flight, flown once; seeds are those of the case's defaults."""
    return fly(Case(maneuver="circle", das=data_system("20/1")))


@cache
def log() -> FlightLog:
    """The good log of it."""
    return record(flight(), data_system("20/1"), flight().case.sensor_seed)


def read(columns: Columns) -> FlightLog:
    """The log that the product's reader makes of columns."""
    return log_of(Table(tuple(columns), tuple(columns.values()), {}, ()))


# Changes.


def rewrite(column: str, new: str, values: Callable[[NDArray[Any]], NDArray[Any]]) -> Change:
    """Write other values, perhaps under another name, in the place of a column."""
    return lambda t: {new if k == column else k: values(v) if k == column else v for k, v in t.items()}


def both(*changes: Change) -> Change:
    """One change after the other."""

    def run(table: Columns) -> Columns:
        for change in changes:
            table = change(table)
        return table

    return run


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
    return {"total_pressure_pa" if k == IMPACT else k: total if k == IMPACT else v for k, v in t.items()}


def reduced_to_sea_level(t: Columns) -> Columns:
    """Static pressure as a weather service reports it (QNH)."""
    factor = air.SEA_LEVEL_PRESSURE / air.standard_pressure(t["altitude_m"])
    return {**t, STATIC: t[STATIC] * factor}


def incompressible(t: Columns) -> Columns:
    mach = air.mach_from_impact_pressure(t[IMPACT], t[STATIC])
    return {**t, IMPACT: 0.7 * t[STATIC] * mach**2}


def probe_as_air(t: Columns) -> Columns:
    return {"air_temperature_k" if k == PROBE else k: v for k, v in t.items()}


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
    return rewrite(column, column, lambda v: v * np.where(np.arange(len(v)) < len(v) // 2, 1.0, factor))


def rows(choose: Callable[[int], NDArray[Any]]) -> Change:
    return lambda t: {k: v[choose(len(v))] for k, v in t.items()}


def track_as_heading(t: Columns) -> Columns:
    return {**t, "heading_rad": np.arctan2(t[EAST], t[NORTH]) % (2.0 * np.pi)}


def _pressures() -> list[Mistake]:
    """Pressures in one unit under the suffix of another; the suffixes are those that a log has long known."""
    found = []
    exchanges = [(unit, "pa") for unit in PRESSURES if unit != "pa"]
    exchanges += [("pa", "hpa"), ("pa", "psf"), ("pa", "inhg"), ("pa", "psi"), ("hpa", "psf"), ("psf", "hpa")]
    exchanges += [("inhg", "psi"), ("psi", "inhg"), ("mmhg", "hpa"), ("inh2o", "hpa")]
    for column in (IMPACT, STATIC, "total_pressure_pa"):
        first: tuple[Change, ...] = (with_total,) if column.startswith("total") else ()
        for unit, suffix in exchanges:
            change = both(*first, scaled(column, 1.0 / PRESSURES[unit], column.replace("_pa", f"_{suffix}")))
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
        Mistake("impact in 12-bit counts", rewrite(IMPACT, IMPACT, lambda v: np.round(v / 3.3665)), impact),
        Mistake("impact as ½ρV²", incompressible, impact, MACH_SMALL),
        Mistake("impact with the wrong sign", scaled(IMPACT, -1.0), impact),
        Mistake("total in the impact column", lambda t: {**t, IMPACT: t[IMPACT] + t[STATIC]}, impact),
        Mistake(
            "airspeed (kt) in the impact column",
            lambda t: {**t, IMPACT: air.calibrated_airspeed(t[IMPACT]) / KNOT},
            impact,
        ),
        Mistake("impact and static exchanged", swapped(IMPACT, STATIC), impact + static),
        Mistake("total and static exchanged", both(with_total, swapped("total_pressure_pa", STATIC)), total),
        Mistake("total +5 hPa", both(with_total, shifted("total_pressure_pa", 500.0)), total),
        Mistake("static as total", lambda t: {**t, STATIC: t[STATIC] + t[IMPACT]}, static),
        Mistake("static x 1.05", scaled(STATIC, 1.05), static),
        Mistake("static reduced to sea level", reduced_to_sea_level, static),
        Mistake(
            "static constant, 1013.25 hPa", rewrite(STATIC, STATIC, lambda v: np.full_like(v, 101325.0)), static
        ),
        Mistake("altitude (m) in the static column", lambda t: {**t, STATIC: t["altitude_m"]}, static),
        Mistake("altitude (ft) in the static column", lambda t: {**t, STATIC: t["altitude_m"] / 0.3048}, static),
    ]


def _temperatures() -> list[Mistake]:
    def from_kelvin(new: str, values: Callable[[NDArray[Any]], NDArray[Any]]) -> Change:
        return rewrite(PROBE, new, values)

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
        ("total as of the air", probe_as_air, ""),
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
        (
            "velocity in kt from the middle on",
            both(*(second_half(c, 1.0 / SPEEDS["kt"]) for c in (NORTH, EAST))),
            "",
        ),
        ("ground speed and track in north and east", speed_and_track, ""),
        ("velocity x 1.02", both(scaled(NORTH, 1.02), scaled(EAST, 1.02)), ONE_RECEIVER),
        ("north without sign", rewrite(NORTH, NORTH, np.abs), ""),
        ("north with the wrong sign", scaled(NORTH, -1.0), ""),
        ("east with the wrong sign", scaled(EAST, -1.0), ""),
        ("north and east with the wrong sign", both(scaled(NORTH, -1.0), scaled(EAST, -1.0)), ""),
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
        ("row number as s", rewrite(clock, clock, lambda v: np.arange(1.0, len(v) + 1.0))),
        ("min as s", scaled(clock, 1.0 / 60.0)),
        ("h as s", scaled(clock, 1.0 / 3600.0)),
        ("s as ms", scaled(clock, 1.0, "time_ms")),
        ("ms as s", scaled(clock, 1e3)),
        ("µs as s", scaled(clock, 1e6)),
        ("x 2", scaled(clock, 2.0)),
        ("rounded to 1 s", rewrite(clock, clock, np.round)),
        ("epoch in single precision", rewrite(clock, clock, lambda v: np.float64(np.float32(v + 1.7e9)))),
        ("restarted in the middle", rewrite(clock, clock, restarted)),
        ("rows reversed", rows(lambda n: np.arange(n)[::-1])),
        ("rows doubled", rows(lambda n: np.repeat(np.arange(n), 2))),
        ("rows shuffled", rows(shuffle.permutation)),
        ("every tenth row", rows(lambda n: np.arange(0, n, 10))),
        ("gps_fresh never true", lambda t: {**t, "gps_fresh": np.zeros(len(t[clock]), dtype=np.bool_)}),
    ]
    return [Mistake(f"clock: {name}", change, ("time", "gps_fresh")) for name, change in table]


def _others() -> list[Mistake]:
    """What the calibration does not use: harmless to its curve."""
    found: list[Mistake] = []
    for name in ("roll", "pitch", "heading", "angle_of_attack", "sideslip"):
        column = f"{name}_rad"
        degrees = 180.0 / np.pi
        found.append(Mistake(f"{name}: ° written as rad", scaled(column, degrees), (name,)))
        found.append(Mistake(f"{name}: rad written as °", scaled(column, 1.0, f"{name}_deg"), (name,)))
    for name in ("roll", "pitch", "angle_of_attack"):
        found.append(Mistake(f"{name} with the wrong sign", scaled(f"{name}_rad", -1.0), (name,)))
    magnetic = rewrite("heading_rad", "heading_rad", lambda v: (v - np.radians(12.0)) % (2.0 * np.pi))
    found.append(Mistake("heading magnetic, 12° off", magnetic, ("heading",)))
    found.append(Mistake("heading is the track", track_as_heading, ("heading",)))
    found.append(Mistake("altitude ft as m", scaled("altitude_m", 1.0 / 0.3048), ("altitude",)))
    found.append(Mistake("altitude m as ft", scaled("altitude_m", 1.0, "altitude_ft"), ("altitude",)))
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


def check(mistake: Mistake) -> tuple[FlightLog | None, str]:
    """Read the spoiled log: the log, or None where it is refused, and what was said about it."""
    try:
        found = read(mistake.change(good_columns(log())))
    except BadInputError as error:
        return None, str(error)
    return found, " | ".join(found.header.get("warnings", ()))


def judge(mistake: Mistake) -> Outcome:
    """Read and calibrate the spoiled log, and hold the answer against the truth."""
    try:
        spoiled, says = check(mistake)
        if spoiled is None:
            return Outcome(mistake, "refused", says)
        found = calibrate(spoiled, CalibrationOptions(latency="checked"))
    except (BadInputError, NoAnswerError) as error:
        return Outcome(mistake, "refused", str(error))
    except Exception as error:  # a traceback is an outcome of its kind
        return Outcome(mistake, "crashed", f"{type(error).__name__}: {error}")
    said = dict.fromkeys([*spoiled.header.get("warnings", ()), *found.warnings])
    case = flight().case
    curve = compare_curve(found.curve, case.pressure_error)
    wind = compare_wind(found.wind, wind_toward(case.wind)[:2])
    size = np.abs(curve.error)
    ratio = float(np.max(size / curve.two_sigma))
    wind_ratio = float(np.linalg.norm(wind.error) / np.linalg.norm(wind.two_sigma))
    return _kind(mistake, " | ".join(said), float(np.max(size)) / KNOT, ratio, wind_ratio)


def _kind(mistake: Mistake, says: str, error_kt: float, ratio: float, wind: float) -> Outcome:
    warned = any(name in says for name in mistake.names)
    if warned:
        kind = "hidden" if error_kt > _ABSURD else "warned"
    elif ratio <= _WRONG and wind <= _WRONG:
        kind = "unharmed"
    elif mistake.unknowable:
        kind = "no log can show it"
    else:
        kind = "hidden" if says else "silent"
    return Outcome(mistake, kind, says, error_kt, ratio, wind)


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; returns exit code 0 where nothing is accepted wrong in silence or hidden below a warning."""
    parser = argparse.ArgumentParser(prog="python -m tests.lab.mistakes", description=__doc__.split("\n")[0])
    parser.add_argument("--each", action="store_true", help="one line a mistake")
    choice = parser.parse_args(arguments)
    found = []
    for mistake in MISTAKES.values():
        begun = time.perf_counter()
        outcome = judge(mistake)
        found.append(outcome)
        if choice.each:
            numbers = f"{outcome.error_kt:8.2f} kt {outcome.ratio:8.1f} {outcome.wind_ratio:8.1f}"
            lasted = time.perf_counter() - begun
            print(f"{outcome.kind:<18} {numbers} {lasted:5.1f} s  {mistake.name}: {outcome.says}", flush=True)
    count = Counter(outcome.kind for outcome in found)
    print(f"{len(found)} mistakes: " + ", ".join(f"{kind} {count[kind]}" for kind in OUTCOMES))
    return 1 if count["silent"] or count["hidden"] or count["crashed"] else 0


if __name__ == "__main__":
    sys.exit(main())
