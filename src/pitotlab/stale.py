"""Which tables of results are of another build: some flights of each are flown again, and their digits
compared.

A new table is a line of `KEPT`, and `python -m pitotlab stale --keep NAME` on the build that flew it.
"""

import csv
from argparse import ArgumentParser
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from itertools import islice
from pathlib import Path
from tempfile import TemporaryDirectory

from pitotbench.bench.calibrations import DEFAULTS
from pitotbench.calibration import calibrate
from pitotbench.calibration.options import CalibrationOptions, options_from
from pitotbench.campaigns.flights import sense
from pitotbench.campaigns.plan_file import read_plan
from pitotbench.campaigns.task import Task
from pitotbench.logbook.formats import write_log
from pitotbench.logbook.reading import read_log
from pitotbench.records import NoAnswerError
from pitotbench.records.calibration import Calibration
from pitotbench.records.log import FlightLog
from pitotbench.simulation.maneuvers import PAPER_MANEUVERS
from pitotbench.simulation.sortie import fly, scaled_case
from pitotbench.units import KNOT
from pitotlab import experiment as lab
from pitotlab.aircraft import FOREIGN, SYSTEM
from pitotlab.blind.analyze import judge
from pitotlab.broken.breaks import KINDS, broken_columns
from pitotlab.broken.measure import answer_of, outcome_of, written
from pitotlab.coverage import COVERED
from pitotlab.derivatives.files import AIRPLANES
from pitotlab.derivatives.generate import draw_cases, flown_log
from pitotlab.drills.drivers import write_plan_file
from pitotlab.made import RESULTS, read_made, said_by_git, write_made, write_rows
from pitotlab.outside.moving_air import CELLS
from pitotlab.outside.written import TRUTH, write_flight
from pitotlab.reference_figures import FLOWN, published_figures
from pitotlab.study import methods
from pitotlab.study.reductions import PAPER, case_of

DIGITS = RESULTS / "digits.csv"
MOVED = 0.01  # of 2σ
LAW, COMMAND = CalibrationOptions(), options_from(DEFAULTS)
_JUDGED = (":/src/pitotbench/calibration", ":/src/pitotbench/estimation")
Pair = tuple[float, float]  # a value and its 2σ


@dataclass(frozen=True, slots=True)
class Digits:
    """The digits of a flight: a value and its 2σ, in kt where the table has no other unit."""

    table: str
    flight: str
    value: float
    two_sigma: float


@dataclass(frozen=True, slots=True)
class Kept:
    """The flights of a table whose digits are kept, what gives those of one, and how many of them a
    check of a minute flies again.
    """

    flights: Sequence[str]
    digits: Callable[[str], Pair]
    quick: int = 3


def _middle(found: Calibration) -> Pair:
    """Return the correction in the middle of a curve and its 2σ [kt]."""
    curve, place = found.curve, len(found.curve.correction) // 2
    return float(curve.correction[place]) / KNOT, float(curve.two_sigma[place]) / KNOT


@cache
def _covered(cell: str) -> FlightLog:
    maneuver, turbulence, seed = cell.split()
    case = lab.random_case(lab.Trial(maneuver, turbulence, int(seed)))
    return sense(fly(case), "20/1")


@cache
def of_coverage(options: CalibrationOptions, flight: str) -> Pair:
    """Return the digits of a flight of the coverage, `maneuver turbulence seed`."""
    return _middle(calibrate(_covered(flight), options))


def of_aircraft(flight: str) -> Pair:
    """Return the digits of a flight of another airplane, `aircraft maneuver seed`."""
    name, maneuver, seed = flight.split()
    case = lab.random_case(lab.Trial(maneuver, "light", int(seed)))
    return _middle(calibrate(sense(fly(scaled_case(replace(case, aircraft=name))), SYSTEM)))


def of_outside(flight: str) -> Pair:
    """Return the digits of a flight of the independent generator, `cell seed`."""
    name, seed = flight.split()
    with TemporaryDirectory() as folder:
        beside = write_flight(CELLS[name], int(seed), Path(folder))
        log = read_log(beside.with_name(beside.name.removesuffix(TRUTH) + ".csv"))
    return _middle(calibrate(log, COMMAND))


def of_study(flight: str) -> Pair:
    """Return the 2σ of the residual of a flight of the study, `setting maneuver seed`, twice."""
    setting, maneuver, seed = flight.split()
    found = calibrate(sense(fly(case_of(setting, maneuver, int(seed))), "50/50"), PAPER)
    return (found.residual_two_sigma / KNOT,) * 2


def of_methods(flight: str) -> Pair:
    """Return the digits of a flight of the maneuvers, `maneuver seed`."""
    maneuver, seed = flight.split()
    case = case_of("light", maneuver, int(seed), pressure_error=methods.STATIC)
    return _middle(calibrate(sense(fly(case), methods.SYSTEM), methods.SPEED))


def of_broken(flight: str) -> Pair:
    """Return 1 where a broken pitot is named, `kind/seed/variant`, and 1."""
    kind, seed, variant = flight.split("/")
    with TemporaryDirectory() as folder:
        columns = broken_columns(KINDS[kind], int(seed), int(variant))
        found, says = answer_of(written(columns, ".csv", Path(folder)))
    return float(outcome_of(KINDS[kind], found, says) == "named"), 1.0


def of_reference(figure: str) -> Pair:
    """Return the model's value of a figure, and the tolerance in its unit."""
    (each,) = [f for f in published_figures() if f.name == figure]
    share = 0.01 * each.value if each.tolerance_unit == "%" else 1.0
    return FLOWN[each.maneuver]("navajo", each), share * each.tolerance


