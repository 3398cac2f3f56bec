"""What is plausible stays without a word, on whatever headings and in whatever wind it was flown."""

import numpy as np
import pytest
from tests.logbook import sample_log as sample

from pitotbench import air
from pitotbench.logbook.plausible_air import LIMITS
from pitotbench.logbook.reading import read_log
from pitotbench.records import BadInputError
from pitotbench.units import KNOT

TIME = np.arange(sample.ROWS) / sample.RATE


def flown(heading, speed=65.0, wind=(5.0, -6.0), height=1830.0, temperature=276.3):
    """The sample log with other headings [rad], airspeed [m/s], wind toward north and east [m/s], height [m]."""
    rng = np.random.default_rng(7)
    table = sample.columns()
    speed = speed * (1.0 + 0.1 * np.sin(TIME / 20.0)) + 0.2 * rng.standard_normal(sample.ROWS)
    mach = speed / air.sound_speed(temperature)
    static = air.standard_pressure(height) + 3.0 * rng.standard_normal(sample.ROWS)
    probe = air.total_temperature(temperature, mach) + 0.1 * rng.standard_normal(sample.ROWS)
    return table | {
        "impact_pressure_pa": air.impact_pressure_from_mach(mach, static),
        "static_pressure_pa": static,
        "total_temperature_k": probe,
        "altitude_m": height + rng.standard_normal(sample.ROWS),
        "heading_rad": heading % (2.0 * np.pi),
        "velocity_north_mps": speed * np.cos(heading) + wind[0] + 0.05 * rng.standard_normal(sample.ROWS),
        "velocity_east_mps": speed * np.sin(heading) + wind[1] + 0.05 * rng.standard_normal(sample.ROWS),
    }


def said(tmp_path, table):
    return read_log(sample.write(tmp_path / "log.csv", table)).header.get("warnings", [])


CIRCLE, SOUTH = TIME / 9.0, np.full(sample.ROWS, np.pi)
OUT_AND_BACK = np.where(TIME < 30.0, 0.6, 0.6 + np.pi)

GOOD = {
    "a circle": flown(CIRCLE),
    "a circle in 60 kt of wind": flown(CIRCLE, wind=(-60.0 * KNOT, 0.0)),
    "one heading with 40 kt of tail wind": flown(SOUTH, wind=(-40.0 * KNOT, 0.0)),
    "out and back": flown(OUT_AND_BACK, wind=(12.0, 3.0)),
    "a jet in a jet stream": flown(CIRCLE / 4.0, 220.0, (45.0, 50.0), 9000.0, 230.0),
    "a small airplane in a wind of half its speed": flown(CIRCLE, 14.0, (7.0, 0.0), 100.0, 285.0),
    "a day 25 K above standard": flown(CIRCLE, temperature=301.0),
    "a day 25 K below standard": flown(CIRCLE, temperature=251.0),
}


@pytest.mark.parametrize("name", list(GOOD))
def test_a_good_log_has_no_warning(tmp_path, name):
    assert said(tmp_path, GOOD[name]) == []


@pytest.mark.parametrize("name", ["a circle", "out and back", "a jet in a jet stream"])
def test_knots_are_named_on_several_headings(tmp_path, name):
    table = dict(GOOD[name])
    for axis in ("north", "east"):
        table[f"velocity_{axis}_mps"] = table[f"velocity_{axis}_mps"] / KNOT
    with pytest.raises(
        BadInputError, match="look like knots: name the columns velocity_north_kt and velocity_east_kt"
    ):
        said(tmp_path, table)


def test_a_zero_that_a_small_gauge_may_have_is_warned_of_and_named(tmp_path):
    table = dict(GOOD["a small airplane in a wind of half its speed"])
    table["impact_pressure_pa"] = table["impact_pressure_pa"] + 100.0
    assert any("zero offset" in words for words in said(tmp_path, table))


def test_weather_moves_the_static_pressure_of_a_height(tmp_path):
    """A low of 980 hPa: 280 m of pressure altitude."""
    table = dict(GOOD["a circle"])
    table["altitude_m"] = table["altitude_m"] - 280.0
    assert said(tmp_path, table) == []


def test_a_height_above_the_field_is_doubted_and_not_refused(tmp_path):
    table = dict(GOOD["a circle"])
    table["altitude_m"] = table["altitude_m"] - 1000.0
    assert any("no weather explains that" in words for words in said(tmp_path, table))


def test_no_day_is_so_warm(tmp_path):
    with pytest.raises(BadInputError, match="70 K warmer than on a standard day"):
        said(tmp_path, flown(CIRCLE, height=8000.0, temperature=236.2 + 70.0))


def test_a_change_of_the_pitot_gain_in_flight_is_warned_of(tmp_path):
    table = dict(GOOD["a circle"])
    table["impact_pressure_pa"] = table["impact_pressure_pa"] * np.where(TIME < 30.0, 1.0, 1.3)
    assert any("from the first to the second half" in words for words in said(tmp_path, table))


def test_a_log_without_height_heading_or_temperature_is_still_checked(tmp_path):
    needed = ("time_s", "impact_pressure_pa", "static_pressure_pa", "velocity_north_mps", "velocity_east_mps")
    table = {name: GOOD["a circle"][name] for name in needed}
    assert said(tmp_path, table) == []
    table["impact_pressure_pa"] = table["impact_pressure_pa"] * 2.0
    with pytest.raises(BadInputError, match="twice the impact pressure"):
        said(tmp_path, table)


def test_the_limits_keep_their_order():
    assert LIMITS.curve_doubted < LIMITS.curve_refused
    assert LIMITS.temperature_doubted < LIMITS.temperature_refused
    assert LIMITS.misfit_doubted < LIMITS.misfit_refused
