"""The estimator of the covering 2σ: generalized least squares, the noise estimated from the log."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import groupby

import numpy as np

from pitotbench.calibration.covering_problem import (
    Linearized,
    Structure,
    first_guess,
    linearize,
    log_prior_of,
    noise_count,
    smoothed,
)
from pitotbench.calibration.nuisances import Nuisance, path_of_nuisances
from pitotbench.calibration.observations import Blocks, Observations, block_length, divide
from pitotbench.calibration.output_error import OutputErrorFit
from pitotbench.calibration.prediction import Prediction
from pitotbench.calibration.wind_path import WindPath, correlated, mean_wind
from pitotbench.calibration.window_winds import window_winds
from pitotbench.estimation.mixture import Posterior
from pitotbench.estimation.noise import NoiseOf
from pitotbench.estimation.restricted_likelihood import (
    NoiseNode,
    Regression,
    Solution,
    most_likely_noise,
    noise_posterior,
    solutions,
    solve,
)
from pitotbench.records import NoAnswerError
from pitotbench.records.calibration import GustsFound, WindowWind
from pitotbench.units import Array

_PASSES = 10  # at most
_FAR = 4.0  # standard errors: a longer step is followed by another
_SMOOTH_PATH = 300.0  # s: a path that follows each gust would bend the problem along its own noise
# m/s, rms between two paths of the wind: what is left is second order, 4 cm/s at 50 m/s
_SAME_PATH = 2.0


@dataclass(frozen=True, slots=True)
class CoveringFit:
    """A fit: θ0, the nodes of the noise posterior and the most likely noise.

    `theta` (p + m,) is the reference point θ0, zero for the m nuisances; the nodes hold corrections
    to it. `path` is that of a drifting wind, and `winds` its mean in each window; None and empty
    for another wind.
    """

    theta: Array
    nodes: tuple[NoiseNode, ...]
    gusts: GustsFound
    problem: Regression  # linearized at θ0
    noise_of: NoiseOf
    path: WindPath | None = None
    winds: tuple[WindowWind, ...] = ()

    @property
    def likely(self) -> NoiseNode:
        """The node of the likeliest noise."""
        return max(self.nodes, key=lambda node: node.weight)


@dataclass(frozen=True, slots=True)
class FirstPass:
    """The result of the first pass: θ (p,), likeliest noise φ, and the path of a drifting wind.

    `solutions` are the answers under each rival prior of the curve: corrections to θ and the
    nuisances, (p + m,), with their covariance. θ is that of the likeliest.
    """

    theta: Array
    noise: Array
    solutions: tuple[Solution, ...]
    path: WindPath | None = None


def fit_covering(
    structure: Structure, obs: Observations, start: Array, path: WindPath | None = None
) -> CoveringFit:
    """Fit from a nearby start θ (p,), and of a drifting wind its path.

    Every node's estimate is a correction to the returned θ.

    The first pass, on blocks twice as long, moves θ to the estimate under the most likely noise.
    The last pass linearizes there and gives the bound. Raises NoAnswerError where the log is too
    short, the fit leaves the model's domain or the steps do not converge.
    """
    return final_pass(structure, obs, first_pass(structure, obs, start, path))


def final_pass(structure: Structure, obs: Observations, near: FirstPass) -> CoveringFit:
    """Run the last pass of `fit_covering`."""
    blocks, log_prior = divide(obs, block_length(obs)), log_prior_of(structure, obs)
    fine = linearize(structure, obs, blocks, near.theta, near.noise, near.path)
    nodes = noise_posterior(fine.regression, fine.noise_of, log_prior, near.noise)
    likely = max(nodes, key=lambda node: node.weight)
    deviation, length, _, wind, *_ = (*map(float, np.exp(likely.noise)), 0.0)
    return CoveringFit(
        theta=np.concatenate([near.theta, np.zeros(len(structure.nuisances))]),
        nodes=_of_mean_winds(structure, fine, nodes),
        gusts=GustsFound(deviation, length, wind * structure.drifting, len(blocks.count)),
        problem=fine.regression,
        noise_of=fine.noise_of,
        path=near.path,
        winds=window_winds(structure, obs, blocks, fine, likely, near.theta)
        if structure.drifting
        else (),
    )


Flown = tuple[Prediction, Observations]


def flown_of(structure: Structure, obs: Observations, fit: CoveringFit) -> Flown:
    """Return the prediction of a fit, and its rows less the path of a wind that drifts."""
    flown = obs if fit.path is None else fit.path.taken_from(obs)
    theta = fit.theta[: structure.model.count]
    return structure.model.predict(theta, flown).without_curve(), flown


def moved_by(
    structure: Structure, obs: Observations, fit: CoveringFit, flown: Flown, cause: Nuisance
) -> Array:
    """Return what a unit of a cause that is no column of a fit moves its unknowns by, (p + m,).

    The answer, θ and nuisances, to what that cause alone would leave in the rows; `flown` as of
    `flown_of`.
    """
    seen = divide(obs, block_length(obs)).mean(cause.column(*flown))
    left = np.zeros(len(fit.problem.response))
    left[: len(seen)] = seen
    if structure.altitude is not None and cause.height is not None:
        heights = cause.height(structure.altitude.state)
        left[len(seen) : len(seen) + len(heights)] = heights
    precision = fit.problem.rivals[fit.likely.rival]
    problem = replace(fit.problem, response=left, prior_precision=precision, prior_mean=None)
    return solve(problem, fit.noise_of(fit.likely.noise))[0]


def _of_mean_winds(
    structure: Structure, problem: Linearized, nodes: Sequence[NoiseNode]
) -> tuple[NoiseNode, ...]:
    """The nodes with the mean wind where the wind drifts; those of one noise share its wind."""
    found: list[NoiseNode] = []
    for _, group in groupby(nodes, key=lambda node: tuple(node.noise)):
        alike = list(group)
        answers = _of_mean_wind(structure, problem, alike[0].noise, alike)
        found += [
            replace(node, estimate=estimate, covariance=covariance)
            for node, (estimate, covariance) in zip(alike, answers, strict=True)
        ]
    return tuple(found)


def _of_mean_wind(
    structure: Structure, problem: Linearized, phi: Array, answers: Sequence[Solution | NoiseNode]
) -> list[tuple[Array, Array]]:
    """Return estimates and covariances of answers under one noise, with a drifting wind's mean."""
    found = [(each.estimate, each.covariance) for each in answers]
    if problem.kernel is None:
        return found
    deviation, first = float(np.exp(phi[3])), structure.model.error_count
    mean = mean_wind(problem.noise_of(phi), problem.regression, problem.kernel, deviation, first)
    return [mean.of(each) for each in found]


