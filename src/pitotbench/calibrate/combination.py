"""Answers of different models meet in the curve and the wind: their mixture, and bounds that hold for it."""

from collections.abc import Sequence

import numpy as np

from pitotbench.calibrate.curve import CurveMap
from pitotbench.calibrate.evidence import Judgment
from pitotbench.estimate.mixture import half_width
from pitotbench.records.calibration import ErrorCurve, Estimate, WindEstimate
from pitotbench.units import Array, MetersPerSecond

_NEGLIGIBLE = 1e-6  # weight of a Gaussian that no bound would notice

Gaussians = tuple[Array, Array, Array]  # weights (m,), means (m, c), standard deviations (m, c)


def combined_curve(judgments: Sequence[Judgment], weights: Array, of_best: ErrorCurve) -> ErrorCurve:
    """The mixture of the curves at the airspeeds of the best one's; white bounds stay those of the best."""
    speeds = of_best.indicated_airspeed
    correction, correction_bound = _summary([_corrections(j, speeds) for j in judgments], weights)
    normalized, normalized_bound = _summary([_normalized(j, speeds) for j in judgments], weights)
    return ErrorCurve(
        indicated_airspeed=speeds,
        correction=correction,
        two_sigma=correction_bound,
        white_two_sigma=of_best.white_two_sigma,
        normalized_pressure_error=normalized,
        normalized_two_sigma=normalized_bound,
    )


def combined_wind(judgments: Sequence[Judgment], weights: Array) -> WindEstimate:
    """The mixture of the winds."""
    value, bound = _summary([_winds(j) for j in judgments], weights)
    parts = zip(("north", "east", "down"), value, bound, strict=False)
    return WindEstimate(*(Estimate(name, float(v), float(b)) for name, v, b in parts))


def _summary(answers: Sequence[Gaussians], weights: Array) -> tuple[Array, Array]:
    """Mean and 2σ half-width of the mixture of all models' Gaussians."""
    shares = np.concatenate([weight * own for weight, (own, _, _) in zip(weights, answers, strict=True)])
    kept = shares > _NEGLIGIBLE
    shares = shares[kept] / shares[kept].sum()
    means = np.concatenate([mean for _, mean, _ in answers])[kept]
    deviations = np.concatenate([deviation for _, _, deviation in answers])[kept]
    return shares @ means, half_width(shares, means, deviations)


def _corrections(judgment: Judgment, speeds: MetersPerSecond) -> Gaussians:
    curve, free = CurveMap(judgment.candidate.model, speeds), judgment.candidate.model.error_count
    k = judgment.answer.mean[:free]
    gradient = curve.correction_gradient(k)
    means = curve.correction(k) + (judgment.answer.means[:, :free] - k) @ gradient.T
    return judgment.answer.weights, means, _deviations(judgment, gradient)


def _normalized(judgment: Judgment, speeds: MetersPerSecond) -> Gaussians:
    basis, free = CurveMap(judgment.candidate.model, speeds).basis(), judgment.candidate.model.error_count
    return judgment.answer.weights, judgment.answer.means[:, :free] @ basis.T, _deviations(judgment, basis)


def _winds(judgment: Judgment) -> Gaussians:
    model, answer = judgment.candidate.model, judgment.answer
    own = slice(model.error_count, model.count)
    variances = np.diagonal(answer.covariances, axis1=1, axis2=2)[:, own]
    return answer.weights, answer.means[:, own], np.sqrt(variances)


def _deviations(judgment: Judgment, gradient: Array) -> Array:
    own = judgment.answer.covariances[:, : gradient.shape[1], : gradient.shape[1]]
    return np.sqrt(np.einsum("cp,mpq,cq->mc", gradient, own, gradient))
