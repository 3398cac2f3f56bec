"""Hold what the product says of broken pitots, good logs and scales against what is true.

Each log is written as a file, read and calibrated as the command does it. A broken one is named
where what is said above the answer, or the refusal, holds the words of its kind; said without them,
it is told under another cause; an answer that may be used and warns of nothing is a silence.
"""

import argparse
import csv
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from functools import partial
from itertools import combinations
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from pitotbench.bench.calibrations import calibrate_each
from pitotbench.broken import find_broken
from pitotbench.campaigns.flights import sense
from pitotbench.logbook.reading import read_log
from pitotbench.records import BadInputError, NoAnswerError
from pitotbench.records.calibration import Calibration
from pitotbench.records.case import Case
from pitotbench.records.log import FlightLog
from pitotbench.sensing.sampling import data_system
from pitotbench.simulation.maneuvers import PAPER_MANEUVERS
from pitotbench.simulation.sortie import fly
from pitotlab.broken.breaks import BASE, KINDS, LIGHT, Kind, broken_columns
from pitotlab.broken.dataflash import write_dataflash
from pitotlab.broken.ulog import write_ulog
from pitotlab.outside.generator import OutsideFlight, generate, write_csv
from pitotlab.outside.kinds import KINDS as GOOD_KINDS
from pitotlab.outside.kinds import ROUGH
from pitotlab.outside.moving_air import Cell
from pitotlab.outside.physics import Array, calibrated_airspeed, impact_pressure
from pitotlab.sets import seeds_of

Key = tuple[str, str, int]
Job = Callable[[Path], Iterator["BrokenRow"]]

CONTAINERS = (".csv", ".bin")
TABLE = Path(__file__).parents[1] / "results" / "broken.csv"
# What is said of a broken pitot, and of nothing else.
SIGNS = (*{word for kind in KINDS.values() for word in kind.words if word != "half"}, "freezes")
BENCH_EACH = 5  # one of so many good logs is flown on the bench
FACTORS = (0.6, 1.6)
THINNED = 2  # every second row of a scaled log is kept, in each container
COPIED = (
    "garmin/c172s-g1000-2011.csv.gz", "garmin/pa28-gifd-2024.csv.gz", "citation/2019-03-12.parquet",
    *(f"perlan/flight{n}-{seat}.igc.gz" for n in (50, 52) for seat in ("front", "rear")),
)  # fmt: skip
MAPPED = {"jmoss/CLASS55.csv": "jmoss", "jmoss/CLASS65.csv": "jmoss", "seaway": "seaway"}


@dataclass(frozen=True, slots=True)
class BrokenRow:
    """What was said of one log. A column of the table each."""

    set: str
    kind: str
    container: str
    seed: int
    outcome: str
    factor: float = float("nan")  # true factor on the airspeed
    found: float = float("nan")
    two_sigma: float = float("nan")
    says: str = ""

    @property
    def key(self) -> Key:
        """What is measured: set, kind where it is chosen, seed."""
        return self.set, self.kind if self.set in ("broken", "real") else "", self.seed


def written(columns: Mapping[str, Array], container: str, folder: Path) -> Path:
    """Write columns in a container and return the file."""
    path = folder / f"log{container}"
    (write_dataflash if container == ".bin" else write_csv)(columns, path)
    return path


SCALED: dict[str, Callable[[Mapping[str, Array], Path], None]] = {
    ".csv": write_csv, ".bin": partial(write_dataflash, every=1), ".ulg": write_ulog,
}  # fmt: skip


def answer_of(path: Path) -> tuple[Calibration | None, str]:
    """The answer of the command for a file, and what it says above it: the refusal without one."""
    try:
        found = calibrate_each([read_log(path)])[0].calibration
    except (BadInputError, NoAnswerError) as error:
        return None, str(error).partition(": ")[2] or str(error)
    lead = [each.words for each in found.disagreements if each.fatal]
    told = [str(each) for each in found.warnings if each.code in ("scale", "broken pitot")]
    return found, " | ".join([*lead, *told])


def outcome_of(kind: Kind, found: Calibration | None, says: str) -> str:
    """`named`, `another cause` or `silence`."""
    if any(word in says for word in kind.words):
        return "named"
    return "another cause" if says or found is None else "silence"


def broken_rows(kind: Kind, seed: int, variant: int, folder: Path) -> Iterator[BrokenRow]:
    """Read a broken log in each container that can hold it."""
    columns = broken_columns(kind, seed, variant)
    for container in CONTAINERS[:1] if kind.shown else CONTAINERS:
        found, says = answer_of(written(columns, container, folder))
        outcome = outcome_of(kind, found, says)
        yield BrokenRow("broken", kind.name, container, seed, outcome, says=says)


