"""Calibrate each log of a folder or a .zip file once, with one curve where they share it."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from pitotbench.bench.calibrations import OneLog, Source, calibrate_each, names_of, sources_of
from pitotbench.calibration.flights import DISAGREE
from pitotbench.calibration.options import CalibrationOptions
from pitotbench.calibration.over_dates import over_dates
from pitotbench.campaigns.progress import progress
from pitotbench.logbook.columns import MAPPING, PARAMETERS
from pitotbench.logbook.identity import airplane_of
from pitotbench.logbook.same_flight import distinct, recorders_notices
from pitotbench.records import BadInputError, NoAnswerError
from pitotbench.records.calibration import CalibratedFlight, PublishedCurve
from pitotbench.records.log import Caution, Choice, CurveMove, FlightLog
from pitotbench.records.over_dates import OverDates

if TYPE_CHECKING:
    from pitotbench.calibration.flights import Known

T = TypeVar("T", bound=OneLog)
_CHANGED = "changed over dates"  # code of the warning
_SHOWN = 3  # logs left out that a warning names with their reason


@dataclass(frozen=True, slots=True)
class FolderAnswer(Generic[T]):
    """A log of a folder with what was given for it, and its flights.

    `over_dates` is the course of the correction over all logs, None where their dates tell none.
    """

    given: T
    log: FlightLog
    flights: tuple[CalibratedFlight, ...]
    over_dates: OverDates | None = None


def calibrate_folder(
    given: Sequence[T],
    read: Callable[[T], FlightLog],
    separately: bool = False,
    report: Callable[[str], None] = lambda _: None,
    label: str = "",
    options: CalibrationOptions | None = None,
    sources: Iterable[Source] = (),
    flags: Iterable[Choice] = (),
    published: tuple[PublishedCurve, ...] = (),
    **choices: Any,
) -> list[FolderAnswer[T]]:
    """Calibrate those of several logs that have an answer; `report` a line on each.

    They share one curve. They have one each if `separately`, of several airplanes or recorders,
    with the model `auto`, and where a log answers by its height alone. Each log is fitted once. A
    warning of each answer names the logs that are left out. `label` is that of the progress shown;
    the other parameters are those of `calibrate_each`. Raises BadInputError where no log has an
    answer.
    """
    known: Known = {}

    def fit(answers: Sequence[tuple[T, FlightLog]]) -> tuple[CalibratedFlight, ...]:
        several, logs = zip(*answers, strict=True)
        files = [*sources_of("log", several, logs), *sources]
        return calibrate_each(logs, options, None, files, flags, published, known, **choices)

    found: list[FolderAnswer[T]] = []
    left_out: list[str] = []
    with progress(label, len(given)) as step:
        for each in given:
            name = Path(each).name if isinstance(each, str | Path) else "a log in memory"
            try:
                log = read(each)
                found.append(FolderAnswer(each, log, fit([(each, log)])))
                curve = found[-1].flights[0].calibration.curve
                place = len(curve.indicated_airspeed) // 2
                report(
                    f"{name}: {curve.correction_kt[place]:+.2f} ± {curve.two_sigma_kt[place]:.2f} "
                    f"kt at {curve.indicated_airspeed_kt[place]:.0f} KIAS"
                )
            except (BadInputError, NoAnswerError) as error:
                reason = str(error).removeprefix(f"{each}: ")
                left_out.append(f"{name}: {reason}")
                report(f"{name}: left out: {reason}")
            step()
    report(f"{len(given)} logs, {len(found)} with an answer")
    if not found:
        raise BadInputError(f"none of its logs has an answer: {'; '.join(left_out[:_SHOWN])}")
    course = (
        None
        if _differ_in_recorder(found)
        else over_dates(_names(found), [a.flights for a in found])
    )
    by_height = {id(each) for each in found if not any(key[0] == id(each.log) for key in known)}
    common = [each for each in found if id(each) not in by_height]
    places = distinct([each.log for each in found], _names(found)).places
    groups = [
        [each for each, at in zip(found, places, strict=True) if at == place]
        for place in range(max(places) + 1)
    ]
    if common and not separately and not _differ_in_recorder(common):
        groups = [common, *(own for own in groups if id(own[0]) in by_height)]
    answers = list[FolderAnswer[T]]()
    for own in groups:
        if len(own) == 1:
            answers += own
            continue
        flights = fit([(each.given, each.log) for each in own])
        answers += [
            replace(each, flights=tuple(flight for flight in flights if flight.place == place))
            for place, each in enumerate(own)
        ]
    first = [own[0] for own in groups]
    apart = recorders_notices([each.log for each in first], _names(first), together=False)
    cautions = (*apart, *_left_out(left_out), *_changed(course))
    return [replace(_warned(each, cautions), over_dates=course) for each in answers]


def _names(answers: Sequence[FolderAnswer[T]]) -> list[str]:
    return names_of([each.given for each in answers], len(answers))


def _differ_in_recorder(answers: Sequence[FolderAnswer[T]]) -> bool:
    """Return whether logs have no curve in common: another recorder shows another airspeed."""
    kinds = {
        (airplane_of(log), *(str(log.header.get(name)) for name in (MAPPING, PARAMETERS)))
        for log in (each.log for each in answers)
    }
    return len(kinds) > 1


def _left_out(words: Sequence[str]) -> tuple[Caution, ...]:
    if not words:
        return ()
    more = f" and {len(words) - _SHOWN} more" if len(words) > _SHOWN else ""
    text = f"logs without an answer: {'; '.join(words[:_SHOWN])}{more}"
    return (Caution(text, "logs left out"),)


def _changed(course: OverDates | None) -> tuple[Caution, ...]:
    """A warning of a change over dates, with what it moves in a curve of all flights at most."""
    if course is None or course.change is None:
        return ()
    size, bound = abs(course.change.size), course.change.two_sigma
    return (Caution(course.words, _CHANGED, moves=CurveMove(size, size / bound)),)


def _warned(answer: FolderAnswer[T], cautions: Sequence[Caution]) -> FolderAnswer[T]:
    """The answer with further warnings; one of a dated change says how the flights disagree."""
    said = {DISAGREE} if any(each.code == _CHANGED for each in cautions) else set()
    return replace(
        answer,
        flights=tuple(
            replace(
                each,
                calibration=replace(
                    each.calibration,
                    warnings=(
                        *(w for w in each.calibration.warnings if w.code not in said),
                        *cautions,
                    ),
                ),
            )
            for each in answer.flights
        ),
    )
