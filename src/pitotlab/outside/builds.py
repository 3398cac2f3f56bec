"""Two builds of the product, judged on the same written logs.

`outside judge` runs in each build: only its calibration and its record of options are used, and
what a build does not know is left out with a note. `outside compare` then reads both files of rows.
"""

import argparse
import json
import re
import sys
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import binomtest, chisquare, norm

from pitotbench.calibration import calibrate
from pitotbench.calibration.options import CalibrationOptions
from pitotbench.logbook.reading import read_log
from pitotbench.records import BadInputError, NoAnswerError
from pitotlab.outside.judge import (
    COMMAND_DEFAULTS,
    NAN,
    aligned,
    append_to,
    read_rows,
    standard_error,
    text_of,
)
from pitotlab.outside.kinds import SETS
from pitotlab.outside.physics import KNOT, Array
from pitotlab.outside.written import TRUTH

Z_AT = (0.1, 0.3, 0.5, 0.7, 0.9)  # of the range of airspeeds
CODES = ", "  # between two
WRONG_BELOW = 0.5  # share of the curve inside its bound
WRONG_BY = 2.0  # of its bound
RANKS = 10  # classes of the test of ranks
CELL_OF = {cell.name: cell for cells in SETS.values() for cell in cells}
PROBES = ("probe_2k", "probe_5k", "probe_-5k", "probe_-20k")


@dataclass(frozen=True, slots=True)
class BuildRow:
    """What one build made of one written log; airspeeds in kt. A column of the file each."""

    set: str
    seed: int
    options: str
    maneuver: str
    gps_hz: float
    outcome: str  # answered, refused or crashed
    inside: float = NAN  # share of the curve inside its bound
    two_sigma_kt: float = NAN  # mean over the curve
    rms_kt: float = NAN
    z1: float = NAN  # error over half the bound, at `Z_AT`
    z2: float = NAN
    z3: float = NAN
    z4: float = NAN
    z5: float = NAN
    worst: float = NAN  # the largest error over the bound
    wind_inside: float = NAN  # share of the two components
    warned: float = NAN  # 1 where there was any warning
    headline: float = NAN  # 1 where two findings disagree
    usable: float = NAN  # 0 where the answer says not to use it
    cpu_s: float = NAN
    codes: str = ""  # of the checks that warn, with their columns, and kinds of the disagreements
    says: str = ""  # warnings and disagreements, or why there is no answer


