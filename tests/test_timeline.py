"""Gaps, pauses and fresh fixes of a time base."""

import numpy as np
import pytest

from pitotbench.timeline import fresh_fixes, gaps, interval, pauses, stretch_numbers, stretches

TIME = np.arange(1000) / 50.0


def without(*lost: slice) -> np.ndarray:
    kept = np.ones(len(TIME), dtype=np.bool_)
    for rows in lost:
        kept[rows] = False
    return TIME[kept]


def test_a_regular_time_base_is_one_stretch():
    assert stretches(TIME, gaps(TIME)) == [slice(0, 1000)]
    assert len(pauses(TIME)) == 0


def test_one_lost_sample_is_a_gap_and_no_pause():
    time = without(slice(400, 401))
    assert stretches(time, gaps(time)) == [slice(0, 400), slice(400, 999)]
    assert len(pauses(time)) == 0


@pytest.mark.parametrize(("seconds", "count"), [(1.9, 0), (2.1, 1)])
def test_at_a_high_rate_a_pause_is_longer_than_two_seconds(seconds, count):
    time = np.where(np.arange(1000) < 400, TIME, TIME + seconds)
    assert len(pauses(time)) == count


@pytest.mark.parametrize(("lost", "count"), [(4, 0), (5, 1)])
def test_at_a_low_rate_a_pause_is_longer_than_five_samples(lost, count):
    time = np.delete(np.arange(100.0), slice(50, 50 + lost))
    assert len(pauses(time)) == count


def test_gaps_do_not_move_the_interval():
    assert interval(without(slice(100, 900), slice(950, 990))) == pytest.approx(0.02)


def test_rows_are_numbered_by_their_stretch():
    time = without(slice(300, 500), slice(900, 1000))
    numbers = stretch_numbers(time, pauses(time))
    np.testing.assert_array_equal(numbers, np.repeat([0, 1], [300, 400]))


@pytest.mark.parametrize("rows", [0, 1])
def test_too_few_rows_for_a_step_have_no_gap(rows):
    assert len(gaps(TIME[:rows])) == len(pauses(TIME[:rows])) == 0


def test_a_fix_is_fresh_where_the_log_marks_it():
    marked = np.array([True, False, True])
    np.testing.assert_array_equal(fresh_fixes(marked, np.zeros(3), np.zeros(3)), marked)


def test_without_a_mark_a_fix_is_fresh_where_either_velocity_changes():
    north, east = np.array([1.0, 1.0, 2.0, 2.0]), np.array([5.0, 5.0, 5.0, 6.0])
    np.testing.assert_array_equal(fresh_fixes(None, north, east), [True, False, True, True])
