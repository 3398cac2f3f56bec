"""Calibrate real logs and hold the answers against what is known of them independently.

The logs are read in place, from the folder that PITOTBENCH_DATA names. Each is calibrated as the
command does it, then without the height, and each half by itself: answers of one airplane must
agree. Beside that, the C172S is held against its handbook, the gliders' winds against the
radiosonde of the day, and two decelerations of a jet on one heading against a weather balloon.
"""

import gzip
import os
import time
from argparse import ArgumentParser
from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np

from pitotbench import air
from pitotbench.bench.workflow import NamedLog, reconcile_fully
from pitotbench.calibration import calibrate_flights
from pitotbench.calibration.options import options_from
from pitotbench.logbook.mapping import find_mapping
from pitotbench.logbook.reading import read_log
from pitotbench.models.maneuver_model import in_place_of_log
from pitotbench.models.maneuver_parts import maneuvers_of
from pitotbench.models.sidpac import read_identification
from pitotbench.records import BadInputError, NoAnswerError
from pitotbench.records.calibration import Calibration, ErrorCurve
from pitotbench.records.log import FlightLog
from pitotbench.records.maneuver import Maneuver
from pitotbench.show.renderers import print_tree
from pitotbench.show.verdict_tree import account_tree
from pitotbench.units import FOOT, KNOT, Array

LOGS = (
    "garmin/c172s-g1000-2011.csv.gz",
    "garmin/pa28-gifd-2024.csv.gz",
    "citation/2019-03-12.parquet",
)
GLIDERS = ("flight50-front", "flight50-rear", "flight52-front", "flight52-rear")
JETS = ("CLASS55", "CLASS65")
# Cessna 172S, Pilot's Operating Handbook, airspeed calibration with flaps up: KIAS, KCAS.
HANDBOOK = np.array(
    [[50, 56], [60, 62], [70, 70], [80, 78], [90, 87], [100, 97], [110, 107]], dtype=float
)
ONE_AIRPLANE = 3.0  # kt, by which one airplane may differ from its handbook
LAUNCH = 200.0  # m above sea level, from which the sondes' heights count
ALOFT = 1500.0  # m, from which the gliders' pressure and temperature are held against the sonde's
PAIRED = 120.0  # s between the middles of two recorders' windows of one wind
KNOWN = 8.0  # kt: 2σ of a wind that counts
AWAY = 25.0  # kt: a sonde of another hour and place in lee waves
# Δp/q_c of the jets by the balloon's pressure at GPS height, and 0.5 hPa as the balloon's own
# doubt.
BALLOON_KT = np.array([260.0, 300.0, 340.0, 380.0, 420.0])
BALLOON = {
    "CLASS55": [0.032, 0.035, 0.035, 0.035, 0.035],
    "CLASS65": [0.036, 0.037, 0.036, 0.036, 0.037],
}
BALLOON_PA = 50.0
ONE_HEADING = np.radians(8.0)  # spread of the track within a deceleration
# Of SIDPAC (NASA), in the folder sidpac.
TWIN_OTTER = ("totter_lon_020213f1_018", "totter_lon_020213f1_017")
CITATION_CLEAN = (46.0, 71.0)  # min, with flaps and gear up
FIT = 1.5  # joined 2σ within which two answers of one log agree


def command(parser: ArgumentParser, words: Sequence[str]) -> None:
    """Print what real logs give, and how it stands beside what is known of them."""
    add = parser.add_argument
    add("--data", type=Path, default=Path(os.environ.get("PITOTBENCH_DATA", "../shared/data")))
    add("--terms", action="store_true", help="the terms of models alone")
    options = parser.parse_args(words)
    if not options.terms:
        _calibrations(options.data)
    one, two = ([read_identification(options.data / f"sidpac/{name}.mat")] for name in TWIN_OTTER)
    _terms("DHC6", one, two)
    _terms("DHC6", two, one)
    log = read_log(options.data / "citation/2019-03-12.parquet")
    since = log.time - log.time[0]
    clean = log.select((since > CITATION_CLEAN[0] * 60.0) & (since < CITATION_CLEAN[1] * 60.0))
    maneuvers = maneuvers_of(clean, "citation")
    _terms("citation", maneuvers[::2], maneuvers[1::2])


