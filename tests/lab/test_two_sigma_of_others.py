"""The 2σ results of the maneuvers that `tests/regression/test_two_sigma.py` leaves out stay where
they were too.
"""

import pytest
from tests.regression.test_two_sigma import OTHERS, compare, compare_light


@pytest.mark.parametrize("maneuver", OTHERS)
def test_smooth_air(maneuver, smooth_flights):
    compare(smooth_flights[maneuver])


@pytest.mark.parametrize("maneuver", OTHERS)
def test_light_turbulence(maneuver, light_flights):
    compare_light(light_flights[maneuver])
