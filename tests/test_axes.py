"""Body axes, earth axes and the direction of the flow."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pitotbench.axes import body_rates, body_to_earth, euler_rates, flow_direction

ANGLES = np.random.default_rng(1).uniform(-1.4, 1.4, (3, 200))
FORWARD, RIGHT, DOWN = np.eye(3)[:, :, None]


def test_body_axes_turn_as_by_heading_then_pitch_then_roll():
    roll, pitch, heading = ANGLES
    vector = np.random.default_rng(2).normal(size=(3, 200))
    oracle = Rotation.from_euler("ZYX", np.stack([heading, pitch, roll], axis=1)).apply(vector.T).T
    np.testing.assert_allclose(body_to_earth(vector, roll, pitch, heading), oracle, atol=1e-13)


@pytest.mark.parametrize(
    ("vector", "roll", "pitch", "heading", "toward"),
    [
        (
            FORWARD,
            0.0,
            0.0,
            0.5 * np.pi,
            [0.0, 1.0, 0.0],
        ),  # the nose of an airplane that flies east
        (FORWARD, 0.0, 0.3, 0.0, [np.cos(0.3), 0.0, -np.sin(0.3)]),  # nose up
        (RIGHT, 0.4, 0.0, 0.0, [0.0, np.cos(0.4), np.sin(0.4)]),  # right wing down
        (DOWN, 0.0, 0.3, 0.0, [np.sin(0.3), 0.0, np.cos(0.3)]),
    ],
)
def test_an_axis_points_where_a_pilot_expects_it(vector, roll, pitch, heading, toward):
    angles = (np.array([a]) for a in (roll, pitch, heading))
    np.testing.assert_allclose(body_to_earth(vector, *angles)[:, 0], toward, atol=1e-15)


def test_the_flow_direction_has_unit_length_and_the_flow_angles():
    alpha, beta, _ = ANGLES
    forward, right, down = flow_direction(alpha, beta)
    np.testing.assert_allclose(np.hypot(np.hypot(forward, right), down), 1.0, atol=1e-14)
    np.testing.assert_allclose(np.arctan2(down, forward), alpha, atol=1e-13)
    np.testing.assert_allclose(np.arcsin(right), beta, atol=1e-13)


def test_rates_of_the_attitude_are_those_of_a_body_that_turns():
    """Against SciPy: a small turn about the body axes, and the attitude after it."""
    roll, pitch, heading = ANGLES
    rates, step = np.random.default_rng(3).normal(size=(3, 200)), 1e-6
    before = Rotation.from_euler("ZYX", np.stack([heading, pitch, roll], axis=1))
    after = (before * Rotation.from_rotvec(step * rates.T)).as_euler("ZYX")[:, ::-1].T
    change = np.mod(after - before.as_euler("ZYX")[:, ::-1].T + np.pi, 2.0 * np.pi) - np.pi
    told = euler_rates(*rates, roll, pitch)
    np.testing.assert_allclose(told, change / step, rtol=1e-3, atol=1e-4)
    np.testing.assert_allclose(body_rates(*told, roll, pitch), rates, atol=1e-12)
