"""Calibrate what was given: read it, choose options, and state what the answer was made from."""

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import fields, replace
from datetime import UTC, datetime
from functools import cache
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from platform import python_version
from typing import TYPE_CHECKING, Any, Union

from pitotbench.records import BadInputError
from pitotbench.records.calibration import CalibratedFlight, PublishedCurve
from pitotbench.records.calibration_request import FACTS
from pitotbench.records.log import Choice, FlightLog, InputFile, Provenance

if TYPE_CHECKING:
    from pandas import DataFrame

    from pitotbench.calibration.flights import Known
    from pitotbench.calibration.options import CalibrationOptions
    from pitotbench.logbook.assembly import Part
    from pitotbench.logbook.columns import Table
    from pitotbench.reconciliation.free_parameters import AnalysisSetting


# What can stand for a log: itself, a file, or a table with the columns of a file.
OneLog = Union[FlightLog, str, Path, "DataFrame"]


# What neither the user nor a mapping stated: of the functions below, and so of the commands, which
# call them. `CalibrationOptions()` alone has the choices of the published figures.
DEFAULTS = {"latency": "checked", "wind": "checked", "model": "smooth"}


def logs_of(
    given: OneLog | Sequence[OneLog],
    asked: str,
    mapping: str | Path | None = None,
    part: "Part | None" = None,
    facts: Mapping[str, Any] | None = None,
) -> list[FlightLog]:
    """Return the logs given to the function `asked`, read and checked where needed.

    `mapping` reads files and tables, and the `part` alone is read with the `facts` of the flight,
    as in `read_log`. Raises BadInputError for anything else, for facts of a log that was read
    without them, and for a file or a table that is no log.
    """
    if isinstance(given, list | tuple):
        if not given:
            raise BadInputError(f"{asked} needs at least one log")
        return [log for each in given for log in logs_of(each, asked, mapping, part, facts)]
    if isinstance(given, FlightLog):
        if facts:
            raise BadInputError(
                f"{asked} cannot state {', '.join(facts)} of a log in memory: give it to read_log"
            )
        return [given if part is None else _rows_of(given, part)]
    from pitotbench.logbook.assembly import WHOLE

    if isinstance(given, str | Path):
        from pitotbench.logbook.reading import read_log

        return [read_log(given, mapping, part=part or WHOLE, **(facts or {}))]
    from pandas import DataFrame  # slow, and not needed for a log

    if isinstance(given, DataFrame):
        from pitotbench.logbook.assembly import log_of
        from pitotbench.logbook.columns import Table
        from pitotbench.logbook.draft import MissingColumnsError
        from pitotbench.logbook.reading import mapped, with_facts

        names = tuple(str(name) for name in given.columns)
        columns = tuple(given[name].to_numpy() for name in given.columns)
        table = with_facts(Table(names, columns), facts or {})
        if mapping is not None:
            return [log_of(mapped(table, mapping), part or WHOLE)]
        try:
            return [log_of(table, part or WHOLE)]
        except MissingColumnsError as error:
            raise BadInputError(_names_to_give(table) or str(error)) from error
    raise BadInputError(
        f"{asked} takes a path, a DataFrame, a log or a list of them, not {type(given).__name__}; "
        "read_log reads a file with a mapping of yours"
    )


def facts_among(choices: dict[str, Any]) -> dict[str, Any]:
    """Take what is stated of the flight out of keywords, and return it by name, as texts."""
    return {name: str(choices.pop(name)) for name in FACTS if name in choices}


def _names_to_give(table: "Table") -> str:
    """Return what to call a table's columns, as names and values tell it; "" where they do not.

    The table is one in memory.
    """
    from pitotbench.logbook.drafting import draft_mapping
    from pitotbench.units import SYMBOLS

    drafted = draft_mapping(table)
    known = [line.guess for line in drafted.lines if line.guess.theirs != line.guess.target()]
    asked = "; ".join(
        f"{g.theirs}: {SYMBOLS.get(g.units[0], g.units[0])}? name it {g.target()}"
        + (f" and multiply it by {g.factor:g}" if g.factor != 1.0 else "")
        for g in known
    )
    lacking = f"; no column was found for {', '.join(drafted.missing)}" * bool(drafted.missing)
    return f"a column's name ends in its unit: {asked}{lacking}" if known else ""


def _rows_of(log: FlightLog, part: "Part") -> FlightLog:
    """Return the part of a log in memory. Raises BadInputError where it holds no two rows."""
    from pitotbench.timeline import minutes_text

    first, last, *_ = part
    time = log.time - log.start
    kept = (time >= (first or 0.0)) & (time <= (float(time[-1]) if last is None else last))
    if int(kept.sum()) < len(part):
        raise BadInputError(
            f"no rows between start and end: the log runs from 0:00 to {minutes_text(time[-1])}"
        )
    return log.part(kept)


