"""Calibrate, reconcile and inspect from Python: a path, a DataFrame, a log or a list of them."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast, overload

from pitotbench.bench.calibration_request import choices_made, mapping_sources
from pitotbench.bench.calibrations import (
    OneLog,
    Source,
    advice_of,
    calibrate_each,
    facts_among,
    flatten,
    logs_of,
    model_sources,
    names_of,
    options_of,
    provenance_of,
    published_of,
    setting_of,
    sources_of,
)
from pitotbench.records.calibration import Calibration
from pitotbench.records.calibration_request import NamedFile, Reading
from pitotbench.records.case import Case
from pitotbench.records.legs import (
    FixedSpeedPoint,
    FixedSpeedResult,
    FlyByPoint,
    HandCard,
    KnownSpeedResult,
)
from pitotbench.records.log import FlightLog, LogInspection
from pitotbench.units import MetersPerSecond, Radians

if TYPE_CHECKING:
    from pitotbench.bench.workflow import FullReconciliation, NamedLog
    from pitotbench.calibration.options import CalibrationOptions
    from pitotbench.reconciliation.free_parameters import AnalysisSetting


@overload
def calibrate(
    logs: OneLog,
    options: "CalibrationOptions | None" = None,
    mapping: str | Path | None = None,
    handbook: str | Path | None = None,
    start: str | None = None,
    end: str | None = None,
    **choices: Any,
) -> Calibration: ...


@overload
def calibrate(
    logs: Sequence[OneLog],
    options: "CalibrationOptions | None" = None,
    mapping: str | Path | None = None,
    handbook: str | Path | None = None,
    start: str | None = None,
    end: str | None = None,
    **choices: Any,
) -> tuple[Calibration, ...]: ...


def calibrate(
    logs: OneLog | Sequence[OneLog],
    options: "CalibrationOptions | None" = None,
    mapping: str | Path | None = None,
    handbook: str | Path | None = None,
    start: str | None = None,
    end: str | None = None,
    **choices: Any,
) -> Calibration | tuple[Calibration, ...]:
    """Estimate the pressure-error curve and the wind from a log, a path, a DataFrame, or a list.

    The answer is that of `pitotbench calibrate`. Parameters: logs, of one airplane; options, or its
    fields as keywords (`model="quadratic"`, `wind="constant"`; what is not named comes from the
    mapping, else from `DEFAULTS`, else from `CalibrationOptions`); mapping, a shipped name or a
    TOML file, for logs with other column names; handbook, a table (CSV) of KIAS and KCAS to compare
    the curve with; start and end, the minutes and seconds of the log between which it is used, such
    as `start="12:30", end="25:00"`; among the keywords also what the logs do not hold, as for
    `read_log` (`height="2000"`, `temperature_c="18±2@ground"`). A list has one curve, and a
    Calibration with its own wind for each log. A folder or a .zip file of several logs stands for
    the list of those that have an answer, whose warnings name the others; they have a curve each
    where they are of several airplanes or recorders. Several flights of one log have one curve, and
    their winds in `winds`. SI units, each number with 2σ. Raises BadInputError for what cannot be
    used, NoAnswerError for a log that does not determine the answer.

    Source: Martos, Kiszely and Foster (2011) for the problem; `docs/method.md` for the methods.
    """
    from pitotbench.calibration.flights import of_one_log
    from pitotbench.logbook.same_flight import distinct

    published, part, facts = published_of(handbook), None, facts_among(choices)
    if start is not None or end is not None:
        from pitotbench.logbook.assembly import part_of

        part = part_of(start, end, names=("start", "end"))
    given = flatten(logs)
    flat = given if mapping else [one for each in given for one in _logs_of(each)]
    if len(flat) > len(given):
        from pitotbench.bench.folder_logs import calibrate_folder

        answers = calibrate_folder(
            flat,
            lambda each: logs_of(each, "calibrate", part=part, facts=facts)[0],
            options=options,
            published=published,
            **choices,
        )
        return tuple(of_one_log(answer.log, answer.flights) for answer in answers if answer.flights)
    read = logs_of(logs, "calibrate", mapping, part, facts)
    named = NamedFile(Path(mapping), str(mapping)) if mapping else None
    asked = Reading(named, str(start or ""), str(end or ""), **facts)
    sources = [*sources_of("log", logs, read), *mapping_sources(asked)]
    made = [each for each in choices_made(asked) if each.source == "stated"]
    flights = calibrate_each(read, options, mapping, sources, made, published, **choices)
    once = distinct(read, names_of(given, len(read)))
    found = tuple(
        of_one_log(once.logs[at], [each for each in flights if each.place == once.first[at]])
        for at in once.places
    )
    return found if isinstance(logs, list | tuple) else found[0]


Legs = (
    tuple[FixedSpeedPoint, ...]
    | tuple[FlyByPoint, ...]
    | HandCard
    | KnownSpeedResult
    | FixedSpeedResult
)


def fixed_speed(
    legs: OneLog | MetersPerSecond,
    track: Radians | None = None,
    mapping: str | Path | None = None,
    **facts: str,
) -> Legs:
    """Answer by the methods that need one true airspeed, as `pitotbench fixed-speed` does.

    Of a log (a path, a DataFrame or a FlightLog; `mapping` and the `facts` of its flight as for
    `calibrate`) the points of its legs and turns; of a card (CSV) with a row a leg its points and
    curves; of tower fly-bys a point a pass; of points with a known speed (`known_airspeed_kt`)
    factor, scale and zero. Three or four ground speeds [m/s] with their true tracks [rad] give the
    true airspeed and the wind, a `FixedSpeedResult`. Raises BadInputError for what cannot be used,
    NoAnswerError where no leg is found.
    Source: `docs/fixed-speed.md`.
    """
    if track is not None:
        from pitotbench.calibration.leg_methods import fixed_speed as of_legs

        return of_legs(cast(MetersPerSecond, legs), track)
    if isinstance(legs, str | Path):
        from pitotbench.calibration.fly_by import reduce_fly_bys
        from pitotbench.calibration.hand_card import reduce_card
        from pitotbench.calibration.known_speed import reduce_known_speeds
        from pitotbench.calibration.options import accuracies_of
        from pitotbench.logbook.points_table import (
            is_fly_by_card,
            is_known_speeds,
            is_points_table,
            read_fly_bys,
            read_known_speeds,
            read_points,
        )

        path, usual = Path(legs), accuracies_of(None, {})
        if is_fly_by_card(path):
            return tuple(reduce_fly_bys(*read_fly_bys(path), usual))
        if is_known_speeds(path):
            return reduce_known_speeds(*read_known_speeds(path))
        if is_points_table(path):
            return reduce_card(*read_points(path), usual)
    from pitotbench.calibration.leg_points import fixed_speed_points

    (log,) = logs_of([cast(OneLog, legs)], "fixed_speed", mapping, facts=facts)
    return tuple(fixed_speed_points(log, options_of([log], mapping)))


def _logs_of(given: OneLog) -> Sequence[OneLog]:
    """Return the paths of the logs of a folder or of a .zip file; another as it is."""
    from pitotbench.logbook.bundle import logs_given

    return logs_given(Path(given)) if isinstance(given, str | Path) else [given]


def inspect(log: OneLog, mapping: str | Path | None = None, **facts: str) -> LogInspection:
    """Return what a log holds and what can be learned from it: from a log, a path or a DataFrame.

    `mapping` and the `facts` of its flight as for `calibrate`. It shows itself as the sentences of
    `pitotbench inspect`; `to_frame` is the table of its channels. Raises BadInputError for a log
    that cannot be used.
    """
    from pitotbench.bench.inspection import inspect_log

    (read,) = logs_of([log], "inspect", mapping, facts=facts)
    return inspect_log(read, options_of([read], mapping))


def reconcile(
    logs: "OneLog | NamedLog | Sequence[OneLog | NamedLog]",
    aircraft: str = "navajo",
    holdout: "OneLog | NamedLog | None" = None,
    card: Case | None = None,
    setting: "AnalysisSetting | None" = None,
    refly: bool = True,
    progress: Callable[[str], None] | None = None,
    mapping: str | Path | None = None,
    keep: bool = True,
    close: str | None = None,
    terms: bool = False,
    choose: str = "",
    **facts: str,
) -> "FullReconciliation":
    """Find where a simulation and logs disagree, and name what the simulation lacks.

    Parameters: logs, a measured one (a log, a path or a DataFrame), or a list of several of one
    airplane whose causes and sizes are the same; aircraft, a model of the hangar, or `none` to
    judge the sensors alone; holdout, another log of the same airplane on which the gap has to
    shrink too; card, what was flown (default: the card in the header of each log); setting, what is
    known of the logs beyond their rows (default: what their mapping advises); refly, whether the
    card is flown again with the named effects; progress, called with a line of text at each step;
    mapping, as for `calibrate`; keep, whether the cache of null flights is read and written; close,
    a name: what is named of the airplane is patched into `./aircraft/<aircraft>+<close>`, and the
    logs are judged again with it, until nothing more closes (`account.closing`); terms, whether all
    aerodynamic terms of the model's file compete; choose, the cause to patch of a set that the logs
    do not tell apart; facts of the flight, as for `calibrate`.
    Returns a record with the `verdict`, the `probabilities` of the causes, the `sizes`, the `patch`
    and the figures of each of the `flights`. It shows itself in a notebook. Raises BadInputError
    for a log that cannot be used or a choice that is in no set, UnknownNameError for an aircraft
    that is not known.
    """
    from pitotbench.bench.workflow import NamedLog, reconcile_fully
    from pitotbench.calibration.reduction import one_thread
    from pitotbench.records.maneuver import Maneuvers

    if close is not None:
        from pitotbench.bench.closing import close_loop
        from pitotbench.simulation.modified import require_free

        require_free(aircraft, close)

    def read(given: Any, role: str, memory: str) -> tuple[list[NamedLog], list[Source]]:
        flat: list[Any] = flatten(given)
        found = [
            each
            if isinstance(each, NamedLog)
            else NamedLog(
                Path(each).name if isinstance(each, str | Path) else f"{memory} {n}",
                logs_of([each], "reconcile", mapping, facts=facts)[0],
            )
            for n, each in enumerate(flat, start=1)
        ]
        logs = [log for each in found if isinstance(log := each.log, FlightLog)]
        given = [each.log if isinstance(each, NamedLog) else each for each in flat]
        return found, sources_of(role, [g for g in given if not isinstance(g, Maneuvers)], logs)

    measured, sources = read(logs, "log", "flight")
    withheld, others = (
        ([], []) if holdout is None else read(holdout, "held-out log", "held-out log")
    )
    made = provenance_of([*sources, *others, *model_sources(aircraft)], [])
    every = [log for each in (*measured, *withheld) if isinstance(log := each.log, FlightLog)]
    chosen = replace(setting or setting_of(advice_of(every, mapping)), terms=terms)
    with one_thread():
        found = reconcile_fully(
            measured,
            aircraft,
            withheld[0] if withheld else None,
            card,
            progress,
            chosen,
            refly and close is None,
            keep=keep,
            choose=choose,
        )
        if close is not None:
            found = close_loop(found, close, withheld[0].log if withheld else None, progress, refly)
    return replace(found, provenance=made)