@cache
def _drills() -> list[Task]:
    with TemporaryDirectory() as folder:
        return [*read_plan(write_plan_file(Path(folder), "10")).tasks(keep_logs="none")]


def of_drills(number: str) -> Pair:
    """Return the digits of a flight of a campaign that is killed, by its number."""
    task = _drills()[int(number)]
    return _middle(calibrate(sense(fly(task.case), task.systems[0]), task.calibrations[0][1]))


def of_derivatives(flight: str) -> Pair:
    """Return the significance of the gap [σ] of an edited airplane, by its name, and 2σ of noise."""
    (case,) = [case for case in _EDITED if case.name == flight]
    with TemporaryDirectory() as folder:
        path = Path(folder) / "log.parquet"
        write_log(flown_log(case), path)
        return float(judge([path])["significance"]), 2.0


def _rapid_decels(table: str, airs: Sequence[str] = ("none", "light", "moderate")) -> list[str]:
    """Return the first ten flights of this maneuver of a table, by the seeds with which it was made."""
    (first,) = (int(made.seeds.split()[0]) for made in read_made() if made.table == table)
    return [f"rapid_decel {airs[n % len(airs)]} {first + n}" for n in range(10)]


# Those whose null flights are shipped.
_EDITED = [c for c in draw_cases(2_050_000, [*AIRPLANES], 1, 15) if c.airplane == "navajo"][:10]
_STUDY = [
    f"smooth {maneuver} {seed}"
    for maneuver in ("rapid_decel", "step_decrease", "circle")
    for seed in range(7_700_001, 7_700_004)
]
_PLANES = islice(
    (f"{name} rapid_decel {seed}" for seed in (100_001, 100_002) for name in FOREIGN), 10
)
_LAW, _COMMAND = COVERED.values()
KEPT: Mapping[str, Kept] = {
    _LAW: Kept(_rapid_decels(_LAW), partial(of_coverage, LAW)),
    _COMMAND: Kept(_rapid_decels(_COMMAND), partial(of_coverage, COMMAND)),
    "peers": Kept(_rapid_decels("peers", ["light"]), partial(of_coverage, LAW)),
    "outside": Kept(
        [f"{cell} {seed}" for seed, cell in enumerate(list(CELLS)[:10], start=6_700_120)],
        of_outside,
        5,
    ),
    "open questions": Kept(
        [
            f"light {maneuver} {seed}"
            for seed in (7_700_001, 7_700_002)
            for maneuver in PAPER_MANEUVERS
        ],
        of_study,
        2,
    ),
    "study": Kept([*_STUDY, "smooth race_track 7700001"], of_study),
    "reference": Kept([each.name for each in published_figures()][:10], of_reference),
    "drills": Kept([str(number) for number in range(10)], of_drills, 10),
    "broken": Kept([f"{kind}/{660_000 + 12 * n}/0" for n, kind in enumerate(KINDS)], of_broken, 5),
    "aircraft": Kept([*_PLANES], of_aircraft, 2),
    "maneuvers, ten seeds": Kept([f"rapid_decel {seed}" for seed in range(1, 11)], of_methods, 2),
    "derivatives": Kept([case.name for case in _EDITED], of_derivatives, 1),
}
# What ten flights cannot tell in a minute: times, measured logs, and null flights of other cards.
APART = ("sealed set", "speed", "terms")


def digits_of(table: str, flights: Sequence[str]) -> list[Digits]:
    """Return the digits of some flights of a table, by this build; NaN for a flight refused."""
    found = []
    for flight in flights:
        try:
            value, two_sigma = KEPT[table].digits(flight)
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


def keep(table: str) -> None:
    """Write the digits of a table by this build, and the build and the date beside its name."""
    digits = read_digits() | {table: digits_of(table, KEPT[table].flights)}
    write_rows(DIGITS, [row for rows in digits.values() for row in rows])
    write_made(table)


def stale(every: bool = False) -> tuple[list[str], list[str]]:
    """Return a line a table whose digits moved or that keeps none, and a line a table that has none.

    Some flights of each table are flown again, all that are kept with `every`.
    """
    lines, apart, held = [], [], read_digits()
    for made in read_made():
        commits = said_by_git("rev-list", "--count", f"{made.build}..HEAD", "--", *_JUDGED)
        head = (
            f"{made.table} ({made.date}, {made.build}, {commits or '?'} commits to the calibration)"
        )
        if made.table in APART:
            apart.append(f"{head}: not judged by digits")
            continue
        kept = held.get(made.table, [])
        if not kept:
            lines.append(f"{head}: keeps no digits")
            continue
        some = kept if every else kept[: KEPT[made.table].quick]
        changed = moved(some, digits_of(made.table, [each.flight for each in some]))
        if changed:
            worst, share = max(changed, key=lambda each: each[1])
            lines.append(
                f"{head}: {len(changed)} of {len(some)} flights moved, at most by {share:.0%} of 2σ "
                f"({worst.flight})"
            )
    return lines, apart


def command(parser: ArgumentParser, words: Sequence[str]) -> int:
    """List the tables of results whose digits this build does not give again, by more than 1 % of 2σ.

    Returns 1 where there are any. About a minute of CPU time, `--all` some four.
    """
    parser.add_argument("--keep", choices=KEPT, help="write the digits of a table, flown anew")
    parser.add_argument("--all", action="store_true", help="fly every flight that is kept")
    choice = parser.parse_args(words)
    if choice.keep:
        keep(choice.keep)
        return 0
    lines, apart = stale(choice.all)
    print("\n".join([*(lines or ["no table is stale"]), *apart]))
    return int(bool(lines))
