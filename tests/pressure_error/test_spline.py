"""The spline: its parameters are its values, it is straight beyond its knots, and it takes shapes no law takes."""

import numpy as np
import pytest

from pitotbench.pressure_error import MODELS
from pitotbench.pressure_error.models import SplineModel, spline_between

KNOTS = (0.5, 1.0, 2.0, 3.0)


def test_parameters_are_values_at_the_knots():
    np.testing.assert_allclose(SplineModel("spline", KNOTS).basis(np.array(KNOTS)), np.eye(4), atol=1e-12)


def test_straight_in_the_logarithm_beyond_the_knots():
    model, k = SplineModel("spline", KNOTS), np.array([0.02, -0.01, 0.03, 0.0])
    for outside in (np.array([0.1, 0.2, 0.4]), np.array([4.0, 8.0, 16.0])):
        rise = np.diff(model.basis(outside) @ k)
        assert rise[0] == pytest.approx(rise[1], rel=1e-9)
        np.testing.assert_allclose(model.basis_slope(outside) @ k * outside, rise[0] / np.log(2.0), rtol=1e-9)


def test_second_derivative_is_continuous_and_ends_at_zero():
    model, step = SplineModel("spline", KNOTS), 1e-3
    for knot in KNOTS:
        u = np.log(knot) + step * np.arange(-2, 3)
        second = np.diff(model.basis(np.exp(u)), 2, axis=0) / step**2
        np.testing.assert_allclose(second[0], second[2], atol=0.2)
        if knot in (KNOTS[0], KNOTS[-1]):
            np.testing.assert_allclose(second[1], 0.0, atol=0.1)


def test_takes_the_shape_of_every_law():
    x = np.linspace(0.9, 2.8, 200)
    fine = spline_between(0.9, 2.8, 13)
    for name, law in MODELS.items():
        missed = law.basis(x) - fine.basis(x) @ law.basis(np.array(fine.knots))
        if name != "spline":
            assert np.max(np.abs(missed)) < 0.02, name  # of terms of order one; in a curve, times 0.05


def test_knots_follow_the_range():
    spread = MODELS["spline"].spread_over(1.0, 4.0)
    assert spread.knots[0] == pytest.approx(1.0)
    assert spread.knots[-1] == pytest.approx(4.0)
    np.testing.assert_allclose(np.diff(np.log(spread.knots)), np.log(4.0) / (len(spread.knots) - 1))
    assert MODELS["linear"].spread_over(1.0, 4.0) is MODELS["linear"]


@pytest.mark.parametrize("knots", [(1.0, 2.0), (0.0, 1.0, 2.0), (1.0, 3.0, 2.0)])
def test_knots_that_are_none(knots):
    with pytest.raises(ValueError, match="three knots"):
        SplineModel("spline", knots)
