"""`--model auto`: which model the log speaks for, and a bound that allows for not knowing it.

Every model of the table is fitted. The answer is a mixture over the models (Bayesian model averaging: Hoeting et
al., Statistical Science 14, 1999), made where models can meet: of their curves at common airspeeds and their winds.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from pitotbench import air
from pitotbench.calibrate.combination import combined_curve, combined_wind
from pitotbench.calibrate.curve_prior import CurvePrior
from pitotbench.calibrate.evidence import Candidate, Judgment, judge
from pitotbench.calibrate.observations import Observations
from pitotbench.calibrate.options import AUTO, CalibrationOptions
from pitotbench.calibrate.result import assemble
from pitotbench.pressure_error import MODELS
from pitotbench.records.calibration import Calibration
from pitotbench.records.errors import NoAnswerError
from pitotbench.units import Array

LAWLESS = "spline"
LAWLESS_SHARE = 0.5  # before the flight: as likely as not, the curve follows no law of the table


@dataclass(frozen=True, slots=True)
class ModelChoice:
    """The candidates as judged, and the weight of each in the answer, (m,), summing to 1."""

    judgments: tuple[Judgment, ...]
    weights: Array

    @property
    def best(self) -> Judgment:
        """The candidate of the greatest weight."""
        return self.judgments[int(np.argmax(self.weights))]


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
    chosen = best.candidate
    diagnostics = {
        "gust_deviation_mps": chosen.fit.gust_deviation,
        "gust_length_m": chosen.fit.gust_length,
        "blocks": chosen.fit.blocks,
        "model_choice": table_of(choice),
    }
    calibration = assemble(
        options, chosen.model, obs, chosen.white, best.answer, diagnostics, warnings(chosen)
    )
    return replace(
        calibration,
        model=f"{AUTO} ({chosen.name})",
        curve=combined_curve(choice.judgments, choice.weights, calibration.curve),
        wind=combined_wind(choice.judgments, choice.weights),
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
    """Judge the candidates under one prior of curves and weigh them by their evidence."""
    x = obs.impact_pressure / candidates[0].model.reference_pressure
    low, high = (float(q) for q in np.quantile(x, [0.001, 0.999]))
    prior = CurvePrior(low, high)
    judgments = tuple(judge(candidate, obs, prior) for candidate in candidates)
    logs = np.array([j.log_evidence for j in judgments]) + np.log(_shares([c.name for c in candidates]))
    weights = np.exp(logs - logs.max())
    return ModelChoice(judgments, weights / weights.sum())


def _shares(names: Sequence[str]) -> Array:
    """What is thought of the models before the flight."""
    laws = max(sum(name != LAWLESS for name in names), 1)
    return np.array([LAWLESS_SHARE if name == LAWLESS else (1.0 - LAWLESS_SHARE) / laws for name in names])


def table_of(choice: ModelChoice) -> list[dict[str, Any]]:
    """The choice as plain data, a row a model: only differences between rows mean anything."""
    return [
        {
            "model": j.candidate.name,
            "parameters": j.candidate.model.error_count,
            "log_likelihood": j.log_likelihood,
            "aicc": j.aicc,
            "bic": j.bic,
            "log_evidence": j.log_evidence,
            "held_out": float(np.sum(j.held_out)),
            "weight": float(weight),
        }
        for j, weight in zip(choice.judgments, choice.weights, strict=True)
    ]
