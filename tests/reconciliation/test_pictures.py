"""The first picture and its sentence: the noise of a mean, and what an effect does to a calibration."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.signal import lfilter

from pitotbench import air
from pitotbench.reconciliation.noise import NoiseModel
from pitotbench.reconciliation.pictures import calibration_change, deviation_of_mean
from pitotbench.units import KNOT


def test_the_noise_of_a_mean_is_that_of_a_long_random_series():
    coefficients = np.array([[0.6, -0.2], [0.9, 0.0]])
    noise = NoiseModel(("a", "b"), coefficients, np.array([0.3, 2.0]), np.eye(2))
    rng = np.random.default_rng(20)
    for channel in (0, 1):
        series = lfilter(
            [1.0], [1.0, *-coefficients[channel]], noise.deviations[channel] * rng.standard_normal(400_000)
        )
        means = np.convolve(series, np.full(8, 1.0 / 8.0), "valid")
        assert deviation_of_mean(noise, channel, 8) == pytest.approx(np.std(means), rel=0.02)


def naming(explained: float, chosen: bool = True) -> SimpleNamespace:
    """A log of two opposite legs, 80 to 150 KIAS, with an effect that is `explained` times the term k1."""
    speed = np.tile(np.linspace(80.0, 150.0, 300) * KNOT, 2)
    pressure = air.impact_pressure(speed)
    x = pressure / 1630.28
    out = np.repeat([1.0, -1.0], 300)
    zero = np.zeros(600)
    along = np.stack([0.5 * speed, 0.5 * speed * x, 0.5 * speed / x, out, zero], axis=1)
    across = np.stack([zero, zero, zero, zero, out], axis=1)
    names = ("curve k1", "curve k2", "curve k3", "wind north", "wind east")
    free = SimpleNamespace(names=names, columns=np.stack([along, across], axis=1), deviations=np.full(5, 40.0))
    column = np.stack([along[:, 0], zero], axis=1)
    layout = SimpleNamespace(
        residuals=SimpleNamespace(names=("airspeed_along", "airspeed_across")),
        signatures=(SimpleNamespace(column=column),),
        free=free,
        track={"impact_pressure": pressure},
    )
    fit = SimpleNamespace(columns=(0,) if chosen else (), sizes=(explained,) if chosen else ())
    return SimpleNamespace(layout=layout, fit=fit)


def test_an_effect_that_is_an_error_curve_is_told_as_that_curve():
    found = calibration_change(naming(0.04))
    # An impact pressure 4 % higher is an airspeed 2 % higher; at Mach 0.23 compressibility takes 1.3 % of that.
    assert found.change == pytest.approx(0.0198 * found.airspeed, rel=0.02)
    assert found.airspeed[0] / KNOT == pytest.approx(81.4, abs=0.5)
    assert calibration_change(naming(0.04, chosen=False)) is None