def _calibrations(data: Path) -> None:
    for name in LOGS:
        _consistent(data / name)
    found = {name: _against_sonde(data / "perlan", name) for name in GLIDERS}
    for front, rear in zip(GLIDERS[::2], GLIDERS[1::2], strict=True):
        _front_and_rear(front, found[front], found[rear])
    for name in JETS:
        _against_balloon(data / "jmoss" / f"{name}.csv", name)


def _terms(aircraft: str, fitted: Sequence[Maneuver], held_out: Sequence[Maneuver]) -> None:
    """The terms of a model beside maneuvers, and what they close on others."""
    from rich.console import Console

    print(f"{aircraft}: fitted to {fitted[0].name}, {len(fitted)} in all; held out {len(held_out)}")
    each, other = (
        NamedLog(some[0].name, in_place_of_log(some, aircraft)) for some in (fitted, held_out)
    )
    outcome = reconcile_fully(each, aircraft, other, refly=False)
    print_tree(account_tree(outcome.account), Console(highlight=False, soft_wrap=True))


def answer_of(log: FlightLog, **choices: Any) -> Calibration | str:
    """The answer of the command for a log, or why there is none."""
    mapping = log.header.get("mapping")
    advised = dict(find_mapping(mapping).calibrate) if mapping else {}
    try:
        options = options_from({"latency": "checked", "wind": "checked", **advised, **choices})
        return calibrate_flights([log], options)[0].calibration
    except (BadInputError, NoAnswerError) as error:
        return str(error)


def _consistent(path: Path) -> None:
    began, log = time.process_time(), read_log(path)
    half = len(log) // 2
    answers = {
        "whole": answer_of(log),
        "no height": answer_of(log, use_altitude=False),
        "first half": answer_of(log.select(np.arange(half))),
        "second half": answer_of(log.select(np.arange(half, len(log)))),
    }
    spent = time.process_time() - began
    print(f"{path.name}: {len(log):,} rows, {spent:.1f} CPU s for four answers")
    for name, found in answers.items():
        print(f"  {name}: {found if isinstance(found, str) else _told(found)}")
    given = {name: found.curve for name, found in answers.items() if not isinstance(found, str)}
    apart = {f"{a} and {b}": _difference(given[a], given[b]) for a, b in combinations(given, 2)}
    worst = max(apart, key=lambda pair: apart[pair])
    print(
        f"  largest difference: {apart[worst]:.2f} of the joined 2σ ({worst}); at most {FIT:g} is "
        "agreement"
    )
    if path.name.startswith("c172s"):
        _against_handbook(answers["whole"])


def _told(found: Calibration) -> str:
    curve = found.curve
    places = np.linspace(0, len(curve.correction) - 1, 5).astype(int)
    points = ", ".join(
        f"{curve.correction_kt[i]:+.2f} ± {curve.two_sigma_kt[i]:.2f} at "
        f"{curve.indicated_airspeed_kt[i]:.0f}"
        for i in places
    )
    said = ", ".join(each.kind for each in found.disagreements) or "none"
    counts = f"{len(found.parts)} parts, {len(found.winds)} winds"
    return f"{points} KIAS [kt]; {counts}, disagreements: {said}"


def _difference(first: ErrorCurve, second: ErrorCurve) -> float:
    """The largest difference of two curves over their common airspeeds, in their joined 2σ."""
    airspeeds = [each.indicated_airspeed for each in (first, second)]
    low, high = max(each[0] for each in airspeeds), min(each[-1] for each in airspeeds)
    if high <= low:
        return 0.0
    at = np.linspace(low, high, 50)
    values = [np.interp(at, each.indicated_airspeed, each.correction) for each in (first, second)]
    bounds = [np.interp(at, each.indicated_airspeed, each.two_sigma) for each in (first, second)]
    return float(np.max(np.abs(values[0] - values[1]) / np.hypot(*bounds)))


