"""The normal equations against plain least squares, and whitening against a process of known spectrum."""

import numpy as np
import pytest

from pitotbench.reconciliation.equations import NormalEquations, equations_from, inner_products
from pitotbench.reconciliation.noise import learned
from pitotbench.reconciliation.null_learning import learn_null_distribution
from pitotbench.reconciliation.track import Grid

N, C = 800, 2


def made(size: float = 0.0, seed: int = 3) -> tuple[NormalEquations, np.ndarray, np.ndarray]:
    """Two free parameters, two signatures, one cell a channel; the residual holds the first signature at a size."""
    draw = np.random.default_rng(seed)
    dense = draw.standard_normal((N, C, 4))
    cells = np.broadcast_to(np.eye(C), (N, C, C))
    residual = draw.standard_normal((N, C)) + dense[:, :, 0] * 5.0 + size * dense[:, :, 2]
    products = inner_products(np.concatenate([dense, cells], axis=2), residual)
    return equations_from(products, 2, np.array([10.0, 10.0])), dense, residual


def test_fit_is_least_squares_with_the_prior_as_rows() -> None:
    equations, dense, residual = made(0.7)
    design = np.concatenate([dense[:, :, :3].reshape(-1, 3), np.diag([0.1, 0.1, 0.0])[:2]])
    wanted = np.linalg.lstsq(design, np.concatenate([residual.ravel(), [0.0, 0.0]]), rcond=None)[0]
    assert equations.fit([0]).sizes[0] == pytest.approx(wanted[2], rel=1e-9)
    covariance = np.linalg.inv(design.T @ design)
    assert equations.fit([0]).deviations[0] == pytest.approx(np.sqrt(covariance[2, 2]), rel=1e-9)
    # The gain is the square of the score.
    equations, _, _ = made(0.3)
    assert equations.fit([0]).gain == pytest.approx(equations.scores([0])[0] ** 2, rel=1e-9)
    assert equations.fit([0], given=[1]).gain == pytest.approx(equations.scores([0], given=[1])[0] ** 2, rel=1e-6)


def test_held_out_gain_separates_a_true_effect_from_a_chance_one() -> None:
    equations, _, _ = made(0.5)
    assert equations.held_out_gain([0]) / equations.fit([0]).gain > 0.9
    nothing, _, _ = made(0.0)
    assert nothing.held_out_gain([0]) < 10.0
    with pytest.raises(ValueError, match="null flights"):
        learn_null_distribution([])


def test_whitening_makes_an_autoregression_white() -> None:
    draw, n = np.random.default_rng(1), 6000
    values = np.zeros((n, 1))
    for i in range(2, n):
        values[i] = 1.2 * values[i - 1] - 0.4 * values[i - 2] + 0.5 * draw.standard_normal()
    grid = Grid(np.arange(n), np.arange(n) == 0, 0.5, np.ones(1), True)
    noise = learned(("x",), [(values, grid, np.zeros_like(values))])
    white = noise.whiten(values, grid, np.zeros_like(values))[20:, 0]
    assert noise.deviations[0] == pytest.approx(0.5, rel=0.05)
    assert abs(np.corrcoef(white[1:], white[:-1])[0, 1]) < 0.04


def test_noise_that_channels_share_is_counted_once() -> None:
    """Two channels with a common gust: whitened they are uncorrelated, and a difference of theirs shows better."""
    draw, n = np.random.default_rng(2), 6000
    gust = draw.standard_normal((n, 1))
    values = np.hstack([gust + 0.5 * draw.standard_normal((n, 1)), gust + 0.5 * draw.standard_normal((n, 1))])
    grid = Grid(np.arange(n), np.arange(n) == 0, 0.5, np.ones(1), True)
    slack = np.zeros_like(values)
    slack[: n // 2, 1] = 1e6  # the second channel says nothing here, and must not spoil the first
    noise = learned(("x", "y"), [(values, grid, np.zeros_like(values))])
    white = noise.whiten(values, grid, slack)
    late = white[n // 2 :]
    assert abs(np.corrcoef(late.T)[0, 1]) < 0.1
    assert white[20 : n // 2, 0].std() == pytest.approx(1.0, abs=0.05)
    assert white[: n // 2, 1].std() < 1e-3
    alone = noise.whiten_alone(np.ones((n, 1)), grid, np.zeros_like(values))[20:]
    power = np.einsum("nck,ncl->kl", alone, alone) / len(alone)
    innovations = noise.innovations(np.ones_like(values), grid, np.zeros_like(values))[20:]
    assert power[0, 0] > 2.0 * np.mean(innovations**2)
