"""The judge's table: one line a cell, from one row a flight."""

import argparse
import csv
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from dataclasses import asdict, dataclass, fields
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, TypeVar

import numpy as np

from pitotbench.calibration import calibrate
from pitotbench.calibration.options import CalibrationOptions
from pitotbench.logbook.reading import read_log
from pitotbench.records import BadInputError, NoAnswerError
from pitotbench.records.calibration import Calibration, ErrorCurve
from pitotbench.units import Booleans
from pitotlab.outside.generator import OutsideFlight, generate, write_csv
from pitotlab.outside.moving_air import CELLS
from pitotlab.outside.oracle import USUAL_ONE_SIGMA, Height, bound, known_covariance
from pitotlab.outside.physics import FOOT, KNOT, Array
from pitotlab.outside.written import checked_seeds

TOLD = 0.9545  # the share of the curve that ±2σ is meant to contain; a flight with less is outside
_SHOWN = ("step_decrease", "rapid_decel", "circle", "race_track", "four_leg")


def table(rows: Sequence[Mapping[str, Any]]) -> str:
    """One line a cell: coverage with its standard error over flights, bound over oracle, share
    warned.

    `/oracle` is the mean of the bound over that of the triangle alone, `/joined` over that of both
    equations; both oracles allow for the usual constant errors of the sensors, as the calibration
    does. `ft` is the position error, which `ft given` flights have. `outside` counts the flights
    with less than 95.45 % of their curve inside the bound.
    """
    cells = list(dict.fromkeys(row["cell"] for row in rows))
    lines = [line_of([row for row in rows if row["cell"] == cell]) for cell in cells]
    columns = list(lines[0])
    return aligned([columns, *([line[column] for column in columns] for line in lines)])


def aligned(lines: Sequence[Sequence[str]]) -> str:
    """Lines of entries under one another, each column as wide as its widest entry."""
    widths = [max(len(text) for text in column) for column in zip(*lines, strict=True)]
    return "\n".join(
        "  ".join(text.rjust(width) for text, width in zip(entries, widths, strict=True))
        for entries in lines
    )


def line_of(rows: Sequence[Mapping[str, Any]]) -> dict[str, str]:
    """The line of one cell; a number that no flight gives is a dash."""
    answered = [row for row in rows if row["outcome"] == "answered"]
    coverage = 100.0 * _column(answered, "curve_coverage")
    bound, error = _column(answered, "two_sigma_kt"), _column(answered, "rms_error_kt")
    outside = [row for row in answered if row["curve_coverage"] < TOLD]
    rms = float(np.sqrt(np.mean(error**2))) if len(error) else float("nan")
    return {
        "cell": rows[0]["cell"],
        "n": str(len(answered)),
        "refused": str(sum(row["outcome"] == "refused" for row in rows)),
        "crashed": str(sum(row["outcome"] == "crashed" for row in rows)),
        "curve %": text_of(_mean(coverage), 1),
        "±": text_of(standard_error(coverage), 1),
        "whole %": text_of(100.0 * _mean(_column(answered, "whole_band")), 0),
        "wind %": text_of(100.0 * _mean(_column(answered, "wind_inside")), 0),
        "2σ kt": text_of(_mean(bound), 3),
        "rms kt": text_of(rms, 3),
        "mean kt": text_of(_mean(_column(answered, "mean_error_kt")), 3),
        "2σ/2rms": text_of(_mean(bound) / (2.0 * rms) if rms else float("nan"), 2),
        "/oracle": text_of(_mean(bound / _column(answered, "oracle_two_sigma_kt")), 2),
        "/joined": text_of(_mean(bound / _column(answered, "joined_two_sigma_kt")), 2),
        "ft %": text_of(100.0 * _mean(_given(answered, "coverage_ft")), 1),
        "2σ ft": text_of(_mean(_given(answered, "two_sigma_ft")), 1),
        "ft given": str(len(_given(answered, "coverage_ft"))),
        "warned %": text_of(100.0 * _mean(_column(answered, "warned")), 0),
        "headline %": text_of(100.0 * _mean(_column(answered, "headline")), 1),
        "outside": str(len(outside)),
        "warned of these %": text_of(100.0 * _mean(_column(outside, "warned")), 0),
        "by maneuver %": _by_maneuver(answered),
    }


