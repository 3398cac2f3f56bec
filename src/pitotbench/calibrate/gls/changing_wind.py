"""Whether the wind of a log changes: a drift and one jump beside the constant wind, weighed by evidence.

A drift is a slow Gauss-Markov process of any size, with a memory between a minute and an hour; a jump is one change
within twenty seconds, at any time. A coarse test over a few noises says which of them may be likely; those are
fitted, and the evidence of each is its restricted likelihood integrated over the noise. The answer is the mixture
of what is likely (Bayesian model averaging: Hoeting et al., Statistical Science 14, 1999). Where a log cannot tell,
as where each speed is flown on one heading only, the prior keeps some of the change in the bound.
"""

from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import logsumexp

from pitotbench.calibrate.gls.covering_fit import Approach, CoveringFit, settle
from pitotbench.calibrate.gls.linearized_problem import (
    WIND_SCALE,
    Linearized,
    Structure,
    linearize,
    log_prior_of,
)
from pitotbench.calibrate.gls.posterior import Posterior, mixed, posterior_of
from pitotbench.calibrate.model.mean_wind import correlations
from pitotbench.calibrate.model.wind_jump import JUMP_SCALE, WindJump, jump_columns, jump_shape, middles
from pitotbench.calibrate.rows.blocks import Blocks, block_length, divide
from pitotbench.calibrate.rows.observations import Observations
from pitotbench.estimate.joint_noise import Noise
from pitotbench.estimate.restricted_likelihood import restricted_log_likelihood
from pitotbench.records.errors import NoAnswerError
from pitotbench.units import Array, MetersPerSecond, Seconds

CONSTANT, DRIFTING, JUMP = "constant", "drifting", "jump"
SHARES = {CONSTANT: 0.6, DRIFTING: 0.35, JUMP: 0.05}  # probabilities before the flight
_MEMORIES = (60.0, 400.0, 3000.0)  # s of a drift, each as likely
_SIZES = (0.2, 0.6, 1.8)  # m/s of a drift, for the coarse test
_SHORTER = (1.0, 0.4, 0.15)  # of the gust length found with a constant wind: a change passes for long gusts
_JUMP_STEP = 10.0  # s between the times tried
_FIRST_JUMP = 15.0  # s after the first row and before the last: of a change nearer to the ends little is known
_WORTH_A_FIT = 0.05  # coarse probability from which on a changing wind is fitted
_NO_SAY = 0.01  # probability below which a wind is left out of the answer
_HALF_NORMAL = 0.5 * np.log(2.0 / np.pi)


@dataclass(frozen=True, slots=True)
class WindChange:
    """How the wind most likely changes, in a log where it does: by how much [m/s], and from when to when [s after
    the first row]."""

    size: float
    begin: float
    end: float


@dataclass(frozen=True, slots=True)
class WindAnswer:
    """The most likely wind's structure and fit; the answer of all that are likely; the probability of each kind;
    and the most likely change."""

    structure: Structure
    fit: CoveringFit
    answer: Posterior
    shares: dict[str, float]
    change: WindChange | None


@dataclass(frozen=True, slots=True)
class _Coarse:
    """The problem for a constant wind on coarse blocks, the structure, rows and blocks, θ, and the most likely
    noise."""

    structure: Structure
    obs: Observations
    blocks: Blocks
    theta: Array
    noise: Array
    plain: Linearized


