"""Logs that hold one flight or several: one curve for all flights, and a separate wind for each.

A log is cut where its recording pauses for more than five minutes. A flight that determines no answer by itself,
such as a taxi or a leg on one heading, is left out where two others remain; else the log is reduced as one flight.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

from pitotbench.calibrate.averaging.model_average import calibrate_auto
from pitotbench.calibrate.joint_fit import join
from pitotbench.calibrate.observability import require_useful
from pitotbench.calibrate.options import AUTO, CalibrationOptions
from pitotbench.calibrate.reduction import Reduction, reduce_log, reference_of
from pitotbench.calibrate.result import assemble
from pitotbench.calibrate.rows.observations import observe
from pitotbench.logbook import flights_in
from pitotbench.records.calibrated_flight import CalibratedFlight
from pitotbench.records.calibration import Calibration
from pitotbench.records.errors import BadInputError, NoAnswerError
from pitotbench.records.log import FlightLog
from pitotbench.units import MetersPerSecond

T = TypeVar("T")
_FEWEST = 2  # flights of one log


@dataclass(frozen=True, slots=True)
class _Part(Generic[T]):
    """A flight cut from a log, with what came of it."""

    log: FlightLog
    found: T
    place: int
    number: int
    count: int
    left_out: tuple[int, ...] = ()


def reduce_flights(logs: Sequence[FlightLog], options: CalibrationOptions) -> list[CalibratedFlight]:
    """Calibrate every flight of the logs, with one curve for all and a separate wind for each.

    The model `auto` gives each flight of a log its own curve, and a warning says so. Raises as `reduce_log` does,
    and BadInputError for several logs with the model `auto`.
    """
    if options.model == AUTO:
        if len(logs) > 1:
            raise BadInputError(
                "several logs have a curve in common only of one model: name it, or use --separately"
            )

        def calibrate(log: FlightLog) -> Calibration:
            calibration = calibrate_auto(log, options)
            require_useful(calibration)
            return calibration

        alone = _parts(logs[0], 0, calibrate)
        return [_flight(part, part.found, 1) for part in alone]
    reference = reference_of([observe(log, options) for log in logs])

    def reduce(log: FlightLog) -> Reduction:
        reduction = reduce_log(log, options, reference)
        require_useful(assemble(reduction))
        return reduction

    parts = [part for place, log in enumerate(logs) for part in _parts(log, place, reduce)]
    if len(parts) == 1:
        return [_flight(parts[0], assemble(parts[0].found), 1)]
    joint = assemble_together(join([part.found for part in parts]))
    return [_flight(part, calibration, len(parts)) for part, calibration in zip(parts, joint, strict=True)]


def assemble_together(joint: Sequence[tuple[Reduction, MetersPerSecond]]) -> list[Calibration]:
    """Assemble the Calibration of each reduction with the joint answer; all have one band for the whole curve."""
    found = [assemble(reduction, airspeeds) for reduction, airspeeds in joint]
    # The band comes from random draws of all unknowns, of which each flight has its own.
    band = found[0].curve.simultaneous_two_sigma
    return [replace(each, curve=replace(each.curve, simultaneous_two_sigma=band)) for each in found]


def _parts(log: FlightLog, place: int, reduce: Callable[[FlightLog], T]) -> list[_Part[T]]:
    """Cut a log into its flights and reduce each; one part, the whole log, where fewer than two give an answer."""
    flights = flights_in(log)
    found: list[_Part[T]] = []
    missing: list[int] = []
    for number, flight in enumerate(flights if len(flights) > 1 else [], start=1):
        try:
            found.append(_Part(flight, reduce(flight), place, number, len(flights)))
        except (NoAnswerError, BadInputError):
            missing.append(number)
    if len(found) < _FEWEST:
        return [_Part(log, reduce(log), place, 1, 1)]
    return [replace(part, left_out=tuple(missing)) for part in found]


def _flight(part: _Part[T], calibration: Calibration, joined: int) -> CalibratedFlight:
    """The flight of a part, with the warnings that the cutting of its log makes."""
    warnings = list(calibration.warnings)
    if part.left_out:
        names = ", ".join(str(number) for number in part.left_out)
        warnings.append(f"flight {names} of this log determines no answer by itself and is left out")
    if part.count > 1 and joined == 1:
        warnings.append("auto gives each flight of this log its own curve: name a model for one curve in common")
    calibration = replace(calibration, warnings=tuple(warnings))
    return CalibratedFlight(part.log, calibration, part.place, part.number, part.count, joined)
