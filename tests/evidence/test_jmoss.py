"""A jet's log against a weather balloon (JMOSS test data, Jurado and McGehee): independent truth.

The balloon's wind over the flight's height band: CLASS55 26.0 kt toward north and 4.8 kt toward east, CLASS65 35.6
and 8.4 kt. Its Δp/q_ci: 0.034 to 0.040 for Mach 0.6 to 0.9. The published tool finds 29.7, 5.3 and 34.2, 10.6 kt.
"""

import numpy as np
import pytest
from shared_data import real_log

from pitotbench.calibrate import CalibrationOptions, calibrate
from pitotbench.logbook import read_log
from pitotbench.units import KNOT

BALLOON_KT = {"CLASS55": (26.0, 4.8), "CLASS65": (35.6, 8.4)}
BALLOON_ERROR = (0.034, 0.040)
OPTIONS = CalibrationOptions(model="quadratic", mach_max=0.93, error_location="static")


@pytest.fixture(scope="module", params=sorted(BALLOON_KT))
def flight(request):
    path = real_log("jmoss", f"{request.param}.csv")
    return request.param, calibrate(read_log(path, mapping="jmoss"), OPTIONS)


def test_wind_is_near_the_balloon(flight):
    """Within 7 kt of the balloon, component by component; the printed difference is the evidence."""
    name, result = flight
    found = np.array([result.wind.north.value, result.wind.east.value]) / KNOT
    print(
        f"{name}: wind toward N, E {found.round(1)} kt, balloon {BALLOON_KT[name]}, "
        f"2σ {result.wind.north.two_sigma / KNOT:.1f}, {result.wind.east.two_sigma / KNOT:.1f} kt"
    )
    assert np.all(np.abs(found - BALLOON_KT[name]) < 7.0)


def test_bound_is_honest_about_colored_residuals(flight):
    """The white bound is a few hundredths of a knot here; the balloon is knots away."""
    _, result = flight
    assert result.wind.north.two_sigma > 10.0 * 0.07 * KNOT
    assert np.all(result.curve.two_sigma > 5.0 * result.curve.white_two_sigma)


def test_pressure_error_agrees_with_the_balloon(flight):
    """Δp/q_c inside the balloon's band within the bound, at every airspeed of the curve."""
    _, result = flight
    curve = result.curve
    ratio = curve.normalized_pressure_error
    indicated = ratio / (1.0 - ratio)  # Δp/q_ci
    low, high = BALLOON_ERROR
    middle = slice(len(indicated) // 4, 3 * len(indicated) // 4)
    slack = curve.normalized_two_sigma[middle] + 0.002
    assert np.all(indicated[middle] > low - slack)
    assert np.all(indicated[middle] < high + slack)
