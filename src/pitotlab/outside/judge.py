"""Judge the calibration on flights of the independent generator, and hold two builds side by side.

`outside judge` runs in each build: only its calibration and its record of options are used, and
what a build does not know is left out with a note. `outside compare` reads the rows of one file, or
of two.
"""

import json
import re
import sys
import time
from argparse import ArgumentParser
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from scipy.stats import chisquare, norm

from pitotbench.calibration import calibrate
from pitotbench.calibration.options import CalibrationOptions
from pitotbench.logbook.reading import read_log
from pitotbench.records import BadInputError, NoAnswerError
from pitotlab.outside.kinds import SETS
from pitotlab.outside.moving_air import Cell
from pitotlab.outside.physics import FOOT, KNOT, Array
from pitotlab.outside.written import TRUTH, write_flight
from pitotlab.sets import append_to, read_rows, seeds_of, wilson

# Where the command's defaults are not those of CalibrationOptions.
COMMAND_DEFAULTS = {"latency": "checked", "wind": "checked", "model": "smooth"}
NAN = float("nan")
Z_AT = (0.1, 0.3, 0.5, 0.7, 0.9)  # of the range of airspeeds
CODES = ", "  # between two
WRONG_BELOW = 0.5  # share of the curve inside its bound
WRONG_BY = 2.0  # of its bound
RANKS = 10  # classes of the test of ranks
CELL_OF = {cell.name: cell for cells in SETS.values() for cell in cells}
PROBES = ("probe_2k", "probe_5k", "probe_-5k", "probe_-20k")


@dataclass(frozen=True, slots=True)
class JudgedRow:
    """What a build made of one log; airspeeds in kt. A column of the file each."""

    set: str
    seed: int
    options: str
    maneuver: str
    gps_hz: float
    outcome: str  # answered, refused or crashed
    inside: float = NAN  # share of the curve inside its bound
    whole: float = NAN  # 1 where the band that is meant for the whole curve holds it
    two_sigma_kt: float = NAN  # mean over the curve
    rms_kt: float = NAN
    z1: float = NAN  # error over half the bound, at `Z_AT`
    z2: float = NAN
    z3: float = NAN
    z4: float = NAN
    z5: float = NAN
    worst: float = NAN  # the largest error over the bound
    inside_ft: float = NAN  # share of the curve whose position error is inside its bound
    wind_inside: float = NAN  # share of the two components
    warned: float = NAN  # 1 where there was any warning
    headline: float = NAN  # 1 where two findings disagree
    usable: float = NAN  # 0 where the answer says not to use it
    cpu_s: float = NAN
    codes: str = ""  # of the checks that warn, with their columns, and kinds of the disagreements
    says: str = ""  # warnings and disagreements, or why there is no answer


@dataclass(frozen=True, slots=True)
class Asked:
    """A log to be judged: its cell and seed, and its truth where it is written already."""

    cell: Cell
    seed: int
    path: Path | None = None

    @property
    def key(self) -> tuple[str, int]:
        """Return the set and the seed of its row."""
        return self.cell.name, self.seed


def options_known(stated: Mapping[str, Any]) -> tuple[CalibrationOptions, str]:
    """Return the options of this build and their words; a choice that it does not know is left out,
    with a note on the error stream.
    """
    known = {}
    for name, value in stated.items():
        try:
            CalibrationOptions(**{name: value})
        except (TypeError, ValueError) as error:
            print(f"left out {name}={value!r}, which this build refuses: {error}", file=sys.stderr)
        else:
            known[name] = value
    return CalibrationOptions(**known), json.dumps(known, sort_keys=True)


def judge_log(path: Path, truth: Mapping[str, Any], options: CalibrationOptions) -> dict[str, Any]:
    """Read and calibrate a log, and hold the answer against its truth: entries of a `JudgedRow`."""
    begun = 0.0
    try:
        log = read_log(path)
        begun = time.process_time()
        found = calibrate(log, options)
    except (BadInputError, NoAnswerError) as error:
        return {"outcome": "refused", "says": str(error)}
    except Exception as error:  # a crash is a result of its kind and must not end a night's run
        return {"outcome": "crashed", "says": f"{type(error).__name__}: {error}"}
    seconds = time.process_time() - begun
    return {"outcome": "answered", "cpu_s": round(seconds, 4), **errors_of(found, truth)}


