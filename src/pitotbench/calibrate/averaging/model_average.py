"""`--model auto`: which model the log speaks for, and a bound that allows for not knowing it.

Every model of the table is fitted and judged. The answer is a mixture over the models and over departures from them
(Bayesian model averaging: Hoeting et al., Statistical Science 14, 1999), made where models can meet: in the curve.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from pitotbench.calibrate.averaging.curve_prior import LAWLESS, LEVEL, Hypothesis, hypotheses
from pitotbench.calibrate.averaging.model_criteria import Judgment, ModelFit, judge_model
from pitotbench.calibrate.averaging.model_weights import Moments, moments, noise_masses, weigh_models
from pitotbench.calibrate.gls.covering_fit import CoveringFit, fit_covering, linearized, mean_wind_under
from pitotbench.calibrate.gls.linearized_problem import Gusts, Linearized, Structure
from pitotbench.calibrate.gls.posterior import Posterior, posterior_of
from pitotbench.calibrate.model.curve_map import CurveMap
from pitotbench.calibrate.model.prediction import PredictionModel
from pitotbench.calibrate.observability import require_observable
from pitotbench.calibrate.options import AUTO, CalibrationOptions
from pitotbench.calibrate.paper import fit_scalar
from pitotbench.calibrate.reduction import Reduction, flown_range, model_of, reduce_log
from pitotbench.calibrate.result import assemble, with_altitude
from pitotbench.pressure_error import MODELS, SplineModel, spline_between
from pitotbench.records.calibration import Calibration, ErrorCurve, Estimate, WindEstimate
from pitotbench.records.errors import NoAnswerError
from pitotbench.records.log import FlightLog
from pitotbench.units import Array

_KNOTS = 13  # of the spline in which models meet: finer than any departure
_LAWS = ("inverse+", "linear", "bias")  # tried in turn for the rows that count
_LEAST_RANGE = 2.0  # ratio of impact pressures, as from 100 to 141 kt


@dataclass(frozen=True, slots=True)
class ModelChoice:
    """The models as judged; what is thought of the curve and how likely each thought is, (h,), summing to 1; the
    spline in which they meet, and the mixture of all as an answer for it."""

    judgments: tuple[Judgment, ...]
    thoughts: tuple[Hypothesis, ...]
    shares: Array
    common: PredictionModel
    answer: Posterior

    @property
    def best(self) -> ModelFit:
        """The candidate that promises to predict best."""
        return min(self.judgments, key=lambda judgment: judgment.unfitness).candidate

    def weight_of(self, name: str) -> float:
        """Probability that the curve follows a model, with departures of any size."""
        own = [share for thought, share in zip(self.thoughts, self.shares, strict=True) if thought.name == name]
        return float(np.sum(own))


def calibrate_auto(log: FlightLog, options: CalibrationOptions) -> Calibration:
    """Fit every model of the table to the same rows, weigh them and combine their answers.

    Raises NoAnswerError where the log determines none of them.
    """
    rows = _rows(log, options)
    choice = choose_model(_judgments(rows), rows)
    best = choice.best
    chosen = replace(
        rows,
        options=replace(rows.options, model=best.name),
        model=best.model,
        white=best.white,
        answer=posterior_of(best.fit),
        diagnostics={**rows.diagnostics, **choice_record(choice)},
    )
    calibration = assemble(chosen)
    return replace(
        calibration,
        model=f"{AUTO} ({best.name})",
        curve=with_altitude(
            _curve(choice, calibration.curve),
            CurveMap(choice.common, calibration.curve.indicated_airspeed),
            choice.answer,
            rows.observations,
        ),
        wind=_wind(choice),
    )


def _rows(log: FlightLog, options: CalibrationOptions) -> Reduction:
    """The log reduced with the first law that it determines: for its rows, its latency, its warnings."""
    reasons: list[NoAnswerError] = []
    for name in _LAWS:
        try:
            return reduce_log(log, replace(options, model=name))
        except NoAnswerError as error:
            reasons.append(error)
    raise reasons[-1]


def _judgments(rows: Reduction) -> list[Judgment]:
    """Of the models that the log determines; where it determines no law, the simplest one's reason is raised."""
    found: list[Judgment] = []
    reasons: list[NoAnswerError] = []
    for name in MODELS:
        try:
            found.append(judge_model(_candidate(name, rows), rows.observations))
        except NoAnswerError as error:
            reasons.append(error)
        except np.linalg.LinAlgError:  # more knots than the flown speeds determine
            reasons.append(NoAnswerError(f"the log does not determine the model {name!r}; fly more speeds"))
    if all(judgment.candidate.name == LAWLESS for judgment in found):
        raise reasons[0]
    return found


def _candidate(name: str, rows: Reduction) -> ModelFit:
    """One model, fitted to be weighed. Raises NoAnswerError where the log does not determine it."""
    obs, reference = rows.observations, rows.model.reference_pressure
    model = replace(model_of(name, rows.options, obs, reference), static_error=rows.model.static_error)
    require_observable(model, obs)
    white = fit_scalar(model, obs)
    assert rows.structure is not None
    fit = fit_covering(replace(rows.structure, model=model), obs, white.theta)
    return ModelFit(name, model, flown_range(obs, reference), white, fit)


