"""Fixed-speed methods: published worked examples and identities."""

import numpy as np
import pytest

from pitotbench.calibration.leg_points import circle_fit, fixed_speed, horseshoe
from pitotbench.records import BadInputError, NoAnswerError
from pitotbench.units import DEGREE, KNOT


def test_horseshoe_is_exact_on_square_tracks():
    """Tracks 0, 90, 180°: the wind along, plus what the wind across leaves of the airspeed."""
    airspeed, (north, east) = 60.0, (4.0, -7.0)
    along, across = np.array([north, east, -north]), np.array([east, north, east])
    assert horseshoe(along + np.sqrt(airspeed**2 - across**2)) == pytest.approx(airspeed, rel=1e-12)


def test_horseshoe_on_square_headings_is_off_by_the_square_of_the_wind():
    airspeed, east = 60.0, 6.0
    speeds = np.array([np.hypot(airspeed, east), airspeed + east, np.hypot(airspeed, east)])
    assert horseshoe(speeds) - airspeed == pytest.approx(east**2 / airspeed, rel=0.2)


def test_circle_fit_is_exact_on_a_circle_and_agrees_with_three_legs():
    angle = np.array([0.3, 1.9, 3.0, 4.4, 6.0])
    velocity = 60.0 * np.stack([np.cos(angle), np.sin(angle)], axis=1) + [4.0, -7.0]
    assert circle_fit(velocity) == pytest.approx([60.0, 4.0, -7.0], rel=1e-9)
    rough = velocity[:3] + np.array([[0.4, -0.1], [-0.3, 0.2], [0.1, 0.5]])
    three = fixed_speed(np.linalg.norm(rough, axis=1), np.arctan2(rough[:, 1], rough[:, 0]))
    assert circle_fit(rough)[0] == pytest.approx(three.true_airspeed, rel=1e-9)


@pytest.mark.parametrize(
    ("speeds_kt", "tracks_deg", "error", "says"),
    [
        ([120, 121, 120], [90, 90, 90], NoAnswerError, "60°"),
        ([120, 130], [0, 90], BadInputError, None),
        ([120, -1, 130], [0, 90, 180], BadInputError, None),
    ],
)
def test_legs_that_determine_nothing_are_refused(speeds_kt, tracks_deg, error, says):
    with pytest.raises(error, match=says):
        fixed_speed(np.array(speeds_kt) * KNOT, np.array(tracks_deg) * DEGREE)
    with pytest.raises(NoAnswerError, match="full"):
        circle_fit(np.outer(np.linspace(59.0, 61.0, 9), [1.0, 0.0]))