def options_known(stated: Mapping[str, Any]) -> tuple[CalibrationOptions, str]:
    """The options of this build and their words; a choice that it does not know is left out, with a
    note on the error stream.
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
    """Read and calibrate a log, and hold the answer against its truth: entries of a `BuildRow`."""
    log, begun = None, 0.0
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
    """The curve and the wind of an answer against the truth."""
    at = np.array(truth["indicated_airspeed_kt"])
    curve = found.curve
    airspeed = curve.indicated_airspeed / KNOT
    flown = (airspeed > at[0] - 0.02) & (airspeed < at[-1] + 0.02)
    true = np.interp(airspeed, at, truth["correction_kt"])
    error, bound = curve.correction / KNOT - true, curve.two_sigma / KNOT
    places = at[0] + np.array(Z_AT) * (at[-1] - at[0])
    z = np.interp(places, airspeed, error) / (0.5 * np.interp(places, airspeed, bound))
    wind = NAN
    if found.wind is not None:
        parts = (found.wind.north, found.wind.east)
        off = np.array([part.value for part in parts]) / KNOT - truth["mean_wind_kt"]
        wind = np.mean(np.abs(off) <= np.array([part.two_sigma for part in parts]) / KNOT)
    told = (*found.warnings, *(each.words for each in found.disagreements))
    return {
        "inside": np.mean(np.abs(error[flown]) <= bound[flown]),
        "two_sigma_kt": np.mean(bound[flown]),
        "rms_kt": np.sqrt(np.mean(error[flown] ** 2)),
        **{f"z{number}": value for number, value in enumerate(z, start=1)},
        "worst": np.max(np.abs(error[flown]) / bound[flown]),
        "wind_inside": wind,
        "warned": float(bool(found.warnings)),
        "headline": float(bool(found.disagreements)),
        "usable": float(found.usable),
        "codes": CODES.join(
            sorted(
                {f"{w.code} {w.column}".strip() for w in found.warnings}
                | {each.kind for each in found.disagreements}
            )
        ),
        "says": " | ".join(told),
    }


def judge_folders(folders: Sequence[Path], out: Path, stated: Mapping[str, Any]) -> None:
    """Judge the logs under folders that the file has no row of yet, and append a row each.

    Raises BadInputError for folders without written logs.
    """
    paths = sorted(path for folder in folders for path in folder.rglob(f"*{TRUTH}"))
    if not paths:
        raise BadInputError(f"{folders[0]} holds no log with its truth: write with outside write")
    done = {(row.set, row.seed, row.options) for row in read_rows(out, BuildRow)}
    choices: dict[str, tuple[CalibrationOptions, str]] = {}
    warm = False
    with append_to(out, BuildRow) as append:
        for path in paths:
            truth = json.loads(path.read_text(encoding="utf-8"))
            # what the set needs yields to what is stated
            asked = {**COMMAND_DEFAULTS, **truth["calibrate"], **stated}
            word = json.dumps(asked, sort_keys=True)
            if word not in choices:
                choices[word] = options_known(asked)
            options, words = choices[word]
            if (truth["set"], truth["seed"], words) in done:
                continue
            done.add((truth["set"], truth["seed"], words))
            log = path.with_name(path.name.removesuffix(TRUTH) + ".csv")
            if not warm:  # what loads with the first calibration is not its time
                judge_log(log, truth, options)
                warm = True
            named = {name: truth[name] for name in ("set", "seed", "maneuver", "gps_hz")}
            row = BuildRow(**named, options=words, **judge_log(log, truth, options))
            append(row)
            print(f"{row.set} {row.seed} {row.maneuver}: {row.outcome}", file=sys.stderr)


def judge_command(parser: argparse.ArgumentParser, words: Sequence[str]) -> None:
    """Judge the installed build on logs of `outside write`; a run that was ended goes on."""
    parser.add_argument("folders", nargs="+", metavar="FOLDER", type=Path)
    parser.add_argument("--out", type=Path, required=True, help="one row a log (CSV)")
    parser.add_argument("--calibrate", default="{}", help="choices of the calibration (JSON)")
    choice = parser.parse_args(words)
    try:
        stated = json.loads(choice.calibrate)
    except json.JSONDecodeError as error:
        parser.error(f"--calibrate {choice.calibrate!r}: {error}")
    judge_folders(choice.folders, choice.out, stated)


def wilson(count: int, of: int) -> tuple[float, float]:
    """The 95 % interval of a share [%] (Wilson 1927)."""
    if not of:
        return NAN, NAN
    found = binomtest(count, of).proportion_ci(method="wilson")
    return 100.0 * float(found.low), 100.0 * float(found.high)


def is_wrong(row: BuildRow) -> bool:
    """Whether under half of the curve is inside its bound, or a point is off by twice its bound."""
    return row.inside < WRONG_BELOW or row.worst > WRONG_BY


def is_silent(row: BuildRow) -> bool:
    """Whether an answer has neither a warning nor a disagreement."""
    return row.warned == 0.0 and row.headline == 0.0


def is_named(row: BuildRow) -> bool:
    """Whether a finding names what is wrong with the flights of the kind; any word where nothing
    has a name of its own.
    """
    pattern = CELL_OF[row.set].named if row.set in CELL_OF else ""
    return not is_silent(row) and bool(re.search(pattern, row.says, re.IGNORECASE))


def _mean_held(rows: Sequence[BuildRow]) -> float:
    """The mean share [%] of the curve inside its bound, all of it where what is wrong is named."""
    held = [1.0 if is_named(row) else row.inside for row in rows]
    return 100.0 * float(np.mean(held)) if held else NAN


FIGURES: dict[str, Callable[[Sequence[BuildRow]], str]] = {
    "n": lambda rows: str(len(rows)),
    "inside %": lambda rows: text_of(100.0 * _mean(rows, "inside"), 1),
    "bound": lambda rows: text_of(_mean(rows, "two_sigma_kt"), 2),
    "rms": lambda rows: text_of(np.sqrt(np.mean(_of(rows, "rms_kt") ** 2)) if rows else NAN, 2),
    "rms z": lambda rows: text_of(np.sqrt(np.mean(_z_of(rows) ** 2)) if rows else NAN, 2),
    "wrong": lambda rows: str(sum(map(is_wrong, rows))),
    "silent": lambda rows: str(sum(is_wrong(row) and is_silent(row) for row in rows)),
    "named": lambda rows: str(sum(map(is_named, rows))),
    "in or named %": lambda rows: text_of(_mean_held(rows), 1),
    "warned": lambda rows: str(sum(not is_silent(row) for row in rows)),
    "headline": lambda rows: str(sum(row.headline == 1.0 for row in rows)),
    "wind %": lambda rows: text_of(100.0 * _mean(rows, "wind_inside"), 0),
    "CPU s": lambda rows: text_of(_mean(rows, "cpu_s"), 2),
}


def compared(
    first: Sequence[BuildRow], second: Sequence[BuildRow]
) -> tuple[list[list[str]], list[str]]:
    """The rows of a table of two builds, a kind each and totals, and what is said below it.

    Counted are the logs that both files have; `n` are those answered, and `2/1` is the mean bound of
    the second over that of the first where both answer.
    """
    for rows in (first, second):
        if len({(row.set, row.seed) for row in rows}) < len(rows):
            raise BadInputError("a file has a log twice, with other options: choose with --options")
    keys = {(row.set, row.seed) for row in first} & {(row.set, row.seed) for row in second}
    sides = [{(row.set, row.seed): row for row in rows} for rows in (first, second)]
    kinds = {name: [key for key in keys if key[0] == name] for name, _ in sorted(keys)}
    if len(kinds) > 1:
        kinds["all"] = list(keys)
        kinds["without probes"] = [key for key in keys if key[0] not in PROBES]
        for name in sorted({sides[0][key].maneuver for key in keys}):
            kinds[name] = [key for key in kinds["without probes"] if sides[0][key].maneuver == name]
    lines = [["kind", *(f"{name} {side}" for name in FIGURES for side in (1, 2)), "2/1"]]
    below = []
    for kind, chosen in kinds.items():
        answered = [
            [side[key] for key in sorted(chosen) if side[key].outcome == "answered"]
            for side in sides
        ]
        entries = [figure(rows) for figure in FIGURES.values() for rows in answered]
        both = [key for key in chosen if all(side[key].outcome == "answered" for side in sides)]
        means = [_mean([side[key] for key in both], "two_sigma_kt") for side in sides]
        lines.append([kind, *entries, text_of(means[1] / means[0], 2)])
        below += [f"{kind}, {side}: {_said_of(rows)}" for side, rows in enumerate(answered, 1)]
    return lines, below


def _said_of(rows: Sequence[BuildRow]) -> str:
    """Intervals of what is wrong and of the share inside, and the test of the ranks."""
    wrong = sum(map(is_wrong, rows))
    silent = sum(is_wrong(row) and is_silent(row) for row in rows)
    spread = standard_error(100.0 * _of(rows, "inside"))
    intervals = [
        f"{name} {count} of {len(rows)} ({low:.1f} to {high:.1f} %)"
        for name, count in (("wrong", wrong), ("in silence", silent))
        for low, high in [wilson(count, len(rows))]
    ]
    inside = f"inside {text_of(100.0 * _mean(rows, 'inside'), 1)} ± {text_of(spread, 1)} %"
    codes = Counter(code for row in rows for code in row.codes.split(CODES) if code)
    said = ", ".join(f"{code} {count}" for code, count in codes.most_common()) or "nothing"
    return ", ".join([*intervals, inside, ranks_of(rows), f"said: {said}"])


def ranks_of(rows: Sequence[BuildRow]) -> str:
    """Whether the ranks Φ(z) are uniform, by one place a flight."""
    z = _z_of(rows)
    if len(z) < RANKS:
        return "ranks –"
    one = z[np.arange(len(z)), np.arange(len(z)) % len(Z_AT)]
    counts = np.histogram(norm.cdf(one), bins=RANKS, range=(0.0, 1.0))[0]
    return f"ranks {' '.join(map(str, counts))} (uniform: p = {chisquare(counts).pvalue:.2g})"


def _z_of(rows: Sequence[BuildRow]) -> Array:
    """Errors over half the bound, (rows, places)."""
    z = [[getattr(row, f"z{number}") for number in range(1, len(Z_AT) + 1)] for row in rows]
    return np.array(z).reshape(-1, len(Z_AT))


def _of(rows: Sequence[BuildRow], name: str) -> Array:
    return np.array([getattr(row, name) for row in rows], dtype=np.float64)


def _mean(rows: Sequence[BuildRow], name: str) -> float:
    values = _of(rows, name)
    values = values[np.isfinite(values)]
    return float(np.mean(values)) if len(values) else NAN


def compare_command(parser: argparse.ArgumentParser, words: Sequence[str]) -> None:
    """Print two files of `outside judge` side by side, a line a kind."""
    add = parser.add_argument
    add("first", type=Path)
    add("second", type=Path)
    add(
        "--options",
        nargs=2,
        default=("", ""),
        metavar="TEXT",
        help="of each file, only rows whose options hold the text",
    )
    choice = parser.parse_args(words)
    rows = [
        [row for row in read_rows(path, BuildRow) if text in row.options]
        for path, text in zip((choice.first, choice.second), choice.options, strict=True)
    ]
    lines, below = compared(rows[0], rows[1])
    print(aligned(lines), *below, sep="\n")