def weigh_winds(structure: Structure, obs: Observations, fit: CoveringFit, answer: Posterior) -> WindAnswer:
    """Weigh a drift and a jump beside the constant wind of a structure, of which fit and answer are given."""
    coarse = _coarse(structure, obs, fit)
    fits: dict[str, tuple[Structure, CoveringFit]] = {}
    for each, start in _likely(coarse):
        approached = Approach(coarse.theta, start, np.zeros((0, 0)))
        with suppress(NoAnswerError):  # a wind that has no fit has no say; the constant one has
            fits[JUMP if each.jump else DRIFTING] = (each, settle(each, obs, approached))
    odds = {CONSTANT: np.log(SHARES[CONSTANT]) + _evidence(fit)}
    for kind, (each, own) in fits.items():
        odds[kind] = np.log(SHARES[kind]) + _evidence(own) + _beside(coarse, each, own)
    total = logsumexp(list(odds.values()))
    shares = {kind: float(np.exp(value - total)) for kind, value in odds.items()}
    answers = {CONSTANT: answer} | {kind: posterior_of(own) for kind, (_, own) in fits.items()}
    best = max(shares, key=lambda kind: shares[kind])
    chosen, own = fits.get(best, (structure, fit))
    return WindAnswer(
        chosen,
        own,
        mixed([(share, answers[kind]) for kind, share in shares.items() if share > _NO_SAY]),
        dict.fromkeys(SHARES, 0.0) | shares,
        None if best == CONSTANT else _change(chosen, obs, own),
    )


def _coarse(structure: Structure, obs: Observations, fit: CoveringFit) -> _Coarse:
    blocks, theta = divide(obs, 2.0 * block_length(obs)), fit.theta[: structure.model.count]
    noise = max(fit.nodes, key=lambda node: node.weight).noise
    return _Coarse(structure, obs, blocks, theta, noise, linearize(structure, obs, blocks, theta))


def _likely(coarse: _Coarse) -> list[tuple[Structure, Array]]:
    """The changing winds that are worth a fit, each with a noise to begin with: at most one drift and one jump."""
    noises = [_with_length(coarse.noise, ratio) for ratio in _SHORTER]
    heights = np.array([_height(coarse, coarse.structure, coarse.plain, phi) for phi in noises])
    times = _jump_times(coarse)
    gains = np.stack([_jump_gains(coarse, coarse.plain.noise_of(phi), times) for phi in noises])
    jumps = heights[:, None] + gains  # (noises, times)
    drifts = [replace(coarse.structure, drifting=True, wind_time=memory) for memory in _MEMORIES]
    trials = [np.insert(phi, 3, np.log(size)) for phi in noises for size in _SIZES]
    grid = np.stack([_drift_heights(coarse, each, trials) for each in drifts])  # (memories, trials)
    odds = {
        CONSTANT: float(logsumexp(heights)),
        DRIFTING: float(logsumexp(grid)) - np.log(len(_MEMORIES)),
        JUMP: float(logsumexp(jumps)) - np.log(len(times)) if len(times) else -np.inf,
    }
    odds = {kind: value + np.log(SHARES[kind]) for kind, value in odds.items()}
    least = float(logsumexp(list(odds.values()))) + np.log(_WORTH_A_FIT)
    found = []
    if odds[DRIFTING] > least:
        memory, trial = np.unravel_index(int(np.argmax(grid)), grid.shape)
        found.append((drifts[int(memory)], trials[int(trial)]))
    if odds[JUMP] > least:
        noise, place = np.unravel_index(int(np.argmax(jumps)), jumps.shape)
        found.append((replace(coarse.structure, jump=WindJump(float(times[place]))), noises[int(noise)]))
    return found


def _with_length(noise: Array, ratio: float) -> Array:
    """A noise with another gust length and the same gusts over short times."""
    phi = noise.copy()
    phi[:2] += np.log(ratio) * np.array([0.5, 1.0])
    return phi


def _height(coarse: _Coarse, structure: Structure, problem: Linearized, phi: Array) -> float:
    """The log-posterior of a noise."""
    prior = log_prior_of(structure, coarse.obs)(phi)
    return restricted_log_likelihood(problem.regression, problem.noise_of(phi)) + prior


def _drift_heights(coarse: _Coarse, structure: Structure, trials: list[Array]) -> Array:
    """The same of a drift for each noise, with the weight of its size among those tried."""
    problem = linearize(structure, coarse.obs, coarse.blocks, coarse.theta)
    apart = float(np.mean(np.diff(np.log(_SIZES))))
    heights = [_height(coarse, structure, problem, phi) for phi in trials]
    return np.asarray(np.array(heights) + np.log(apart) + _HALF_NORMAL)


