"""`--model auto`: which model the log speaks for, and a bound that allows for not knowing it.

Every model of the table is fitted and judged. The answer is a mixture over the models and over departures from them
(Bayesian model averaging: Hoeting et al., Statistical Science 14, 1999), made where models can meet: in the curve.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.special import logsumexp

from pitotbench.calibrate.covering import linearized
from pitotbench.calibrate.curve import CurveMap
from pitotbench.calibrate.curve_prior import LEVEL, Hypothesis, hypotheses
from pitotbench.calibrate.evidence import moments, noise_masses, weigh
from pitotbench.calibrate.judgment import Candidate, Judgment, judge
from pitotbench.calibrate.observations import Observations
from pitotbench.calibrate.options import AUTO, CalibrationOptions
from pitotbench.calibrate.prediction import PredictionModel
from pitotbench.calibrate.result import Answer, answer_of, assemble
from pitotbench.estimate.restricted_likelihood import Regression
from pitotbench.pressure_error import MODELS, spline_between
from pitotbench.records.calibration import Calibration, ErrorCurve, Estimate, WindEstimate
from pitotbench.records.errors import NoAnswerError
from pitotbench.units import Array

_KNOTS = 13  # of the spline in which models meet: finer than any departure


@dataclass(frozen=True, slots=True)
class ModelChoice:
    """The models as judged; weight of each, (m,); what is thought and the log evidence of each thought, (h,); the
    spline in which they meet, and the mixture of all as an answer for it."""

    judgments: tuple[Judgment, ...]
    weights: Array
    thoughts: tuple[Hypothesis, ...]
    log_evidences: Array
    common: PredictionModel
    answer: Answer

    @property
    def best(self) -> Candidate:
        """The candidate of the greatest weight."""
        return self.judgments[int(np.argmax(self.weights))].candidate


def calibrate_auto(
    options: CalibrationOptions,
    obs: Observations,
    fit: Callable[[str], Candidate],
    warnings: Callable[[Candidate], tuple[str, ...]],
) -> Calibration:
    """Fit every model of the table, weigh them and combine their answers.

    Raises NoAnswerError where the log determines none of them.
    """
    choice = choose(_candidates(fit), obs)
    best = choice.best
    diagnostics = {
        "gust_deviation_mps": best.fit.gust_deviation,
        "gust_length_m": best.fit.gust_length,
        "blocks": best.fit.blocks,
        "model_choice": table_of(choice),
        "departure": departures_of(choice),
    }
    calibration = assemble(
        options, best.model, obs, best.white, answer_of(best.fit), diagnostics, warnings(best)
    )
    return replace(
        calibration,
        model=f"{AUTO} ({best.name})",
        curve=_curve(choice, calibration.curve),
        wind=_wind(choice),
    )


def _candidates(fit: Callable[[str], Candidate]) -> list[Candidate]:
    """The models that the log determines; where it determines none, the simplest one's reason is raised."""
    found: list[Candidate] = []
    reasons: list[NoAnswerError] = []
    for name in MODELS:
        try:
            found.append(fit(name))
        except NoAnswerError as error:
            reasons.append(error)
    if not found:
        raise reasons[0]
    return found


def choose(candidates: Sequence[Candidate], obs: Observations) -> ModelChoice:
    """Judge the candidates and weigh them, each with departures of every size."""
    judgments = tuple(judge(candidate, obs) for candidate in candidates)
    nearest = min(judgments, key=lambda judgment: judgment.aicc).candidate
    common, problem, masses = _common_problem(nearest, obs)
    knots = np.array(common.error.knots)
    level = max(LEVEL, float(np.sqrt(np.mean((nearest.model.error.basis(knots) @ _error(nearest)) ** 2))))
    thoughts = tuple(hypotheses([c.model.error for c in candidates], knots, level))
    nodes = [
        moments(problem, nearest.fit.noise_of(node.noise), float(mass))
        for node, mass in zip(nearest.fit.nodes, masses, strict=True)
    ]
    answer, logs = weigh(thoughts, nodes)
    shares = np.exp(logs - logsumexp(logs))
    weights = np.array([sum(shares[h] for h, t in enumerate(thoughts) if t.name == c.name) for c in candidates])
    return ModelChoice(judgments, weights, thoughts, logs, common, answer)


def _error(candidate: Candidate) -> Array:
    return candidate.fit.theta[: candidate.model.error_count]


def _common_problem(nearest: Candidate, obs: Observations) -> tuple[PredictionModel, Regression, Array]:
    """The problem in a fine spline, linearized at the curve of the candidate that fits best."""
    model, fit = nearest.model, nearest.fit
    x = obs.impact_pressure / model.reference_pressure
    low, high = (float(q) for q in np.quantile(x, [0.001, 0.999]))
    common = replace(model, error=spline_between(low, high, _KNOTS))
    knots = np.array(common.error.knots)
    k = model.error.basis(knots) @ _error(nearest)
    theta = np.concatenate([k, fit.theta[model.error_count :]])
    problem, _ = linearized(common, obs, theta, fit.gust_deviation)
    # For the curve and the wind themselves, not for corrections to those at which it was linearized.
    response = problem.response + problem.regressors @ theta
    return common, replace(problem, response=response), noise_masses(fit)


def _curve(choice: ModelChoice, of_best: ErrorCurve) -> ErrorCurve:
    """The mixture at the airspeeds of the best model's curve; the white bound stays that of the best model."""
    curve, free = CurveMap(choice.common, of_best.indicated_airspeed), choice.common.error_count
    k = choice.answer.mean[:free]
    gradient, basis = np.zeros((2, len(of_best.indicated_airspeed), len(choice.answer.mean)))
    gradient[:, :free], basis[:, :free] = curve.correction_gradient(k), curve.basis()
    return replace(
        of_best,
        correction=curve.correction(k),
        two_sigma=choice.answer.two_sigma(gradient),
        normalized_pressure_error=curve.normalized(k),
        normalized_two_sigma=choice.answer.two_sigma(basis),
    )


def _wind(choice: ModelChoice) -> WindEstimate:
    own = slice(choice.common.error_count, choice.common.count)
    values = choice.answer.mean[own]
    bounds = choice.answer.two_sigma(np.eye(len(choice.answer.mean)))[own]
    parts = zip(("north", "east", "down"), values, bounds, strict=False)
    return WindEstimate(*(Estimate(name, float(v), float(b)) for name, v, b in parts))


def table_of(choice: ModelChoice) -> list[dict[str, Any]]:
    """The choice as plain data, a row a model; of logarithms only differences between rows mean anything."""
    return [
        {
            "model": j.candidate.name,
            "parameters": j.candidate.model.error_count,
            "log_likelihood": float(j.log_likelihood),
            "aicc": float(j.aicc),
            "bic": float(j.bic),
            "held_out": float(np.sum(j.held_out)),
            "weight": float(weight),
        }
        for j, weight in zip(choice.judgments, choice.weights, strict=True)
    ]


def departures_of(choice: ModelChoice) -> dict[str, float]:
    """Probability of each size of departure from a law, by its root mean square in Δp/q_c."""
    shares = np.exp(choice.log_evidences - logsumexp(choice.log_evidences))
    sizes = dict.fromkeys((t.departure for t in choice.thoughts), 0.0)
    for thought, share in zip(choice.thoughts, shares, strict=True):
        sizes[thought.departure] += float(share)
    return {f"{size:g}": share for size, share in sizes.items()}
