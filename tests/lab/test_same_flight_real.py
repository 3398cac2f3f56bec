"""Real logs that are given twice, and the two recorders of a glider."""

from dataclasses import replace

import numpy as np
from tests.shared_data import real_log

from pitotbench import calibrate, read_log, write_log
from pitotbench.logbook.same_flight import distinct, recorders


def test_a_real_log_and_its_copy_are_one_and_its_two_recorders_are_told(tmp_path):
    path = real_log("garmin", "c172s-g1000-2011.csv.gz")
    log = read_log(path)
    copy = read_log(write_log(log, tmp_path / "copy.parquet"))
    later = replace(log, header={**log.header, "start": "2011-08-13 14:59:07"})
    assert distinct([log, copy], ["a", "b"]).logs == (log,)
    assert len(distinct([log, replace(later, time=log.time + 5.0)], ["a", "b"]).logs) == 1
    front, rear = (
        read_log(real_log("perlan", f"flight50-{seat}.igc.gz")) for seat in ("front", "rear")
    )
    assert distinct([front, rear], ["a", "b"]).logs == (front, rear)
    assert recorders([front, rear, log]) == [(0, 1)]


def test_a_real_log_given_twice_has_the_answer_of_one(tmp_path):
    path = real_log("garmin", "c172s-g1000-2011.csv.gz")
    log = read_log(path)
    once = calibrate(log)
    for found in calibrate([log, write_log(log, tmp_path / "copy.parquet")]):
        assert np.array_equal(found.curve.correction, once.curve.correction)
        assert np.array_equal(found.curve.two_sigma, once.curve.two_sigma)
