"""Hold the calibration's bounds against flights of the outside generator.

    python -m tests.outside.judge --cells base,calm --flights 60 --seed 1 --jobs 1 --out FILE.csv

writes one row a flight and prints one line a cell. Rows that the file already holds are not flown again. Seeds
below 50,000 serve development; a number that is published comes from seeds that begin at 600,000 or above, which
nobody has looked at while the code was written.

The calibration runs with the choices of `pitotbench calibrate` without a flag; `--options error_location=static`
states others, and its rows are kept apart from those.
"""

import argparse
import csv
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from tests.outside.cells import CELLS
from tests.outside.compressible import FOOT, KNOT
from tests.outside.generator import OutsideFlight, generate, write_csv
from tests.outside.oracle import USUAL, Height, bound, known_covariance
from tests.outside.tally import FORMS, table

from pitotbench.calibrate import CalibrationOptions, calibrate
from pitotbench.logbook import read_log
from pitotbench.records.calibration import Calibration, ErrorCurve
from pitotbench.records.errors import BadInputError, NoAnswerError
from pitotbench.units import Booleans

DEVELOPMENT_BELOW, SCORED_FROM = 50_000, 600_000
# Where the command's defaults are not those of CalibrationOptions.
COMMAND_DEFAULTS = {"latency": "checked", "wind": "checked"}
LONG_LOG = 600.0  # s; above it the oracle's blocks are twice as long, to save seven eighths of its time
NAN = float("nan")


@dataclass(frozen=True, slots=True)
class Row:
    """What came of one flight; speeds in kt. A column of the file each."""

    cell: str
    seed: int
    options: str
    maneuver: str
    gps_hz: float
    outcome: str  # answered, refused or crashed
    curve_coverage: float = NAN  # share of the curve's points inside their bound
    whole_band: float = NAN  # 1 where the band that is meant for the whole curve holds it
    wind_inside: float = NAN  # share of the two components
    two_sigma_kt: float = NAN  # mean over the curve
    rms_error_kt: float = NAN
    mean_error_kt: float = NAN
    wind_error_kt: float = NAN
    oracle_two_sigma_kt: float = NAN  # the triangle alone
    joined_two_sigma_kt: float = NAN  # with the height and the vertical velocity
    coverage_ft: float = NAN  # share of the points at which the position error is inside its bound; NaN without one
    two_sigma_ft: float = NAN  # mean over the curve
    rms_error_ft: float = NAN
    warned: float = NAN  # 1 where there was any warning
    seconds: float = NAN
    says: str = ""  # the warnings, or why there is no answer


def judge(cell: str, seed: int, stated: Mapping[str, str]) -> Row:
    """Fly one flight, calibrate its log, and hold the answer against the truth."""
    maneuvers = CELLS[cell].maneuvers
    flight = generate(CELLS[cell], maneuvers[seed % len(maneuvers)], seed)
    begun = time.perf_counter()
    found = _answer(flight, options_for(stated))
    entries: dict[str, float | str] = {
        "cell": cell,
        "options": options_text(stated),
        "maneuver": flight.maneuver,
        "gps_hz": flight.fix_rate,
        "seconds": round(time.perf_counter() - begun, 2),
    }
    if isinstance(found, Calibration):
        entries |= {"outcome": "answered", **_held_against_truth(found, flight), **_oracles(flight)}
    else:
        entries |= {"outcome": found[0], "says": found[1]}
    return Row(seed=seed, **entries)  # type: ignore[arg-type]


def options_for(stated: Mapping[str, str]) -> CalibrationOptions:
    """What the command `pitotbench calibrate` chooses, with some choices stated."""
    return CalibrationOptions(**{**COMMAND_DEFAULTS, **stated})  # type: ignore[arg-type]


