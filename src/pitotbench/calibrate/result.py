"""Assemble a Calibration from either fit."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pitotbench import air
from pitotbench.calibrate.gls.posterior import Posterior
from pitotbench.calibrate.model.curve_map import CurveMap, curve_airspeeds
from pitotbench.calibrate.model.nuisances import Nuisance
from pitotbench.calibrate.model.prediction import PredictionModel
from pitotbench.calibrate.options import CalibrationOptions
from pitotbench.calibrate.output_error import OutputErrorFit
from pitotbench.calibrate.reduction import Reduction
from pitotbench.calibrate.rows.observations import Observations
from pitotbench.records.calibration import Calibration, ErrorCurve, Estimate, Residuals, Share, WindEstimate
from pitotbench.units import Array, MetersPerSecond


def assemble(reduction: Reduction, airspeeds: MetersPerSecond | None = None) -> Calibration:
    """Everything a user sees; the curve at indicated airspeeds [m/s], of the log's own range where None."""
    model, obs, white, answer = reduction.model, reduction.observations, reduction.white, reduction.answer
    if airspeeds is None:
        airspeeds = curve_airspeeds(air.calibrated_airspeed(obs.impact_pressure))
    residuals = _residuals(model, obs, answer.mean[: model.count])
    return Calibration(
        model=reduction.options.model,
        method=reduction.options.method,
        parameters=_parameters(model, answer),
        reference_pressure=model.reference_pressure,
        wind=_wind(model, answer),
        curve=with_altitude(
            _curve(CurveMap(model, airspeeds), white, answer), CurveMap(model, airspeeds), answer, obs
        ),
        residual_two_sigma=_published_two_sigma(reduction.options, model, obs, white),
        samples=len(obs),
        converged=True,
        reason=white.reason,
        condition_number=white.condition_number,
        residuals=residuals,
        warnings=reduction.warnings,
        shares=_shares(CurveMap(model, airspeeds), answer, reduction.nuisances),
        diagnostics={"iterations": white.iterations, **reduction.diagnostics},
        error_location=reduction.error_location,
    )


def _published_two_sigma(
    options: CalibrationOptions, model: PredictionModel, obs: Observations, white: OutputErrorFit
) -> float:
    """2σ of the residual between data and model as airspeed [m/s], of the fit as the paper does it."""
    airspeed = (
        white.residuals[0] if options.form == "scalar" else _residuals(model, obs.as_held(), white.theta).airspeed
    )
    return 2.0 * float(np.std(airspeed))


def _parameters(model: PredictionModel, answer: Posterior) -> tuple[Estimate, ...]:
    bounds = answer.two_sigma(np.eye(len(answer.mean)))
    names = model.error.parameter_names
    return tuple(Estimate(name, float(v), float(b)) for name, v, b in zip(names, answer.mean, bounds, strict=False))


def _wind(model: PredictionModel, answer: Posterior) -> WindEstimate:
    bounds = answer.two_sigma(np.eye(len(answer.mean)))
    names = ("north", "east", "down")[: model.count - model.error_count]
    parts = [
        Estimate(name, float(answer.mean[i]), float(bounds[i]))
        for i, name in enumerate(names, start=model.error_count)
    ]
    return WindEstimate(*parts)


def _curve(curve: CurveMap, white: OutputErrorFit, answer: Posterior) -> ErrorCurve:
    k = answer.mean[: curve.model.error_count]
    gradient, basis = _widened(curve.correction_gradient(k), answer), _widened(curve.basis(), answer)
    bounds = answer.two_sigma(gradient)
    own = gradient[:, : curve.model.count]
    white_variance = np.einsum("cp,pq,cq->c", own, white.covariance, own)
    return ErrorCurve(
        indicated_airspeed=curve.indicated_airspeed,
        correction=curve.correction(k),
        two_sigma=bounds,
        simultaneous_two_sigma=answer.simultaneous(gradient, bounds),
        white_two_sigma=2.0 * np.sqrt(white_variance),
        normalized_pressure_error=curve.normalized(k),
        normalized_two_sigma=answer.two_sigma(basis),
    )


def with_altitude(curve: ErrorCurve, of: CurveMap, answer: Posterior, obs: Observations) -> ErrorCurve:
    """The curve with what the error does to the altitude, where it is the static source's: at the middle of the
    log's static pressures."""
    if not of.model.static_error:
        return curve
    pressure = float(np.median(obs.static_pressure))
    k = answer.mean[: of.model.error_count]
    gradient = _widened(of.altitude_gradient(k, pressure), answer)
    return replace(
        curve, altitude_correction=of.altitude(k, pressure), altitude_two_sigma=answer.two_sigma(gradient)
    )


def _widened(gradient: Array, answer: Posterior) -> Array:
    """A gradient with respect to the error parameters as one with respect to all of θ."""
    wide = np.zeros((len(gradient), len(answer.mean)))
    wide[:, : gradient.shape[1]] = gradient
    return wide


def _shares(curve: CurveMap, answer: Posterior, nuisances: Sequence[Nuisance]) -> tuple[Share, ...]:
    """What each nuisance contributes to the bounds."""
    free, count = curve.model.error_count, curve.model.count
    gradient = _widened(curve.correction_gradient(answer.mean[:free]), answer)
    every = np.eye(len(answer.mean))
    wind, bounds = every[free : free + 2], answer.two_sigma(every)
    return tuple(
        Share(
            nuisance.name,
            Estimate(nuisance.name, float(answer.mean[place]), float(bounds[place])),
            float(np.sqrt(np.mean(answer.two_sigma_by(place, gradient) ** 2))),
            float(np.max(answer.two_sigma_by(place, wind))),
        )
        for place, nuisance in enumerate(nuisances, start=count)
    )


def _residuals(model: PredictionModel, obs: Observations, theta: Array) -> Residuals:
    prediction = model.predict(theta, obs)
    indicated = air.calibrated_airspeed(obs.impact_pressure)
    airspeed = indicated - air.calibrated_airspeed(prediction.indicated)
    return Residuals(time=obs.time, indicated_airspeed=indicated, airspeed=airspeed, used=obs.used)
