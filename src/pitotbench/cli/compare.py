"""`pitotbench compare`: two calibrations, logs, or versions of an airplane's file, side by side."""

import argparse
from collections.abc import Callable
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from pitotbench.cli.shared_flags import (
    asked_flags,
    flag,
    read_logs,
    require_page,
    say,
    shared,
    stated_choices,
    stated_facts,
    tell,
)
from pitotbench.records import BadInputError
from pitotbench.records.calibration_request import FACTS, CalibrationChoices, Reading

if TYPE_CHECKING:
    from pitotbench.records.calibration import ErrorCurve

BEYOND = 1  # the exit code of a change beyond the tolerance, as of diff and cmp


class Kind(NamedTuple):
    """What can be compared: its name, whether a path is one, and the command for two of it."""

    name: str
    known_by: Callable[[Path], bool]
    compare: Callable[[argparse.Namespace], int | None]


FLAGS = (
    flag(
        "first",
        type=Path,
        metavar="A",
        help="a calibration (--json of calibrate), a log, or a JSBSim file (.xml)",
    ),
    flag("second", type=Path, metavar="B", help="another of the same kind, held against the first"),
    *asked_flags(Reading, CalibrationChoices, only=("mapping", *FACTS, "accuracies")),
    *shared("json", "report", "units"),
    flag("--model", help="of two logs: the pressure-error model (as for calibrate)"),
    flag(
        "--card",
        metavar="MANEUVER",
        help="of two airplanes: the card that A flies (default: diagnostic)",
    ),
    flag(
        "--tolerance",
        type=float,
        metavar="PERCENT",
        help="of two airplanes: exit code 1 where a force, a moment, power or mass changes by more "
        "than this share of its largest value in the flight",
    ),
)


def run(options: argparse.Namespace) -> int:
    """Compare what the two arguments are; return exit code 0, or 1 beyond a tolerance.

    Raises BadInputError where they are of two kinds.
    """
    require_page(options.report, (options.first, options.second))
    kinds = [
        next(kind for kind in KINDS if kind.known_by(path))
        for path in (options.first, options.second)
    ]
    if kinds[0] is not kinds[1]:
        raise BadInputError(
            f"{options.first.name} is a {kinds[0].name}, {options.second.name} a {kinds[1].name}: "
            "give two alike"
        )
    return kinds[0].compare(options) or 0


def _logs(options: argparse.Namespace) -> None:
    from pitotbench.bench.calibrations import calibrate_each

    paths = [options.first, options.second]
    curves = []
    for path, log in zip(
        paths, read_logs(paths, options.mapping, facts=stated_facts(options)), strict=True
    ):
        flight, *_ = calibrate_each([log], None, options.mapping, **stated_choices(options))
        curves.append((path.stem, flight.calibration.curve))
    _tell(curves, options)


def _tell(curves: "list[tuple[str, ErrorCurve]]", options: argparse.Namespace) -> None:
    from pitotbench.show.curve_difference import compare_curves, difference_json, difference_tree

    (first, one), (second, other) = curves
    if first == second:
        first, second = str(options.first), str(options.second)
    found = compare_curves(first, one, second, other)
    tell(
        options,
        lambda: difference_json(found),
        lambda: difference_tree(found, one, other),
        f"{second} against {first}",
    )


def _read_curve(path: Path) -> "tuple[str, ErrorCurve]":
    """Return the name and the curve of a calibration as `calibrate --json` prints it.

    Raises BadInputError.
    """
    import json

    import numpy as np

    from pitotbench.records.calibration import ErrorCurve
    from pitotbench.records.intake import require_regular
    from pitotbench.units import KNOT

    def column(rows: Any, key: str, unit: float = 1.0) -> "np.ndarray[Any, Any]":
        for number, row in enumerate(rows, start=1):
            if not isinstance(row[key], int | float) or not isfinite(row[key]):
                raise BadInputError(
                    f"{key} of point {number} of the curve is no number; calibrate the log again"
                )
        return np.array([row[key] for row in rows], dtype=float) * unit

    try:
        require_regular(path)
        found = json.loads(path.read_text(encoding="utf-8"))
        if isinstance(found, list):
            if len({json.dumps(each["curve"]) for each in found}) != 1:
                raise BadInputError("several curves; calibrate one log, or the logs together")
            found = found[0]
        rows = found["curve"]
        if not rows:
            raise BadInputError("its curve holds no point; calibrate the log again")
        curve = ErrorCurve(
            indicated_airspeed=column(rows, "indicated_airspeed_kt", KNOT),
            correction=column(rows, "correction_kt", KNOT),
            two_sigma=column(rows, "two_sigma_kt", KNOT),
            simultaneous_two_sigma=column(rows, "simultaneous_two_sigma_kt", KNOT),
            white_two_sigma=column(rows, "white_two_sigma_kt", KNOT),
            normalized_pressure_error=column(rows, "normalized_pressure_error"),
            normalized_two_sigma=column(rows, "normalized_two_sigma"),
        )
    except BadInputError as error:
        raise BadInputError(f"{path}: {error}") from error
    except OSError as error:
        raise BadInputError(f"{path}: cannot be read: {error.strerror or error}") from error
    except (ValueError, LookupError, TypeError, OverflowError) as error:
        raise BadInputError(
            f"{path}: not a calibration; write one with: pitotbench calibrate LOG --json > "
            f"{path.name}"
        ) from error
    return path.stem, curve


def _airplanes(options: argparse.Namespace) -> int:
    from pitotbench.models.comparison import compare_models
    from pitotbench.show.comparison import comparison_json, comparison_tree
    from pitotbench.simulation.maneuvers import MANEUVERS

    tolerance = options.tolerance
    if tolerance is not None and not (isfinite(tolerance) and tolerance >= 0.0):
        raise BadInputError(f"--tolerance {tolerance:g}: give a share in percent, 0 or more")
    card = options.card or "diagnostic"
    _ = MANEUVERS[card]  # a spelling mistake is reported before anything is flown
    found = compare_models(str(options.first), str(options.second), card, say)
    tell(
        options,
        lambda: comparison_json(found),
        lambda: comparison_tree(found),
        "What changed in flight",
    )
    return BEYOND if tolerance is not None and 100.0 * found.largest > tolerance else 0


# A new kind is a line here, above the last one, which takes what no other does.
KINDS = (
    Kind("JSBSim file", lambda path: path.suffix.lower() == ".xml", _airplanes),
    Kind(
        "calibration",
        lambda path: path.suffix.lower() == ".json",
        lambda options: _tell(
            [_read_curve(path) for path in (options.first, options.second)], options
        ),
    ),
    Kind("log", lambda path: True, _logs),
)
