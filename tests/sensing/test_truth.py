"""The truth beside the log: whole, and never mistaken for a log."""

import numpy as np
import pytest
from tests.sensing import synthetic_flight as fixture

from pitotbench.logbook.formats import write_log
from pitotbench.logbook.reading import read_log
from pitotbench.records import BadInputError
from pitotbench.records.case import Case, EffectSpec
from pitotbench.sensing.recorder import read_truth, record, truth_path, write_truth
from pitotbench.sensing.sampling import SYSTEMS


def test_truth_reads_back(tmp_path):
    flight = fixture.flight(case=Case(effects=(EffectSpec("lag", {"lag_s": 0.3}),)))
    path = write_truth(flight, tmp_path / "log.csv")
    assert path == tmp_path / "log.truth.parquet" == truth_path(tmp_path / "log.csv")
    back = read_truth(path)
    assert back.case == flight.case
    assert set(back.channels) == set(flight.channels)
    for name, values in flight.channels.items():
        np.testing.assert_array_equal(back[name], values, err_msg=name)
    np.testing.assert_array_equal(back.segment, flight.segment)
    np.testing.assert_array_equal(back.on_condition, flight.on_condition)


def test_writing_a_log_writes_no_truth(tmp_path):
    write_log(record(fixture.flight(), SYSTEMS["20/1"], 1), tmp_path / "log.parquet")
    assert [p.name for p in tmp_path.iterdir()] == ["log.parquet"]


def test_a_truth_file_is_no_log(tmp_path):
    path = write_truth(fixture.flight(), tmp_path / "log.csv")
    with pytest.raises(BadInputError, match="missing columns"):
        read_log(path)


def test_a_log_is_no_truth(tmp_path):
    path = write_log(record(fixture.flight(), SYSTEMS["20/1"], 1), tmp_path / "log.parquet")
    with pytest.raises(BadInputError, match="not a truth file"):
        read_truth(path)
    with pytest.raises(BadInputError, match="not a truth file"):
        read_truth(tmp_path / "none.truth.parquet")
