"""Body axes, earth axes and the direction of the flow."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pitotbench.axes import body_to_earth, flow_direction

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
