"""Minutes of a log that are left out: which rows go, and what is refused."""

from pathlib import Path

import numpy as np
import pytest
from tests.logbook import sample_log

from pitotbench.logbook.assembly import part_of
from pitotbench.logbook.reading import read_log
from pitotbench.records import BadInputError


def test_the_rows_between_two_moments_go_and_all_others_stay(tmp_path: Path) -> None:
    path = sample_log.write(tmp_path / "log.csv", sample_log.columns())
    whole = read_log(path)
    part = read_log(path, part=part_of("0:05", "0:50", ["0:10-0:20", "30-0:35"]))
    time = whole.time - whole.start
    left = (time >= 5.0) & (time <= 50.0)
    left &= ~((time >= 10.0) & (time <= 20.0)) & ~((time >= 30.0) & (time <= 35.0))
    np.testing.assert_array_equal(part.time, whole.time[left])
    np.testing.assert_array_equal(part.impact_pressure, whole.impact_pressure[left])
    assert part.start == whole.start


@pytest.mark.parametrize(
    ("spans", "words"),
    [
        (["0:10"], r"--without '0:10': give two moments, such as 14:00-15:30"),
        (["0:10-soon"], "--without 'soon': give minutes and seconds"),
        (["0:00-2:00"], "no rows remain; the log runs from 0:00 to 1:00"),
    ],
)
def test_what_leaves_nothing_or_is_no_span_is_refused(
    tmp_path: Path, spans: list[str], words: str
) -> None:
    path = sample_log.write(tmp_path / "log.csv", sample_log.columns())
    with pytest.raises(BadInputError, match=words):
        read_log(path, part=part_of(None, None, spans))
