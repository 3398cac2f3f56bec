"""Logs of real recorders, read in place as the units wrote them, with no mapping."""

import gzip
import warnings

import numpy as np
import pytest
from tests.shared_data import real_log

from pitotbench import air, calibrate, read_log
from pitotbench.logbook.drafting import draft_mapping
from pitotbench.logbook.reading import read_table
from pitotbench.records import USUAL_ACCURACIES
from pitotbench.units import FOOT, KNOT


@pytest.mark.parametrize(
    ("name", "rows", "start", "told"),
    [
        (
            "c172s-g1000-2011.csv.gz",
            3966,
            "2011-08-12 14:59:07",
            "728 of 3966 time stamps repeat the one before",
        ),
        ("pa28-gifd-2024.csv.gz", 10678, "2024-07-20 12:25:12", "the first 2 rows are dropped"),
    ],
)
def test_garmin_logs_are_read_as_the_units_wrote_them(name, rows, start, told):
    """The airspeeds of the G1000 of 2011 jitter at rest, where they read 0 they are dropped."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        log = read_log(real_log("garmin", name))
    assert 0.85 * rows < len(log) <= rows
    assert log.header["start"] == start
    assert any(told in warning for warning in log.header["warnings"])
    assert not any("TOML" in warning for warning in log.header["warnings"])
    assert (
        sum(
            "made true by 'magnetic_variation_deg'" in warning for warning in log.header["warnings"]
        )
        == 1
    )
    assert log.time[0] >= 0.0
    fast = np.hypot(log.velocity_north, log.velocity_east) > 80.0 * KNOT
    indicated = air.calibrated_airspeed(log.impact_pressure)[fast]
    assert (
        np.abs(
            np.median(indicated) - np.median(np.hypot(log.velocity_north, log.velocity_east)[fast])
        )
        < 15 * KNOT
    )
    pressure_altitude = air.pressure_altitude(log.static_pressure)
    assert np.median(np.abs(pressure_altitude - log.altitude)) < 400.0 * FOOT


def test_the_spread_clock_agrees_with_the_path(tmp_path):
    """The distance between fixes, over the ground speed, is the time between rows: by the clock it
    is 0 to 2 s.
    """
    log = read_log(real_log("garmin", "c172s-g1000-2011.csv.gz"))
    speed = np.hypot(log.velocity_north, log.velocity_east)
    turning = np.hypot(np.diff(log.velocity_north), np.diff(log.velocity_east))
    steps = np.diff(log.time)[(speed[1:] > 50.0 * KNOT) & (turning < 3.0)]
    usual = steps[steps < 2.0]
    assert len(usual) > 0.98 * len(steps)
    assert 0.8 < usual.min() <= usual.max() < 1.5


@pytest.mark.parametrize("name", ["flight50-front", "flight52-front", "flight52-rear"])
def test_a_glider_recorder_in_the_stratosphere(name):
    """Its true airspeed stands for the pressures; people's names stay in the file."""
    path = real_log("perlan", f"{name}.igc.gz")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        log = read_log(path)
    assert len(log) > 18_000
    top = air.pressure_altitude(log.static_pressure).max()
    assert top == pytest.approx(19.05e3 if "50" in name else 23.3e3, abs=100.0)
    assert 200.0 < log.air_temperature.min() < 212.0
    assert log.header["air_data"] == "computer: true airspeed"
    assert log.header["glider"] == "Perlan 2"
    with gzip.open(
        path, "rt", errors="replace"
    ) as file:  # pilot, crew and registration of the recorder's header
        private = [
            line.split(":")[-1].strip()
            for line in file
            if line.startswith(("HFPLT", "HFCM2", "HFGID", "HOPLT"))
        ]
    assert private
    assert not any(text and text in str(log.header) for text in private)
    speed = air.true_airspeed(log.impact_pressure, log.static_pressure, log.air_temperature)
    assert 100.0 < speed.max() < 160.0
    assert log.header["start"].startswith("2018-08-26 15:54" if "50" in name else "2018-09-02 14:4")


def test_the_citation_is_recognized_and_its_velocity_comes_from_its_path():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        log = read_log(real_log("citation", "2019-03-12.parquet"))
    assert log.header["mapping"] == "citation"
    assert log.header["air_data"] == "computer: calibrated airspeed"
    assert log.header["start"] == "12:39:59"
    assert len(log) > 43_000
    assert log.header["accuracy"]["velocity_mps"] < USUAL_ACCURACIES["velocity_mps"] + 0.05
    flying = air.calibrated_airspeed(log.impact_pressure) > 120.0 * KNOT
    airspeed = air.true_airspeed(log.impact_pressure, log.static_pressure, log.air_temperature)[
        flying
    ]
    speed = np.hypot(log.velocity_north, log.velocity_east)[flying]
    assert np.quantile(np.abs(speed - airspeed), 0.99) < 60.0 * KNOT  # the wind of the day
    assert np.median(log.specific_force_z[flying]) == pytest.approx(-9.83, abs=0.05)
    # The first tenths of the Dutch roll, of the roll and of the pull-up: signs of the rates by the
    # surfaces.
    for start, rate, surface, sign in (
        (3363.5, log.yaw_rate, log.rudder, -1.0),
        (3063.5, log.roll_rate, log.aileron, 1.0),
        (3112.5, log.pitch_rate, log.elevator, -1.0),
    ):
        rows = (log.time - log.time[0] > start) & (log.time - log.time[0] < start + 1.7)
        assert sign * np.corrcoef(surface[rows], np.gradient(rate, log.time)[rows])[0, 1] > 0.6


@pytest.mark.parametrize(
    ("name", "asked"), [("c172s-g1000-2011", ("TRK", "HDG")), ("pa28-gifd-2024", ("HDG",))]
)
def test_a_garmin_log_is_drafted_with_the_one_question_that_it_leaves(name, asked):
    """Whether a direction is magnetic, as the variation beside it suggests: its name does not say
    so. The positions tell it of the track, where the variation is more than a delay in turns.
    """
    drafted = draft_mapping(read_table(real_log("garmin", f"{name}.csv.gz")))
    lines = {line.guess.theirs: line for line in drafted.lines}
    assert not drafted.unusable
    assert {lines["GndSpd"].guess.quantity, lines["IAS"].guess.quantity} == {
        "ground_speed",
        "indicated_airspeed",
    }
    assert asked == ("TRK", "HDG") or lines["TRK"].guess.target() == "magnetic_track_deg"
    for column in asked:
        assert lines[column].question.startswith("is it true, or magnetic as 'MagVar'")


def test_a_g3x_log_of_84_minutes_is_read_without_its_heading():
    """`test-data/log_test.csv` of eric-vickery/AirspeedCalibrator: velocities in whole m/s, blanks
    before the first fix and after the last; the sign of its variation is not that of other logs.
    """
    log = read_log(real_log("garmin", "log_test.csv"))
    assert log.header["mapping"] == "garmin_g3x"
    assert log.header["start"].startswith("2021-11-28")
    assert 4500 < len(log) < 5185
    told = " ".join(log.header["warnings"])
    assert "the finer 'ground_speed_kt' is used" in told
    assert "the axes are turned" not in told
    # By hand, in windows of steady flight: 2.5 to 3 % high at 120 KIAS.
    curve = calibrate(log).curve
    found, bound = (
        float(np.interp(120.0 * KNOT, curve.indicated_airspeed, values)) / KNOT
        for values in (curve.correction, curve.two_sigma)
    )
    assert abs(found + 3.3) < bound < 2.0
