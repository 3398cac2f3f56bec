"""The location of the pressure error for the fixed-speed methods, as a fit of the curve judges it."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from pitotbench.calibrate.options import AUTO, CalibrationOptions
from pitotbench.records.errors import BadInputError, NoAnswerError
from pitotbench.records.log import FlightLog

_STATIC = "static"
_LAW = "inverse+"  # with which the height is judged where the options name all models


@dataclass(frozen=True, slots=True)
class LikelyLocation:
    """`static` is the share of the static source in the answer.

    `doubt` is the standard deviation that the location adds, as a share of the difference between the locations.
    """

    static: float
    doubt: float


def location_of(options: CalibrationOptions, location: str, diagnostics: Mapping[str, Any]) -> LikelyLocation:
    """The location that a calibration found, from its options, its place of the error and its diagnostics."""
    probability = diagnostics.get("static_probability")
    if probability is not None:
        return LikelyLocation(probability, float((probability * (1.0 - probability)) ** 0.5))
    # Without evidence the static source is an assumption, and the difference is one standard deviation.
    assumed = options.error_location == AUTO and options.method == "covering" and location == _STATIC
    return LikelyLocation(float(location == _STATIC), float(assumed))


def likely_location(log: FlightLog, options: CalibrationOptions) -> LikelyLocation:
    """Judge the location by the height where the log has it; else take the usual one, with doubt."""
    if options.error_location != AUTO:
        return location_of(options, options.error_location, {})
    from pitotbench.calibrate.gls.location import assumed_location  # slow to load; a stated location needs no fit
    from pitotbench.calibrate.reduction import reduce_log

    if log.altitude is not None and options.use_altitude:
        model = _LAW if options.model == AUTO else options.model
        try:
            fit = reduce_log(log, replace(options, model=model, method="covering", latency="given"))
        except (NoAnswerError, BadInputError):  # too few airspeeds for a curve
            pass
        else:
            return location_of(options, fit.error_location, fit.diagnostics)
    return location_of(options, assumed_location(log.header), {})
