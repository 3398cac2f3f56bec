"""Pauses of the recording and several flights in one log."""

import numpy as np
import pytest
from tests.logbook import sample_log as sample

from pitotbench.logbook.checks import flights_in
from pitotbench.logbook.reading import read_log

HALF = sample.ROWS // 2


def paused(seconds, row=HALF):
    """The sample log with its clock put on by some seconds from a row on, and no labels."""
    table = {name: values for name, values in sample.columns().items() if name != "segment"}
    return {**table, "time_s": table["time_s"] + seconds * (np.arange(sample.ROWS) >= row)}


def read(tmp_path, table):
    log = read_log(sample.write(tmp_path / "log.csv", table))
    return log, log.header.get("warnings", [])


def test_two_flights_an_hour_apart_are_said_and_parted(tmp_path):
    log, warnings = read(tmp_path, paused(3600.0))
    assert len(warnings) == 1
    assert "seems to hold 2 flights" in warnings[0]
    assert f"before row {HALF + 1};" in warnings[0]
    first, second = flights_in(log)
    assert (len(first), len(second)) == (HALF, sample.ROWS - HALF)
    np.testing.assert_array_equal(np.concatenate([first.time, second.time]), log.time)


def test_a_pause_of_half_a_minute_is_mentioned_and_parts_no_flight(tmp_path):
    log, warnings = read(tmp_path, paused(30.0))
    assert warnings == [f"the recording pauses once, for up to 30 s, before row {HALF + 1}"]
    assert flights_in(log) == [log]
    # Where the segment changes it is meant, and rows that were dropped are none.
    segment = sample.columns()["segment"]
    assert segment[HALF - 1] != segment[HALF]
    assert read(tmp_path, {**paused(30.0), "segment": segment})[1] == []
    table = paused(0.0)
    table["static_pressure_pa"][100:150] = np.nan
    (warning,) = read(tmp_path, table)[1]
    assert "50 of 600 values are not numbers" in warning


@pytest.mark.parametrize("name", ["static_pressure_pa", "impact_pressure_pa"])
def test_equal_values_before_and_after_a_pause_are_not_stuck(tmp_path, name):
    table = paused(30.0)
    table[name][HALF] = table[name][HALF - 1]
    assert len(read(tmp_path, table)[0]) == sample.ROWS


def test_a_receiver_that_fails_once_between_sparse_fixes_is_held_elsewhere(tmp_path):
    """One fix in ten rows, and twenty seconds without: only the failure is skipped."""
    table = paused(0.0)
    rows = np.arange(sample.ROWS)
    stale = (rows % 10 != 0) | ((rows >= 200) & (rows < 400))
    for name in ("velocity_north_mps", "velocity_east_mps", "velocity_down_mps", "altitude_m"):
        table[name] = np.where(stale, np.nan, table[name])
    log, warnings = read(tmp_path, table)
    assert 380 <= len(log) <= 420
    assert any("values are not numbers" in w and "% of the log" in w for w in warnings)
    assert log.gps_fresh.sum() == 40
