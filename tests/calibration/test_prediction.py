"""The prediction and its Jacobian: identities against finite differences and against the sensed truth."""

import numpy as np
import pytest
from tests.calibration import trajectories as fixture

from pitotbench.calibration import prediction
from pitotbench.calibration.observations import observe
from pitotbench.calibration.options import CalibrationOptions
from pitotbench.calibration.prediction import PredictionModel
from pitotbench.pressure_error import MODELS, REFERENCE_PRESSURE


@pytest.fixture(scope="module")
def calm():
    log = fixture.fly(fixture.step_decrease(5), 5, 5, fixture.CALM)
    return observe(log, CalibrationOptions())


def theta_for(model):
    return np.concatenate(
        [[-0.05, 0.01, 0.02, -0.01, 0.03][: model.error_count], [4.0, -3.0, 0.5][: model.count - model.error_count]]
    )


def test_prediction_at_the_truth_is_what_was_sensed_and_its_slope_the_derivative_over_true_airspeed(calm):
    model = PredictionModel(MODELS["inverse+"], REFERENCE_PRESSURE)
    theta = np.array([*fixture.TRUTH.parameters, *fixture.WIND])
    np.testing.assert_allclose(model.predict(theta, calm).indicated, calm.impact_pressure, rtol=1e-9)
    theta = theta_for(model)
    here = model.predict(theta, calm)
    toward = -(calm.velocity_north - theta[3]) / here.true_airspeed
    np.testing.assert_allclose(here.jacobian[:, 3], here.slope * toward, rtol=1e-9)


@pytest.mark.parametrize("name", list(MODELS))
@pytest.mark.parametrize("static_error", [False, True])
def test_jacobian_is_the_derivative(calm, name, static_error):
    model = PredictionModel(MODELS[name], REFERENCE_PRESSURE, static_error, wind_down=True)
    theta = theta_for(model)
    jacobian = model.predict(theta, calm).jacobian
    for i in range(model.count):
        step = np.zeros(model.count)
        step[i] = 1e-5
        up, down = model.predict(theta + step, calm), model.predict(theta - step, calm)
        np.testing.assert_allclose(jacobian[:, i], (up.indicated - down.indicated) / 2e-5, rtol=2e-5, atol=2e-4)


def test_static_source_error_moves_the_static_pressure(calm):
    """With the error in the static source, p = p_i − Δp: total pressure is conserved at any Mach number."""
    model = PredictionModel(MODELS["bias"], REFERENCE_PRESSURE, static_error=True)
    f = 0.04
    here = model.predict(np.array([f, *fixture.WIND]), calm)
    ratio = here.impact_pressure / calm.static_pressure
    true_static = calm.static_pressure / (1.0 + f * ratio)
    total = true_static * (1.0 + ratio)
    np.testing.assert_allclose(here.indicated, total - calm.static_pressure, rtol=1e-9)


@pytest.mark.parametrize("static_error", [False, True])
def test_the_size_of_a_block_does_not_matter(calm, monkeypatch, static_error):
    """Blocks that stopped their Newton steps one by one would differ by the last step, some 1e-10."""
    model = PredictionModel(MODELS["inverse+"], REFERENCE_PRESSURE, static_error, wind_down=True)
    whole = model.predict(theta_for(model), calm)
    monkeypatch.setattr(prediction, "_BLOCK", 64)
    parts = model.predict(theta_for(model), calm)
    for name in ("indicated", "jacobian", "impact_pressure", "true_airspeed", "slope"):
        np.testing.assert_allclose(getattr(parts, name), getattr(whole, name), rtol=1e-13, atol=0.0)
