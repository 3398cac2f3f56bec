"""White noise plus recursions, and the joint likelihood of two sets of rows, against dense
matrices.
"""

import numpy as np
import pytest

from pitotbench.estimation.noise import Intervals, JointNoiseOf, MarkovNoise, MarkovProcess
from pitotbench.estimation.point_noise import (
    PointNoise,
    UnknownColumns,
    ornstein_uhlenbeck,
    random_walk,
)
from pitotbench.estimation.restricted_likelihood import Regression, restricted_log_likelihood, solve

N = 40
RNG = np.random.default_rng(7)
TIME = np.cumsum(RNG.uniform(1.0, 3.0, N))
FIRST = np.isin(np.arange(N), [0, 25])
WHITE = np.stack(
    [RNG.uniform(0.01, 0.02, N), np.where(np.arange(N) % 5 == 0, np.inf, RNG.uniform(0.05, 0.1, N))]
)
TIED = np.isfinite(WHITE[1])
COLUMNS = np.concatenate([RNG.standard_normal((N, 3)), np.zeros((int(TIED.sum()), 3))])
PRECISION = np.array([0.0, 1.0, 4.0])


def _walk_and_slow(rate: float, level: float, memory: float) -> np.ndarray:
    """Dense covariance of (walk, slow − walk) of one flight, the walk beginning at zero in each
    stretch.
    """
    part = np.cumsum(FIRST)
    start = np.array([TIME[FIRST][p - 1] for p in part])
    walk = rate**2 * np.minimum.outer(TIME - start, TIME - start) * np.equal.outer(part, part)
    slow = level**2 * np.exp(-np.abs(np.subtract.outer(TIME, TIME)) / memory)
    both = np.block([[walk, -walk], [-walk, slow + walk]]) + np.diag(
        np.where(np.isfinite(WHITE), WHITE, 1.0).ravel()
    )
    kept = np.concatenate([np.ones(N, dtype=bool), TIED])
    return both[np.ix_(kept, kept)]


def _dense(rate: float, level: float, memory: float) -> tuple[np.ndarray, np.ndarray]:
    """Covariance with what is known of the columns, and the columns of which nothing is:
    beginnings, the first.
    """
    begins = np.stack([(np.cumsum(FIRST) == p).astype(float) for p in (1, 2)], axis=1)
    begins = np.concatenate([begins, -begins[TIED]])
    known = COLUMNS[:, 1:] / np.sqrt(PRECISION[1:])
    return _walk_and_slow(rate, level, memory) + known @ known.T, np.column_stack(
        [begins, COLUMNS[:, 0]]
    )


def _noise(rate: float, level: float, memory: float) -> PointNoise:
    processes = [
        random_walk(TIME, rate, FIRST, (1.0, -1.0)),
        ornstein_uhlenbeck(TIME, level, memory, (0.0, 1.0)),
    ]
    return PointNoise(WHITE, processes, UnknownColumns(COLUMNS, PRECISION))


def test_products_agree_with_dense_matrices():
    covariance, free = _dense(0.05, 2.0, 60.0)
    inverse = np.linalg.inv(covariance)
    expected = inverse - inverse @ free @ np.linalg.inv(free.T @ inverse @ free) @ free.T @ inverse
    found = _noise(0.05, 2.0, 60.0).weigh(np.eye(len(covariance)))
    np.testing.assert_allclose(found, expected, atol=1e-8 * np.abs(expected).max())


def test_determinants_differ_as_those_of_dense_matrices():
    def dense(*phi: float) -> float:
        covariance, free = _dense(*phi)
        inner = free.T @ np.linalg.solve(covariance, free)
        return float(np.linalg.slogdet(covariance)[1] + np.linalg.slogdet(inner)[1])

    one, other = (0.05, 2.0, 60.0), (0.1, 1.0, 200.0)
    found = _noise(*one).log_determinant - _noise(*other).log_determinant
    assert found == pytest.approx(dense(*one) - dense(*other), abs=1e-8)


