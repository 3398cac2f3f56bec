"""Which tables of results are of another build: some flights of each are flown again, and their digits
compared.

A new table is a line of `KEPT`, and `python -m pitotlab stale --keep NAME` on the build that flew it.
"""

import csv
import subprocess
from argparse import ArgumentParser
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from datetime import UTC, datetime
from functools import cache, partial
from pathlib import Path
from tempfile import TemporaryDirectory

from pitotbench.bench.calibrations import DEFAULTS
from pitotbench.calibration import calibrate
from pitotbench.calibration.options import CalibrationOptions, options_from
from pitotbench.campaigns.flights import sense
from pitotbench.logbook.columns import atomic
from pitotbench.logbook.reading import read_log
from pitotbench.records import NoAnswerError
from pitotbench.records.calibration import Calibration
from pitotbench.records.log import FlightLog
from pitotbench.simulation.sortie import fly
from pitotbench.units import KNOT
from pitotlab import experiment as lab
from pitotlab.made import RESULTS, TABLES, Made, read_made
from pitotlab.outside.generator import generate, write_csv
from pitotlab.outside.moving_air import CELLS
from pitotlab.study.reductions import PAPER, case_of

DIGITS = RESULTS / "digits.csv"
MOVED = 0.01  # of 2σ
LAW, COMMAND = CalibrationOptions(), options_from(DEFAULTS)
_JUDGED = (":/src/pitotbench/calibration", ":/src/pitotbench/estimation")


@dataclass(frozen=True, slots=True)
class Digits:
    """The digits of a flight: a value and its 2σ [kt]."""

    table: str
    flight: str
    value: float
    two_sigma: float


@cache
def _covered(cell: str) -> FlightLog:
    maneuver, turbulence, seed = cell.split()
    case = lab.random_case(lab.Trial(maneuver, turbulence, int(seed)))
    return sense(fly(case), "20/1")


def _middle(found: Calibration) -> tuple[float, float]:
    """Return the correction in the middle of a curve and its 2σ [kt]."""
    curve, place = found.curve, len(found.curve.correction) // 2
    return float(curve.correction[place]) / KNOT, float(curve.two_sigma[place]) / KNOT


def of_coverage(options: CalibrationOptions, flight: str) -> tuple[float, float]:
    """Return the digits of a flight of the coverage, `maneuver turbulence seed`."""
    return _middle(calibrate(_covered(flight), options))


def of_outside(flight: str) -> tuple[float, float]:
    """Return the digits of a flight of the independent generator, `cell seed`."""
    name, seed = flight.split()
    cell = CELLS[name]
    flown = generate(cell, cell.maneuvers[int(seed) % len(cell.maneuvers)], int(seed))
    with TemporaryDirectory() as folder:
        path = Path(folder) / "log.csv"
        write_csv(flown.columns, path)
        return _middle(calibrate(read_log(path), COMMAND))


def of_study(flight: str) -> tuple[float, float]:
    """Return the 2σ of the residual of a flight of the study, `setting maneuver seed`, twice."""
    setting, maneuver, seed = flight.split()
    found = calibrate(sense(fly(case_of(setting, maneuver, int(seed))), "50/50"), PAPER)
    return (found.residual_two_sigma / KNOT,) * 2


def _rapid_decels(first: int) -> tuple[str, ...]:
    airs = ("none", "light", "moderate") * 4
    return tuple(f"rapid_decel {airs[place]} {first + place}" for place in range(10))


_STUDY = [
    f"smooth {maneuver} {seed}"
    for maneuver in ("rapid_decel", "step_decrease", "circle")
    for seed in range(7_700_001, 7_700_004)
]
# The name of a table: its flights, and what gives the digits of one.
KEPT: Mapping[str, tuple[Sequence[str], Callable[[str], tuple[float, float]]]] = {
    "coverage, the paper's law": (_rapid_decels(100_001), partial(of_coverage, LAW)),
    "coverage, the command's defaults": (_rapid_decels(171_001), partial(of_coverage, COMMAND)),
    "outside": (
        tuple(f"{cell} {seed}" for seed, cell in enumerate(list(CELLS)[:10], start=6_700_000)),
        of_outside,
    ),
    "study": ((*_STUDY, "smooth race_track 7700001"), of_study),
}


