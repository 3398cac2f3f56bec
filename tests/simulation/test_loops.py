"""Loops on linear models: the step response against its closed form, the designs against their limits."""

import numpy as np
import pytest

from pitotbench.simulation.autopilot.envelope import Trim
from pitotbench.simulation.autopilot.loops import (
    LEAST_DAMPING,
    Linear,
    bank_loop,
    damping,
    pitch_loop,
    shape,
    step_response,
)
from pitotbench.simulation.plant import SimulationError


def model(stiffness=-8.0, elevator=-6.0, aileron=3.0):
    trim = Trim(60.0, 55.0, 0.05, 0.0, 0.5, np.array([0.0, 1.0]), np.array([-1.0, 1.0]), 1.0)
    pitch = np.array([[-1.2, 0.97, -0.02], [stiffness, -3.0, elevator]])
    lateral = np.array(
        [[-0.12, 0.05, -0.99, 0.0, 0.02], [-4.0, -3.0, 0.8, aileron, 0.2], [3.0, -0.1, -0.5, -0.05, -0.8]]
    )
    return Linear(trim, pitch, lateral, 9.8 / 60.0)


def test_a_step_response_is_the_exact_one():
    time = np.linspace(0.0, 5.0, 51)
    found = step_response(np.array([[0.0, 1.0], [-4.0, -2.0]]), np.array([0.0, 4.0]), 0, time)
    w = np.sqrt(3.0)
    exact = 1.0 - np.exp(-time) * (np.cos(w * time) + np.sin(w * time) / w)
    np.testing.assert_allclose(found, exact, atol=1e-12)


def test_damping_is_that_of_the_slowest_damped_pair():
    assert damping(np.array([[0.0, 1.0], [-4.0, -2.0]])) == pytest.approx(0.5)
    assert damping(np.array([[0.2]])) == -1.0


@pytest.mark.parametrize("stiffness", [-30.0, -8.0, 1.0])  # the last is statically unstable
@pytest.mark.parametrize("sign", [1.0, -1.0])  # a control wired the other way round gets the other sign
def test_the_loops_found_are_damped_and_reach_their_targets(stiffness, sign):
    one = model(stiffness, elevator=-6.0 * sign, aileron=3.0 * sign)
    gains = shape("kite", [one], 1.0)
    time = np.linspace(0.0, 20.0, 401)
    pitch = pitch_loop(one, gains.pitch_rate[0], gains.pitch_integral[0])
    bank = bank_loop(one, gains.bank[0], gains.roll_rate[0], gains.yaw_rate[0])
    assert damping(pitch[0]) >= LEAST_DAMPING
    assert step_response(*pitch, 1, time)[-1] == pytest.approx(1.0, abs=0.02)
    assert step_response(*bank, 3, time)[60] == pytest.approx(1.0, abs=0.25)


def test_a_control_that_does_nothing_is_named():
    with pytest.raises(SimulationError, match="kite: the ailerons do nothing at 107 KCAS"):
        shape("kite", [model(aileron=0.0)], 1.0)
    with pytest.raises(SimulationError, match="kite: the elevator does nothing"):
        shape("kite", [model(elevator=0.0)], 1.0)
    # A slow engine slows the loop of the speed.
    assert shape("kite", [model()], 6.0).speed < 0.5 * shape("kite", [model()], 0.2).speed
