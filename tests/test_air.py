"""Airspeed and atmosphere relations against published tables, an independent package, and
themselves.
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from openap import aero

from pitotbench import air
from pitotbench.units import FOOT, INCH_OF_MERCURY, KNOT

# U.S. Standard Atmosphere 1976, Table I (geopotential height m, K, Pa); identical to ICAO Doc 7488
# below 32 km.
STANDARD_ATMOSPHERE = [
    (0.0, 288.150, 101325.0),
    (1000.0, 281.650, 89874.6),
    (2000.0, 275.150, 79495.2),
    (5000.0, 255.650, 54019.9),
    (10000.0, 223.150, 26436.3),
    (11000.0, 216.650, 22632.1),
    (15000.0, 216.650, 12044.6),
    (20000.0, 216.650, 5474.89),
    (32000.0, 228.650, 868.019),
]
# The same, Table I by geometric height m, as it is printed above 20 km, and the radius of the Earth
# that it takes.
STRATOSPHERE = [(25e3, 221.552, 2549.2), (30e3, 226.509, 1197.0)]
EARTH_RADIUS = 6356766.0
# The same standard in feet and inches of mercury, as pressure altitudes are printed in altimeter
# test tables.
ALTIMETER_TABLE = [(5000, 24.896), (10000, 20.577), (20000, 13.750), (30000, 8.885)]
# NACA Report 1135 (Ames Research Staff, 1953), Table I: M, p/p_t, T/T_t.
COMPRESSIBLE_FLOW = [
    (0.20, 0.9725, 0.9921),
    (0.30, 0.9395, 0.9823),
    (0.50, 0.8430, 0.9524),
    (0.60, 0.7840, 0.9328),
    (0.80, 0.6560, 0.8865),
    (0.90, 0.5913, 0.8606),
]

heights = st.floats(-500.0, 32_000.0)
speeds = st.floats(5.0, 330.0)
pressures = st.floats(6e3, 108e3)
temperatures = st.floats(200.0, 330.0)


@pytest.mark.parametrize(("height", "temperature", "pressure"), STANDARD_ATMOSPHERE)
def test_standard_atmosphere_1976(height, temperature, pressure):
    assert air.standard_temperature(height) == pytest.approx(temperature, abs=1e-3)
    assert air.standard_pressure(height) == pytest.approx(pressure, rel=2e-5)
    assert air.pressure_altitude(pressure) == pytest.approx(height, abs=0.3)


def test_standard_stratosphere_1976_and_the_altimeter_table():
    for geometric, temperature, pressure in STRATOSPHERE:
        height = EARTH_RADIUS * geometric / (EARTH_RADIUS + geometric)
        assert air.standard_temperature(height) == pytest.approx(temperature, abs=1e-3)
        assert air.standard_pressure(height) == pytest.approx(pressure, rel=6e-5)
    for feet, inches in ALTIMETER_TABLE:
        assert air.standard_pressure(feet * FOOT) / INCH_OF_MERCURY == pytest.approx(
            inches, abs=6e-4
        )


@pytest.mark.parametrize(("mach", "pressure_ratio", "temperature_ratio"), COMPRESSIBLE_FLOW)
def test_naca_report_1135(mach, pressure_ratio, temperature_ratio):
    impact = air.impact_pressure_from_mach(mach, 50_000.0)
    assert 50_000.0 / (50_000.0 + impact) == pytest.approx(pressure_ratio, abs=5.1e-5)
    assert 250.0 / air.total_temperature(250.0, mach) == pytest.approx(
        temperature_ratio, abs=5.1e-5
    )


def test_source_figures_of_the_scale():
    """One knot is 2.0 % of q_c at 100 KCAS (0.030 kt a pascal) and 1.3 % at 160 (Martos et al.
    2011).
    """
    for knots, percent in ((100.0, 2.0), (160.0, 1.3)):
        q = air.impact_pressure(knots * KNOT)
        slope = air.calibrated_airspeed_slope(q) / KNOT
        assert 100.0 / (slope * q) == pytest.approx(percent, abs=0.05)
    assert air.calibrated_airspeed_slope(air.impact_pressure(100.0 * KNOT)) / KNOT == pytest.approx(
        0.030, abs=1e-3
    )


@given(speeds, st.floats(0.0, 11_000.0))
def test_openap_agrees(speed, height):
    """Calibrated to true airspeed on a standard day; the package's own constants differ in the
    fifth digit.
    """
    p, temperature = air.standard_pressure(height), air.standard_temperature(height)
    ours = air.true_airspeed(air.impact_pressure(speed), p, temperature)
    if ours < air.sound_speed(temperature):
        assert ours == pytest.approx(aero.cas2tas(speed, height), rel=2e-4)


@given(heights, speeds, pressures, temperatures)
def test_heights_and_airspeeds_invert(height, speed, pressure, temperature):
    assert air.pressure_altitude(air.standard_pressure(height)) == pytest.approx(height, abs=1e-6)
    assert air.calibrated_airspeed(air.impact_pressure(speed)) == pytest.approx(speed, rel=1e-11)
    q = air.impact_pressure_from_true_airspeed(speed, pressure, temperature)
    assert air.true_airspeed(q, pressure, temperature) == pytest.approx(speed, rel=1e-11)


@given(temperatures, st.floats(0.0, 0.95), st.floats(0.5, 1.0))
def test_the_temperature_of_a_probe_inverts(temperature, mach, recovery):
    probe = air.total_temperature(temperature, mach, recovery)
    assert probe >= temperature
    assert air.air_temperature(probe, mach, recovery) == pytest.approx(temperature, rel=1e-14)
    if mach > 0.01:
        speed = mach * air.sound_speed(temperature)
        assert air.mach_from_true_airspeed(speed, probe, recovery) == pytest.approx(mach, rel=1e-11)


@given(st.floats(20.0, 300.0))
def test_slope_is_the_derivative(speed):
    q = float(air.impact_pressure(speed))
    step = 1e-4 * q
    difference = (air.calibrated_airspeed(q + step) - air.calibrated_airspeed(q - step)) / (
        2.0 * step
    )
    assert air.calibrated_airspeed_slope(q) == pytest.approx(float(difference), rel=1e-6)


@pytest.mark.filterwarnings("error")
def test_at_the_ends():
    """½ρV² to first order: the plain formula would lose digits here, ours must not."""
    density = air.SEA_LEVEL_PRESSURE / (air.GAS_CONSTANT * air.SEA_LEVEL_TEMPERATURE)
    assert air.impact_pressure(0.01) == pytest.approx(0.5 * density * 1e-4, rel=1e-8)
    assert air.calibrated_airspeed(0.0) == 0.0
    # T_t/T = 1 + 0.2 r M²: at Mach 0.5 and r = 0.9 the 250 K air reads 261.25 K.
    assert air.total_temperature(250.0, 0.5, 0.9) == pytest.approx(261.25)
    # What is no pressure gives no number and no word.
    assert np.isnan(air.calibrated_airspeed(np.array([-50.0]))).all()
    assert np.isnan(air.pressure_altitude(np.array([0.0, -1.0]))).all()
