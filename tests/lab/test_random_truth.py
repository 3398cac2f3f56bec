"""The random truth: the draws of the committed campaign, and few flights in calm air."""

import numpy as np
import pytest

from pitotbench.records.case import PressureErrorSpec
from pitotlab.experiment import (
    CENTER,
    FIRST_SCORED_SEED,
    SPREAD,
    STRONGEST_WIND,
    Trial,
    random_case,
)


def test_the_parameters_follow_the_draw_of_a_wind():
    """The committed campaign drew a wind before the parameters, from one stream."""
    rng = np.random.default_rng([FIRST_SCORED_SEED, 77])
    rng.uniform(size=2)
    expected = CENTER + SPREAD * rng.standard_normal(3)
    case = random_case(Trial("circle", "light", FIRST_SCORED_SEED))
    assert case.pressure_error.parameters == pytest.approx(tuple(expected), rel=1e-12)
    assert tuple(CENTER) == PressureErrorSpec().parameters


def test_in_calm_air_twenty_flights_are_sensed_again_and_again():
    first, again = (random_case(Trial("circle", "none", FIRST_SCORED_SEED + n)) for n in (3, 23))
    assert (first.truth_seed, first.wind) == (again.truth_seed, again.wind)
    assert first.sensor_seed != again.sensor_seed
    assert first.pressure_error != again.pressure_error


def test_winds_are_no_stronger_than_stated():
    speeds = [random_case(Trial("circle", "light", seed)).wind.speed for seed in range(400)]
    assert max(speeds) <= STRONGEST_WIND
    assert np.mean(np.square(speeds)) == pytest.approx(0.5 * STRONGEST_WIND**2, rel=0.15)
