"""Calibrate and reconcile from Python: with a path, a DataFrame, a log, or a list of them."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Union, overload

from pitotbench.records import BadInputError
from pitotbench.records.calibration import Calibration
from pitotbench.records.case import Case
from pitotbench.records.log import FlightLog

if TYPE_CHECKING:
    from pandas import DataFrame

    from pitotbench.bench.workflow import FullReconciliation
    from pitotbench.calibration.options import CalibrationOptions
    from pitotbench.reconciliation.free_parameters import AnalysisSetting

# What can stand for a log: itself, a file, or a table with the columns of a file.
OneLog = Union[FlightLog, str, Path, "DataFrame"]


def logs_of(given: OneLog | Sequence[OneLog], asked: str) -> list[FlightLog]:
    """Return the logs that stand for what was given to the function `asked`, read and checked where needed.

    Raises BadInputError for anything else, and for a file or a table that is no log.
    """
    if isinstance(given, list | tuple):
        if not given:
            raise BadInputError(f"{asked} needs at least one log")
        return [log for each in given for log in logs_of(each, asked)]
    if isinstance(given, FlightLog):
        return [given]
    if isinstance(given, str | Path):
        from pitotbench.logbook.reading import read_log

        return [read_log(given)]
    from pandas import DataFrame  # slow, and not needed for a log

    if isinstance(given, DataFrame):
        from pitotbench.logbook.columns import Table
        from pitotbench.logbook.reading import log_of

        names = tuple(str(name) for name in given.columns)
        return [log_of(Table(names, tuple(given[name].to_numpy() for name in given.columns)))]
    raise BadInputError(
        f"{asked} takes a path, a DataFrame, a log or a list of them, not {type(given).__name__}; read_log reads a "
        "file with a mapping of yours"
    )


@overload
def calibrate(logs: OneLog, options: "CalibrationOptions | None" = None, **choices: Any) -> Calibration: ...


@overload
def calibrate(
    logs: Sequence[OneLog], options: "CalibrationOptions | None" = None, **choices: Any
) -> tuple[Calibration, ...]: ...


def calibrate(
    logs: OneLog | Sequence[OneLog], options: "CalibrationOptions | None" = None, **choices: Any
) -> Calibration | tuple[Calibration, ...]:
    """Estimate the pressure-error curve and the wind: from a log, a path, a DataFrame, or a list of them.

    Parameters: logs, of one airplane; options, or its fields as keywords (`model="quadratic"`, `wind="checked"`;
    the defaults are those of `CalibrationOptions`, before them what the format of a log advises). A list has one
    curve, and a Calibration with its own wind for each log. SI units, each number with 2σ.
    Raises BadInputError for what cannot be used, NoAnswerError for a log that does not determine the answer.
    Source: Martos, Kiszely and Foster (2011) for the problem; `docs/method.md` for the methods.
    """
    from pitotbench.calibration import calibrate as calibrate_one
    from pitotbench.calibration import calibrate_together
    from pitotbench.calibration.options import options_from
    from pitotbench.logbook.mapping import find_mapping, shipped

    read = logs_of(logs, "calibrate")
    if options is not None and choices:
        raise BadInputError("give either options or keywords, not both")
    if options is None:
        known = shipped()
        found = next((n for log in read if (n := str(log.header.get("mapping", ""))) in known), None)
        options = options_from({**(find_mapping(found).calibrate if found else {}), **choices})
    if isinstance(logs, list | tuple):
        return calibrate_together(read, options)
    return calibrate_one(read[0], options)


def reconcile(
    logs: OneLog | Sequence[OneLog],
    aircraft: str = "navajo",
    holdout: OneLog | None = None,
    card: Case | None = None,
    setting: "AnalysisSetting | None" = None,
    refly: bool = True,
    progress: Callable[[str], None] | None = None,
) -> "FullReconciliation":
    """Find where a simulation and measured logs disagree, and name the effect that the simulation lacks.

    Parameters: logs, a measured one (a log, a path or a DataFrame), or a list of several of one airplane whose
    causes and sizes are the same; aircraft, a model of the hangar, or `none` to judge the sensors alone; holdout,
    another log of the same airplane on which the gap has to shrink too; card, what was flown (default: the card in
    the header of each log); setting, what is known of the logs beyond their rows; refly, whether the card is flown
    again with the named effects; progress, called with a line of text at each step.
    Returns a record with the `verdict`, the `probabilities` of the causes, the `sizes`, the `patch` and the figures
    of each of the `flights`. It shows itself in a notebook.
    Raises BadInputError for a log that cannot be used, UnknownNameError for an aircraft that is not known.
    """
    from pitotbench.bench.rounds import NamedLog
    from pitotbench.bench.workflow import reconcile_fully

    other = None if holdout is None else NamedLog("held-out log", logs_of(holdout, "reconcile")[0])
    several = logs_of(logs, "reconcile")
    names = ["measured log"] if len(several) == 1 else [f"flight {i}" for i in range(1, len(several) + 1)]
    measured = [NamedLog(name, log) for name, log in zip(names, several, strict=True)]
    return reconcile_fully(measured, aircraft, other, card, progress, setting, refly)