def errors_of(found: Any, truth: Mapping[str, Any]) -> dict[str, Any]:
    """Return the errors of curve, position and wind of an answer, and what it says."""
    at = np.array(truth["indicated_airspeed_kt"])
    curve = found.curve
    airspeed = curve.indicated_airspeed / KNOT
    flown = (airspeed > at[0] - 0.02) & (airspeed < at[-1] + 0.02)
    true = np.interp(airspeed, at, truth["correction_kt"])
    error, bound = curve.correction / KNOT - true, curve.two_sigma / KNOT
    places = at[0] + np.array(Z_AT) * (at[-1] - at[0])
    z = np.interp(places, airspeed, error) / (0.5 * np.interp(places, airspeed, bound))
    wind = in_feet = NAN
    if found.wind is not None:
        parts = (found.wind.north, found.wind.east)
        off = np.array([part.value for part in parts]) / KNOT - truth["mean_wind_kt"]
        wind = np.mean(np.abs(off) <= np.array([part.two_sigma for part in parts]) / KNOT)
    if curve.altitude_correction is not None:
        off = curve.altitude_correction / FOOT - np.interp(airspeed, at, truth["position_error_ft"])
        in_feet = np.mean((np.abs(off) <= curve.altitude_two_sigma / FOOT)[flown])
    told = (*found.warnings, *(each.words for each in found.disagreements))
    codes = {f"{w.code} {w.column}".strip() for w in found.warnings}
    return {
        "inside": np.mean(np.abs(error[flown]) <= bound[flown]),
        "whole": float(np.all((np.abs(error) <= curve.simultaneous_two_sigma / KNOT)[flown])),
        "two_sigma_kt": np.mean(bound[flown]),
        "rms_kt": np.sqrt(np.mean(error[flown] ** 2)),
        **{f"z{number}": value for number, value in enumerate(z, start=1)},
        "worst": np.max(np.abs(error[flown]) / bound[flown]),
        "inside_ft": in_feet,
        "wind_inside": wind,
        "warned": float(bool(found.warnings)),
        "headline": float(bool(found.disagreements)),
        "usable": float(found.usable),
        "codes": CODES.join(sorted(codes | {each.kind for each in found.disagreements})),
        "says": " | ".join(told),
    }


def judged(stated: Mapping[str, Any], asked: Asked) -> JudgedRow:
    """Judge one log, that is flown first where it is not written yet."""
    with TemporaryDirectory() as folder:
        beside = asked.path or write_flight(asked.cell, asked.seed, Path(folder))
        truth = json.loads(beside.read_text(encoding="utf-8"))
        # what the set needs yields to what is stated
        options, words = options_known({**COMMAND_DEFAULTS, **truth["calibrate"], **stated})
        log = beside.with_name(beside.name.removesuffix(TRUTH) + ".csv")
        named = {name: truth[name] for name in ("set", "seed", "maneuver", "gps_hz")}
        return JudgedRow(**named, options=words, **judge_log(log, truth, options))


def logs_of(where: Sequence[str], seeds: Sequence[int]) -> list[Asked]:
    """Return the logs of sets, by their names, and of folders in which logs are written.

    Raises BadInputError for what is neither.
    """
    asked = []
    for name in where:
        paths = sorted(Path(name).rglob(f"*{TRUTH}")) if name not in SETS else []
        if name not in SETS and not paths:
            known = f"sets: {', '.join(SETS)}"
            raise BadInputError(
                f"{name} holds no log with its truth: write with outside write; {known}"
            )
        asked += [Asked(cell, seed) for cell in SETS.get(name, ()) for seed in seeds]
        seeds_in = {path: int(path.name.removesuffix(TRUTH)) for path in paths}
        asked += [Asked(CELL_OF[p.parent.name], seed, p) for p, seed in seeds_in.items()]
    return asked


def judge(
    asked: Sequence[Asked], out: Path, stated: Mapping[str, Any], jobs: int = 1
) -> list[JudgedRow]:
    """Judge the logs that the file has no row of by these choices; return all rows asked for."""
    held = {(row.set, row.seed): row for row in read_rows(out, JudgedRow) if _chose(row, stated)}
    missing = [each for each in asked if each.key not in held]
    with append_to(out, JudgedRow) as append:
        for row in _each(partial(judged, stated), missing, jobs):
            append(row)
            held[row.set, row.seed] = row
            print(f"{row.set} {row.seed} {row.maneuver}: {row.outcome}", file=sys.stderr)
    return [held[each.key] for each in asked]


def _chose(row: JudgedRow, stated: Mapping[str, Any]) -> bool:
    """Return whether a row was judged by these choices, and by no others but those of its set."""
    chosen = json.loads(row.options)
    usual = {**COMMAND_DEFAULTS, **dict(CELL_OF[row.set].calibrate)}
    return bool(chosen == {**usual, **stated})