def _jump_times(coarse: _Coarse) -> Seconds:
    last = float(middles(coarse.blocks)[-1])
    return np.arange(_FIRST_JUMP, last - _FIRST_JUMP, _JUMP_STEP)


def _jump_gains(coarse: _Coarse, noise: Noise, times: Seconds) -> Array:
    """What a jump at each time adds to the restricted log-likelihood, (times,)."""
    data, seen, rows = coarse.plain.regression, *_seen(coarse.structure, coarse.plain, coarse.blocks)
    columns = np.zeros((len(data.response), 2 * len(times)))
    for place, time in enumerate(times):
        columns[:rows, 2 * place : 2 * place + 2] = jump_columns(WindJump(float(time)), coarse.blocks, seen)
    own = data.instruments
    weighed = noise.weigh(np.column_stack([own, data.response, columns]))
    p = own.shape[1]
    normal = own.T @ weighed[:, :p] + np.diag(data.prior_precision)
    rest = weighed[:, p:] - weighed[:, :p] @ np.linalg.solve(normal, own.T @ weighed[:, p:])
    pull = (columns.T @ rest[:, 0]).reshape(-1, 2)
    products = np.stack([columns[:, i : i + 2].T @ rest[:, i + 1 : i + 3] for i in range(0, 2 * len(times), 2)])
    precision = products + np.eye(2) / JUMP_SCALE**2
    explained = np.einsum("ti,tij,tj->t", pull, np.linalg.inv(precision), pull)
    return np.asarray(0.5 * (explained - np.linalg.slogdet(JUMP_SCALE**2 * precision)[1]))


def _seen(structure: Structure, problem: Linearized, blocks: Blocks) -> tuple[Array, int]:
    """Direction cosines of the triangle's rows, (outputs, blocks, 2), and how many rows they are."""
    rows, first = len(blocks.count) * (1 + structure.crosswind), structure.model.error_count
    return problem.regression.regressors[:rows, first : first + 2].reshape(-1, len(blocks.count), 2), rows


def _evidence(fit: CoveringFit) -> float:
    """The logarithm of the restricted likelihood integrated over the noise, up to a constant of all winds."""
    return float(logsumexp([node.log_mass for node in fit.nodes]))


def _beside(coarse: _Coarse, structure: Structure, fit: CoveringFit) -> float:
    """What evidence leaves out: the constant of the size's prior, or the times at which the jump may be as well."""
    if structure.jump is None:
        return float(_HALF_NORMAL - np.log(WIND_SCALE))
    noise = max(fit.nodes, key=lambda node: node.weight).noise
    times = _jump_times(coarse)
    gains = _jump_gains(coarse, coarse.plain.noise_of(noise), times)
    return float(logsumexp(gains) - np.max(gains) - np.log(len(times)))


def _change(structure: Structure, obs: Observations, fit: CoveringFit) -> WindChange:
    """The best prediction of how the wind changes (Robinson 1991), by its two most different values."""
    blocks = divide(obs, block_length(obs))
    node = max(fit.nodes, key=lambda each: each.weight)
    rows, first = len(blocks.count) * (1 + structure.crosswind), structure.model.error_count
    data = fit.problem
    left = data.response - data.regressors @ node.estimate
    pull = data.regressors[:rows, first : first + 2] * fit.noise_of(node.noise).weigh(left[:, None])[:rows]
    pull = pull.reshape(-1, len(blocks.count), 2).sum(axis=0)
    if structure.jump is None:
        path = np.exp(2.0 * node.noise[3]) * correlations(blocks, structure.wind_time) @ pull
    else:
        shape = JUMP_SCALE * jump_shape(structure.jump, blocks)
        path = np.outer(shape, shape @ pull)
    return _extremes(path, middles(blocks))


def _extremes(path: MetersPerSecond, time: Seconds) -> WindChange:
    """The change along the direction in which a wind (n, 2) varies most."""
    axis = np.linalg.svd(path - path.mean(axis=0), full_matrices=False)[2][0]
    along = path @ axis
    ends = sorted((int(np.argmin(along)), int(np.argmax(along))))
    return WindChange(float(np.ptp(along)), float(time[ends[0]]), float(time[ends[1]]))
