"""Calibration of a FlightLog. Nothing in this package can read the truth of a simulated flight.

The estimators load with the first calibration, so that options and the arithmetic of legs do not
wait for SciPy. All arrays are SI and radians; parameters of the error curve are without units.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING

from numpy.linalg import LinAlgError

from pitotbench.broken import BROKEN
from pitotbench.calibration.leg_methods import fixed_speed as fixed_speed
from pitotbench.calibration.options import Accuracies as Accuracies
from pitotbench.calibration.options import CalibrationOptions as CalibrationOptions
from pitotbench.logbook.columns import PARAMETERS, SENSOR
from pitotbench.logbook.plausibility import SPEED_FACTOR
from pitotbench.records import BadInputError, NoAnswerError, OneHeadingError, UndeterminedError
from pitotbench.records.calibration import (
    CalibratedFlight,
    Calibration,
    Disagreement,
    RecordedAutopilot,
)
from pitotbench.records.legs import FixedSpeedResult as FixedSpeedResult
from pitotbench.records.log import Caution, FlightLog

if TYPE_CHECKING:
    from pitotbench.calibration.flights import Known

_CAUSES = (BROKEN, SPEED_FACTOR)  # codes of warnings that say why there is no answer


def calibrate(log: FlightLog, options: CalibrationOptions | None = None) -> Calibration:
    """Estimate the pressure-error curve and the wind from a log.

    Parameters: log; options (defaults: Inverse+, covering method). The result is in SI units, each
    number with 2σ. Raises BadInputError for a log that cannot be used, NoAnswerError for one that
    does not determine the answer.
    Source: Martos, Kiszely and Foster (2011) for the problem; see `covering` and `output_error` for
    the methods.
    """
    from pitotbench.calibration.reduction import one_thread, reduce_log
    from pitotbench.calibration.result import assemble

    chosen = options or CalibrationOptions()
    with one_thread(), _named_cause([log], chosen):
        try:
            found = assemble(reduce_log(log, chosen))
        except OneHeadingError as error:
            found = _by_height(log, chosen, error)
        return _held_up(CalibratedFlight(log, _judged(found, log), 0), chosen).calibration


def calibrate_flights(
    logs: Sequence[FlightLog],
    options: CalibrationOptions | None = None,
    known: "Known | None" = None,
    first: Callable[[tuple[CalibratedFlight, ...]], object] | None = None,
) -> tuple[CalibratedFlight, ...]:
    """Estimate one curve from all flights of the logs, with a separate wind for each flight.

    A log that pauses for more than five minutes holds several flights. A warning says where the
    flights disagree about the curve. `known` keeps what was fitted of each log (`reduce_flights`).
    `first` is called with the flights before their findings are held against another reading of the
    columns, which may cost as much again. Raises as `calibrate` does.
    """
    from pitotbench.calibration.flights import reduce_flights
    from pitotbench.calibration.reduction import one_thread
    from pitotbench.calibration.scale import with_scale

    chosen = options or CalibrationOptions()
    with one_thread(), _named_cause(logs, chosen):
        try:
            flights = reduce_flights(logs, chosen, known)
        except OneHeadingError as error:
            if len(logs) > 1:
                raise
            flights = [CalibratedFlight(logs[0], _by_height(logs[0], chosen, error), 0)]
        judged = tuple(
            replace(each, calibration=_judged(each.calibration, each.log)) for each in flights
        )
        if first is not None:
            first(
                tuple(
                    replace(each, calibration=with_scale(each.calibration, each.log))
                    for each in judged
                )
            )
        return tuple(_held_up(each, chosen) for each in judged)


def _held_up(flight: CalibratedFlight, options: CalibrationOptions) -> CalibratedFlight:
    """Return a flight with the factor on its airspeed, and what each finding would move.

    Both hold the answer against another reading of the columns.
    """
    from pitotbench.calibration.readings import with_readings
    from pitotbench.calibration.scale import with_scale

    scaled = replace(flight, calibration=with_scale(flight.calibration, flight.log))
    return replace(scaled, calibration=with_readings(scaled, options))


def _by_height(log: FlightLog, options: CalibrationOptions, error: OneHeadingError) -> Calibration:
    """Return the answer by height alone for a log of one heading.

    Raises `error` where its height tells nothing.
    """
    from pitotbench.calibration.result import assemble_by_height

    try:
        return assemble_by_height(log, options)
    except NoAnswerError:
        raise error from None


@contextmanager
def _named_cause(logs: Sequence[FlightLog], options: CalibrationOptions) -> Iterator[None]:
    """Name the cause where the block finds no answer: limits, or channels that disagree.

    A cause that the reading of the log found comes first.
    """
    from pitotbench.calibration.expected_bound import geometry_suffices
    from pitotbench.calibration.observations import limit_words

    try:
        yield
    except (NoAnswerError, LinAlgError) as error:
        text = str(error)
        # What the reading of the log has found is the cause, whatever the fit stumbles over.
        causes = [each for log in logs for each in log.cautions if each.code in _CAUSES]
        if causes:
            raise BadInputError(str(causes[0])) from error
        if isinstance(error, LinAlgError):
            raise
        if isinstance(error, UndeterminedError) and all(
            geometry_suffices(log, options) for log in logs
        ):
            text = (
                "the log does not determine the answer, although its headings and speeds suffice: "
                "air data and GPS "
                "velocity disagree; check that both are of one flight and one clock, and the "
                "units, axes and signs "
                "of the velocity"
            )
        raise type(error)(text + "".join({limit_words(log, options): 0 for log in logs})) from error


def _judged(calibration: Calibration, log: FlightLog) -> Calibration:
    """Return the calibration with the display's steps in its bound, and warn of a doubtful curve.

    Raises NoAnswerError where its bound is too wide.
    """
    from pitotbench.calibration.fit_checks import judge_curve, propwash_effect, require_useful
    from pitotbench.calibration.result import with_display_steps

    calibration = with_display_steps(calibration, log)
    parameters = log.header.get(PARAMETERS)
    if isinstance(parameters, Mapping) and all(
        isinstance(value, int | float) for value in parameters.values()
    ):
        wash, sensor = propwash_effect(calibration.residuals, log), log.header.get(SENSOR, 1)
        recorded = RecordedAutopilot(parameters, wash, sensor if isinstance(sensor, int) else 1)
        calibration = replace(calibration, autopilot=recorded)
    require_useful(calibration, log)
    curve = calibration.curve
    verdict = judge_curve(
        curve.indicated_airspeed, curve.normalized_pressure_error, curve.normalized_two_sigma
    )
    if calibration.autopilot is not None and verdict.kind != "plausible":
        # The parameters that formed the airspeed are part of its error, and what is asked for.
        names = ", ".join(
            f"{name} {value:g}" for name, value in calibration.autopilot.parameters.items()
        )
        size = verdict.words.partition("; ")[0]
        words = f"{size}: a wrong old parameter ({names}) looks so; --params gives new ones"
        verdict = replace(verdict, words=words)
    if verdict.kind != "plausible":
        caution = Caution(verdict.words, "curve size", size=verdict.worst)
        calibration = replace(calibration, warnings=(*calibration.warnings, caution))
    broken = [
        Disagreement("pitot", str(each), 0.0, fatal=True)
        for each in log.cautions
        if each.code == BROKEN
    ]
    return replace(calibration, disagreements=(*broken, *calibration.disagreements))