def choose_model(judgments: Sequence[Judgment], rows: Reduction) -> ModelChoice:
    """Weigh the models, each with departures of every size. At least one judgment must be of a law."""
    laws = [judgment for judgment in judgments if judgment.candidate.name != LAWLESS]
    nearest = min(laws, key=lambda judgment: judgment.aicc).candidate
    structure, problem, theta = _common_problem(nearest, rows)
    common = structure.model
    assert isinstance(common.error, SplineModel)
    knots = np.array(common.error.knots)
    level = max(LEVEL, float(np.sqrt(np.mean(_curve_of(nearest, knots) ** 2))))
    thoughts = tuple(hypotheses([law.candidate.model.error for law in laws], knots, level))
    answer, shares = weigh_models(thoughts, _moments(nearest.fit, structure, problem, theta))
    return ModelChoice(tuple(judgments), thoughts, shares, common, answer)


def _moments(fit: CoveringFit, structure: Structure, problem: Linearized, theta: Array) -> list[Moments]:
    """What the data say of the common problem under each noise of a fit."""
    found = []
    for node, mass in zip(fit.nodes, noise_masses(fit), strict=True):
        noise = fit.noise_of(node.noise)
        mean = mean_wind_under(problem, structure, noise, node.noise)
        found.append(moments(problem.regression, theta, noise, float(mass), mean))
    return found


def _curve_of(candidate: ModelFit, x: Array) -> Array:
    return candidate.model.error.basis(x) @ candidate.fit.theta[: candidate.model.error_count]


def _common_problem(nearest: ModelFit, rows: Reduction) -> tuple[Structure, Linearized, Array]:
    """The structure with a fine spline, its problem at the curve of the law that fits best, and θ0 there."""
    spline = spline_between(*_wide_enough(*nearest.flown), _KNOTS)
    common = replace(nearest.model, error=spline)
    k = _curve_of(nearest, np.array(spline.knots))
    theta = np.concatenate([k, nearest.fit.theta[nearest.model.error_count :]])
    assert rows.structure is not None
    structure = replace(rows.structure, model=common)
    gusts = Gusts(nearest.fit.gust_deviation, nearest.fit.gust_length)
    return structure, linearized(structure, rows.observations, theta, gusts), theta


def _wide_enough(low: float, high: float) -> tuple[float, float]:
    """The range over which the prior of curves holds: over less, nobody expects the whole change of a curve."""
    margin = float(np.sqrt(max(_LEAST_RANGE * low / high, 1.0)))
    return low / margin, high * margin


def _curve(choice: ModelChoice, of_best: ErrorCurve) -> ErrorCurve:
    """The mixture at the airspeeds of the best model's curve; the white bound stays that of the best model."""
    curve, free = CurveMap(choice.common, of_best.indicated_airspeed), choice.common.error_count
    k = choice.answer.mean[:free]
    gradient, basis = np.zeros((2, len(of_best.indicated_airspeed), len(choice.answer.mean)))
    gradient[:, :free], basis[:, :free] = curve.correction_gradient(k), curve.basis()
    bounds = choice.answer.two_sigma(gradient)
    return replace(
        of_best,
        correction=curve.correction(k),
        two_sigma=bounds,
        simultaneous_two_sigma=choice.answer.simultaneous(gradient, bounds),
        normalized_pressure_error=curve.normalized(k),
        normalized_two_sigma=choice.answer.two_sigma(basis),
    )


def _wind(choice: ModelChoice) -> WindEstimate:
    own = slice(choice.common.error_count, choice.common.count)
    values = choice.answer.mean[own]
    bounds = choice.answer.two_sigma(np.eye(len(choice.answer.mean)))[own]
    parts = zip(("north", "east", "down"), values, bounds, strict=False)
    return WindEstimate(*(Estimate(name, float(v), float(b)) for name, v, b in parts))


def choice_record(choice: ModelChoice) -> dict[str, Any]:
    """The choice as plain data: `model_choice`, a row a model, and `departure`, the probability of each size."""
    return {"model_choice": _table(choice), "departure": _departures(choice)}


def _table(choice: ModelChoice) -> list[dict[str, Any]]:
    """The choice as plain data, a row a model; of logarithms only differences between rows mean anything.

    A model that the log does not determine by itself has a weight alone.
    """
    judged = {judgment.candidate.name: judgment for judgment in choice.judgments}
    weights = {name: choice.weight_of(name) for name in MODELS}
    return [
        {
            "model": name,
            **(_criteria(judged[name]) if name in judged else {}),
            "weight": weight,
            "chosen": name == choice.best.name,
        }
        for name, weight in weights.items()
        if name in judged or weight > 0.0
    ]


def _criteria(judgment: Judgment) -> dict[str, Any]:
    return {
        "parameters": judgment.candidate.model.error_count,
        "log_likelihood": judgment.log_likelihood,
        "aicc": judgment.aicc,
        "bic": judgment.bic,
        "held_out": float(np.sum(judgment.held_out)),
    }


def _departures(choice: ModelChoice) -> dict[str, float]:
    """Probability of each size of departure from a law, by its root mean square in Δp/q_c."""
    sizes = dict.fromkeys((t.departure for t in choice.thoughts), 0.0)
    for thought, share in zip(choice.thoughts, choice.shares, strict=True):
        sizes[thought.departure] += float(share)
    return {f"{size:g}": share for size, share in sizes.items()}
