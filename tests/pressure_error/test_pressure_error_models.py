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
    TableCurve,
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
    for one, slope in zip(np.eye(len(model.parameter_names)), difference.T, strict=True):
        np.testing.assert_allclose(model.curve(X, one)[1], slope, atol=1e-7)


@models
def test_curve_is_the_sum_of_the_terms(name):
    model = MODELS[name].spread_over(0.45, 3.1)  # X goes beyond it at both ends
    parameters = np.linspace(0.5, -0.3, len(model.parameter_names))
    np.testing.assert_allclose(
        model.curve(X, parameters)[0], model.basis(X) @ parameters, atol=1e-12
    )


@models
def test_basis_has_a_column_a_parameter(name):
    model = MODELS[name]
    assert model.basis(X).shape == (50, len(model.parameter_names))
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
    ],
)
def test_a_table_that_is_none_is_refused(make, says):
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


def test_the_smooth_curve_takes_the_shape_of_every_law():
    x = np.linspace(0.9, 2.8, 200)
    smooth = MODELS["smooth"].spread_over(0.9, 2.8).basis(x)
    for name in ("bias", "linear", "quadratic", "inverse", "inverse+"):
        law = MODELS[name].basis(x)
        missed = law - smooth @ np.linalg.lstsq(smooth, law)[0]
        assert np.max(np.abs(missed)) < 1e-3, name  # of terms of order one


def test_the_smooth_curve_follows_the_range():
    spread = MODELS["smooth"].spread_over(1.0, 4.0)
    assert (spread.low, spread.high) == pytest.approx((1.0, 4.0))
    assert MODELS["linear"].spread_over(1.0, 4.0) is MODELS["linear"]