def calibrate_each(
    logs: Sequence[FlightLog],
    options: "CalibrationOptions | None" = None,
    mapping: str | Path | None = None,
    sources: "Iterable[Source]" = (),
    flags: Iterable[Choice] = (),
    published: tuple[PublishedCurve, ...] = (),
    known: "Known | None" = None,
    first: Callable[[tuple[CalibratedFlight, ...]], object] | None = None,
    names: Sequence[str] = (),
    **choices: Any,
) -> tuple[CalibratedFlight, ...]:
    """Calibrate each flight of the logs as `calibrate` does, with what contradicts its curve.

    A flight that several logs hold counts once, with the first of them as its place, and says so.
    `sources` are the files of the logs and `flags` further choices, for the record; `published` are
    the curves of a handbook; `known` and `first` are as for `calibrate_flights`; `names` are those
    of the logs, where the sources do not tell them. Raises as `calibrate` does.
    """
    from pitotbench.calibration import calibrate_flights
    from pitotbench.calibration.fit_checks import with_points
    from pitotbench.calibration.flown_tracks import one_sided
    from pitotbench.calibration.leg_points import cross_check
    from pitotbench.calibration.options import stated_wind
    from pitotbench.logbook.same_flight import distinct, recorders_notices

    if options is not None and choices:
        raise BadInputError("give either options or keywords, not both")
    for each in () if options is None else fields(options):
        value = getattr(options, each.name)
        if value != each.default or type(value) is not type(each.default):
            choices[each.name] = value
    chosen = options_of(logs, mapping, **choices)
    settings = settings_of(chosen, choices, advice_of(logs, mapping))
    files = list(sources)
    made = provenance_of(files, [*settings, *flags])
    called = names or names_of([given for _, given, log in files if log is not None], len(logs))
    once = distinct(logs, called)
    kept = [called[place] for place in once.first]
    notices = (*once.notices, *recorders_notices(once.logs, kept))

    def as_given(flight: CalibratedFlight) -> CalibratedFlight:
        found = flight.calibration
        return replace(
            flight,
            calibration=replace(found, warnings=(*found.warnings, *notices)),
            place=once.first[flight.place],
            leader=once.first[flight.leader],
        )

    def checked(flight: CalibratedFlight) -> CalibratedFlight:
        found = flight.calibration
        whole = with_points(found, cross_check(flight.log, chosen, found))
        scatter = 2.0 * float(whole.residuals.airspeed.std())
        whole = replace(
            whole,
            curve=replace(whole.curve, published=published),
            residual_two_sigma=scatter,
            one_sided=() if stated_wind(chosen.wind) else one_sided(flight.log, whole),
            provenance=made,
        )
        return as_given(replace(flight, calibration=whole))

    def told(flights: tuple[CalibratedFlight, ...]) -> None:
        if first is not None:
            first(tuple(map(as_given, flights)))

    found = calibrate_flights(once.logs, chosen, known, None if first is None else told)
    return tuple(map(checked, found))


def names_of(given: Sequence[OneLog], count: int) -> list[str]:
    """Return the names of logs in notices: of a path that of the file, else the number."""
    named = dict(enumerate(given))
    return [
        Path(each).name if isinstance(each := named.get(n), str | Path) else f"log {n + 1}"
        for n in range(count)
    ]


def published_of(handbook: str | Path | None) -> tuple[PublishedCurve, ...]:
    """Return the curves of a handbook's table; none without one.

    Raises BadInputError for another table.
    """
    from pitotbench.logbook.handbook_table import read_published

    return () if handbook is None else read_published(Path(handbook))


def options_of(
    logs: Iterable[FlightLog] = (), mapping: str | Path | None = None, **choices: Any
) -> "CalibrationOptions":
    """Return the options of a calibration: the choices, else those of the mapping, else defaults.

    An accuracy that is not named keeps the value of the mapping. Raises as `options_from` does.
    """
    from pitotbench.calibration.options import options_from

    advised = advice_of(logs, mapping)
    named = choices.get("accuracies")
    if isinstance(named, Mapping):
        choices["accuracies"] = {**advised.get("accuracies", {}), **named}
    stated = {**advised, **choices}
    # The published method knows no prior, which a smooth curve needs.
    usual = {k: v for k, v in DEFAULTS.items() if k != "model" or stated.get("method") != "paper"}
    return options_from(usual | stated)