def first_pass(
    structure: Structure, obs: Observations, start: Array, path: WindPath | None = None
) -> FirstPass:
    """Run the first pass of `fit_covering`, repeated from a start (p,) or a path that is far away.

    Raises NoAnswerError where the log is too short for its unknowns or the steps do not converge.
    """
    theta, mode, count, log_prior = start, None, structure.model.count, log_prior_of(structure, obs)
    blocks = divide(obs, 2.0 * block_length(obs))
    unknowns = count + noise_count(structure)
    if len(blocks.count) <= unknowns:
        raise NoAnswerError(
            f"by its clock the log lasts {obs.time[-1] - obs.time[0]:.3g} s, too short for "
            f"{unknowns} unknowns: "
            "check the unit of the time, or fly longer"
        )
    for _ in range(_PASSES):
        rough = linearize(structure, obs, blocks, theta, path=path)
        guess = first_guess(rough, structure) if mode is None else mode
        mode = most_likely_noise(rough.regression, rough.noise_of, log_prior, guess)
        found = solutions(rough.regression, rough.noise_of(mode))
        best = int(np.argmax([each.weight for each in found]))
        # The next point has the mean wind: the level of a drifting wind may be far from any wind of
        # the flight.
        moved = _of_mean_wind(structure, rough, mode, found)
        step, covariance = moved[best]
        step = np.where(np.arange(len(step)) < count, step, 0.0)  # a nuisance stays what it is
        theta, last = theta + step[:count], path
        if structure.drifting:
            path = _path(structure, obs, blocks, rough, mode, found[best].estimate)
        if np.all(
            np.abs(step[:count]) < _FAR * np.sqrt(np.diag(covariance)[:count])
        ) and _has_converged(last, path):
            return FirstPass(
                theta,
                mode,
                tuple(
                    Solution(each.weight, estimate - step, spread)
                    for each, (estimate, spread) in zip(found, moved, strict=True)
                ),
                path,
            )
    raise NoAnswerError(
        "the fit does not converge: check the log for gross errors, or choose a simpler model"
    )


