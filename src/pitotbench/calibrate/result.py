"""The Calibration assembled from a reduction by either method."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pitotbench import air
from pitotbench.calibrate.gls.posterior import Posterior
from pitotbench.calibrate.model.curve_map import CurveMap, curve_airspeeds
from pitotbench.calibrate.model.nuisances import ZERO, Nuisance
from pitotbench.calibrate.model.prediction import PredictionModel
from pitotbench.calibrate.output_error import OutputErrorFit
from pitotbench.calibrate.reduction import Reduction
from pitotbench.calibrate.rows.observations import Observations
from pitotbench.records.calibration import Calibration, ErrorCurve, Estimate, Residuals, Share, WindEstimate
from pitotbench.records.errors import NoAnswerError
from pitotbench.units import Array, MetersPerSecond

_FEWEST_POINTS = 2  # of a curve


def assemble(reduction: Reduction, airspeeds: MetersPerSecond | None = None) -> Calibration:
    """Assemble the Calibration of a reduction.

    `airspeeds` (c,) [m/s] are the indicated airspeeds of the curve; None takes the range of the log. Raises
    NoAnswerError where the impact pressure is hardly more than its zero offset.
    """
    model, obs, white, answer = reduction.model, reduction.observations, reduction.white, reduction.answer
    zero = found_zero(model, answer, reduction.nuisances)
    if airspeeds is None:
        airspeeds = curve_airspeeds(air.calibrated_airspeed(obs.impact_pressure))
    curve = CurveMap(model, _above_zero(airspeeds, zero), 0.0 if zero is None else zero.value)
    residuals = _residuals(model, obs, answer.mean[: model.count])
    return Calibration(
        model=reduction.options.model,
        method=reduction.options.method,
        parameters=_parameters(model, answer),
        reference_pressure=model.reference_pressure,
        wind=_wind(model, answer),
        curve=with_altitude(_curve(curve, white, answer, reduction.nuisances), curve, answer, obs),
        residual_two_sigma=2.0 * float(np.std(white.residuals[0])),
        samples=len(obs),
        converged=True,
        reason=white.reason,
        condition_number=white.condition_number,
        residuals=residuals,
        warnings=reduction.warnings,
        shares=_shares(curve, answer, reduction.nuisances),
        diagnostics={"iterations": white.iterations, **reduction.diagnostics},
        error_location=reduction.error_location,
        assumptions=reduction.assumptions,
        impact_pressure_zero=zero,
    )


def found_zero(model: PredictionModel, answer: Posterior, nuisances: Sequence[Nuisance]) -> Estimate | None:
    """Return the zero offset of the impact pressure [Pa], or None where it was not estimated."""
    place = _zero_place(model, nuisances)
    if place is None:
        return None
    only = np.eye(len(answer.mean))[[place]]
    return Estimate(ZERO, float(answer.mean[place]), float(answer.two_sigma(only)[0]))


def _zero_place(model: PredictionModel, nuisances: Sequence[Nuisance]) -> int | None:
    names = [nuisance.name for nuisance in nuisances]
    return model.count + names.index(ZERO) if ZERO in names else None


def _above_zero(airspeeds: MetersPerSecond, zero: Estimate | None) -> MetersPerSecond:
    """The airspeeds whose impact pressure exceeds the zero offset plus its 2σ.

    Raises NoAnswerError where there are fewer than two.
    """
    if zero is None:
        return airspeeds
    above = air.impact_pressure(airspeeds) > zero.value + zero.two_sigma
    if np.count_nonzero(above) < _FEWEST_POINTS:
        raise NoAnswerError(
            f"the impact pressure is hardly more than its zero offset ({zero.value:+.0f} ± {zero.two_sigma:.0f} "
            "Pa, 2σ): fly faster, or set the sensor's zero before the flight"
        )
    return airspeeds[above]


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


def _curve(curve: CurveMap, white: OutputErrorFit, answer: Posterior, nuisances: Sequence[Nuisance]) -> ErrorCurve:
    k = answer.mean[: curve.model.error_count]
    gradient, basis = correction_gradient(curve, answer, nuisances), widened(curve.basis(), answer)
    bounds = answer.two_sigma(gradient)
    part = gradient[:, : curve.model.count]
    white_variance = np.einsum("cp,pq,cq->c", part, white.covariance, part)
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
    """Add the altitude correction [m] and its 2σ to the curve where the error is the static source's.

    They are computed at the median of the log's static pressures.
    """
    if not of.model.static_error:
        return curve
    pressure = float(np.median(obs.static_pressure))
    k = answer.mean[: of.model.error_count]
    gradient = widened(of.altitude_gradient(k, pressure), answer)
    return replace(
        curve, altitude_correction=of.altitude(k, pressure), altitude_two_sigma=answer.two_sigma(gradient)
    )


def correction_gradient(curve: CurveMap, answer: Posterior, nuisances: Sequence[Nuisance]) -> Array:
    """Derivative of the correction [m/s] with respect to all of θ, (c, p), including the zero offset."""
    k = answer.mean[: curve.model.error_count]
    gradient, place = widened(curve.correction_gradient(k), answer), _zero_place(curve.model, nuisances)
    if place is not None:
        gradient[:, place] = curve.correction_by_zero(k)
    return gradient


def widened(gradient: Array, answer: Posterior) -> Array:
    """Extend a gradient (c, K) over the error parameters with zeros to one over all of θ, (c, p)."""
    wide = np.zeros((len(gradient), len(answer.mean)))
    wide[:, : gradient.shape[1]] = gradient
    return wide


def _shares(curve: CurveMap, answer: Posterior, nuisances: Sequence[Nuisance]) -> tuple[Share, ...]:
    """The contribution of each nuisance to the bounds."""
    free, count = curve.model.error_count, curve.model.count
    gradient = correction_gradient(curve, answer, nuisances)
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
