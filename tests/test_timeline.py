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


def test_gaps_part_stretches_and_move_no_interval():
    assert stretches(TIME, gaps(TIME)) == [slice(0, 1000)]
    assert len(pauses(TIME)) == 0
    time = without(slice(400, 401))  # one lost sample is a gap and no pause
    assert stretches(time, gaps(time)) == [slice(0, 400), slice(400, 999)]
    assert len(pauses(time)) == 0
    assert interval(without(slice(100, 900), slice(950, 990))) == pytest.approx(0.02)
    time = without(slice(300, 500), slice(900, 1000))
    np.testing.assert_array_equal(
        stretch_numbers(time, pauses(time)), np.repeat([0, 1], [300, 400])
    )


@pytest.mark.parametrize(
    ("time", "count"),
    [
        # At a high rate a pause is longer than two seconds, at a low one longer than five samples.
        *(
            (TIME + np.where(np.arange(1000) < 400, 0.0, seconds), int(seconds > 2.0))
            for seconds in (1.9, 2.1)
        ),
        *((np.delete(np.arange(100.0), slice(50, 50 + lost)), int(lost > 4)) for lost in (4, 5)),
        *((TIME[:rows], 0) for rows in (0, 1)),
    ],
)
def test_a_pause_is_longer_than_two_seconds_and_five_samples(time, count):
    assert len(pauses(time)) == count
    assert len(time) > 1 or len(gaps(time)) == 0


def test_a_fix_is_fresh_where_the_log_marks_it_or_else_where_either_velocity_changes():
    marked = np.array([True, False, True])
    np.testing.assert_array_equal(fresh_fixes(marked, np.zeros(3), np.zeros(3)), marked)
    north, east = np.array([1.0, 1.0, 2.0, 2.0]), np.array([5.0, 5.0, 5.0, 6.0])
    np.testing.assert_array_equal(fresh_fixes(None, north, east), [True, False, True, True])
