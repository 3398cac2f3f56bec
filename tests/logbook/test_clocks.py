"""Clocks as recorders write them, pauses of the recording, and several flights in one log."""

import gzip

import numpy as np
import pytest
from tests.logbook import sample_log as sample

from pitotbench import BadInputError, read_log
from pitotbench.logbook.flight_parts import flights_in
from pitotbench.timeline import minutes_text


def stamps_of(true: np.ndarray, tremble: float, seed: int) -> np.ndarray:
    """Whole seconds of a clock that is read late by up to `tremble` [s]; they never run back."""
    late = tremble * np.random.default_rng(seed).random(len(true))
    return np.maximum.accumulate(np.floor(true + late))


@pytest.mark.parametrize(
    ("interval", "tremble", "within"),
    [(0.1, 0.0, 0.3), (0.97, 0.0, 0.6), (1.0, 0.9, 0.5), (0.25, 0.6, 0.3)],
)
def test_rows_are_spread_over_the_whole_seconds_of_a_clock(interval, tremble, within, read):
    true = 7.3 + interval * np.arange(sample.ROWS)
    log = read({**sample.columns(), "time_s": stamps_of(true, tremble, 1)})
    assert len(log) == sample.ROWS
    off = log.time - true
    assert np.abs(off - np.median(off)).max() < within
    steps = np.diff(log.time)
    assert 0.5 * interval < steps.min() <= steps.max() < 1.5 * interval


def test_a_pause_between_whole_seconds_stays(read):
    true = 0.1 * np.arange(sample.ROWS) + np.where(np.arange(sample.ROWS) < 300, 0.0, 40.0)
    log = read({**sample.columns(), "time_s": np.floor(true)})
    assert np.abs(log.time - true - np.median(log.time - true)).max() < 0.5
    assert np.diff(log.time)[299] == pytest.approx(40.0, abs=1.0)


def local_clock(folder, offsets, above=""):
    """The sample at one row a second from 23:59:00 on a local clock, with its offset from UTC in
    each row.
    """
    from datetime import UTC, datetime, timedelta

    start = datetime(2024, 7, 21, 4, 59, tzinfo=UTC)
    table = sample.columns()
    local = [
        start + timedelta(seconds=row, hours=float(offset[:3]))
        for row, offset in enumerate(offsets)
    ]
    del table["time_s"]
    table = {
        "date": np.array([f"{moment:%Y-%m-%d}" for moment in local]),
        "clock_time": np.array([f"{moment:%H:%M:%S}" for moment in local]),
        "utc_offset": np.array(offsets),
        **table,
    }
    return sample.write(folder / "log.csv", table, above)


def test_a_zone_that_is_left_in_flight_sets_no_clock_back_and_one_that_is_none_is_refused(tmp_path):
    log = read_log(local_clock(tmp_path, ["-05:00"] * 300 + ["-06:00"] * 300))
    np.testing.assert_allclose(log.time, np.arange(sample.ROWS))
    assert log.header["start"] == "2024-07-21 04:59:00"
    with pytest.raises(BadInputError, match=r"'utc_offset', row 1: '-05h' is no offset from UTC"):
        read_log(local_clock(tmp_path, ["-05h"] * sample.ROWS))


def test_seconds_since_1970_count_from_the_first_row(read):
    table = sample.columns()
    table["time_s"] = 1313144657.0 + table["time_s"]
    log = read(table)
    assert (log.time[0], log.time[-1]) == pytest.approx((0.0, 59.9))
    assert log.header["start"] == "2011-08-12 10:24:17"


def test_a_packed_log_is_read_as_it_is(tmp_path):
    plain = sample.write(tmp_path / "log.csv", sample.columns())
    packed = tmp_path / "log.csv.gz"
    packed.write_bytes(gzip.compress(plain.read_bytes()))
    np.testing.assert_array_equal(read_log(packed).time, read_log(plain).time)
    packed.write_bytes(packed.read_bytes()[:-100])
    with pytest.raises(BadInputError, match="not a complete gzip file"):
        read_log(packed)


def test_minutes_of_a_log():
    assert [minutes_text(seconds) for seconds in (0.0, 65.4, 3599.6)] == ["0:00", "1:05", "60:00"]


HALF = sample.ROWS // 2


def paused(seconds, row=HALF):
    """The sample log with its clock put on by some seconds from a row on, and no labels."""
    table = {name: values for name, values in sample.columns().items() if name != "segment"}
    return {**table, "time_s": table["time_s"] + seconds * (np.arange(sample.ROWS) >= row)}


def read_paused(tmp_path, table):
    log = read_log(sample.write(tmp_path / "log.csv", table))
    return log, log.header.get("warnings", [])


def test_two_flights_an_hour_apart_are_said_and_parted(tmp_path):
    log, warnings = read_paused(tmp_path, paused(3600.0))
    assert len(warnings) == 1
    assert "seems to hold 2 flights" in warnings[0]
    assert f"before row {HALF + 1};" in warnings[0]
    first, second = flights_in(log)
    assert (len(first), len(second)) == (HALF, sample.ROWS - HALF)
    np.testing.assert_array_equal(np.concatenate([first.time, second.time]), log.time)


def test_sessions_of_two_days_in_one_file_are_two_flights(tmp_path):
    log, warnings = read_paused(tmp_path, paused(2.0 * 86400.0))
    assert "'time_s' jumps by more than a day before row 301" in warnings[0]
    assert [len(flight) for flight in flights_in(log)] == [HALF, sample.ROWS - HALF]
    # Within a recording the clock goes on as it was written.
    steps = np.diff(log.time)
    np.testing.assert_allclose(np.delete(steps, HALF - 1), 0.1, atol=1e-6)
    assert steps[HALF - 1] < 3600.0


def test_a_pause_of_half_a_minute_is_mentioned_and_parts_no_flight(tmp_path):
    log, warnings = read_paused(tmp_path, paused(30.0))
    assert warnings == [f"the recording pauses once, for up to 30 s, before row {HALF + 1}"]
    assert flights_in(log) == [log]
    # Where the segment changes it is meant, and rows that were dropped are none.
    segment = sample.columns()["segment"]
    assert segment[HALF - 1] != segment[HALF]
    assert read_paused(tmp_path, {**paused(30.0), "segment": segment})[1] == []
    table = paused(0.0)
    table["static_pressure_pa"][100:150] = np.nan
    (warning,) = read_paused(tmp_path, table)[1]
    assert "50 of 600 values are not numbers" in warning


@pytest.mark.parametrize("name", ["static_pressure_pa", "impact_pressure_pa"])
def test_equal_values_before_and_after_a_pause_are_not_stuck(tmp_path, name):
    table = paused(30.0)
    table[name][HALF] = table[name][HALF - 1]
    assert len(read_paused(tmp_path, table)[0]) == sample.ROWS


def test_a_receiver_that_fails_once_between_sparse_fixes_is_held_elsewhere(tmp_path):
    """One fix in ten rows, and twenty seconds without: only the failure is skipped."""
    table = paused(0.0)
    rows = np.arange(sample.ROWS)
    stale = (rows % 10 != 0) | ((rows >= 200) & (rows < 400))
    for name in ("velocity_north_mps", "velocity_east_mps", "velocity_down_mps", "altitude_m"):
        table[name] = np.where(stale, np.nan, table[name])
    log, warnings = read_paused(tmp_path, table)
    assert 380 <= len(log) <= 420
    assert any("values are not numbers" in w and "% of the log" in w for w in warnings)
    assert log.gps_fresh.sum() == 40