def _path(
    structure: Structure,
    obs: Observations,
    blocks: Blocks,
    problem: Linearized,
    phi: Array,
    estimate: Array,
) -> WindPath:
    """The wind less its mean over the rows, as estimated under one noise, block by block."""
    wind = _process(structure, blocks, problem, phi, estimate)
    wind += blocks.mean(
        path_of_nuisances(structure.nuisances, estimate[structure.model.count :], obs)
    )
    wind = smoothed(wind, blocks, _SMOOTH_PATH)
    return WindPath(blocks.mean(obs.time), wind - np.average(wind, axis=0, weights=blocks.count))


def _process(
    structure: Structure, blocks: Blocks, problem: Linearized, phi: Array, estimate: Array
) -> Array:
    """The slow process of the wind, as estimated under one noise, (blocks, 2) [m/s]."""
    data, first = problem.regression, structure.model.error_count
    weighed = problem.noise_of(phi).weigh((data.response - data.regressors @ estimate)[:, None])
    # the rows of the height, which stand last, see no wind
    seen = (weighed * data.regressors[:, first : first + 2])[: len(blocks.count)]
    memory = structure.priors.slow_wind_s
    return np.asarray(np.exp(2.0 * phi[3]) * correlated(blocks, memory, seen))


def drift_of(structure: Structure, obs: Observations, fit: CoveringFit, answer: Array) -> WindPath:
    """Return the slow part of a drifting wind, less the wind of an answer (p + m,).

    The estimate is for the answer's curve and constants, under the most likely noise. A path that
    followed each gust would leave no residual, so it is smoothed.
    """
    count, first = structure.model.count, structure.model.error_count
    blocks, phi = divide(obs, block_length(obs)), fit.likely.noise
    problem = linearize(structure, obs, blocks, answer[:count], phi, fit.path)
    data, estimate = problem.regression, np.zeros(len(answer))
    estimate[count:] = answer[count:]
    winds = data.regressors[:, first : first + 2]
    weighed = problem.noise_of(phi).weigh(winds)
    left = data.response - data.regressors @ estimate
    level = np.linalg.solve(weighed.T @ winds, weighed.T @ left)
    estimate[first : first + 2] = level
    wind = level + _process(structure, blocks, problem, phi, estimate)
    return WindPath(blocks.mean(obs.time), smoothed(wind, blocks, _SMOOTH_PATH))


def _has_converged(before: WindPath | None, path: WindPath | None) -> bool:
    """Whether another path of the wind would hardly change the problem.

    The path before may be that of other rows, as before a faulty one was left out.
    """
    if path is None:
        return True
    moved = path.wind if before is None else path.wind - before.at(path.time)
    return float(np.sqrt(np.mean(moved**2))) < _SAME_PATH


def posterior_of(fit: OutputErrorFit | CoveringFit) -> Posterior:
    """Return the posterior of a fit: a Gaussian for output error, a mixture for covering."""
    if isinstance(fit, OutputErrorFit):
        return Posterior(np.ones(1), fit.theta[None], fit.covariance[None])
    return Posterior(
        np.array([node.weight for node in fit.nodes]),
        fit.theta + np.stack([node.estimate for node in fit.nodes]),
        np.stack([node.covariance for node in fit.nodes]),
    )
