"""Fixed-speed methods: published worked examples and identities."""

import numpy as np
import pytest

from pitotbench.calibrate.fixed_speed import fixed_speed, horseshoe
from pitotbench.records.errors import BadInputError, NoAnswerError
from pitotbench.units import DEGREE, KNOT


def solve(speeds_kt, tracks_deg):
    return fixed_speed(np.array(speeds_kt) * KNOT, np.array(tracks_deg) * DEGREE)


def test_four_leg_worked_example():
    """Ground speeds 178, 185, 188, 184 kt on tracks 178, 82, 355, 265°: published 183.7267 ± 0.8271 kt."""
    result = solve([178, 185, 188, 184], [178, 82, 355, 265])
    assert result.true_airspeed / KNOT == pytest.approx(183.7267, abs=5e-5)
    assert result.spread / KNOT == pytest.approx(0.8271, abs=5e-5)


def test_three_leg_worked_example():
    """Gray 1998: 140, 112, 120 kt on 192, 283, 20°: 129.9985 kt, wind 20.63 kt from 314.76°."""
    result = solve([140, 112, 120], [192, 283, 20])
    assert result.true_airspeed / KNOT == pytest.approx(129.9985, abs=5e-5)
    assert result.wind_speed / KNOT == pytest.approx(20.63, abs=5e-3)
    assert result.wind_from / DEGREE == pytest.approx(314.76, abs=5e-3)
    assert result.spread is None


def test_horseshoe_recovers_the_airspeed():
    """Headings 0, 90, 180° in a wind: the formula is exact for tracks that are 90° apart in heading."""
    airspeed, wind = 60.0, np.array([4.0, 0.0])
    legs = airspeed * np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]]) + wind
    assert horseshoe(np.linalg.norm(legs, axis=1)) == pytest.approx(airspeed, rel=5e-3)


def test_parallel_legs_are_no_answer():
    with pytest.raises(NoAnswerError, match="60°"):
        solve([120, 121, 120], [90, 90, 90])


@pytest.mark.parametrize(("speeds", "tracks"), [([120, 130], [0, 90]), ([120, -1, 130], [0, 90, 180])])
def test_bad_legs_are_bad_input(speeds, tracks):
    with pytest.raises(BadInputError):
        solve(speeds, tracks)