def _each(
    work: Callable[[Asked], JudgedRow], asked: Sequence[Asked], jobs: int
) -> Iterator[JudgedRow]:
    if jobs == 1:
        yield from map(work, asked)
        return
    with ProcessPoolExecutor(jobs) as pool:
        yield from pool.map(work, asked)


def judge_command(parser: ArgumentParser, words: Sequence[str]) -> None:
    """Judge this build on sets of the independent generator, or on logs of `outside write`; print
    the table.

    A run that was ended goes on.
    """
    add = parser.add_argument
    add("logs", nargs="+", metavar="SET or FOLDER", help=f"sets: {', '.join(SETS)}")
    add("--seeds", default="1:61", metavar="A:B", help="of each cell of a set, from A to B - 1")
    add("--jobs", type=int, default=1)
    add("--out", type=Path, required=True, help="one row a log (CSV); read first, then added to")
    add("--calibrate", default="{}", help="choices of the calibration (JSON)")
    choice = parser.parse_args(words)
    seeds = seeds_of(parser, choice.seeds)
    try:
        stated = json.loads(choice.calibrate)
    except json.JSONDecodeError as error:
        parser.error(f"--calibrate {choice.calibrate!r}: {error}")
    rows = judge(logs_of(choice.logs, seeds), choice.out, stated, choice.jobs)
    print(*table(rows), sep="\n")


def text_of(value: float, digits: int) -> str:
    """Return a number, or a dash where there is none."""
    return f"{value:.{digits}f}" if np.isfinite(value) else "–"


def aligned(lines: Sequence[Sequence[str]]) -> str:
    """Return lines of entries under one another, each column as wide as its widest entry."""
    widths = [max(len(text) for text in column) for column in zip(*lines, strict=True)]
    return "\n".join(
        "  ".join(text.rjust(width) for text, width in zip(entries, widths, strict=True))
        for entries in lines
    )


def is_wrong(row: JudgedRow) -> bool:
    """Return whether under half of the curve is inside its bound, or a point is off by twice it."""
    return row.inside < WRONG_BELOW or row.worst > WRONG_BY


def is_silent(row: JudgedRow) -> bool:
    """Return whether an answer has neither a warning nor a disagreement."""
    return row.warned == 0.0 and row.headline == 0.0


def is_named(row: JudgedRow) -> bool:
    """Return whether a finding names what is wrong with the flights of the kind; any word where
    nothing has a name of its own.
    """
    pattern = CELL_OF[row.set].named if row.set in CELL_OF else ""
    return not is_silent(row) and bool(re.search(pattern, row.says, re.IGNORECASE))


def _mean_held(rows: Sequence[JudgedRow]) -> float:
    """Return the mean share [%] of the curve inside its bound, all of it where what is wrong is
    named.
    """
    held = [1.0 if is_named(row) else row.inside for row in rows]
    return 100.0 * float(np.mean(held)) if held else NAN


FIGURES: dict[str, Callable[[Sequence[JudgedRow]], str]] = {
    "n": lambda rows: str(len(rows)),
    "inside %": lambda rows: text_of(100.0 * _mean(rows, "inside"), 1),
    "whole %": lambda rows: text_of(100.0 * _mean(rows, "whole"), 0),
    "bound": lambda rows: text_of(_mean(rows, "two_sigma_kt"), 2),
    "rms": lambda rows: text_of(np.sqrt(np.mean(_of(rows, "rms_kt") ** 2)) if rows else NAN, 2),
    "rms z": lambda rows: text_of(np.sqrt(np.mean(_z_of(rows) ** 2)) if rows else NAN, 2),
    "wrong": lambda rows: str(sum(map(is_wrong, rows))),
    "silent": lambda rows: str(sum(is_wrong(row) and is_silent(row) for row in rows)),
    "named": lambda rows: str(sum(map(is_named, rows))),
    "in or named %": lambda rows: text_of(_mean_held(rows), 1),
    "warned": lambda rows: str(sum(not is_silent(row) for row in rows)),
    "headline": lambda rows: str(sum(row.headline == 1.0 for row in rows)),
    "ft %": lambda rows: text_of(100.0 * _mean(rows, "inside_ft"), 0),
    "wind %": lambda rows: text_of(100.0 * _mean(rows, "wind_inside"), 0),
    "CPU s": lambda rows: text_of(_mean(rows, "cpu_s"), 2),
}


