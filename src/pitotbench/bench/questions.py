"""Calibrate, reconcile and inspect from Python: a path, a DataFrame, a log, a list; and where
answers come from.
"""

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import fields, replace
from datetime import UTC, datetime
from functools import cache
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from platform import python_version
from typing import TYPE_CHECKING, Any, Union, overload

from pitotbench.records import BadInputError
from pitotbench.records.calibration import Calibration
from pitotbench.records.case import Case
from pitotbench.records.log import Choice, FlightLog, InputFile, LogInspection, Provenance

if TYPE_CHECKING:
    from pandas import DataFrame

    from pitotbench.bench.workflow import FullReconciliation
    from pitotbench.calibration.options import CalibrationOptions
    from pitotbench.reconciliation.free_parameters import AnalysisSetting

# What can stand for a log: itself, a file, or a table with the columns of a file.
OneLog = Union[FlightLog, str, Path, "DataFrame"]


def logs_of(given: OneLog | Sequence[OneLog], asked: str) -> list[FlightLog]:
    """Return the logs that stand for what was given to the function `asked`, read and checked where
    needed.

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
        f"{asked} takes a path, a DataFrame, a log or a list of them, not {type(given).__name__}; "
        "read_log reads a "
        "file with a mapping of yours"
    )


@overload
def calibrate(
    logs: OneLog, options: "CalibrationOptions | None" = None, **choices: Any
) -> Calibration: ...


@overload
def calibrate(
    logs: Sequence[OneLog], options: "CalibrationOptions | None" = None, **choices: Any
) -> tuple[Calibration, ...]: ...


def calibrate(
    logs: OneLog | Sequence[OneLog], options: "CalibrationOptions | None" = None, **choices: Any
) -> Calibration | tuple[Calibration, ...]:
    """Estimate the pressure-error curve and the wind: from a log, a path, a DataFrame, or a list of
    them.

    Parameters: logs, of one airplane; options, or its fields as keywords (`model="quadratic"`,
    `wind="checked"`; the defaults are those of `CalibrationOptions`, before them what the format of
    a log advises). A list has one curve, and a Calibration with its own wind for each log. SI
    units, each number with 2σ. Raises BadInputError for what cannot be used, NoAnswerError for a
    log that does not determine the answer.
    Source: Martos, Kiszely and Foster (2011) for the problem; `docs/method.md` for the methods.
    """
    from pitotbench.calibration import calibrate as calibrate_one
    from pitotbench.calibration import calibrate_together
    from pitotbench.calibration.options import options_from

    read = logs_of(logs, "calibrate")
    if options is not None and choices:
        raise BadInputError("give either options or keywords, not both")
    advised = advice_of(read) if options is None else {}
    chosen = options or options_from({**advised, **choices})
    stated = (
        choices
        if options is None
        else [f.name for f in fields(options) if getattr(options, f.name) != f.default]
    )
    made = provenance_of(sources_of("log", logs, read), settings_of(chosen, stated, advised))
    if isinstance(logs, list | tuple):
        return tuple(replace(each, provenance=made) for each in calibrate_together(read, chosen))
    return replace(calibrate_one(read[0], chosen), provenance=made)


def inspect(log: OneLog) -> LogInspection:
    """Return what a log holds and what can be learned from it: from a log, a path or a DataFrame.

    It shows itself as the sentences of `pitotbench inspect`; `to_frame` is the table of its
    channels. Raises BadInputError for a log that cannot be used.
    """
    from pitotbench.bench.inspection import inspect_log
    from pitotbench.calibration.options import options_from

    (read,) = logs_of([log], "inspect")
    return inspect_log(read, options_from(advice_of([read])))


def advice_of(logs: Iterable[FlightLog], mapping: str | None = None) -> Mapping[str, Any]:
    """Return the choices that a mapping advises: the one named, else the shipped one that
    recognized a log.
    """
    from pitotbench.logbook.mapping import find_mapping, shipped

    known = {} if mapping else shipped()
    found = mapping or next(
        (n for log in logs if (n := str(log.header.get("mapping", ""))) in known), None
    )
    return find_mapping(found).calibrate if found else {}


def reconcile(
    logs: OneLog | Sequence[OneLog],
    aircraft: str = "navajo",
    holdout: OneLog | None = None,
    card: Case | None = None,
    setting: "AnalysisSetting | None" = None,
    refly: bool = True,
    progress: Callable[[str], None] | None = None,
) -> "FullReconciliation":
    """Find where a simulation and measured logs disagree, and name the effect that the simulation
    lacks.

    Parameters: logs, a measured one (a log, a path or a DataFrame), or a list of several of one
    airplane whose causes and sizes are the same; aircraft, a model of the hangar, or `none` to
    judge the sensors alone; holdout, another log of the same airplane on which the gap has to
    shrink too; card, what was flown (default: the card in the header of each log); setting, what is
    known of the logs beyond their rows; refly, whether the card is flown again with the named
    effects; progress, called with a line of text at each step. Returns a record with the `verdict`,
    the `probabilities` of the causes, the `sizes`, the `patch` and the figures of each of the
    `flights`. It shows itself in a notebook. Raises BadInputError for a log that cannot be used,
    UnknownNameError for an aircraft that is not known.
    """
    from pitotbench.bench.workflow import NamedLog, reconcile_fully
    from pitotbench.calibration.reduction import one_thread

    held = [] if holdout is None else logs_of(holdout, "reconcile")
    several = logs_of(logs, "reconcile")
    names = (
        ["measured log"]
        if len(several) == 1
        else [f"flight {i}" for i in range(1, len(several) + 1)]
    )
    measured = [NamedLog(name, log) for name, log in zip(names, several, strict=True)]
    other = NamedLog("held-out log", held[0]) if held else None
    other_source = [] if holdout is None else sources_of("held-out log", holdout, held)
    made = provenance_of(
        [*sources_of("log", logs, several), *other_source, *model_sources(aircraft)], []
    )
    with one_thread():
        found = reconcile_fully(measured, aircraft, other, card, progress, setting, refly)
    return replace(found, provenance=made)


# What an answer was made from and with, for the record that is filed.

_LIBRARIES = ("numpy", "scipy", "pandas", "jsbsim")
Source = tuple[
    str, OneLog, FlightLog | None
]  # role, what was given, and the log read of it; None of another file


def provenance_of(sources: Iterable[Source], choices: Iterable[Choice]) -> Provenance:
    """Return the provenance of an answer made now: inputs with their digests, choices, versions,
    and the date.
    """
    date = datetime.now(UTC).strftime("%Y-%m-%d")
    return Provenance(
        tuple(_input_of(*each) for each in sources), tuple(choices), _versions(), date
    )


def sources_of(
    role: str, given: OneLog | Sequence[OneLog], logs: Sequence[FlightLog]
) -> list[Source]:
    """Return what was given, a list flattened, each with the log that was read of it."""
    return [(role, source, log) for source, log in zip(_flat(given), logs, strict=True)]


def _flat(given: OneLog | Sequence[OneLog]) -> list[OneLog]:
    if isinstance(given, Sequence) and not isinstance(given, str):
        return [one for each in given for one in _flat(each)]
    return [given]


def model_sources(aircraft: str) -> list[Source]:
    """Return the file of an aircraft as its author wrote it, and its folder; nothing for `none`."""
    from pitotbench.simulation.aircraft import original

    found = None if aircraft == "none" else original(aircraft)
    if found is None or found.is_file():
        return [("aircraft", found, None)] if found else []
    return [("aircraft", found / f"{found.name}.xml", None), ("its folder", found, None)]


def _input_of(role: str, source: OneLog, log: FlightLog | None) -> InputFile:
    import numpy as np

    from pitotbench import air
    from pitotbench.bench.digests import file_sha256

    name, channels = "in memory", {} if log is None else log.channels()
    if isinstance(source, str | Path):
        name, digest = Path(source).name, file_sha256(Path(source))
    else:
        digest = sha256(
            b"".join(key.encode() + array.tobytes() for key, array in channels.items())
        ).hexdigest()
    if log is None:
        return InputFile(role, name, digest)
    speed = air.calibrated_airspeed(np.maximum(log.impact_pressure, 0.0))
    spans = [
        np.quantile(each, (0.05, 0.95))
        for each in (speed, air.pressure_altitude(log.static_pressure))
    ]
    airspeeds, heights = ((float(low), float(high)) for low, high in spans)
    minutes, origin = (
        float(log.time[-1] - log.time[0]) / 60.0,
        "simulated" if log.simulated else "measured",
    )
    return InputFile(
        role, name, digest, len(log), minutes, origin, tuple(channels), airspeeds, heights
    )


def settings_of(
    options: "CalibrationOptions", stated: Collection[str], advised: Collection[str]
) -> list[Choice]:
    """Return every option of a calibration but the accuracies, which the answer holds, with who
    chose it.
    """
    from pitotbench.units import KNOT

    values = {f.name: getattr(options, f.name) for f in fields(options) if f.name != "accuracies"}
    values["ground_speed_min"] = f"{options.ground_speed_min / KNOT:g} kt"
    values["gps_latency"] = f"{options.gps_latency:g} s"
    by = {**dict.fromkeys(advised, "mapping"), **dict.fromkeys(stated, "stated")}
    plain = {"True": "yes", "False": "no", "None": "none"}
    return [Choice(n, plain.get(str(v), str(v)), by.get(n, "default")) for n, v in values.items()]


def flag_choice(name: str, value: str | None, default: str) -> Choice:
    """Return the choice of a flag: what it states, else its default in words."""
    return Choice(
        name, default if value is None else value, "default" if value is None else "stated"
    )


@cache
def _versions() -> Mapping[str, str]:
    from pitotbench import __version__
    from pitotbench.bench.digests import NOT_DECIDING, package_digest

    own = f"{__version__} (code {package_digest(NOT_DECIDING)})"
    return {
        "pitotbench": own,
        "Python": python_version(),
        **{name: version(name) for name in _LIBRARIES},
    }
