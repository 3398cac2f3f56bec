"""Noise as recursions: against dense covariances, and a stack of noises against the same one by
one.
"""

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pitotbench.estimation.noise import Intervals, MarkovNoise, MarkovProcess
from pitotbench.estimation.point_noise import (
    PointNoise,
    UnknownColumns,
    ornstein_uhlenbeck,
    random_walk,
)
from pitotbench.estimation.restricted_likelihood import Regression, noise_posterior

POINTS = 60


def spread(seed=0, n=14):
    """Unequal intervals with a gap in the middle."""
    rng = np.random.default_rng(seed)
    edges = np.cumsum(rng.uniform(0.3, 1.5, n + 2))
    edges[n // 2 + 1 :] += 3.0
    left = np.delete(np.arange(n + 1), n // 2)
    return Intervals(edges, left)


def dense(intervals, white, processes):
    start, length = intervals.edges[intervals.left], intervals.length
    inside = (start[:, None] + length[:, None] * (np.arange(POINTS) + 0.5) / POINTS).ravel()
    lag = np.abs(inside[:, None] - inside)
    n, total = len(start), np.diag(white)
    for p in processes:
        cell = np.exp(-lag / p.correlation_time[0]).reshape(n, POINTS, n, POINTS).mean(axis=(1, 3))
        total = total + p.deviation**2 * (p.loading @ p.loading.T) * cell
    return total


@settings(max_examples=20, deadline=None)
@given(
    seed=st.integers(0, 10**6),
    count=st.integers(0, 3),
    deviation=st.floats(1e-3, 5.0),
    scale=st.floats(0.5, 500.0),
)
def test_products_and_determinant_match_the_dense_covariance(seed, count, deviation, scale):
    rng = np.random.default_rng(seed)
    intervals = spread(seed)
    n, states = len(intervals.left), len(intervals.edges)
    white = rng.uniform(0.05, 0.3, n)
    processes = [
        MarkovProcess(
            deviation * (j + 1), np.full(states, scale * 3.0**j), rng.uniform(-1, 1, (n, 1 + j % 2))
        )
        for j in range(count)
    ]
    noise, covariance = MarkovNoise(intervals, white, processes), dense(intervals, white, processes)
    data = rng.standard_normal((n, 4))
    wanted = np.linalg.solve(covariance, data)
    np.testing.assert_allclose(noise.weigh(data), wanted, atol=3e-3 * np.abs(wanted).max())
    assert noise.log_determinant == pytest.approx(np.linalg.slogdet(covariance)[1], abs=2e-2)


def test_a_memory_that_changes_is_that_of_a_process_in_its_own_time():
    """With the correlation time constant from edge to edge, the process is one of unit memory in
    time over it.
    """
    intervals, rng = spread(5), np.random.default_rng(5)
    n, time = len(intervals.left), rng.uniform(0.5, 20.0, len(intervals.edges))
    own = np.concatenate([[0.0], np.cumsum(np.diff(intervals.edges) / time[:-1])])
    stretched, ones = Intervals(own, intervals.left), np.ones_like(time)
    white, loading = rng.uniform(0.05, 0.3, n), rng.uniform(-1.0, 1.0, (n, 2))
    changing = MarkovNoise(intervals, white, [MarkovProcess(0.8, time, loading)])
    steady = MarkovNoise(stretched, white, [MarkovProcess(0.8, ones, loading)])
    data = rng.standard_normal((n, 3))
    np.testing.assert_allclose(changing.weigh(data), steady.weigh(data), rtol=1e-9, atol=1e-9)
    assert changing.log_determinant == pytest.approx(steady.log_determinant, abs=1e-9)


def test_a_long_gap_makes_parts_independent_and_white_noise_alone_is_a_division():
    intervals = Intervals(np.array([0.0, 1.0, 1e6, 1e6 + 1.0]), np.array([0, 2]))
    process = MarkovProcess(1.0, np.full(4, 10.0), np.ones((2, 1)))
    weighed = MarkovNoise(intervals, np.full(2, 0.1), [process]).weigh(np.array([[1.0], [0.0]]))
    assert abs(weighed[1, 0]) < 1e-12
    noise = MarkovNoise(Intervals(np.arange(3.0), np.arange(2)), np.array([0.5, 4.0]), [])
    np.testing.assert_allclose(noise.weigh(np.array([[1.0], [2.0]])), [[2.0], [0.5]])
    assert noise.log_determinant == pytest.approx(np.log(2.0))
    endless = MarkovProcess(1.0, np.array([9.0, 9.0, 1e300, 9.0, 9.0]), np.ones((4, 1)))
    with pytest.raises(np.linalg.LinAlgError, match="positive definite"):
        MarkovNoise(Intervals(np.arange(5.0), np.arange(4)), np.full(4, 0.1), [endless])


def test_two_outputs_see_one_process_from_two_sides():
    """Along and across a turning path, against one dense covariance of both."""
    intervals, rng = spread(3), np.random.default_rng(3)
    n = len(intervals.left)
    angle = rng.uniform(0.0, 2.0 * np.pi, n)
    along = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    across = np.stack([-np.sin(angle), np.cos(angle)], axis=1)
    white = rng.uniform(0.05, 0.3, (2, n))
    processes = [MarkovProcess(0.7, np.full(len(intervals.edges), 9.0), np.stack([along, across]))]
    both = np.concatenate([along, across])
    start, length = intervals.edges[intervals.left], intervals.length
    inside = (start[:, None] + length[:, None] * (np.arange(POINTS) + 0.5) / POINTS).ravel()
    kernel = (
        np.exp(-np.abs(inside[:, None] - inside) / 9.0)
        .reshape(n, POINTS, n, POINTS)
        .mean(axis=(1, 3))
    )
    covariance = np.diag(white.ravel()) + 0.49 * (both @ both.T) * np.tile(kernel, (2, 2))
    noise, data = MarkovNoise(intervals, white, processes), rng.standard_normal((2 * n, 3))
    wanted = np.linalg.solve(covariance, data)
    np.testing.assert_allclose(noise.weigh(data), wanted, atol=3e-3 * np.abs(wanted).max())
    assert noise.log_determinant == pytest.approx(np.linalg.slogdet(covariance)[1], abs=2e-2)
    # What the two outputs of an interval say of each other, without the whole inverse.
    precision = np.linalg.inv(covariance).reshape(2, n, 2, n)
    wanted = np.moveaxis(np.diagonal(precision, axis1=1, axis2=3), 2, 0)
    np.testing.assert_allclose(noise.precision_blocks, wanted, atol=3e-3 * np.abs(wanted).max())


def test_the_blocks_of_the_precision_are_those_of_the_products_with_it():
    """Of two processes of different widths and of memories that change, to rounding."""
    intervals, rng = spread(8), np.random.default_rng(8)
    n, states = len(intervals.left), len(intervals.edges)
    angle, zero = rng.uniform(0.0, 2.0 * np.pi, n), np.zeros((n, 1))
    along = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    across = np.stack([-np.sin(angle), np.cos(angle)], axis=1)
    processes = [
        MarkovProcess(0.7, rng.uniform(0.5, 20.0, states), np.stack([along, across])),
        MarkovProcess(30.0, np.full(states, 900.0), np.stack([zero + 1.0, zero])),
    ]
    noise = MarkovNoise(intervals, rng.uniform(0.05, 0.3, (2, n)), processes)
    whole = noise.weigh(np.eye(2 * n)).reshape(2, n, 2, n)
    wanted = np.moveaxis(np.diagonal(whole, axis1=1, axis2=3), 2, 0)
    np.testing.assert_allclose(noise.precision_blocks, wanted, atol=1e-9)


N, LEVELS, MEMORIES = 90, np.array([0.3, 0.9, 2.0]), np.array([4.0, 9.0, 40.0])
RNG = np.random.default_rng(7)
WHITE, TURN = RNG.uniform(0.05, 0.3, N), RNG.uniform(0.0, 6.0, N)
ALONG = np.stack([np.cos(TURN), np.sin(TURN)], axis=1)
INTERVALS = Intervals(np.cumsum(RNG.uniform(0.3, 1.5, N + 2)), np.delete(np.arange(N + 1), N // 2))


def markov(levels, memories):
    """Two outputs that see gusts, and a slow wind whose memory is the same in every noise."""
    across = np.stack([-ALONG[:, 1], ALONG[:, 0]], axis=1)
    seen, edges = np.stack([ALONG, across]), np.ones(N + 2)
    white = np.stack(
        [WHITE + levels[..., None] ** 2, WHITE * np.ones_like(levels)[..., None]], axis=-2
    )
    gusts = MarkovProcess(levels, memories[..., None] * edges, seen)
    return MarkovNoise(INTERVALS, white, [gusts, MarkovProcess(0.5 * levels, 900.0 * edges, seen)])


def heights(levels, memories):
    """Heights and fixes at some of the points, a walk and a slow error, and two unknown columns."""
    time, first, fix = (
        np.arange(N) * 2.0,
        np.arange(N) % 30 == 0,
        np.where(np.arange(N) % 4, np.inf, 0.3),
    )
    white = np.broadcast_to(np.stack([WHITE, fix]), (*np.shape(levels), 2, N))
    processes = [
        random_walk(time, 0.1 * levels, first, (1.0, -1.0)),
        ornstein_uhlenbeck(time, levels, memories, (0.0, 1.0)),
    ]
    rows = N + int(np.isfinite(fix).sum())
    columns = np.random.default_rng(3).standard_normal((rows, 2))
    return PointNoise(white, processes, UnknownColumns(columns, np.array([0.0, 2.0])))


@pytest.mark.parametrize(("family", "rows"), [(markov, 2 * N), (heights, N + 23)])
def test_a_stack_has_the_numbers_of_each_noise(family, rows):
    data = RNG.standard_normal((rows, 4))
    stack = family(LEVELS, MEMORIES)
    weighed = stack.weigh(data)
    assert weighed.shape == (3, rows, 4)
    for place in range(3):
        alone = family(LEVELS[place], MEMORIES[place])
        np.testing.assert_allclose(weighed[place], alone.weigh(data), rtol=1e-10, atol=1e-12)
        assert stack.log_determinants[place] == pytest.approx(alone.log_determinant, abs=1e-9)
    assert (
        np.ptp(stack.log_determinants) > 1.0
    )  # noises that differ: one in place of another would be seen


@dataclass(frozen=True)
class OneByOne:
    """Gusts and white noise of φ = (ln level, ln white level), refused above a level."""

    refused: float = np.inf

    def __call__(self, phi):
        if np.any(phi[..., 0] > self.refused):
            raise np.linalg.LinAlgError
        level, white = np.exp(phi[..., 0]), np.exp(phi[..., 1])
        gusts = MarkovProcess(level, np.full(N + 2, 6.0), ALONG[:, :1])
        return MarkovNoise(INTERVALS, white[..., None, None] ** 2 * np.ones(N), [gusts])


@dataclass(frozen=True)
class Together(OneByOne):
    """The same, made together."""

    def stack(self, phis):
        return self(phis)


@pytest.mark.parametrize("refused", [np.inf, 0.02])
def test_a_search_is_the_same_with_noises_made_together(refused):
    """Also where one noise of a stack is refused: the others of that stack count nevertheless."""
    X = np.column_stack([np.ones(N), np.linspace(-1.0, 1.0, N)])
    y = np.random.default_rng(11).standard_normal(N) + np.repeat(
        np.random.default_rng(12).standard_normal(N // 9), 9
    )
    problem = Regression(y, X, X, np.zeros(2))

    def prior(phi):
        return -0.5 * float(phi @ phi)

    found = [
        noise_posterior(problem, of(refused), prior, np.log([0.2, 0.2]))
        for of in (OneByOne, Together)
    ]
    assert len(found[0]) == 9
    for one, other in zip(*found, strict=True):
        assert one.weight == pytest.approx(other.weight, rel=1e-9)
        np.testing.assert_allclose(one.noise, other.noise, rtol=1e-9)
        np.testing.assert_allclose(one.covariance, other.covariance, rtol=1e-9)
