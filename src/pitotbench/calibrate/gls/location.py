"""Where the pressure error sits, and the fit that goes with it.

A static source's error moves the static pressure (p = p_i − Δp) and shows against GPS height; an error of the
total source, or of the impact pressure alone (as published), leaves it right. The last two predict the same data,
so that no log can separate them. The wind triangle hardly knows the place; with the altitude equation beside it the
evidence is clear.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import chdtrc

from pitotbench.calibrate.gls.altitude_rows import (
    NOISE_COUNT,
    AltitudeRows,
    altitude_guess,
    altitude_log_prior,
    altitude_noise,
    altitude_regression,
    altitude_rows,
)
from pitotbench.calibrate.gls.covering_fit import Approach, CoveringFit, approach, fit_covering, settle
from pitotbench.calibrate.gls.linearized_problem import Structure
from pitotbench.calibrate.gls.posterior import Posterior, mixed, posterior_of
from pitotbench.calibrate.options import AUTO, CalibrationOptions
from pitotbench.calibrate.rows.observations import Observations
from pitotbench.estimate.restricted_likelihood import (
    LogPrior,
    NoiseOf,
    Regression,
    mode_and_evidence,
    restricted_log_likelihood,
    solve,
)
from pitotbench.records.log import FlightLog
from pitotbench.units import Array

STATIC, TOTAL, IMPACT = "static", "total", "impact"
_SURE = 1e-3  # probability of the less likely place below which it has no say
_CERTAIN = 500.0  # log odds beyond which there is nothing to compute
_LEAST_GAINED = 1e-6  # share of a variance below which the altitude says nothing in a direction
_FAR_OFF = 40.0  # log odds by which noises on a coarse net decide
_NOISIER = ((1.0, 1.0, 1.0), (2.0, 1.0, 1.0), (2.0, 0.5, 2.0), (4.0, 1.0, 1.0), (4.0, 0.5, 4.0))
_BENCH = "pitotbench flight log"  # begins the `format` of a synthetic log's header


@dataclass(frozen=True, slots=True)
class Located:
    """Where the error sits, the probability that it is the static source's (None where it was stated or assumed),
    the structure with its fit, the answer (a mixture where two places are likely), and the probability that wind
    triangle and altitude equation differ by so much about the curve by chance (None where only one speaks of it, or
    where no vertical velocity carries the height)."""

    location: str
    static_probability: float | None
    structure: Structure
    fit: CoveringFit
    answer: Posterior
    chance: float | None = None


def assumed_location(header: Mapping[str, object]) -> str:
    """Where the error of a log is taken to sit before anything is known: as published for a synthetic log, else the
    static source, whose error is the larger one on nearly every airplane (Gracey 1980)."""
    return IMPACT if str(header.get("format", "")).startswith(_BENCH) else STATIC


def fit_located(
    log: FlightLog, options: CalibrationOptions, structure: Structure, obs: Observations, start: Array
) -> Located:
    """Fit with the error where the options say, or where the log says (`auto`).

    `structure` without altitude rows; `start` θ (p,).
    """
    stated = None if options.error_location == AUTO else options.error_location
    assumed = stated or assumed_location(log.header)
    bare = _at(structure, assumed == STATIC)
    rows = None
    if stated in (None, STATIC):
        count = structure.model.error_count
        rows = altitude_rows(log, obs, options.gps_latency, start[count : count + 2])
    if rows is not None:
        return _with_height(stated, assumed, bare, rows, obs, start)
    fit = fit_covering(bare, obs, start)
    answer = posterior_of(fit)
    if stated is None and assumed == STATIC:
        answer = _widened(answer, posterior_of(fit_covering(_at(structure, False), obs, start)))
    return Located(assumed, None, bare, fit, answer)


def _at(structure: Structure, static: bool, rows: AltitudeRows | None = None) -> Structure:
    return replace(structure, model=replace(structure.model, static_error=static), altitude=rows)


def _with_height(
    stated: str | None, assumed: str, bare: Structure, rows: AltitudeRows, obs: Observations, start: Array
) -> Located:
    """The triangle on coarse blocks, then what the altitude rows add to it; the likely places are fitted."""
    near = approach(bare, obs, start)
    joint, gain, chance = _with_rows(near, bare, rows)
    moved = _at(bare, True, rows)
    if stated is not None:
        fit = settle(moved, obs, joint)
        return Located(stated, None, moved, fit, posterior_of(fit), chance)
    odds = gain - _evidence_without_curve(rows, joint.noise[-NOISE_COUNT:], gain)
    probability = float(1.0 / (1.0 + np.exp(-np.clip(odds, -_CERTAIN, _CERTAIN))))
    elsewhere = IMPACT if assumed == IMPACT else TOTAL
    shares = {STATIC: probability, elsewhere: 1.0 - probability}
    tried = {STATIC: (moved, joint), elsewhere: (_at(bare, False), near)}
    fits = {name: settle(tried[name][0], obs, tried[name][1]) for name in tried if shares[name] > _SURE}
    best = max(fits, key=lambda name: shares[name])
    answer = mixed([(shares[name], posterior_of(fit)) for name, fit in fits.items()])
    return Located(best, probability, tried[best][0], fits[best], answer, chance if best == STATIC else None)


def _with_rows(near: Approach, bare: Structure, rows: AltitudeRows) -> tuple[Approach, float, float | None]:
    """Where the altitude rows move the answer of the triangle, the logarithm of how likely it makes them, and the
    probability of so large a move by chance (None without vertical velocity).

    What the triangle knows of the curve is their prior: k = k0 + L z with LLᵀ its covariance, z standard normal.
    """
    free = bare.model.error_count
    known = near.covariance[:free, :free]
    scale = np.sqrt(np.diag(known))
    root = scale[:, None] * np.linalg.cholesky(known / np.outer(scale, scale))
    plain = altitude_regression(rows, bare.model, near.theta, ())
    seen = plain.regressors[:, :free] @ root
    problem = Regression(plain.response, seen, seen, np.ones(free))
    noise, log_evidence = _tried(problem, rows)
    z, left = solve(problem, altitude_noise(rows, noise))
    # Without vertical velocity the plain noise makes the number too small: it would cry wolf.
    chance = None if rows.tie is None else _chance(z, left)
    own = bare.model.count
    step = near.covariance[:own, :free] @ np.linalg.solve(root.T, z)
    return Approach(near.theta + step, np.concatenate([near.noise, noise]), near.covariance), log_evidence, chance


def _chance(z: Array, left: Array) -> float:
    """Probability of so large an estimate z of a standard normal vector, of which the covariance `left` remains.

    Before anything is seen, such an estimate varies by what it takes off the variance of one.
    """
    gained, axes = np.linalg.eigh(np.eye(len(z)) - left)
    moved = gained > _LEAST_GAINED
    distance = float(np.sum((axes.T @ z)[moved] ** 2 / gained[moved]))
    return float(chdtrc(int(moved.sum()), distance))


def _evidence_without_curve(rows: AltitudeRows, noise: Array, gain: float) -> float:
    """How likely the altitude rows are where the static pressure is right: heights and their noise alone.

    Where no noise near the one given makes them nearly as likely as `gain`, the best of those noises will do: the
    exact number would change nothing.
    """
    problem = altitude_regression(rows, None, np.zeros(0), ())
    near = [noise + np.log(factors) for factors in _NOISIER]
    best = max(
        restricted_log_likelihood(problem, altitude_noise(rows, phi)) + altitude_log_prior(rows, phi)
        for phi in near
    )
    return best if gain - best > _FAR_OFF else _tried(problem, rows)[1]


def _tried(problem: Regression, rows: AltitudeRows) -> tuple[Array, float]:
    """The most likely noise of a problem of altitude rows alone, and the evidence."""
    return mode_and_evidence(problem, *_noise_and_prior(rows), altitude_guess(rows))


def _noise_and_prior(rows: AltitudeRows) -> tuple[NoiseOf, LogPrior]:
    """The family of the altitude rows' noise, and the prior of its parameters."""
    return lambda phi: altitude_noise(rows, phi), lambda phi: altitude_log_prior(rows, phi)


def _widened(answer: Posterior, other: Posterior) -> Posterior:
    """An answer whose bound holds another place too: the difference counts as one standard deviation."""
    apart = other.mean - answer.mean
    return replace(answer, covariances=answer.covariances + np.outer(apart, apart))
