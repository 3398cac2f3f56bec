"""The location of the pressure error, and the fit for it.

An error of the static source changes the static pressure (p = p_i − Δp), and GPS height shows it.
An error of the total source, or of the impact pressure alone (as published), does not change the
static pressure. These two predict the same data, so no log can separate them. The wind triangle
hardly depends on the location; the altitude equation together with it gives clear evidence.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import chdtrc

from pitotbench.calibration.altitude import (
    NOISE_COUNT,
    AltitudeNoise,
    AltitudeRows,
    altitude_guess,
    altitude_log_prior,
    altitude_regression,
    altitude_rows,
)
from pitotbench.calibration.covering import (
    CoveringFit,
    FirstPass,
    final_pass,
    first_pass,
    fit_covering,
    posterior_of,
)
from pitotbench.calibration.covering_problem import Structure, priors_at
from pitotbench.calibration.fit_checks import DISAGREE
from pitotbench.calibration.nuisances import Nuisance, nuisances_of, with_filter, with_signs
from pitotbench.calibration.observations import Observations
from pitotbench.calibration.options import AUTO, CalibrationOptions, Priors, priors_of
from pitotbench.calibration.prediction import PredictionModel
from pitotbench.calibration.wind_path import WindPath
from pitotbench.estimation.mixture import Posterior, mixed
from pitotbench.estimation.noise import NoiseOf
from pitotbench.estimation.restricted_likelihood import (
    LogPrior,
    Regression,
    Solution,
    mode_and_evidence,
    noise_posterior,
    restricted_log_likelihood,
    solve,
)
from pitotbench.pressure_error.models import SmoothModel
from pitotbench.records import NoAnswerError
from pitotbench.records.log import PRESSURE, FlightLog
from pitotbench.units import Array, Pascal, Seconds

STATIC, TOTAL, IMPACT = "static", "total", "impact"
SURE = 1e-3  # probability below which the less likely location is left out of the answer
_CERTAIN = 500.0  # log odds, clipped here to keep the exponential finite
# share of a variance: of a direction that gains less, small errors of the model decide
_LEAST_GAINED = 0.01
_FAR_OFF = 40.0  # log odds beyond which a coarse list of noises is enough
# Factors on (slow error, its correlation time, third parameter): a wrong location makes the heights
# look noisier.
_NOISIER = ((1.0, 1.0, 1.0), (2.0, 1.0, 1.0), (2.0, 0.5, 2.0), (4.0, 1.0, 1.0), (4.0, 0.5, 4.0))
_BENCH = "pitotbench flight log"  # the `format` in a synthetic log's header begins with it


@dataclass(frozen=True, slots=True)
class ErrorPlace:
    """The location of the error and the fit for it.

    `static_probability` is the probability of the static source, None where the location was stated
    or assumed. `answer` is a mixture where two locations are likely. `chance` is the probability
    that the curves of wind triangle and altitude equation differ by so much by chance; it is None
    without the altitude equation for this location. `without_height_and_with` are the curve's
    parameters (K,) by the triangle and by both; empty likewise.
    """

    location: str
    static_probability: float | None
    structure: Structure
    fit: CoveringFit
    answer: Posterior
    chance: float | None = None
    without_height_and_with: tuple[Array, ...] = ()


@dataclass(frozen=True, slots=True)
class ByHeight:
    """The curve by height alone: its model, the answer in its parameters, and what the fit leaves.

    The latter are block means in flight, (n,): time [s], impact pressure and the rest of the
    pressure error [Pa].
    """

    model: PredictionModel
    answer: Posterior
    time: Seconds
    impact_pressure: Pascal
    left: Pascal


def assumed_location(header: Mapping[str, object]) -> str:
    """Return the location of the error before any evidence.

    That is the static source, and for a synthetic log the published location. The static source has
    the larger error on nearly every airplane (Gracey 1980).
    """
    return IMPACT if str(header.get("format", "")).startswith(_BENCH) else STATIC


def fit_located(
    log: FlightLog,
    options: CalibrationOptions,
    structure: Structure,
    obs: Observations,
    start: Array,
    path: WindPath | None = None,
) -> ErrorPlace:
    """Fit with the error at the location that the options state, or that the log supports (`auto`).

    Parameters: log; options; structure, without altitude rows; obs; start, θ (p,); path of a
    drifting wind. Raises as `fit_covering` does.
    """
    stated = None if options.error_location == AUTO else options.error_location
    assumed = stated or assumed_location(log.header)
    bare = _at(structure, assumed == STATIC)
    wind = start[structure.model.error_count :][:2]
    seen = options.use_altitude and stated in (None, STATIC)
    rows = altitude_rows(log, obs, options, wind) if seen else None
    near = first_pass(bare, obs, start, path)
    bare = _informed(bare, near)
    if rows is not None:
        return _with_height(stated, assumed, rows, obs, bare, near)
    fit = final_pass(bare, obs, near)
    answer = posterior_of(fit)
    if stated is None and assumed == STATIC:
        answer = with_difference(
            answer,
            posterior_of(fit_covering(_at(structure, False), obs, start, path)).mean - answer.mean,
        )
    return ErrorPlace(assumed, None, bare, fit, answer)


def _informed(structure: Structure, near: FirstPass) -> Structure:
    """The structure with the prior of a smoothing that the latency of the first pass asks for."""
    found, first = max(near.solutions, key=lambda each: each.weight), structure.model.count
    return replace(
        structure,
        nuisances=with_filter(
            structure.nuisances, found.estimate[first:], found.covariance[first:, first:]
        ),
    )


def _at(structure: Structure, static: bool, rows: AltitudeRows | None = None) -> Structure:
    return replace(structure, model=replace(structure.model, static_error=static), altitude=rows)


def _with_height(
    stated: str | None,
    assumed: str,
    rows: AltitudeRows,
    obs: Observations,
    bare: Structure,
    near: FirstPass,
) -> ErrorPlace:
    """Add the altitude rows to the answer of the triangle, and fit the likely locations.

    The triangle's answer is that on coarse blocks.
    """
    probe = next((each.deviation for each in bare.nuisances if each.name == "temperature_k"), 0.0)
    wide = rows.with_probe(probe)
    joint, gain, chance = _with_rows(near, bare, rows)
    moved = _at(bare, True, rows)
    free = bare.model.error_count
    both = near.theta[:free], joint.theta[:free]
    if stated is not None:
        fit = final_pass(moved, obs, joint)
        answer = _of_triangle_and_height(fit, chance, bare, obs, near, both)
        return ErrorPlace(stated, None, moved, fit, answer, chance, both)
    noise, without = _without_curve(wide, joint.noise[-NOISE_COUNT:], gain)
    odds = gain - without
    probability = float(1.0 / (1.0 + np.exp(-np.clip(odds, -_CERTAIN, _CERTAIN))))
    elsewhere = IMPACT if assumed == IMPACT else TOTAL
    shares = {STATIC: probability, elsewhere: 1.0 - probability}
    separate = replace(near, noise=np.concatenate([near.noise, noise]))
    tried = {STATIC: (moved, joint), elsewhere: (_at(bare, False, rows), separate)}
    fits = {
        name: final_pass(tried[name][0], obs, tried[name][1])
        for name in tried
        if shares[name] > SURE
    }
    best = max(fits, key=lambda name: shares[name])
    answer = mixed(
        [
            (
                shares[name],
                _of_triangle_and_height(fit, chance, bare, obs, near, both)
                if name == STATIC
                else posterior_of(fit),
            )
            for name, fit in fits.items()
        ]
    )
    place = ErrorPlace(best, probability, tried[best][0], fits[best], answer)
    return replace(place, chance=chance, without_height_and_with=both) if best == STATIC else place


def _of_triangle_and_height(
    fit: CoveringFit,
    chance: float,
    bare: Structure,
    obs: Observations,
    near: FirstPass,
    both: Sequence[Array],
) -> Posterior:
    """Return the answer for a static source: the `fit` of triangle and height together.

    Where they differ more than by chance, neither is known to be the wrong one. The bound is then
    widened by no factor: the answer is the mixture of this fit and of the triangle's own (`bare`,
    without the height), one as probable as the other. Between the passes a temperature or a noise
    can take up the difference, which is not gone with it: the curves of the first pass, `both`
    without the height and with it, are in the mixture as well.
    """
    if chance >= DISAGREE:
        return posterior_of(fit)
    fits, count = (final_pass(_at(bare, True), obs, near), fit), bare.model.count
    # Each with its signs first: one sign must not decide between them.
    answers = [with_signs(posterior_of(each), bare.nuisances, count) for each in fits]
    first = [_with_curve(answer, k) for answer, k in zip(answers, both, strict=True)]
    return mixed([(1.0, each) for each in (*answers, *first)])


def _with_curve(answer: Posterior, curve: Array) -> Posterior:
    """An answer moved to the parameters of a curve, (K,)."""
    moved = np.zeros(len(answer.mean))
    moved[: len(curve)] = curve - answer.mean[: len(curve)]
    return replace(answer, means=answer.means + moved)


_OF_HEIGHT = 3  # passes of the fit by height alone: the problem is nearly linear
_NO_LIFT = 1e-6  # Δp/q_c
_UNKNOWN_WIND = 15.0  # m/s, for the slope of the pressure levels where the wind is not known


def fit_by_height(
    log: FlightLog, options: CalibrationOptions, obs: Observations, model: PredictionModel
) -> ByHeight:
    """Fit the static source's error to height and static pressure, without wind or airspeed.

    At one airspeed the height hardly tells the level of the curve: a smooth curve has a prior of it
    here. Its part in 1/x is a constant pressure, which no height shows, and is taken as none.
    Raises NoAnswerError for a log without a height, and as `restricted_likelihood.noise_posterior`
    does.
    """
    rows = altitude_rows(log, obs, options, np.array([_UNKNOWN_WIND, 0.0]))
    if rows is None or not options.use_altitude or options.error_location not in (AUTO, STATIC):
        raise NoAnswerError("no height by GPS tells of the static source")
    priors, law = priors_of(options.priors), model.error
    if isinstance(law, SmoothModel):
        law = replace(law, level=priors.curve_level, lift=_NO_LIFT)
    model = replace(model, error=law, static_error=True)
    nuisances = (*nuisances_of(options, obs), *_height_form(log, priors))
    structure = Structure(model, nuisances, drifting=False, priors=priors)
    theta, guess, free = np.zeros(model.count), altitude_guess(rows), model.error_count
    for _ in range(_OF_HEIGHT):
        whole = altitude_regression(rows, model, theta, nuisances)
        places = np.flatnonzero(np.any(whole.regressors != 0.0, axis=0))
        seen, (precisions, mean) = whole.regressors[:, places], priors_at(structure, theta)
        problem = Regression(whole.response, seen, seen, precisions[:, places], mean[places])
        nodes = noise_posterior(problem, *_noise_and_prior(rows), guess)
        found = Posterior(
            np.array([node.weight for node in nodes]),
            theta[:free] + np.stack([node.estimate[:free] for node in nodes]),
            np.stack([node.covariance[:free, :free] for node in nodes]),
        )
        theta[:free] = found.mean
    left = altitude_regression(rows, model, theta, ()).response[: len(rows)] / rows.state.gain
    flying = rows.state.impact_pressure > 0.0
    return ByHeight(
        model, found, rows.time[flying], rows.state.impact_pressure[flying], left[flying]
    )


def _height_form(log: FlightLog, priors: Priors) -> tuple[Nuisance, ...]:
    """A part of the heights that no airspeed has.

    An air-data computer corrects the airspeed and the altitude apart. A log of pressures has none.
    """
    if log.units_by["air_data"] == PRESSURE:
        return ()
    return (
        Nuisance(
            "height_form",
            priors.height_form,
            lambda prediction, obs: np.zeros(len(obs)),
            height=lambda state: state.gain * state.impact_pressure,
        ),
    )


def _with_rows(
    near: FirstPass, bare: Structure, rows: AltitudeRows
) -> tuple[FirstPass, float, float]:
    """Update the triangle's answer with the altitude rows.

    Returns the new answer, the log evidence of the rows given the triangle, and the probability of
    so large a change by chance: both over the rival priors of the curve, as likely as the triangle
    leaves them.
    """
    likely = [each for each in near.solutions if each.weight > SURE]
    updated, start = list[tuple[FirstPass, float, float]](), altitude_guess(rows)
    for each in likely:  # the noise of the last prior is near that of the next
        updated.append(_updated(near, each, bare, rows, start))
        start = updated[-1][0].noise[-NOISE_COUNT:]
    weights = np.array([each.weight for each in likely])
    odds = np.log(weights) + np.array([evidence for _, evidence, _ in updated])
    chance = float(weights @ np.array([chance for _, _, chance in updated]))
    return updated[int(np.argmax(odds))][0], float(np.logaddexp.reduce(odds)), chance


def _updated(
    near: FirstPass, triangle: Solution, bare: Structure, rows: AltitudeRows, start: Array
) -> tuple[FirstPass, float, float]:
    """The triangle's answer with the altitude rows, under one prior of the curve.

    The noise is searched from `start`. What the triangle knows of the unknowns that the rows see is
    their prior: β = β0 + L z, with LLᵀ its covariance and z standard normal.
    """
    count, model = bare.model.count, replace(bare.model, static_error=True)
    theta = near.theta + triangle.estimate[:count]
    plain = altitude_regression(rows, model, theta, bare.nuisances)
    places = np.flatnonzero(np.any(plain.regressors != 0.0, axis=0))
    known = triangle.covariance[np.ix_(places, places)]
    scale = np.sqrt(np.diag(known))
    root = scale[:, None] * np.linalg.cholesky(known / np.outer(scale, scale))
    seen = plain.regressors[:, places]
    moved = np.where(places < count, 0.0, triangle.estimate[places])
    problem = Regression(
        plain.response - seen @ moved, seen @ root, seen @ root, np.ones(len(places))
    )
    noise, log_evidence = _tried(problem, rows, start)
    z, left = solve(problem, AltitudeNoise(rows)(noise))
    step = triangle.covariance[:count, places] @ np.linalg.solve(root.T, z)
    joint = replace(near, theta=theta + step, noise=np.concatenate([near.noise, noise]))
    return joint, log_evidence, _chance(z, left)


def _chance(z: Array, left: Array) -> float:
    """Return the probability of so large an estimate z of a standard normal vector.

    Before the data are known, an estimate with the posterior covariance `left` has the covariance 1
    − `left`.
    """
    gained, axes = np.linalg.eigh(np.eye(len(z)) - left)
    moved = gained > _LEAST_GAINED
    if not moved.any():
        return 1.0
    distance = float(np.sum((axes.T @ z)[moved] ** 2 / gained[moved]))
    return float(chdtrc(int(moved.sum()), distance))


def _without_curve(rows: AltitudeRows, noise: Array, gain: float) -> tuple[Array, float]:
    """Return the likely noise and log evidence of the rows where the static pressure has no error.

    Where no noise near the given one brings it close to `gain`, the best of those noises is enough:
    the exact number would not change the decision.
    """
    problem = altitude_regression(rows, None, np.zeros(0), ())
    near = [noise + np.log(factors) for factors in _NOISIER]
    heights = [restricted_log_likelihood(problem, AltitudeNoise(rows)(phi)) + altitude_log_prior(rows, phi)
               for phi in near]  # fmt: skip
    best = int(np.argmax(heights))
    return (
        (near[best], heights[best])
        if gain - heights[best] > _FAR_OFF
        else _tried(problem, rows, near[best])
    )


def _tried(problem: Regression, rows: AltitudeRows, start: Array) -> tuple[Array, float]:
    """Return the most likely noise of altitude rows alone, from `start`, and log evidence."""
    return mode_and_evidence(problem, *_noise_and_prior(rows), start)


def _noise_and_prior(rows: AltitudeRows) -> tuple[NoiseOf, LogPrior]:
    """The family of the altitude rows' noise, and the prior of its parameters."""
    return AltitudeNoise(rows), lambda phi: altitude_log_prior(rows, phi)


def with_difference(answer: Posterior, difference: Array) -> Posterior:
    """Widen an answer by its difference (p,) from another location's, taken as one deviation."""
    return replace(answer, covariances=answer.covariances + np.outer(difference, difference))