def advice_of(
    logs: Iterable[FlightLog] = (), mapping: str | Path | None = None
) -> Mapping[str, Any]:
    """Return the choices advised by the mapping that is named, else by that of a log.

    A log has the mapping by which it was read.
    """
    from pitotbench.logbook.columns import CALIBRATE
    from pitotbench.logbook.mapping import find_mapping

    if mapping is not None:
        return find_mapping(mapping).calibrate
    advised = (log.header.get(CALIBRATE) for log in logs)
    return next((each for each in advised if isinstance(each, Mapping) and each), {})


def setting_of(advised: Mapping[str, Any]) -> "AnalysisSetting":
    """Return the setting of a reconciliation that the mapping of a foreign log advises."""
    from pitotbench.reconciliation.free_parameters import AnalysisSetting

    static = advised.get("error_location") == "static"
    mach = advised.get("mach_max")
    return AnalysisSetting(static_error=static, mach_max=mach if isinstance(mach, float) else 1.0)


_LIBRARIES = ("numpy", "scipy", "pandas", "jsbsim")
# Role, what was given, and the log read of it; None of another file.
Source = tuple[str, OneLog, FlightLog | None]


def provenance_of(sources: Iterable[Source], choices: Iterable[Choice]) -> Provenance:
    """Return the provenance of a new answer: inputs with digests, choices, versions, and date."""
    date = datetime.now(UTC).strftime("%Y-%m-%d")
    return Provenance(
        tuple(_input_of(*each) for each in sources), tuple(choices), _versions(), date
    )


def sources_of(
    role: str, given: OneLog | Sequence[OneLog], logs: Sequence[FlightLog | None]
) -> list[Source]:
    """Return what was given, a list flattened, each with the log that was read of it."""
    return [(role, source, log) for source, log in zip(flatten(given), logs, strict=True)]


def flatten(given: OneLog | Sequence[OneLog]) -> list[OneLog]:
    """Return what was given as one list, those within lists included."""
    if isinstance(given, Sequence) and not isinstance(given, str):
        return [one for each in given for one in flatten(each)]
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
    from pitotbench.campaigns.digests import file_sha256
    from pitotbench.logbook.identity import airplane_of, day_of, kind_of
    from pitotbench.records.outputs import file_name

    name, channels = "in memory", {} if log is None else log.channels()
    if isinstance(source, str | Path):
        path = Path(source)  # of a file in a .zip, the digest is that of the .zip
        there = next((each for each in (path, *path.parents) if each.exists()), path)
        name, digest = file_name(path), file_sha256(there)
    else:
        told = sha256()
        for key, array in channels.items():  # one after another: together they fill the memory
            told.update(key.encode())
            plain = array.astype(np.str_) if array.dtype == object else array
            told.update(np.ascontiguousarray(plain).view(np.uint8).data)
        digest = told.hexdigest()
    if log is None:
        return InputFile(role, name, digest)
    shown = np.stack(
        [
            air.calibrated_airspeed(np.maximum(log.impact_pressure, 0.0)),
            air.pressure_altitude(log.static_pressure),
        ]
    )
    airspeeds, heights = (
        (float(low), float(high)) for low, high in np.quantile(shown, (0.05, 0.95), axis=1).T
    )
    return InputFile(
        role,
        name,
        digest,
        rows=len(log),
        minutes=float(log.time[-1] - log.time[0]) / 60.0,
        origin="simulated" if log.simulated else "measured",
        channels=tuple(channels),
        airspeeds=airspeeds,
        heights=heights,
        airplane=airplane_of(log),
        flown=day_of(log),
        kind=kind_of(log),
    )


def settings_of(
    options: "CalibrationOptions", stated: Collection[str], advised: Collection[str]
) -> list[Choice]:
    """Return every option of a calibration with who chose it, but the accuracies.

    The answer holds these.
    """
    from pitotbench.units import SUFFIXES

    values = {f.name: getattr(options, f.name) for f in fields(options) if f.name != "accuracies"}
    for name, suffix in ((f.name, f.metadata.get("unit")) for f in fields(options)):
        if suffix and values[name] is not None:
            unit = SUFFIXES[suffix]
            values[name] = f"{values[name] / unit.factor:g} {unit.symbol}"
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
    from pitotbench.campaigns.digests import NOT_DECIDING, package_digest
    from pitotbench.version import __version__

    own = f"{__version__} (code {package_digest(NOT_DECIDING)})"
    return {
        "pitotbench": own,
        "Python": python_version(),
        **{name: version(name) for name in _LIBRARIES},
    }
