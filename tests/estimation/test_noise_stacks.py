"""A stack of noises against the same noises one by one."""

from dataclasses import dataclass

import numpy as np
import pytest

from pitotbench.estimation.noise import Intervals, MarkovNoise, MarkovProcess
from pitotbench.estimation.point_noise import PointNoise, UnknownColumns, ornstein_uhlenbeck, random_walk
from pitotbench.estimation.restricted_likelihood import Regression, noise_posterior

N, LEVELS, MEMORIES = 90, np.array([0.3, 0.9, 2.0]), np.array([4.0, 9.0, 40.0])
RNG = np.random.default_rng(7)
WHITE, TURN = RNG.uniform(0.05, 0.3, N), RNG.uniform(0.0, 6.0, N)
ALONG = np.stack([np.cos(TURN), np.sin(TURN)], axis=1)
INTERVALS = Intervals(np.cumsum(RNG.uniform(0.3, 1.5, N + 2)), np.delete(np.arange(N + 1), N // 2))


def markov(levels, memories):
    """Two outputs that see gusts, and a slow wind whose memory is the same in every noise."""
    across = np.stack([-ALONG[:, 1], ALONG[:, 0]], axis=1)
    seen, edges = np.stack([ALONG, across]), np.ones(N + 2)
    white = np.stack([WHITE + levels[..., None] ** 2, WHITE * np.ones_like(levels)[..., None]], axis=-2)
    gusts = MarkovProcess(levels, memories[..., None] * edges, seen)
    return MarkovNoise(INTERVALS, white, [gusts, MarkovProcess(0.5 * levels, 900.0 * edges, seen)])


def heights(levels, memories):
    """Heights and fixes at some of the points, a walk and a slow error, and two unknown columns."""
    time, first, fix = np.arange(N) * 2.0, np.arange(N) % 30 == 0, np.where(np.arange(N) % 4, np.inf, 0.3)
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
    assert np.ptp(stack.log_determinants) > 1.0  # noises that differ: one in place of another would be seen


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

    found = [noise_posterior(problem, of(refused), prior, np.log([0.2, 0.2])) for of in (OneByOne, Together)]
    assert len(found[0]) == 9
    for one, other in zip(*found, strict=True):
        assert one.weight == pytest.approx(other.weight, rel=1e-9)
        np.testing.assert_allclose(one.noise, other.noise, rtol=1e-9)
        np.testing.assert_allclose(one.covariance, other.covariance, rtol=1e-9)
