"""A jet's log against a weather balloon (JMOSS test data, Jurado and McGehee): independent truth.

The balloon's wind over the flight's height band: CLASS55 26.0 kt toward north and 4.8 kt toward
east, CLASS65 35.6 and 8.4 kt. Its Δp/q_ci: 0.034 to 0.040 for Mach 0.6 to 0.9. The published tool
finds 29.7, 5.3 and 34.2, 10.6 kt.
"""

import re
from dataclasses import replace

import numpy as np
import pytest
from tests.shared_data import real_log

from pitotbench import CalibrationOptions, air, read_log
from pitotbench.calibration import calibrate
from pitotbench.calibration.options import Accuracies
from pitotbench.units import KNOT

BALLOON_KT = {"CLASS55": (26.0, 4.8), "CLASS65": (35.6, 8.4)}
BALLOON_ERROR = (0.034, 0.040)
OPTIONS = CalibrationOptions(model="quadratic", mach_max=0.93, error_location="static")


BY_HEIGHT = {  # Δp/q_c at 260, 300, 340, 380, 420 KIAS: indicated pressure less the balloon's at the GPS height
    "CLASS55": (0.032, 0.035, 0.035, 0.035, 0.035),
    "CLASS65": (0.036, 0.037, 0.036, 0.036, 0.037),
}


def _log(name, **changes):
    """The log; without its height it serves the wind triangle alone."""
    return replace(read_log(real_log("jmoss", f"{name}.csv"), mapping="jmoss"), **changes)


@pytest.fixture(scope="module", params=sorted(BALLOON_KT))
def flight(request):
    return request.param, calibrate(_log(request.param, altitude=None), OPTIONS)


def test_wind_is_near_the_balloon_and_the_bound_honest_about_colored_residuals(flight):
    """Within 7 kt of the balloon, component by component; the printed difference is the evidence.

    The white bound is a few hundredths of a knot here; the balloon is knots away.
    """
    name, result = flight
    found = np.array([result.wind.north.value, result.wind.east.value]) / KNOT
    print(
        f"{name}: wind toward N, E {found.round(1)} kt, balloon {BALLOON_KT[name]}, "
        f"2σ {result.wind.north.two_sigma / KNOT:.1f}, {result.wind.east.two_sigma / KNOT:.1f} kt"
    )
    assert np.all(np.abs(found - BALLOON_KT[name]) < 7.0)
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


def _balloon_temperature(pressure):
    """Air temperature [K] that the balloon measured at static pressures [Pa]."""
    lines = real_log("jmoss", "WB.txt").read_text(encoding="latin-1").splitlines()
    rows = [line.split() for line in lines if re.match(r"^\s*\d{4,6}\s+\d", line)]
    celsius, hectopascal = np.array([(float(row[4]), float(row[6])) for row in rows]).T
    return np.interp(-pressure, -100.0 * hectopascal, celsius) + 273.15


@pytest.mark.parametrize(("name", "low", "high"), [("CLASS55", -1.0, 1.0), ("CLASS65", 1.5, 4.0)])
def test_no_residual_shows_how_far_the_probe_is_off(name, low, high):
    """Against the balloon at the same pressure: nearly right on one flight, 2.7 K too warm on the
    other.
    """
    log = _log(name, altitude=None)
    mach = air.mach_from_impact_pressure(log.impact_pressure, log.static_pressure)
    offset = log.total_temperature / (1.0 + 0.2 * mach**2) - _balloon_temperature(
        log.static_pressure
    )
    offset = offset[mach < 0.8]
    print(f"{name}: probe minus balloon {offset.mean():+.2f} ± {offset.std():.2f} K")
    assert low < offset.mean() < high
    warmer = replace(log, total_temperature=log.total_temperature - offset.mean())
    plain, corrected = (calibrate(each, OPTIONS) for each in (log, warmer))
    assert corrected.residual_two_sigma == pytest.approx(plain.residual_two_sigma, rel=0.01)
    stated = calibrate(log, replace(OPTIONS, accuracies=Accuracies(temperature_k=5.0)))
    difference = np.abs(corrected.curve.correction - plain.curve.correction)
    assert np.all(difference < stated.curve.two_sigma)


def test_the_air_data_of_one_log_trail_the_gps():
    """Half a second, seen in planned accelerations of CLASS65; CLASS55 holds too few to tell."""
    options = replace(OPTIONS, wind="drifting", latency="checked")
    for name, significant in (("CLASS65", True), ("CLASS55", False)):
        result = calibrate(_log(name, altitude=None), options)
        found = result.diagnostics.latency
        latency, bound = found.value, found.two_sigma
        print(f"{name}: latency of the GPS {latency:+.2f} ± {bound:.2f} s (2σ)")
        assert (abs(latency) > bound) == significant
        assert abs(latency + 0.5) < bound


_SURE = (
    "its curve lies 0.012 to 0.023 below the balloon's, 1.4 to 1.5 times the 2σ: the heights of this "
    "log pull the curve down, and the smooth curve does not contradict them"
)


@pytest.mark.parametrize(
    "name", ["CLASS55", pytest.param("CLASS65", marks=pytest.mark.xfail(reason=_SURE, strict=True))]
)
def test_height_and_triangle_together_hold_the_curve_of_the_balloon(name):
    """Below Mach 0.8, where the curve is flat, with a temperature that may be 5 K off."""
    options = CalibrationOptions(
        model="smooth", mach_max=0.8, accuracies=Accuracies(temperature_k=5.0)
    )
    result = calibrate(_log(name), options)
    curve, places = result.curve, np.array([260.0, 300.0, 340.0, 380.0]) * KNOT
    found = np.interp(places, curve.indicated_airspeed, curve.normalized_pressure_error)
    bound = np.interp(places, curve.indicated_airspeed, curve.normalized_two_sigma)
    print(
        f"{name}: {result.error_location}, Δp/q_c {found.round(4)} ± {bound.round(4)}, balloon "
        f"{BY_HEIGHT[name]}"
    )
    assert result.error_location == "static"
    assert np.all(np.abs(found - BY_HEIGHT[name][:4]) < bound)


@pytest.mark.parametrize("name", sorted(BALLOON_KT))
def test_the_height_shows_what_the_triangle_hides(name):
    """A quadratic up to Mach 0.93 cannot follow the transonic rise; of a doubtful total source the
    height would owe less.
    """
    exact = replace(OPTIONS, accuracies={"total_source": 0.0})
    assert "height" in [each.kind for each in calibrate(_log(name), exact).disagreements]
