"""`--model auto`: the models weighed by the log, and a bound that includes the doubt about the
model.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import block_diag
from scipy.special import logsumexp

from pitotbench.calibration.altitude import altitude_rows
from pitotbench.calibration.covering import (
    CoveringFit,
    Linearized,
    Posterior,
    Structure,
    fit_covering,
    linearized,
    mean_wind_under,
    posterior_of,
)
from pitotbench.calibration.fit_checks import disagreements, require_observable
from pitotbench.calibration.location import SURE, mixed, widened_by
from pitotbench.calibration.model_evidence import (
    LAWLESS,
    LEVEL,
    Hypothesis,
    Judgment,
    ModelFit,
    hypotheses,
    judge_model,
)
from pitotbench.calibration.observations import wind_drifts
from pitotbench.calibration.options import AUTO, CalibrationOptions
from pitotbench.calibration.output_error import fit_scalar
from pitotbench.calibration.prediction import CurveMap, MeanWind, Nuisance, PredictionModel
from pitotbench.calibration.reduction import Reduction, flown_range, model_of, reduce_log
from pitotbench.calibration.result import (
    assemble,
    correction_gradient,
    found_zero,
    residuals_of,
    widened,
    with_altitude,
)
from pitotbench.calibration.wind import check_wind
from pitotbench.estimation.noise import Noise
from pitotbench.estimation.restricted_likelihood import Regression, restricted_log_likelihood
from pitotbench.pressure_error import MODELS
from pitotbench.pressure_error.models import SplineModel, spline_between
from pitotbench.records import NoAnswerError
from pitotbench.records.calibration import (
    Calibration,
    Criteria,
    ErrorCurve,
    Estimate,
    WeighedModel,
    WindEstimate,
)
from pitotbench.records.log import FlightLog
from pitotbench.units import Array

# The probability of each hypothesis of the curve given a log, and the answer averaged over the
# hypotheses. A fine spline describes the curve; its parameters are the curve's values at many
# knots. Every hypothesis is a Gaussian prior of these values. All hypotheses share one
# linearization, one set of noises and one set of data, so their evidences can be compared.
# Restricted likelihoods of models with different terms cannot: each of them leaves out other
# contrasts of the data. The wind's prior is flat, and the same for all.

_NEGLIGIBLE = 1e-6  # weight of a Gaussian that changes no bound


@dataclass(frozen=True, slots=True)
class Moments:
    """The sums that a fit needs under one noise of covariance C.

    They are the products, with weights C⁻¹, of regressors X, instruments Z and response y, and
    log|C|. `log_mass` is the logarithm of prior times volume of the noise's node. `mean_wind`
    converts the level of a drifting wind to its mean; it is None for a wind that does not drift.

    The evidence uses the instruments as regressors (response y + Zθ0). The noise of the GPS is both
    in the regressors and in the response; with the regressors themselves it would favor curves with
    bends, above all where the airplane holds its speed.
    """

    normal: Array  # ZᵀC⁻¹X + Π, with the prior precision Π of the nuisances
    spread: Array  # ZᵀC⁻¹Z + Π
    gradient: Array  # ZᵀC⁻¹(y + Xθ0), for the estimate
    clean_gradient: Array  # ZᵀC⁻¹(y + Zθ0), for the evidence
    clean_square: float
    log_determinant: float
    log_mass: float
    mean_wind: MeanWind | None


def moments(
    problem: Regression,
    theta: Array,
    noise: Noise,
    log_mass: float,
    mean_wind: MeanWind | None = None,
) -> Moments:
    """Compute the moments under one noise.

    Parameters: problem, linearized at θ0; theta, θ0 (p,); noise; log_mass, see `noise_masses`;
    mean_wind, of the same problem.
    """
    X, Z = problem.regressors, problem.instruments
    clean = problem.response + Z @ theta
    weighed, weighed_clean = noise.weigh(Z), noise.weigh(clean[:, None])[:, 0]
    known = np.diag(problem.prior_precision)
    whole = replace(
        problem, response=problem.response + X @ theta
    )  # of θ itself, not of a correction to θ0
    return Moments(
        normal=weighed.T @ X + known,
        spread=weighed.T @ Z + known,
        gradient=weighed.T @ whole.response,
        clean_gradient=weighed.T @ clean,
        clean_square=float(clean @ weighed_clean),
        log_determinant=noise.log_determinant,
        log_mass=log_mass,
        mean_wind=None if mean_wind is None else replace(mean_wind, problem=whole),
    )


def noise_masses(fit: CoveringFit) -> Array:
    """Logarithm of prior times volume of each node of a fit's noise, (nodes,): its mass without the
    likelihood.
    """
    likelihoods = [
        restricted_log_likelihood(fit.problem, fit.noise_of(node.noise)) for node in fit.nodes
    ]
    return np.array([node.log_mass for node in fit.nodes]) - likelihoods


def weigh_models(
    hypotheses: Sequence[Hypothesis], nodes: Sequence[Moments]
) -> tuple[Posterior, Array]:
    """Return the mixture over all hypotheses and noises, and the probability of each hypothesis,
    (h,).

    The first parameters of the problem are the curve's values at the points for which the
    hypotheses were made.
    """
    evidences = np.empty((len(hypotheses), len(nodes)))
    precisions = [_precision(hypothesis, len(nodes[0].gradient)) for hypothesis in hypotheses]
    for h, hypothesis in enumerate(hypotheses):
        prior = float(np.log(hypothesis.probability)) - 0.5 * float(
            np.linalg.slogdet(hypothesis.covariance)[1]
        )
        for j, node in enumerate(nodes):
            evidences[h, j] = prior + _log_evidence(node, precisions[h])
    weights = np.exp(evidences - logsumexp(evidences))
    kept = np.argwhere(weights > _NEGLIGIBLE)
    answers = [_posterior(nodes[j], precisions[h]) for h, j in kept]
    shares = np.array([weights[h, j] for h, j in kept])
    answer = Posterior(
        shares / shares.sum(), np.stack([m for m, _ in answers]), np.stack([c for _, c in answers])
    )
    return answer, weights.sum(axis=1)


def _precision(hypothesis: Hypothesis, size: int) -> Array:
    count = len(hypothesis.covariance)
    precision = np.zeros((size, size))
    precision[:count, :count] = np.linalg.inv(hypothesis.covariance)
    return precision


def _log_evidence(node: Moments, precision: Array) -> float:
    total = node.spread + precision
    misfit = node.clean_square - float(
        node.clean_gradient @ np.linalg.solve(total, node.clean_gradient)
    )
    return node.log_mass - 0.5 * (
        node.log_determinant + float(np.linalg.slogdet(total)[1]) + misfit
    )


def _posterior(node: Moments, precision: Array) -> tuple[Array, Array]:
    """Mean and covariance by instruments, as in `restricted_likelihood.solve`; a drifting wind as
    its mean.
    """
    inverse = np.linalg.inv(node.normal + precision)
    covariance = inverse @ (node.spread + precision) @ inverse.T
    answer = (inverse @ node.gradient, 0.5 * (covariance + covariance.T))
    return answer if node.mean_wind is None else node.mean_wind.of(answer)


# Every model of the table is fitted and judged. The answer is a mixture over the models and over
# departures from them (Bayesian model averaging: Hoeting et al., Statistical Science 14, 1999). The
# mixture is made of curves, because the parameters of different models cannot be compared.

_KNOTS = 13  # of the spline that describes the curves of all models: fine enough for any likely departure
_LAWS = ("inverse+", "linear", "bias")  # tried in turn to select the rows, the richest law first
_LEAST_RANGE = 2.0  # ratio of impact pressures, as from 100 to 141 kt


@dataclass(frozen=True, slots=True)
class ModelChoice:
    """The models as judged, the hypotheses of the curve, and the mixture of all.

    `shares` (h,) are the probabilities of the hypotheses after the flight and sum to 1. `common` is
    the model with a fine spline that describes every curve, and `answer` the mixture in its
    parameters.
    """

    judgments: tuple[Judgment, ...]
    hypotheses: tuple[Hypothesis, ...]
    shares: Array
    common: PredictionModel
    answer: Posterior

    @property
    def best(self) -> ModelFit:
        """The candidate that is expected to predict new data best."""
        return min(self.judgments, key=lambda judgment: judgment.unfitness).candidate

    def weight_of(self, name: str) -> float:
        """Probability that the curve follows a model, with departures of any size."""
        part = [
            share
            for hypothesis, share in zip(self.hypotheses, self.shares, strict=True)
            if hypothesis.name == name
        ]
        return float(np.sum(part))


def calibrate_auto(log: FlightLog, options: CalibrationOptions) -> Calibration:
    """Fit every model of the table to the same rows, weigh the models and combine their answers.

    Raises NoAnswerError where the log determines no model, and BadInputError for a log that cannot
    be used.
    """
    rows = _rows(log, options)
    choice = _over_winds(choose_model(_judgments(rows), rows), rows)
    choice = _of_every_location(choice, log, rows, options)
    best = choice.best
    chosen = replace(
        rows,
        options=replace(rows.options, model=best.name),
        model=best.model,
        white=best.white,
        fit=best.fit,
        answer=posterior_of(best.fit),
        diagnostics=replace(
            rows.diagnostics,
            iterations=best.white.iterations,
            models=_weighed(choice),
            departures=_departures(choice),
        ),
    )
    calibration = assemble(chosen)
    zero = found_zero(choice.common, choice.answer, rows.nuisances)
    common = CurveMap(
        choice.common, calibration.curve.indicated_airspeed, 0.0 if zero is None else zero.value
    )
    curve = with_altitude(
        _curve(choice, calibration.curve, common, rows.nuisances),
        common,
        choice.answer,
        rows.observations,
        calibration.place_assumed,
    )
    residuals = residuals_of(replace(chosen, model=choice.common, answer=choice.answer))
    return replace(
        calibration,
        model=f"{AUTO} ({best.name})",
        curve=curve,
        residuals=residuals,
        disagreements=disagreements(
            rows.diagnostics.height_agreement, residuals, curve, rows.path is not None
        ),
        wind=_wind(choice),
        impact_pressure_zero=zero,
    )


def _over_winds(choice: ModelChoice, rows: Reduction) -> ModelChoice:
    """Average the answer over changes of the wind, as the fit of the richest law does.

    A change moves the mixture by what it moves that law's curve, at the knots, and its other
    unknowns.
    """
    drifts = wind_drifts(rows.options, rows.observations)
    if rows.options.wind != "checked" or drifts:
        return choice
    judged = {judgment.candidate.name: judgment.candidate for judgment in choice.judgments}
    law = next(judged[name] for name in _LAWS if name in judged)
    structure = Structure(law.model, rows.nuisances, drifts, altitude=rows.altitude)
    steady = posterior_of(law.fit)
    changed = check_wind(structure, rows.observations, law.fit, steady)[1]
    first, free = len(steady.weights), law.model.error_count
    share = float(changed.weights[:first].sum())
    assert isinstance(choice.common.error, SplineModel)
    turn = block_diag(
        law.model.error.basis(np.array(choice.common.error.knots)), np.eye(len(steady.mean) - free)
    )
    answer, moved = choice.answer, changed.means[first:] - steady.mean
    spread = changed.covariances[first:] - steady.covariance
    averaged = Posterior(
        np.concatenate([share * answer.weights, changed.weights[first:]]),
        np.concatenate([answer.means, answer.mean + moved @ turn.T]),
        np.concatenate([answer.covariances, answer.covariance + turn @ spread @ turn.T]),
    )
    return replace(choice, answer=averaged)


def _of_every_location(
    choice: ModelChoice, log: FlightLog, rows: Reduction, options: CalibrationOptions
) -> ModelChoice:
    """Widen the answer by the doubt about the location of the error, as the fit of one model does.

    Where the height leaves two locations likely, the answer is a mixture of both. Where there is no
    evidence, the difference between them, for the best model, counts as one standard deviation.
    """
    static, share = rows.model.static_error, rows.diagnostics.static_probability
    if options.error_location != AUTO or (share is None and not static):
        return choice
    if share is None:
        moved = _moved(choice, _candidate(choice.best.name, _at_other_location(log, rows)))
        return replace(choice, answer=widened_by(choice.answer, moved))
    share = share if static else 1.0 - share
    if share > 1.0 - SURE:
        return choice
    there = _at_other_location(log, rows)
    try:
        other = _over_winds(choose_model(_judgments(there), there), there).answer
    except NoAnswerError:  # the other location explains no curve
        return choice
    return replace(choice, answer=mixed([(share, choice.answer), (1.0 - share, other)]))


def _at_other_location(log: FlightLog, rows: Reduction) -> Reduction:
    """The same rows for an error of the other kind of location, with the height where that is the
    static source.
    """
    static, free = not rows.model.static_error, rows.model.error_count
    heights = None
    if static and rows.options.use_altitude:
        wind = rows.answer.mean[free : free + 2]
        heights = altitude_rows(log, rows.observations, rows.options.gps_latency, wind)
    return replace(rows, model=replace(rows.model, static_error=static), altitude=heights)


def _moved(choice: ModelChoice, other: ModelFit) -> Array:
    """The answer of the best model less that at another location, in the parameters of the mixture,
    (p,).
    """
    assert isinstance(choice.common.error, SplineModel)
    knots = np.array(choice.common.error.knots)
    means = []
    for each in (choice.best, other):
        mean, free = posterior_of(each.fit).mean, each.model.error_count
        means.append(np.concatenate([each.model.error.basis(knots) @ mean[:free], mean[free:]]))
    return np.asarray(means[0] - means[1])


def _rows(log: FlightLog, options: CalibrationOptions) -> Reduction:
    """Reduce the log with the first law that it determines; this gives the rows, the latency and
    the warnings.
    """
    reasons: list[NoAnswerError] = []
    for name in _LAWS:
        try:
            return reduce_log(log, replace(options, model=name))
        except NoAnswerError as error:
            reasons.append(error)
    raise reasons[-1]


def _judgments(rows: Reduction) -> list[Judgment]:
    """Judge the models that the log determines. Raises the NoAnswerError of the simplest law where
    it determines none."""
    found: list[Judgment] = []
    reasons: list[NoAnswerError] = []
    for name in MODELS:
        try:
            found.append(judge_model(_candidate(name, rows), rows.observations))
        except NoAnswerError as error:
            reasons.append(error)
        except np.linalg.LinAlgError:  # more knots than the flown speeds determine
            reasons.append(
                NoAnswerError(f"the log does not determine the model {name!r}; fly more speeds")
            )
    if all(judgment.candidate.name == LAWLESS for judgment in found):
        raise reasons[0]
    return found


def _candidate(name: str, rows: Reduction) -> ModelFit:
    """Fit one model. Raises NoAnswerError where the log does not determine it."""
    obs, reference = rows.observations, rows.model.reference_pressure
    model = replace(
        model_of(name, rows.options, obs, reference), static_error=rows.model.static_error
    )
    require_observable(model, obs)
    white = fit_scalar(model, obs if rows.path is None else rows.path.taken_from(obs))
    structure = Structure(
        model, rows.nuisances, wind_drifts(rows.options, obs), altitude=rows.altitude
    )
    fit = fit_covering(structure, obs, white.theta, rows.path)
    return ModelFit(name, model, flown_range(obs, reference), white, fit)


def choose_model(judgments: Sequence[Judgment], rows: Reduction) -> ModelChoice:
    """Weigh the models, each with departures of every size.

    At least one judgment must be of a law: the common problem is linearized at the curve of the
    best law.
    """
    laws = [judgment for judgment in judgments if judgment.candidate.name != LAWLESS]
    nearest = min(laws, key=lambda judgment: judgment.aicc).candidate
    structure, problem, theta = _common_problem(nearest, rows)
    common = structure.model
    assert isinstance(common.error, SplineModel)
    knots = np.array(common.error.knots)
    # An airplane with a large error must not be an outlier of its prior, so the level grows with
    # the curve.
    level = max(LEVEL, float(np.sqrt(np.mean(_curve_of(nearest, knots) ** 2))))
    prior = tuple(hypotheses([law.candidate.model.error for law in laws], knots, level))
    answer, shares = weigh_models(prior, _moments(nearest.fit, structure, problem, theta))
    return ModelChoice(tuple(judgments), prior, shares, common, answer)


def _moments(
    fit: CoveringFit, structure: Structure, problem: Linearized, theta: Array
) -> list[Moments]:
    """The moments of the common problem under each noise of a fit."""
    found = []
    for node, mass in zip(fit.nodes, noise_masses(fit), strict=True):
        noise = fit.noise_of(node.noise)
        mean = mean_wind_under(problem, structure, noise, node.noise)
        found.append(moments(problem.regression, theta, noise, float(mass), mean))
    return found


def _curve_of(candidate: ModelFit, x: Array) -> Array:
    return candidate.model.error.basis(x) @ candidate.fit.theta[: candidate.model.error_count]


def _common_problem(nearest: ModelFit, rows: Reduction) -> tuple[Structure, Linearized, Array]:
    """The structure with a fine spline, its problem linearized at the curve of the best law, and θ0
    there.
    """
    spline = spline_between(*_wide_enough(*nearest.flown), _KNOTS)
    common = replace(nearest.model, error=spline)
    k = _curve_of(nearest, np.array(spline.knots))
    theta = np.concatenate([k, nearest.fit.theta[nearest.model.error_count :]])
    obs, fit = rows.observations, nearest.fit
    structure = Structure(
        common, rows.nuisances, wind_drifts(rows.options, obs), altitude=rows.altitude
    )
    return structure, linearized(structure, obs, theta, fit.gust_deviation, fit.path), theta


def _wide_enough(low: float, high: float) -> tuple[float, float]:
    """Widen a range of x to the least one for which the prior of curves is meant.

    Over a narrower range a curve is not expected to change by as much as the prior allows.
    """
    margin = float(np.sqrt(max(_LEAST_RANGE * low / high, 1.0)))
    return low / margin, high * margin


def _curve(
    choice: ModelChoice, of_best: ErrorCurve, curve: CurveMap, nuisances: Sequence[Nuisance]
) -> ErrorCurve:
    """The mixture's curve at the airspeeds of the best model's curve; the white bound remains the
    best model's.
    """
    k = choice.answer.mean[: choice.common.error_count]
    gradient, basis = (
        correction_gradient(curve, choice.answer, nuisances),
        widened(curve.basis(), choice.answer),
    )
    bounds = choice.answer.two_sigma(gradient)
    return replace(
        of_best,
        correction=curve.correction(k),
        two_sigma=bounds,
        simultaneous_two_sigma=choice.answer.simultaneous(gradient, bounds),
        normalized_pressure_error=curve.normalized(k),
        normalized_two_sigma=choice.answer.two_sigma(basis),
        correlation=choice.answer.correlation(gradient),
    )


def _wind(choice: ModelChoice) -> WindEstimate:
    part = slice(choice.common.error_count, choice.common.count)
    values = choice.answer.mean[part]
    bounds = choice.answer.two_sigma(np.eye(len(choice.answer.mean)))[part]
    parts = zip(("north", "east", "down"), values, bounds, strict=False)
    return WindEstimate(*(Estimate(name, float(v), float(b)) for name, v, b in parts))


def _weighed(choice: ModelChoice) -> tuple[WeighedModel, ...]:
    """The models that the log determines by itself, with their criteria, and others that have a
    weight.
    """
    criteria = {judgment.candidate.name: _criteria(judgment) for judgment in choice.judgments}
    weights = {name: choice.weight_of(name) for name in MODELS}
    return tuple(
        WeighedModel(name, criteria.get(name), weight, name == choice.best.name)
        for name, weight in weights.items()
        if name in criteria or weight > 0.0
    )


def _criteria(judgment: Judgment) -> Criteria:
    return Criteria(
        parameters=judgment.candidate.model.error_count,
        log_likelihood=judgment.log_likelihood,
        aicc=judgment.aicc,
        bic=judgment.bic,
        held_out=float(np.sum(judgment.held_out)),
    )


def _departures(choice: ModelChoice) -> dict[str, float]:
    """Probability of each size of departure from a law, keyed by its root mean square in Δp/q_c."""
    sizes = dict.fromkeys((hypothesis.departure for hypothesis in choice.hypotheses), 0.0)
    for hypothesis, share in zip(choice.hypotheses, choice.shares, strict=True):
        sizes[hypothesis.departure] += float(share)
    return {f"{size:g}": share for size, share in sizes.items()}