def standard_error(values: Array) -> float:
    """Standard error of the mean over flights; NaN for fewer than two."""
    return float(np.std(values, ddof=1) / np.sqrt(len(values))) if len(values) > 1 else float("nan")


def _by_maneuver(rows: Sequence[Mapping[str, Any]]) -> str:
    told = []
    for name in _SHOWN:
        flown = _column([row for row in rows if row["maneuver"] == name], "curve_coverage")
        if len(flown):
            told.append(f"{name.partition('_')[0]} {100.0 * _mean(flown):.0f}")
    return ", ".join(told) or "–"


def _column(rows: Sequence[Mapping[str, Any]], name: str) -> Array:
    return np.array([row[name] for row in rows], dtype=np.float64)


def _given(rows: Sequence[Mapping[str, Any]], name: str) -> Array:
    """The values of a column without those that are missing."""
    values = _column(rows, name)
    return values[np.isfinite(values)]


def _mean(values: Array) -> float:
    return float(np.mean(values)) if len(values) else float("nan")


def text_of(value: float, digits: int) -> str:
    """A number, or a dash where there is none."""
    return f"{value:.{digits}f}" if np.isfinite(value) else "–"


# Where the command's defaults are not those of CalibrationOptions.
COMMAND_DEFAULTS = {"latency": "checked", "wind": "checked", "model": "smooth"}
LONG_LOG = 600.0  # s; above it the oracle's blocks are twice as long, to save its time
NAN = float("nan")
AnyRow = TypeVar("AnyRow")


@dataclass(frozen=True, slots=True)
class Row:
    """What came of one flight; speeds in kt. A column of the file each."""

    cell: str
    seed: int
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
    coverage_ft: float = NAN  # share of the points whose position error is inside its bound
    two_sigma_ft: float = NAN  # mean over the curve
    rms_error_ft: float = NAN
    warned: float = NAN  # 1 where there was any warning
    headline: float = NAN  # 1 where two findings of the log disagree
    seconds: float = NAN
    says: str = ""  # the warnings, or why there is no answer


def judge(cell: str, seed: int) -> Row:
    """Fly one flight, calibrate its log, and hold the answer against the truth."""
    maneuvers = CELLS[cell].maneuvers
    flight = generate(CELLS[cell], maneuvers[seed % len(maneuvers)], seed)
    begun = time.perf_counter()
    found = _answer(flight)
    entries: dict[str, float | str] = {
        "cell": cell,
        "maneuver": flight.maneuver,
        "gps_hz": flight.fix_rate,
        "seconds": round(time.perf_counter() - begun, 2),
    }
    if isinstance(found, Calibration):
        entries |= {"outcome": "answered", **_errors_of(found, flight), **_oracles(flight)}
    else:
        entries |= {"outcome": found[0], "says": found[1]}
    return Row(seed=seed, **entries)  # type: ignore[arg-type]


def usual_options() -> CalibrationOptions:
    """What the command `pitotbench calibrate` chooses."""
    return CalibrationOptions(**COMMAND_DEFAULTS)  # type: ignore[arg-type]


def _answer(flight: OutsideFlight) -> Calibration | tuple[str, str]:
    with TemporaryDirectory() as folder:
        path = Path(folder) / "log.csv"
        write_csv(flight.columns, path)
        try:
            return calibrate(read_log(path), usual_options())
        except (BadInputError, NoAnswerError) as error:
            return "refused", str(error)
        except Exception as error:  # a crash is a result of its kind and must not end a night's run
            return "crashed", f"{type(error).__name__}: {error}"


def _errors_of(found: Calibration, flight: OutsideFlight) -> dict[str, float | str]:
    curve, cell = found.curve, flight.cell
    airspeed = curve.indicated_airspeed
    inside = (airspeed > cell.low - 0.01) & (airspeed < cell.high + 0.01)
    error = (curve.correction - flight.correction(airspeed))[inside]
    parts = (found.known_wind.north, found.known_wind.east)
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
        **_position_error_of(curve, flight, inside),
        "warned": float(bool(found.warnings)),
        "headline": float(bool(found.disagreements)),
        "says": " | ".join(found.warnings),
    }