def _answer(flight: OutsideFlight, options: CalibrationOptions) -> Calibration | tuple[str, str]:
    with TemporaryDirectory() as folder:
        path = Path(folder) / "log.csv"
        write_csv(flight, path)
        try:
            return calibrate(read_log(path), options)
        except (BadInputError, NoAnswerError) as error:
            return "refused", str(error)
        except Exception as error:  # a crash is a result of its kind and must not end a night's run
            return "crashed", f"{type(error).__name__}: {error}"


def _held_against_truth(found: Calibration, flight: OutsideFlight) -> dict[str, float | str]:
    curve, cell = found.curve, flight.cell
    inside = (curve.indicated_airspeed > cell.low - 0.01) & (curve.indicated_airspeed < cell.high + 0.01)
    error = (curve.correction - flight.correction(curve.indicated_airspeed))[inside]
    parts = (found.wind.north, found.wind.east)
    wind_error = np.array([part.value for part in parts]) - flight.truth.mean_wind
    within = np.abs(wind_error) <= np.array([part.two_sigma for part in parts])
    return {
        "curve_coverage": float(np.mean(np.abs(error) <= curve.two_sigma[inside])),
        "whole_band": float(np.all(np.abs(error) <= curve.simultaneous_two_sigma[inside])),
        "wind_inside": float(np.mean(within)),
        "two_sigma_kt": float(np.mean(curve.two_sigma[inside])) / KNOT,
        "rms_error_kt": float(np.sqrt(np.mean(error**2))) / KNOT,
        "mean_error_kt": float(np.mean(error)) / KNOT,
        "wind_error_kt": float(np.linalg.norm(wind_error)) / KNOT,
        **_position_error_held(curve, flight, inside),
        "warned": float(bool(found.warnings)),
        "says": " | ".join(found.warnings),
    }


def _position_error_held(curve: ErrorCurve, flight: OutsideFlight, inside: Booleans) -> dict[str, float]:
    """The position error against the truth; nothing where the answer has none, as for an error elsewhere."""
    if curve.altitude_correction is None or curve.altitude_two_sigma is None:
        return {}
    truth = flight.truth
    known = np.interp(curve.indicated_airspeed, truth.indicated_airspeed, truth.position_error)
    error = (curve.altitude_correction / FOOT - known)[inside]
    bound = curve.altitude_two_sigma[inside] / FOOT
    return {
        "coverage_ft": float(np.mean(np.abs(error) <= bound)),
        "two_sigma_ft": float(np.mean(bound)),
        "rms_error_ft": float(np.sqrt(np.mean(error**2))),
    }


def _oracles(flight: OutsideFlight) -> dict[str, float]:
    if not known_covariance(flight):
        return {}
    block = 2.0 if flight.state.time[-1] > LONG_LOG else 1.0
    return {
        name: float(np.mean(bound(flight, height, block, accuracy=USUAL).curve)) / KNOT
        for name, height in (("oracle_two_sigma_kt", Height.NONE), ("joined_two_sigma_kt", Height.WITH_VELOCITY))
    }


def options_text(stated: Mapping[str, str]) -> str:
    """The stated choices as one word of the file."""
    return ",".join(f"{name}={value}" for name, value in sorted(stated.items())) or "defaults"


def read_rows(path: Path) -> list[Row]:
    """The rows of a file of the judge, none where there is no file; a row that breaks off is cut from the file.

    Raises ValueError for a file with other columns.
    """
    if not path.exists():
        return []
    whole = path.read_bytes()
    kept = whole[: whole.rfind(b"\n") + 1]
    if kept != whole:
        path.write_bytes(kept)
    names = [field.name for field in fields(Row)]
    lines = list(csv.reader(kept.decode("utf-8").splitlines()))
    if lines and lines[0] != names:
        raise ValueError(f"{path} has other columns than this judge writes: give another --out")
    return [_row(dict(zip(names, line, strict=True))) for line in lines[1:]]


def _row(cells: Mapping[str, str]) -> Row:
    kinds: dict[str, Callable[[str], object]] = {"seed": int}
    texts = {"cell", "options", "maneuver", "outcome", "says"}
    entries = {name: text if name in texts else kinds.get(name, float)(text) for name, text in cells.items()}
    return Row(**entries)  # type: ignore[arg-type]