def _against_handbook(found: Calibration | str) -> None:
    if isinstance(found, str):
        return
    speed = found.curve.indicated_airspeed_kt
    for indicated, calibrated in HANDBOOK:
        if speed[0] - 1.5 <= indicated <= speed[-1] + 1.5:
            value = float(np.interp(indicated, speed, found.curve.correction_kt))
            bound = float(np.interp(indicated, speed, found.curve.two_sigma_kt))
            known = calibrated - indicated
            said = "inside" if abs(value - known) <= np.hypot(bound, ONE_AIRPLANE) else "OUTSIDE"
            told = f"{value:+.2f} ± {bound:.2f} kt, handbook {known:+.0f}"
            print(f"  {indicated:.0f} KIAS: {told}: {said}")


@dataclass(frozen=True, slots=True)
class Sonde:
    """A sounding: height [m], wind toward north and east [m/s], pressure [Pa], temperature [K]."""

    height: Array
    north: Array
    east: Array
    pressure: Array
    temperature: Array

    def at(self, name: str, height: Array | float) -> Array:
        """One of the quantities at heights [m]."""
        return np.asarray(np.interp(height, self.height, getattr(self, name)))


Glider = tuple[FlightLog, Calibration | str]


def _against_sonde(folder: Path, name: str) -> Glider:
    began, log = time.process_time(), read_log(folder / f"{name}.igc.gz")
    found = answer_of(log)
    seconds = time.process_time() - began
    if isinstance(found, str):
        print(f"{name}: {found}")
        return log, found
    sonde = read_sonde(folder / f"{name.partition('-')[0]}-sounding.txt.gz")
    known = [w for w in found.winds if max(w.north.two_sigma, w.east.two_sigma) <= KNOWN * KNOT]
    inside = 0
    for window in known:
        good, told = True, []
        for e, axis in ((window.north, "north"), (window.east, "east")):
            true = float(sonde.at(axis, window.altitude))
            good &= abs(e.value - true) <= np.hypot(e.two_sigma, AWAY * KNOT)
            found_kt = f"{e.value / KNOT:+.0f} ± {e.two_sigma / KNOT:.0f}"
            told.append(f"{e.name} {found_kt} (sonde {true / KNOT:+.0f})")
        inside += good
        print(f"  {window.altitude:6,.0f} m: {', '.join(told)} kt{'' if good else ' OUTSIDE'}")
    print(
        f"{name}: {seconds:.1f} CPU s, {len(known)} of {len(found.winds)} winds known, {inside} "
        "inside the sonde's"
    )
    assert log.altitude is not None
    assert log.air_temperature is not None
    aloft = log.altitude > ALOFT
    for words, measured, quantity, unit, size in (
        ("static pressure at GPS height", log.static_pressure, "pressure", "hPa", 100.0),
        ("air temperature at GPS height", log.air_temperature, "temperature", "K", 1.0),
    ):
        apart = (measured[aloft] - sonde.at(quantity, log.altitude[aloft])) / size
        print(f"  {words} less the sonde's: {_spread(apart)} {unit}")
    return log, found


def _spread(values: Array) -> str:
    low, middle, high = np.quantile(values, [0.05, 0.5, 0.95])
    rms = np.sqrt(np.mean(values**2))
    return f"median {middle:+.2f}, nine in ten {low:+.2f} to {high:+.2f}, rms {rms:.2f}"


