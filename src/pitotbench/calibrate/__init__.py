"""FlightLog to Calibration. Nothing in this room can reach the truth of a simulated flight."""

from functools import cache, partial
from typing import Any

import numpy as np
from threadpoolctl import ThreadpoolController

from pitotbench.calibrate.covering import fit_covering
from pitotbench.calibrate.fixed_speed import FixedSpeedResult as FixedSpeedResult
from pitotbench.calibrate.fixed_speed import fixed_speed as fixed_speed
from pitotbench.calibrate.judgment import Candidate
from pitotbench.calibrate.observability import require_observable, require_useful
from pitotbench.calibrate.observations import Observations, observe
from pitotbench.calibrate.options import AUTO
from pitotbench.calibrate.options import CalibrationOptions as CalibrationOptions
from pitotbench.calibrate.output_error import OutputErrorFit
from pitotbench.calibrate.paper import fit_scalar, fit_vector
from pitotbench.calibrate.prediction import PredictionModel
from pitotbench.calibrate.result import Answer, answer_of, assemble
from pitotbench.calibrate.structure import calibrate_auto
from pitotbench.pressure_error import MODELS, REFERENCE_PRESSURE
from pitotbench.records.calibration import Calibration
from pitotbench.records.log import FlightLog

_ILL_CONDITIONED = 1e6
_FULL_SCALE_RATIO = 8.0  # q_ci/q_ref above which the reference pressure is raised to the data

_LEAST_RANGE = 1.01  # of x between the outer knots of a spline, where the airspeed hardly changes


def calibrate(log: FlightLog, options: CalibrationOptions | None = None) -> Calibration:
    """Recover the pressure-error curve and the wind from a log.

    Parameters: log; options (defaults: Inverse+, covering method).
    Raises BadInputError for a log that cannot be used, NoAnswerError for one that does not determine the answer.
    Source: Martos, Kiszely and Foster (2011) for the problem; see `covering` and `output_error` for the methods.
    """
    # One thread: faster on arrays of this size, and the same digits on any number of cores.
    with _threads().limit(limits=1):
        return _calibrate(log, options or CalibrationOptions())


@cache
def _threads() -> ThreadpoolController:
    """Looked up once: finding the loaded libraries takes longer than a fit."""
    return ThreadpoolController()


def _calibrate(log: FlightLog, options: CalibrationOptions) -> Calibration:
    obs = observe(log, options)
    if options.model == AUTO:
        fit = partial(_candidate, options, obs)
        calibration = calibrate_auto(options, obs, fit, lambda chosen: _warnings(log, obs, chosen.white))
        require_useful(calibration)
        return calibration
    model = _model(options.model, options, obs)
    require_observable(model, obs)
    white = fit_vector(model, obs, log) if options.form == "vector" else fit_scalar(model, obs)
    answer, diagnostics = _bound(options, model, obs, white)
    calibration = assemble(options, model, obs, white, answer, diagnostics, _warnings(log, obs, white))
    require_useful(calibration)
    return calibration


def _model(name: str, options: CalibrationOptions, obs: Observations) -> PredictionModel:
    """What is fitted; a model with knots gets them over the range of the data."""
    error = MODELS[name].spread_over(*_flown(obs))
    return PredictionModel(error, _reference(obs), options.error_location == "static", options.wind_down)


def _flown(obs: Observations) -> tuple[float, float]:
    """The range of x = q_ci/q_ref in the data, without the outermost thousandths."""
    low, high = (float(q) for q in np.quantile(obs.impact_pressure, [0.001, 0.999]) / _reference(obs))
    return low, max(high, _LEAST_RANGE * low)


def _candidate(options: CalibrationOptions, obs: Observations, name: str) -> Candidate:
    """One model, fitted to be weighed. Raises NoAnswerError where the log does not determine it."""
    model = _model(name, options, obs)
    require_observable(model, obs)
    white = fit_scalar(model, obs)
    return Candidate(name, model, _flown(obs), white, fit_covering(model, obs, white.theta))


def _bound(
    options: CalibrationOptions, model: PredictionModel, obs: Observations, white: OutputErrorFit
) -> tuple[Answer, dict[str, Any]]:
    """The answer whose bound is reported: of the chosen method."""
    if options.method == "paper":
        return answer_of(white), {}
    fit = fit_covering(model, obs, white.theta)
    return answer_of(fit), {
        "gust_deviation_mps": fit.gust_deviation,
        "gust_length_m": fit.gust_length,
        "blocks": fit.blocks,
    }


def _reference(obs: Observations) -> float:
    """The usual reference pressure [Pa], or a round one near the data's middle for fast airplanes."""
    middle = float(np.median(obs.impact_pressure))
    if middle < _FULL_SCALE_RATIO * REFERENCE_PRESSURE:
        return REFERENCE_PRESSURE
    return float(round(middle, -3))


def _warnings(log: FlightLog, obs: Observations, white: OutputErrorFit) -> tuple[str, ...]:
    warnings = list(log.header.get("warnings", ()))
    if obs.standard_day:
        warnings.append("no temperature in the log: a standard day is assumed; 5 K off is about 1 kt at 100 kt")
    if white.condition_number > _ILL_CONDITIONED:
        warnings.append(
            f"condition number {white.condition_number:.1e}: the parameters are nearly confounded; "
            "trust the curve inside the flown speeds, not the single parameters"
        )
    return tuple(warnings)
