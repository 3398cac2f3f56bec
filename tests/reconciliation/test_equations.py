"""The normal equations against plain least squares, whitening, and the first picture with the noise
of a mean.
"""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.signal import lfilter

from pitotbench import air
from pitotbench.reconciliation.equations import NormalEquations, equations_from, products_of
from pitotbench.reconciliation.noise import NoiseModel, learned
from pitotbench.reconciliation.null_learning import learn_null_distribution
from pitotbench.reconciliation.pictures import calibration_change, deviation_of_mean
from pitotbench.reconciliation.track import Grid
from pitotbench.units import KNOT

N, C = 800, 2


def made(size: float = 0.0, seed: int = 3) -> tuple[NormalEquations, np.ndarray, np.ndarray]:
    """Two free parameters, two signatures, one cell a channel; the residual holds the first
    signature at a size.
    """
    draw = np.random.default_rng(seed)
    dense = draw.standard_normal((N, C, 4))
    cells = np.broadcast_to(np.eye(C), (N, C, C))
    residual = draw.standard_normal((N, C)) + dense[:, :, 0] * 5.0 + size * dense[:, :, 2]
    every = np.concatenate([dense, cells, residual[:, :, None]], axis=2)
    products = products_of(every, np.arange(len(every)) * 8 // len(every))
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
    assert equations.fit([0], given=[1]).gain == pytest.approx(
        equations.scores([0], given=[1])[0] ** 2, rel=1e-6
    )


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
    """Two channels with a common gust: whitened they are uncorrelated, and a difference of theirs
    shows better.
    """
    draw, n = np.random.default_rng(2), 6000
    gust = draw.standard_normal((n, 1))
    values = np.hstack(
        [gust + 0.5 * draw.standard_normal((n, 1)), gust + 0.5 * draw.standard_normal((n, 1))]
    )
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


def test_the_noise_of_a_mean_is_that_of_a_long_random_series():
    coefficients = np.array([[0.6, -0.2], [0.9, 0.0]])
    noise = NoiseModel(("a", "b"), coefficients, np.array([0.3, 2.0]), np.eye(2))
    rng = np.random.default_rng(20)
    for channel in (0, 1):
        series = lfilter(
            [1.0],
            [1.0, *-coefficients[channel]],
            noise.deviations[channel] * rng.standard_normal(400_000),
        )
        means = np.convolve(series, np.full(8, 1.0 / 8.0), "valid")
        assert deviation_of_mean(noise, channel, 8) == pytest.approx(np.std(means), rel=0.02)


def legs(explained: float, chosen: bool = True) -> tuple[SimpleNamespace, SimpleNamespace]:
    """A log of two opposite legs, 80 to 150 KIAS, with an effect that is `explained` times the term
    k1.
    """
    speed = np.tile(np.linspace(80.0, 150.0, 300) * KNOT, 2)
    pressure = air.impact_pressure(speed)
    x = pressure / 1630.28
    out = np.repeat([1.0, -1.0], 300)
    zero = np.zeros(600)
    along = np.stack([0.5 * speed, 0.5 * speed * x, 0.5 * speed / x, out, zero], axis=1)
    across = np.stack([zero, zero, zero, zero, out], axis=1)
    names = ("curve k1", "curve k2", "curve k3", "wind north", "wind east")
    free = SimpleNamespace(
        names=names, columns=np.stack([along, across], axis=1), deviations=np.full(5, 40.0)
    )
    column = np.stack([along[:, 0], zero], axis=1)
    layout = SimpleNamespace(
        residuals=SimpleNamespace(
            names=("airspeed_along", "airspeed_across"), values=np.zeros((600, 2))
        ),
        signatures=(SimpleNamespace(column=column),),
        free=free,
        track={"impact_pressure": pressure},
    )
    fit = SimpleNamespace(columns=(0,) if chosen else (), sizes=(explained,) if chosen else ())
    return layout, fit


def test_an_effect_that_is_an_error_curve_is_told_as_that_curve():
    found = calibration_change(*legs(0.04))
    # An impact pressure 4 % higher is an airspeed 2 % higher; at Mach 0.23 compressibility takes
    # 1.3 % of that.
    assert found.change == pytest.approx(0.0198 * found.airspeed, rel=0.02)
    assert found.airspeed[0] / KNOT == pytest.approx(81.4, abs=0.5)
    assert calibration_change(*legs(0.04, chosen=False)) is None