def _front_and_rear(name: str, front: Glider, rear: Glider) -> None:
    """The two recorders of one flight against each other, and what is made of them."""
    began = [datetime.fromisoformat(str(log.header["start"])) for log, _ in (front, rear)]
    shift = (began[1] - began[0]).total_seconds()
    (one, found), (other, also) = front, rear
    assert one.altitude is not None
    assert other.altitude is not None
    clock = other.time + shift
    rows = (one.altitude > ALOFT) & (one.time > clock[0]) & (one.time < clock[-1])
    print(f"{name} less its rear recorder, {int(rows.sum()):,} s:")
    for words, channel, unit, size in (
        ("impact pressure", "impact_pressure", "Pa", 1.0),
        ("static pressure", "static_pressure", "hPa", 100.0),
        ("air temperature", "air_temperature", "K", 1.0),
        ("GPS height", "altitude", "m", 1.0),
    ):
        there = np.interp(one.time[rows], clock, getattr(other, channel))
        print(f"  {words}: {_spread((getattr(one, channel)[rows] - there) / size)} {unit}")
    if isinstance(found, str) or isinstance(also, str):
        return
    pairs = [
        (a, b)
        for a in found.winds
        for b in also.winds
        if abs(0.5 * (a.begin + a.end) - 0.5 * (b.begin + b.end) - shift) < PAIRED
        and max(e.two_sigma for w in (a, b) for e in (w.north, w.east)) <= KNOWN * KNOT
    ]
    for axis in ("north", "east"):
        winds = [(getattr(a, axis), getattr(b, axis)) for a, b in pairs]
        apart = np.array([a.value - b.value for a, b in winds]) / KNOT
        joined = [np.hypot(a.two_sigma, b.two_sigma) / KNOT for a, b in winds]
        inside = int(np.sum(np.abs(apart) <= joined))
        rms = float(np.sqrt(np.mean(apart**2)))
        print(
            f"  wind toward {axis}, {len(pairs)} windows: bias {np.mean(apart):+.2f} kt, rms "
            f"{rms:.2f} kt, {inside} inside the joined 2σ"
        )
    print(f"  curves: at most {_difference(found.curve, also.curve):.2f} of the joined 2σ apart")


def read_sonde(path: Path) -> Sonde:
    """Read a sounding."""
    rows = []
    with gzip.open(path, "rt", errors="replace") as file:
        for line in file:
            try:
                rows.append([float(cell) for cell in line.split()[:7]])
            except ValueError:
                continue
    height, _, pressure, warmth, _, knots, degrees = np.array([r for r in rows if len(r) == 7]).T
    toward, speed = np.radians(degrees + 180.0), knots * KNOT
    wind = speed * np.cos(toward), speed * np.sin(toward)
    return Sonde(height * FOOT + LAUNCH, *wind, 100.0 * pressure, warmth + 273.15)


def _against_balloon(path: Path, name: str) -> None:
    """The longest part of a jet's log on one heading, calibrated without anything else."""
    log = read_log(path, "jmoss")
    track = np.unwrap(np.arctan2(log.velocity_east, log.velocity_north))
    longest = range(0)
    for first in range(0, len(log), 100):
        low, high = np.minimum.accumulate(track[first:]), np.maximum.accumulate(track[first:])
        count = int(np.searchsorted(high - low, ONE_HEADING))
        longest = max(longest, range(first, first + count), key=len)
    part = log.select(np.arange(longest.start, longest.stop))
    found = answer_of(replace(part, header={**part.header, "mapping": "jmoss"}))
    if isinstance(found, str):
        print(f"{name} on one heading: {found}")
        return
    speed, inside = found.curve.indicated_airspeed_kt, []
    held = (speed[0] - 1.5 <= BALLOON_KT) & (speed[-1] + 1.5 >= BALLOON_KT)
    for at, true in zip(BALLOON_KT[held], np.array(BALLOON[name])[held], strict=True):
        value = float(np.interp(at, speed, found.curve.normalized_pressure_error))
        bound = float(np.interp(at, speed, found.curve.normalized_two_sigma))
        dynamic = float(air.impact_pressure(at * KNOT))
        inside.append(abs(value - true) * dynamic <= np.hypot(bound * dynamic, BALLOON_PA))
        said = "" if inside[-1] else " OUTSIDE"
        print(f"  {at:.0f} KIAS: Δp/q_c {value:.4f} ± {bound:.4f}, balloon {true:.3f}{said}")
    wind = "unknown" if found.wind is None else "known"
    told = f"{sum(inside)} of {len(inside)} inside"
    print(f"{name} on one heading: {len(part) / 20:.0f} s, wind {wind}, {told}")
