"""Assemble a Calibration from either fit."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from pitotbench import air
from pitotbench.calibrate.covering import CoveringFit
from pitotbench.calibrate.curve import CurveMap, curve_airspeeds
from pitotbench.calibrate.observations import Observations
from pitotbench.calibrate.options import CalibrationOptions
from pitotbench.calibrate.output_error import OutputErrorFit
from pitotbench.calibrate.prediction import PredictionModel
from pitotbench.estimate.mixture import half_width
from pitotbench.records.calibration import Calibration, ErrorCurve, Estimate, Residuals, WindEstimate
from pitotbench.units import Array


@dataclass(frozen=True, slots=True)
class Answer:
    """Weighted Gaussian answers for θ: weights (m,), means (m, p), covariances (m, p, p)."""

    weights: Array
    means: Array
    covariances: Array

    @property
    def mean(self) -> Array:
        return np.asarray(self.weights @ self.means)

    def two_sigma(self, gradient: Array) -> Array:
        """Half-widths of linear functions of θ, gradient (c, p)."""
        means = self.means @ gradient.T
        variances = np.einsum("cp,mpq,cq->mc", gradient, self.covariances, gradient)
        return half_width(self.weights, means, np.sqrt(variances))


def answer_of(fit: OutputErrorFit | CoveringFit) -> Answer:
    """The answer of a fit: one Gaussian for output error, a mixture for the covering estimator."""
    if isinstance(fit, OutputErrorFit):
        return Answer(np.ones(1), fit.theta[None], fit.covariance[None])
    return Answer(
        np.array([node.weight for node in fit.nodes]),
        fit.theta + np.stack([node.estimate for node in fit.nodes]),
        np.stack([node.covariance for node in fit.nodes]),
    )


def assemble(
    options: CalibrationOptions,
    model: PredictionModel,
    obs: Observations,
    white: OutputErrorFit,
    answer: Answer,
    diagnostics: dict[str, Any],
    warnings: tuple[str, ...],
) -> Calibration:
    """Everything a user sees, from the answer and the white fit that preceded it."""
    residuals = _residuals(model, obs, answer.mean)
    return Calibration(
        model=options.model,
        method=options.method,
        parameters=_parameters(model, answer),
        reference_pressure=model.reference_pressure,
        wind=_wind(model, answer),
        curve=_curve(model, obs, white, answer),
        residual_two_sigma=_published_two_sigma(options, model, obs, white),
        samples=len(obs),
        converged=True,
        reason=white.reason,
        condition_number=white.condition_number,
        residuals=residuals,
        warnings=warnings,
        diagnostics={"iterations": white.iterations, **diagnostics},
    )


def _published_two_sigma(
    options: CalibrationOptions, model: PredictionModel, obs: Observations, white: OutputErrorFit
) -> float:
    """2σ of the residual between data and model as airspeed [m/s], of the fit as the paper does it."""
    airspeed = (
        white.residuals[0] if options.form == "scalar" else _residuals(model, obs.as_held(), white.theta).airspeed
    )
    return 2.0 * float(np.std(airspeed))


def _parameters(model: PredictionModel, answer: Answer) -> tuple[Estimate, ...]:
    bounds = answer.two_sigma(np.eye(model.count))
    names = model.error.parameter_names
    return tuple(Estimate(name, float(v), float(b)) for name, v, b in zip(names, answer.mean, bounds, strict=False))


def _wind(model: PredictionModel, answer: Answer) -> WindEstimate:
    bounds = answer.two_sigma(np.eye(model.count))
    names = ("north", "east", "down")[: model.count - model.error_count]
    parts = [
        Estimate(name, float(answer.mean[i]), float(bounds[i]))
        for i, name in enumerate(names, start=model.error_count)
    ]
    return WindEstimate(*parts)


def _curve(model: PredictionModel, obs: Observations, white: OutputErrorFit, answer: Answer) -> ErrorCurve:
    airspeeds = curve_airspeeds(air.calibrated_airspeed(obs.impact_pressure))
    curve, free = CurveMap(model, airspeeds), model.error_count
    k = answer.mean[:free]
    gradient, basis = np.zeros((len(airspeeds), model.count)), np.zeros((len(airspeeds), model.count))
    gradient[:, :free], basis[:, :free] = curve.correction_gradient(k), curve.basis()
    white_variance = np.einsum("cp,pq,cq->c", gradient, white.covariance, gradient)
    return ErrorCurve(
        indicated_airspeed=airspeeds,
        correction=curve.correction(k),
        two_sigma=answer.two_sigma(gradient),
        white_two_sigma=2.0 * np.sqrt(white_variance),
        normalized_pressure_error=curve.normalized(k),
        normalized_two_sigma=answer.two_sigma(basis),
    )


def _residuals(model: PredictionModel, obs: Observations, theta: Array) -> Residuals:
    prediction = model.predict(theta, obs)
    indicated = air.calibrated_airspeed(obs.impact_pressure)
    airspeed = indicated - air.calibrated_airspeed(prediction.indicated)
    return Residuals(time=obs.time, indicated_airspeed=indicated, airspeed=airspeed, used=obs.used)
