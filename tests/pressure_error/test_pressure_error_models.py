"""Every model of the table: its slope is its derivative, its inverse undoes it, its sign is the
paper's.
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pitotbench import UnknownNameError, air
from pitotbench.pressure_error import MODELS, REFERENCE_PRESSURE
from pitotbench.pressure_error.models import (
    PressureErrorCurve,
    PressureErrorRangeError,
    SplineModel,
    TableCurve,
    spline_between,
)
from pitotbench.units import KNOT

X = np.linspace(0.3, 4.0, 50)
SPEEDS = np.linspace(60.0, 160.0, 21) * KNOT
small = st.floats(-0.02, 0.02)
LARGE = 0.06  # Δp/q_c (1σ), of a slope; what is usually smaller is drawn smaller
models = pytest.mark.parametrize("name", list(MODELS))


@models
def test_slope_is_the_derivative(name):
    model, step = MODELS[name].spread_over(0.45, 4.1), 1e-6
    difference = (model.basis(X + step) - model.basis(X - step)) / (2.0 * step)
    np.testing.assert_allclose(model.basis_slope(X), difference, atol=1e-7)


@models
def test_basis_has_a_column_a_parameter(name):
    model = MODELS[name]
    assert model.basis(X).shape == model.basis_slope(X).shape == (50, len(model.parameter_names))
    assert np.linalg.matrix_rank(model.basis(X)) == len(model.parameter_names)
    assert all(parameter in model.formula for parameter in model.parameter_names)


@models
@given(data=st.data())
def test_indicated_and_true_invert(name, data):
    with np.errstate(divide="ignore"):  # a parameter without a prior may be as large as any
        usual = np.max(MODELS[name].precisions ** -0.5, axis=0)
    k = tuple(data.draw(small) * min(1.0, each / LARGE) for each in usual)
    curve = PressureErrorCurve(MODELS[name], k, REFERENCE_PRESSURE)
    true = air.impact_pressure(SPEEDS)
    np.testing.assert_allclose(
        curve.impact_pressure(curve.indicated_impact_pressure(true)), true, rtol=1e-10
    )


def test_sign_is_true_minus_indicated_and_the_reference_is_100_knots():
    """Δp = q_c − q_ci: with Δp/q_c = +0.1 the airplane reads 10 % of q_c too low."""
    curve = PressureErrorCurve(MODELS["bias"], (0.1,), REFERENCE_PRESSURE)
    assert curve.indicated_impact_pressure(np.array([1000.0])) == pytest.approx(900.0)
    assert curve.impact_pressure(np.array([900.0])) == pytest.approx(1000.0)
    assert pytest.approx(float(air.impact_pressure(100.0 * KNOT)), abs=0.01) == REFERENCE_PRESSURE


def test_formulas_of_the_source():
    """Martos et al. (2011), Fig 4, at q_ci = 2 q_ref."""
    x = np.array([2.0 * REFERENCE_PRESSURE])
    wanted = {
        "bias": 1.0,
        "linear": 1.0 + 10.0 * 2,
        "quadratic": 1.0 + 20.0 + 400.0,
        "inverse": 1.0 + 10.0 / 2,
    }
    wanted["inverse+"] = 1.0 + 20.0 + 50.0
    for name, value in wanted.items():
        k = (1.0, 10.0, 100.0)[: len(MODELS[name].parameter_names)]
        assert PressureErrorCurve(MODELS[name], k, REFERENCE_PRESSURE).normalized(
            x
        ) == pytest.approx(value), name


def test_no_solution_a_wrong_number_of_parameters_and_an_unknown_model_are_said():
    curve = PressureErrorCurve(MODELS["inverse"], (0.0, 2.0), REFERENCE_PRESSURE)
    with pytest.raises(PressureErrorRangeError, match="no indicated impact pressure"):
        curve.indicated_impact_pressure(np.array([100.0, 500.0]))
    with pytest.raises(ValueError, match="takes the parameters k1, k2, k3"):
        PressureErrorCurve(MODELS["inverse+"], (0.1,), REFERENCE_PRESSURE)
    with pytest.raises(UnknownNameError, match="'inverse"):
        MODELS["invers"]


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: TableCurve((50.0,), (0.1,)), "pressure-error table"),
        (lambda: TableCurve((50.0, 60.0), (0.1,)), "pressure-error table"),
        (lambda: TableCurve((60.0, 50.0), (0.1, 0.2)), "pressure-error table"),
        (lambda: SplineModel("spline", (1.0, 2.0)), "three knots"),
        (lambda: SplineModel("spline", (0.0, 1.0, 2.0)), "three knots"),
        (lambda: SplineModel("spline", (1.0, 3.0, 2.0)), "three knots"),
    ],
)
def test_a_table_and_knots_that_are_none_are_refused(make, says):
    with pytest.raises(ValueError, match=says):
        make()


def test_table_interpolates_holds_its_ends_and_inverts():
    table = TableCurve((50.0, 70.0), (0.10, 0.02))
    speeds = np.array([40.0, 50.0, 60.0, 70.0, 90.0])
    values = table.normalized(air.impact_pressure(speeds))
    np.testing.assert_allclose(values, [0.10, 0.10, 0.06, 0.02, 0.02], atol=1e-12)
    table, true = (
        TableCurve((50.0, 60.0, 70.0), (0.08, 0.02, -0.03)),
        air.impact_pressure(np.linspace(40, 80, 41)),
    )
    np.testing.assert_allclose(
        table.impact_pressure(table.indicated_impact_pressure(true)), true, rtol=1e-9
    )


KNOTS = (0.5, 1.0, 2.0, 3.0)


def test_parameters_are_values_at_the_knots():
    np.testing.assert_allclose(
        SplineModel("spline", KNOTS).basis(np.array(KNOTS)), np.eye(4), atol=1e-12
    )


def test_straight_in_the_logarithm_beyond_the_knots():
    model, k = SplineModel("spline", KNOTS), np.array([0.02, -0.01, 0.03, 0.0])
    for outside in (np.array([0.1, 0.2, 0.4]), np.array([4.0, 8.0, 16.0])):
        rise = np.diff(model.basis(outside) @ k)
        assert rise[0] == pytest.approx(rise[1], rel=1e-9)
        np.testing.assert_allclose(
            model.basis_slope(outside) @ k * outside, rise[0] / np.log(2.0), rtol=1e-9
        )


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
            assert np.max(np.abs(missed)) < 0.02, (
                name
            )  # of terms of order one; in a curve, times 0.05


def test_knots_follow_the_range():
    spread = MODELS["spline"].spread_over(1.0, 4.0)
    assert spread.knots[0] == pytest.approx(1.0)
    assert spread.knots[-1] == pytest.approx(4.0)
    np.testing.assert_allclose(np.diff(np.log(spread.knots)), np.log(4.0) / (len(spread.knots) - 1))
    assert MODELS["linear"].spread_over(1.0, 4.0) is MODELS["linear"]
