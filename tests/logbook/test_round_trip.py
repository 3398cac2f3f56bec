"""Whatever is written reads back equal, in every format; nothing is ever half written."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from tests.logbook import sample_log as sample
from tests.logbook.bad_logs import NEEDED

from pitotbench import BadInputError, FlightLog, read_log, write_log
from pitotbench.logbook.formats import FORMATS

HEADER = {
    "format": "pitotbench flight log 1",
    "seeds": {"truth": 1, "sensor": 2},
    "case": {"aircraft": "navajo", "card": {}, "das": {"air_rate_hz": 33.3, "name": "33.3/7"}},
    "note": 'quotes " and # marks, äöü',
}
formats = pytest.mark.parametrize("suffix", list(FORMATS))


def assert_equal(one: FlightLog, two: FlightLog) -> None:
    assert set(one.channels()) == set(two.channels())
    for name, values in one.channels().items():
        np.testing.assert_array_equal(values, getattr(two, name), err_msg=name)
    assert dict(one.header) == dict(two.header)


@formats
@pytest.mark.parametrize("names", [None, ("time", *(q.rpartition("_")[0] for q in NEEDED[1:]))])
def test_a_whole_and_a_minimal_log(tmp_path, suffix, names):
    log = replace(sample.log(), header=HEADER)
    log = log if names is None else FlightLog(**{name: getattr(log, name) for name in names})
    assert_equal(read_log(write_log(log, tmp_path / f"log{suffix}")), log)


@formats
@settings(max_examples=5, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(values=st.lists(st.floats(-250.0, 250.0), min_size=90, max_size=90))
def test_every_digit(tmp_path, suffix, values):
    rows = 6 * np.arange(90)
    log = replace(
        sample.log().select(rows), velocity_down=np.array(values), gps_fresh=np.array(values) > 0.0
    )
    back = read_log(write_log(log, tmp_path / f"log{suffix}"))
    np.testing.assert_array_equal(back.velocity_down, log.velocity_down)
    np.testing.assert_array_equal(back.gps_fresh, log.gps_fresh)


def test_csv_looks_as_agreed(tmp_path):
    write_log(replace(sample.log(), header=HEADER), tmp_path / "log.csv")
    lines = (tmp_path / "log.csv").read_text(encoding="utf-8").splitlines()
    above = [line for line in lines if line.startswith("#")]
    assert lines[: len(above)] == above
    assert lines[len(above)].startswith(
        "time_s,impact_pressure_pa,static_pressure_pa,velocity_north_mps"
    )
    assert len(lines) == len(above) + 1 + sample.ROWS


def test_a_failed_write_leaves_nothing(tmp_path, monkeypatch):
    def broken(path, columns, header):
        path.write_text("half a lo")
        raise RuntimeError("power cut")

    good = write_log(sample.log(), tmp_path / "log.csv").read_bytes()
    monkeypatch.setitem(FORMATS._entries, ".csv", replace(FORMATS[".csv"], write=broken))
    with pytest.raises(RuntimeError):
        write_log(sample.log(), tmp_path / "log.csv")
    assert [p.name for p in tmp_path.iterdir()] == ["log.csv"]
    assert (tmp_path / "log.csv").read_bytes() == good


def test_an_old_log_is_replaced_not_overwritten(tmp_path):
    """Whoever still reads the old file reads it to its end."""
    write_log(sample.log(), tmp_path / "log.csv")
    (tmp_path / "old").hardlink_to(tmp_path / "log.csv")
    write_log(sample.log().select(np.arange(50)), tmp_path / "log.csv")
    assert (tmp_path / "old").stat().st_size > 5 * (tmp_path / "log.csv").stat().st_size


@pytest.mark.parametrize(
    ("name", "says"),
    [
        *((name, r"\.csv, \.parquet, \.mat") for name in ("log.txt", "log", "log.xlsx")),
        ("a/log.csv", "be written"),
    ],
)
def test_unknown_formats_name_the_known_and_a_folder_must_be_there(tmp_path, name, says):
    with pytest.raises(BadInputError, match=says):
        write_log(sample.log(), tmp_path / name)