def table(*files: Sequence[JudgedRow]) -> list[str]:
    """Return the table of one build or of two, a kind a line and totals, and what is said below it.

    Counted are the logs that all files have; `n` are those answered, and `2/1` is the mean bound of
    the second over that of the first where both answer. Raises BadInputError where a file has a log
    twice.
    """
    for rows in files:
        if len({(row.set, row.seed) for row in rows}) < len(rows):
            raise BadInputError("a file has a log twice, with other options: choose with --options")
    sides = [{(row.set, row.seed): row for row in rows} for rows in files]
    keys = [key for key in sides[0] if all(key in side for side in sides)]
    kinds = {name: [key for key in keys if key[0] == name] for name, _ in keys}
    if len(kinds) > 1:
        kinds["all"] = list(keys)
        kinds["without probes"] = [key for key in keys if key[0] not in PROBES]
        for name in sorted({sides[0][key].maneuver for key in keys}):
            kinds[name] = [key for key in kinds["without probes"] if sides[0][key].maneuver == name]
    numbers = [str(number) for number in range(1, len(sides) + 1)]
    lines = [["kind", *(f"{name} {side}" for name in FIGURES for side in numbers), "2/1"]]
    below = []
    for kind, chosen in kinds.items():
        answered = [
            [side[key] for key in sorted(chosen) if side[key].outcome == "answered"]
            for side in sides
        ]
        entries = [figure(rows) for figure in FIGURES.values() for rows in answered]
        both = [key for key in chosen if all(side[key].outcome == "answered" for side in sides)]
        means = [_mean([side[key] for key in both], "two_sigma_kt") for side in sides]
        lines.append([kind, *entries, text_of(means[-1] / means[0], 2)])
        for number, side, rows in zip(numbers, sides, answered, strict=True):
            unanswered = Counter(side[key].outcome for key in chosen)
            below.append(f"{kind}, {number}: {_said_of(rows, unanswered)}")
    return [aligned(lines), *below]


def _said_of(rows: Sequence[JudgedRow], outcomes: Counter[str]) -> str:
    """Return intervals of what is wrong and of the share inside, the test of the ranks, and words."""
    wrong = sum(map(is_wrong, rows))
    silent = sum(is_wrong(row) and is_silent(row) for row in rows)
    inside = 100.0 * _of(rows, "inside")
    spread = np.std(inside, ddof=1) / np.sqrt(len(rows)) if len(rows) > 1 else NAN
    intervals = []
    for name, count in (("wrong", wrong), ("in silence", silent)):
        low, high = (100.0 * end for end in wilson(count, len(rows)))
        intervals.append(f"{name} {count} of {len(rows)} ({low:.1f} to {high:.1f} %)")
    share = f"inside {text_of(_mean(rows, 'inside') * 100.0, 1)} ± {text_of(float(spread), 1)} %"
    none = f"{outcomes['refused']} refused, {outcomes['crashed']} crashed"
    codes = Counter(code for row in rows for code in row.codes.split(CODES) if code)
    said = ", ".join(f"{code} {count}" for code, count in codes.most_common()) or "nothing"
    return ", ".join([*intervals, share, none, ranks_of(rows), f"said: {said}"])


def ranks_of(rows: Sequence[JudgedRow]) -> str:
    """Return whether the ranks Φ(z) are uniform, by one place a flight."""
    z = _z_of(rows)
    if len(z) < RANKS:
        return "ranks –"
    one = z[np.arange(len(z)), np.arange(len(z)) % len(Z_AT)]
    counts = np.histogram(norm.cdf(one), bins=RANKS, range=(0.0, 1.0))[0]
    return f"ranks {' '.join(map(str, counts))} (uniform: p = {chisquare(counts).pvalue:.2g})"


def _z_of(rows: Sequence[JudgedRow]) -> Array:
    """Return errors over half the bound, (rows, places)."""
    z = [[getattr(row, f"z{number}") for number in range(1, len(Z_AT) + 1)] for row in rows]
    return np.array(z).reshape(-1, len(Z_AT))


def _of(rows: Sequence[JudgedRow], name: str) -> Array:
    return np.array([getattr(row, name) for row in rows], dtype=np.float64)


def _mean(rows: Sequence[JudgedRow], name: str) -> float:
    values = _of(rows, name)
    values = values[np.isfinite(values)]
    return float(np.mean(values)) if len(values) else NAN


def compare_command(parser: ArgumentParser, words: Sequence[str]) -> None:
    """Print a file of `outside judge`, or two of them side by side, a line a kind."""
    add = parser.add_argument
    add("files", type=Path, nargs="+", metavar="FILE", help="one, or two")
    add("--options", nargs="*", default=(), metavar="TEXT", help="of each file, only rows with it")
    choice = parser.parse_args(words)
    texts = (*choice.options, "", "")
    rows = [
        [row for row in read_rows(path, JudgedRow) if text in row.options]
        for path, text in zip(choice.files[:2], texts, strict=False)
    ]
    print(*table(*rows), sep="\n")
