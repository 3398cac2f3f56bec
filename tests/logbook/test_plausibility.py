"""What is plausible stays without a word, on whatever headings and in whatever wind it was flown."""

import numpy as np
import pytest
from tests.logbook import sample_log as sample
from tests.logbook.bad_logs import GOOD, NEEDED, TIME

from pitotbench.logbook.reading import read_log


def said(tmp_path, table):
    return read_log(sample.write(tmp_path / "log.csv", table)).header.get("warnings", [])


@pytest.mark.parametrize("name", list(GOOD))
def test_a_good_log_has_no_warning(tmp_path, name):
    assert said(tmp_path, GOOD[name]) == []


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


def test_a_change_of_the_pitot_gain_in_flight_is_warned_of(tmp_path):
    table = dict(GOOD["a circle"])
    table["impact_pressure_pa"] = table["impact_pressure_pa"] * np.where(TIME < 30.0, 1.0, 1.3)
    assert any("from the first to the second half" in words for words in said(tmp_path, table))


def test_a_good_log_without_height_heading_or_temperature_has_no_warning(tmp_path):
    assert said(tmp_path, {name: GOOD["a circle"][name] for name in NEEDED}) == []