def judge_all(
    cells: Sequence[str], seeds: Sequence[int], stated: Mapping[str, str], jobs: int, out: Path
) -> list[Row]:
    """Judge what the file does not hold yet, append row by row, and return all rows that were asked for."""
    held = {(row.cell, row.seed, row.options): row for row in read_rows(out)}
    asked = [(cell, seed, options_text(stated)) for cell in cells for seed in seeds]
    missing = [(cell, seed) for cell, seed, options in asked if (cell, seed, options) not in held]
    new = not out.exists() or out.stat().st_size == 0
    with out.open("a", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        if new:
            writer.writerow([field.name for field in fields(Row)])
        for count, row in enumerate(_judged(missing, stated, jobs), start=1):
            writer.writerow(" ".join(str(value).split()) for value in asdict(row).values())
            file.flush()
            held[row.cell, row.seed, row.options] = row
            _progress(f"[{count}/{len(missing)}] {row.cell} {row.maneuver} seed {row.seed}: {row.outcome}")
    return [held[key] for key in asked]


def _progress(line: str) -> None:
    """One line that renews itself on a terminal, a line each elsewhere."""
    live = sys.stderr.isatty()
    print(f"\r{line:<60}" if live else line, end="" if live else "\n", file=sys.stderr, flush=True)


def _judged(missing: Sequence[tuple[str, int]], stated: Mapping[str, str], jobs: int) -> Iterator[Row]:
    if jobs == 1:
        for cell, seed in missing:
            yield judge(cell, seed, stated)
        return
    with ProcessPoolExecutor(jobs) as pool:
        for done in as_completed([pool.submit(judge, cell, seed, stated) for cell, seed in missing]):
            yield done.result()


def _seeds(parser: argparse.ArgumentParser, first: int, flights: int) -> range:
    seeds = range(first, first + flights)
    if flights < 1 or first < 0 or (seeds[-1] >= DEVELOPMENT_BELOW and first < SCORED_FROM):
        parser.error(
            f"seeds {first} to {first + flights - 1}: stay below {DEVELOPMENT_BELOW} (development) "
            f"or begin at {SCORED_FROM} or above (scored)"
        )
    return seeds


def _stated(parser: argparse.ArgumentParser, text: str) -> dict[str, str]:
    pairs = [part.partition("=") for part in text.split(",") if part]
    if any(not equals for _, equals, _ in pairs):
        parser.error(f"--options {text!r}: give NAME=VALUE,NAME=VALUE")
    return {name: value for name, _, value in pairs}


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; returns exit code 0."""
    parser = argparse.ArgumentParser(prog="python -m tests.outside.judge", description=__doc__.split("\n")[0])
    parser.add_argument("--cells", default="base", help=f"with commas, or all: {', '.join(CELLS)}")
    parser.add_argument("--flights", type=int, default=60, help="a cell")
    parser.add_argument("--seed", type=int, default=1, help="of the first flight")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--options", default="", help="choices of the calibration, NAME=VALUE with commas")
    parser.add_argument("--format", choices=FORMS, default="text", help="of the table")
    parser.add_argument("--out", type=Path, required=True, help="one row a flight (CSV); read first, then added to")
    choice = parser.parse_args(arguments)
    cells = list(CELLS) if choice.cells == "all" else choice.cells.split(",")
    unknown = [cell for cell in cells if cell not in CELLS]
    if unknown:
        parser.error(f"unknown cell {unknown[0]!r}; known: {', '.join(CELLS)}")
    seeds, stated = _seeds(parser, choice.seed, choice.flights), _stated(parser, choice.options)
    rows = judge_all(cells, seeds, stated, choice.jobs, choice.out)
    if sys.stderr.isatty():
        print(file=sys.stderr)
    print(table([asdict(row) for row in rows], choice.format))
    return 0


if __name__ == "__main__":
    sys.exit(main())