def _position_error_of(
    curve: ErrorCurve, flight: OutsideFlight, inside: Booleans
) -> dict[str, float]:
    """The position error against the truth; nothing where the answer has none."""
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
    known = partial(bound, flight, seconds=block, accuracy=USUAL_ONE_SIGMA)
    return {
        "oracle_two_sigma_kt": float(np.mean(known(Height.NONE).curve)) / KNOT,
        "joined_two_sigma_kt": float(np.mean(known(Height.WITH_VELOCITY).curve)) / KNOT,
    }


def read_rows(path: Path, kind: type[AnyRow]) -> list[AnyRow]:
    """The rows of a file of the judge, none where there is no file; a row that breaks off is cut
    from the file.

    Raises ValueError for a file with other columns.
    """
    if not path.exists():
        return []
    whole = path.read_bytes()
    kept = whole[: whole.rfind(b"\n") + 1]
    if kept != whole:
        path.write_bytes(kept)
    columns = fields(kind)  # type: ignore[arg-type]
    lines = list(csv.reader(kept.decode("utf-8").splitlines()))
    if lines and lines[0] != [field.name for field in columns]:
        raise ValueError(f"{path} has other columns than this judge writes: give another --out")
    return [
        kind(*(field.type(cell) for field, cell in zip(columns, line, strict=True)))  # type: ignore[operator]
        for line in lines[1:]
    ]


@contextmanager
def append_to(path: Path, kind: type[AnyRow]) -> Iterator[Callable[[AnyRow], None]]:
    """What appends a row to a file of the judge; a new file gets a line of names first."""
    with path.open("a", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        if not file.tell():
            writer.writerow([field.name for field in fields(kind)])  # type: ignore[arg-type]

        def append(row: AnyRow) -> None:
            cells = asdict(row).values()  # type: ignore[call-overload]
            writer.writerow(" ".join(str(cell).split()) for cell in cells)
            file.flush()

        yield append


def judge_all(cells: Sequence[str], seeds: Sequence[int], jobs: int, out: Path) -> list[Row]:
    """Judge what the file does not hold yet, append row by row; return all rows asked for."""
    held = {(row.cell, row.seed): row for row in read_rows(out, Row)}
    asked = [(cell, seed) for cell in cells for seed in seeds]
    missing = [each for each in asked if each not in held]
    with append_to(out, Row) as append:
        for count, row in enumerate(_judged(missing, jobs), start=1):
            append(row)
            held[row.cell, row.seed] = row
            _progress(
                f"[{count}/{len(missing)}] {row.cell} {row.maneuver} seed {row.seed}: {row.outcome}"
            )
    return [held[key] for key in asked]


def _progress(line: str) -> None:
    """One line that renews itself on a terminal, a line each elsewhere."""
    live = sys.stderr.isatty()
    print(f"\r{line:<60}" if live else line, end="" if live else "\n", file=sys.stderr, flush=True)


def _judged(missing: Sequence[tuple[str, int]], jobs: int) -> Iterator[Row]:
    if jobs == 1:
        for cell, seed in missing:
            yield judge(cell, seed)
        return
    with ProcessPoolExecutor(jobs) as pool:
        asked = [pool.submit(judge, cell, seed) for cell, seed in missing]
        for done in as_completed(asked):
            yield done.result()


def command(parser: argparse.ArgumentParser, words: Sequence[str]) -> None:
    """Judge the calibration on flights of the independent generator, cell by cell; print the table."""
    add = parser.add_argument
    add("--cells", default="base", help=f"with commas, or all: {', '.join(CELLS)}")
    add("--flights", type=int, default=60, help="a cell")
    add("--seed", type=int, default=1, help="of the first flight")
    add("--jobs", type=int, default=1)
    add("--out", type=Path, required=True, help="one row a flight (CSV); read first, then added to")
    choice = parser.parse_args(words)
    cells = list(CELLS) if choice.cells == "all" else choice.cells.split(",")
    unknown = [cell for cell in cells if cell not in CELLS]
    if unknown:
        parser.error(f"unknown cell {unknown[0]!r}; known: {', '.join(CELLS)}")
    seeds = checked_seeds(parser, choice.seed, choice.flights)
    rows = judge_all(cells, seeds, choice.jobs, choice.out)
    if sys.stderr.isatty():
        print(file=sys.stderr)
    print(table([asdict(row) for row in rows]))