def digits_of(table: str, flights: Sequence[str]) -> list[Digits]:
    """Return the digits of some flights of a table, by this build; NaN for a flight refused."""
    found = []
    for flight in flights:
        try:
            value, two_sigma = KEPT[table][1](flight)
        except NoAnswerError:
            value = two_sigma = float("nan")
        found.append(Digits(table, flight, round(value, 6), round(two_sigma, 6)))
    return found


def moved(kept: Sequence[Digits], now: Sequence[Digits]) -> list[tuple[Digits, float]]:
    """Return the flights whose value or 2σ moved by more than 1 % of the 2σ kept, with the share.

    A flight that is refused by one build alone has moved by all.
    """
    found = []
    for old, new in zip(kept, now, strict=True):
        change = max(abs(new.value - old.value), abs(new.two_sigma - old.two_sigma))
        same = old.value != old.value and new.value != new.value  # refused by both
        share = 0.0 if same else change / old.two_sigma
        if not share <= MOVED:
            found.append((old, share))
    return found


def read_digits() -> dict[str, list[Digits]]:
    """Return the digits that are kept, by table."""
    found: dict[str, list[Digits]] = {}
    with DIGITS.open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            each = Digits(row["table"], row["flight"], float(row["value"]), float(row["two_sigma"]))
            found.setdefault(each.table, []).append(each)
    return found


def _write(path: Path, kind: type[Digits] | type[Made], rows: Sequence[Digits | Made]) -> None:
    with atomic(path) as scratch, scratch.open("w", encoding="utf-8", newline="") as file:
        table = csv.DictWriter(file, [f.name for f in fields(kind)], lineterminator="\n")
        table.writeheader()
        table.writerows(map(asdict, rows))


def _git(*words: str) -> str:
    """Return what git says in the checkout, or nothing where there is none."""
    done = subprocess.run(
        ["git", *words], cwd=RESULTS, capture_output=True, encoding="utf-8", check=False
    )
    return done.stdout.strip()


def keep(table: str) -> None:
    """Write the digits of a table by this build, and the build and the date beside its name."""
    digits = read_digits() | {table: digits_of(table, KEPT[table][0])}
    today = {
        "build": _git("rev-parse", "--short=8", "HEAD"),
        "date": f"{datetime.now(UTC):%Y-%m-%d}",
    }
    made = [Made(**asdict(m) | today) if m.table == table else m for m in read_made()]
    _write(DIGITS, Digits, [row for rows in digits.values() for row in rows])
    _write(TABLES, Made, made)


def stale(most: int | None = None) -> list[str]:
    """Return a line a table whose digits moved or that keeps none, of `most` flights of each."""
    lines = []
    for made in read_made():
        kept = read_digits().get(made.table, [])[:most]
        commits = _git("rev-list", "--count", f"{made.build}..HEAD", "--", *_JUDGED)
        head = (
            f"{made.table} ({made.date}, {made.build}, {commits or '?'} commits to the calibration)"
        )
        if not kept:
            lines.append(f"{head}: keeps no digits")
            continue
        changed = moved(kept, digits_of(made.table, [each.flight for each in kept]))
        if changed:
            worst, share = max(changed, key=lambda each: each[1])
            lines.append(
                f"{head}: {len(changed)} of {len(kept)} flights moved, at most by {share:.0%} of 2σ "
                f"({worst.flight})"
            )
    return lines


def command(parser: ArgumentParser, words: Sequence[str]) -> int:
    """List the tables of results whose digits this build does not give again, by more than 1 % of 2σ.

    Returns 1 where there are any. About a minute of CPU time.
    """
    parser.add_argument(
        "--keep", choices=KEPT, help="write the digits of a table that was flown anew"
    )
    choice = parser.parse_args(words)
    if choice.keep:
        keep(choice.keep)
        return 0
    lines = stale()
    print("\n".join(lines) or "no table is stale")
    return int(bool(lines))