def _false(log: FlightLog) -> str:
    """What is wrongly said of a good log, empty where nothing is."""
    told = find_broken(log.channels())
    if told is not None:
        return told.words
    try:
        found = calibrate_each([log])[0].calibration
    except (BadInputError, NoAnswerError) as error:
        return next((str(error) for word in SIGNS if word in str(error)), "")
    wrong = [each.words for each in found.disagreements if each.kind in ("scale", "pitot")]
    return " | ".join(wrong)


def good_rows(number: int, seed: int, folder: Path) -> Iterator[BrokenRow]:
    """Read a good log: a flight of the outside generator in one of its kinds, or of the bench."""
    cells = list((GOOD_KINDS | ROUGH).values())
    name = "bench" if number % BENCH_EACH == 0 else cells[number % len(cells)].name
    try:
        if name == "bench":
            log = _bench_log(seed)
        else:
            cell = cells[number % len(cells)]
            flight = generate(cell, cell.maneuvers[seed % len(cell.maneuvers)], seed)
            log = read_log(written(flight.columns, ".csv", folder))
        says = _false(log)
    except BadInputError as error:
        says = str(error)
    yield BrokenRow("good", name, "", seed, "false" if says else "right", says=says)


def _bench_log(seed: int) -> FlightLog:
    maneuver = PAPER_MANEUVERS[seed % len(PAPER_MANEUVERS)]
    turbulence = ("none", "light", "moderate")[seed // 5 % 3]
    case = Case(maneuver=maneuver, turbulence=turbulence, truth_seed=seed, sensor_seed=seed)
    return sense(fly(case), data_system(("20/1", "50/50", "20/5")[seed % 3]))


def real_rows(data: Path, name: str, mapping: str | None, _: Path) -> Iterator[BrokenRow]:
    """Read a measured log that is at hand."""
    says = _false(read_log(data / name, mapping))
    yield BrokenRow("real", name, "", 0, "false" if says else "right", says=says)


def scaled(flight: OutsideFlight, factor: float) -> dict[str, Array]:
    """The columns of a log whose airspeed is to be multiplied by `factor`, without a temperature."""
    columns = {n: c for n, c in flight.columns.items() if "temperature" not in n}
    shown = calibrated_airspeed(np.maximum(columns["impact_pressure_pa"], 0.0)) / factor
    return columns | {"impact_pressure_pa": impact_pressure(shown)}


def scaled_flight(cell: Cell, seed: int, given: float) -> tuple[dict[str, Array], float]:
    """Fly a cell; return every second row of its log with the airspeed divided by a factor, and the
    true factor on it, the airplane's own error included.
    """
    flight = generate(cell, cell.maneuvers[seed % len(cell.maneuvers)], seed)
    right = calibrated_airspeed(flight.state.impact)
    own = float(np.mean(right / calibrated_airspeed(flight.state.indicated_impact)))
    return {n: c[::THINNED] for n, c in scaled(flight, given).items()}, given * own


def scale_rows(number: int, seed: int, folder: Path) -> Iterator[BrokenRow]:
    """Find a factor from 0.6 to 1.6, the airplane's own error included, in each container."""
    cell = replace((BASE, LIGHT)[number % 2], temperature="air")
    given = FACTORS[0] + (FACTORS[1] - FACTORS[0]) * ((number * 0.618) % 1.0)
    columns, true = scaled_flight(cell, seed, given)
    for container in SCALED:
        path = folder / f"log{container}"
        SCALED[container](columns, path)
        found, says = answer_of(path)
        row = BrokenRow("scale", cell.name, container, seed, "refused", true, says=says)
        if found is not None and found.scale is not None:
            factor, two_sigma = found.scale.factor, found.scale.two_sigma
            outcome = "inside" if abs(factor - true) <= two_sigma else "outside"
            row = replace(row, outcome=outcome, found=factor, two_sigma=two_sigma)
        yield row


GOOD, SCALES = 300, 40  # logs that are good, and logs whose airspeed has a factor


def jobs(choice: argparse.Namespace, seeds: range) -> Iterator[tuple[Key, Job]]:
    """What is to be measured, one log each: its key in the table, and what gives its rows from a
    folder to write in; good logs, which take longest, come last.
    """
    place = iter(seeds)
    for kind in KINDS.values():
        for variant, seed in zip(range(choice.each), place, strict=False):
            yield ("broken", kind.name, seed), partial(broken_rows, kind, seed, variant)
    good = list(zip(range(GOOD), place, strict=False))
    for name, mapping in ({**dict.fromkeys(COPIED), **MAPPED} if choice.data else {}).items():
        if (choice.data / name).exists():
            yield ("real", name, 0), partial(real_rows, choice.data, name, mapping)
    for number, seed in zip(range(SCALES), place, strict=False):
        yield ("scale", "", seed), partial(scale_rows, number, seed)
    for number, seed in good:
        yield ("good", "", seed), partial(good_rows, number, seed)


def command(parser: argparse.ArgumentParser, words: Sequence[str]) -> None:
    """Count broken pitots that are named, false alarms on good logs, and scales inside their bound.

    A measurement that was stopped goes on where its table ends.
    """
    parser.add_argument("--seeds", required=True, metavar="A:B", help="from A to B - 1")
    parser.add_argument("--each", type=int, default=6, help="logs of a kind (default: %(default)s)")
    parser.add_argument("--data", type=Path, help="folder of measured logs")
    parser.add_argument("--out", type=Path, help=f"write the table, such as {TABLE.name}")
    choice = parser.parse_args(words)
    seeds = seeds_of(parser, choice.seeds)
    if len(seeds) < (needed := choice.each * len(KINDS) + GOOD + SCALES):
        parser.error(f"give {needed} seeds")
    head = f"# python -m pitotlab broken --seeds {choice.seeds}"
    rows = list(_kept(choice.out, head)) if choice.out else []
    done = {row.key for row in rows}
    with TemporaryDirectory() as folder:
        for key, job in jobs(choice, seeds):
            if key not in done:
                rows += [_told(row) for row in job(Path(folder))]
                if choice.out:
                    _write(rows, choice.out, head)
    for line in summary(rows):
        print(line)


def _told(row: BrokenRow) -> BrokenRow:
    if row.outcome not in ("named", "right", "inside"):
        print(
            f"  {row.set} {row.kind} {row.container} {row.seed}: {row.outcome} {row.factor:.3f} "
            f"{row.found:.3f} ± {row.two_sigma:.3f} {row.says[:200]}",
            flush=True,
        )
    return row


def summary(rows: Sequence[BrokenRow]) -> Iterator[str]:
    """Counts by set, by kind of broken pitot, and how far the containers' scales differ."""
    for name in dict.fromkeys(row.set for row in rows):
        counts = Counter(row.outcome for row in rows if row.set == name)
        told = ", ".join(f"{count} {outcome}" for outcome, count in counts.most_common())
        yield f"{name}: {sum(counts.values())} logs: {told}"
    for kind in KINDS:
        counts = Counter(r.outcome for r in rows if (r.set, r.kind) == ("broken", kind))
        yield f"  {kind}: " + ", ".join(f"{n} {outcome}" for outcome, n in counts.most_common())
    found: dict[int, dict[str, BrokenRow]] = {}
    for row in rows:
        if row.set == "scale" and np.isfinite(row.found):
            found.setdefault(row.seed, {})[row.container] = row
    for one, other in combinations(SCALED, 2):
        pairs = [(e[one], e[other]) for e in found.values() if {one, other} <= e.keys()]
        apart = [abs(a.found - b.found) / (0.5 * max(a.two_sigma, b.two_sigma)) for a, b in pairs]
        if apart:
            told = f"{np.median(apart):.2f} σ apart (median), {max(apart):.2f} at most"
            yield f"scales of {one} and {other}: {told}, of {len(apart)}"


def _kept(path: Path, head: str) -> Iterator[BrokenRow]:
    """The rows of a measurement that was stopped, none where the table is of another one."""
    if not path.exists():
        return
    with path.open(encoding="utf-8", newline="") as file:
        if file.readline().rstrip("\n") != head:
            return
        for row in csv.DictReader(file):
            kept: dict[str, Any] = {**row, "seed": int(row["seed"])}
            yield BrokenRow(**kept | {n: float(row[n]) for n in ("factor", "found", "two_sigma")})


def _write(rows: Sequence[BrokenRow], path: Path, head: str) -> None:
    part = path.with_suffix(".part")  # a run that is stopped here leaves the table before
    with part.open("w", encoding="utf-8", newline="") as file:
        file.write(head + "\n")
        table = csv.DictWriter(file, [f.name for f in fields(BrokenRow)], lineterminator="\n")
        table.writeheader()
        for row in rows:
            numbers = {n: f"{v:.6g}" if isinstance(v, float) else v for n, v in asdict(row).items()}
            table.writerow(numbers | {"says": row.says[:60]})
    part.replace(path)