def _joint() -> tuple[Regression, JointNoiseOf, np.ndarray]:
    """Forty means in gusts and the altitude rows above, three shared coefficients of which one is a
    wind's.
    """
    edges = np.arange(N + 1.0)
    intervals = Intervals(edges, np.arange(N))
    second = N + int(TIED.sum())
    X = RNG.standard_normal((N + second, 3))
    X[N:, 2] = 0.0
    X[2 * N :] = 0.0
    y = RNG.standard_normal(N + second)
    problem = Regression(
        y, X, X + 0.01 * RNG.standard_normal(X.shape) * (X != 0.0), np.array([0.0, 0.0, 2.0])
    )

    def gusts(phi: np.ndarray) -> MarkovNoise:
        level, memory = np.exp(phi)
        process = MarkovProcess(float(level), np.full(N + 1, memory), np.ones((N, 1)))
        return MarkovNoise(intervals, np.full(N, 0.04), [process])

    def heights(phi: np.ndarray) -> PointNoise:
        return _noise(*np.exp(phi))

    data = np.column_stack([problem.instruments, y])
    return problem, JointNoiseOf(data, gusts, heights, 2, N), gusts


PHI = np.log([0.5, 6.0, 0.05, 2.0, 60.0])
OTHER = np.log([0.8, 9.0, 0.1, 1.0, 90.0])


def _dense_joint(
    problem: Regression, gusts: np.ndarray, phi: np.ndarray
) -> tuple[float, np.ndarray, np.ndarray]:
    """Restricted log-likelihood, estimate and covariance with every matrix formed."""
    first = np.linalg.inv(gusts(phi[:2]).weigh(np.eye(N)))
    second, free = _dense(*np.exp(phi[2:]))
    size = len(first) + len(second)
    covariance, flat = np.zeros((size, size)), np.zeros((size, free.shape[1]))
    covariance[:N, :N], covariance[N:, N:], flat[N:] = first, second, free
    inverse = np.linalg.inv(covariance)
    wide, clean = (np.column_stack([x, flat]) for x in (problem.regressors, problem.instruments))
    prior = np.diag(np.append(problem.prior_precision, np.zeros(flat.shape[1])))
    normal = clean.T @ inverse @ clean + prior
    pull = clean.T @ inverse @ problem.response
    rest = problem.response @ inverse @ problem.response - pull @ np.linalg.solve(normal, pull)
    log_likelihood = -0.5 * (np.linalg.slogdet(covariance)[1] + np.linalg.slogdet(normal)[1] + rest)
    gain = np.linalg.inv(clean.T @ inverse @ wide + prior)
    spread = gain @ (clean.T @ inverse @ clean + prior) @ gain.T
    return float(log_likelihood), (gain @ clean.T @ inverse @ problem.response)[:3], spread[:3, :3]


def test_the_joint_problem_agrees_with_dense_least_squares():
    problem, noise_of, gusts = _joint()
    found = [restricted_log_likelihood(problem, noise_of(phi)) for phi in (PHI, OTHER)]
    expected = [_dense_joint(problem, gusts, phi)[0] for phi in (PHI, OTHER)]
    assert found[0] - found[1] == pytest.approx(expected[0] - expected[1], abs=1e-8)
    estimate, covariance = solve(problem, noise_of(PHI))
    _, dense_estimate, dense_covariance = _dense_joint(problem, gusts, PHI)
    np.testing.assert_allclose(estimate, dense_estimate, atol=1e-8)
    np.testing.assert_allclose(covariance, dense_covariance, atol=1e-8)


def test_what_is_remembered_is_what_is_computed():
    problem, noise_of, _ = _joint()
    noise_of(PHI).products()
    mixed = np.concatenate([PHI[:2], OTHER[2:]])
    again = restricted_log_likelihood(problem, noise_of(mixed))
    fresh = JointNoiseOf(noise_of.data, noise_of.first, noise_of.second, 2, N)
    assert again == restricted_log_likelihood(problem, fresh(mixed))
    assert again != restricted_log_likelihood(problem, fresh(PHI))
