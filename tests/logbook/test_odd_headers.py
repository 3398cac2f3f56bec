"""Headers that hold something else than ours do, and cells that are no numbers: a warning or one clear error."""

import numpy as np
import pytest
from tests.logbook import sample_log as sample
from tests.logbook.bad_logs import with_decimal_commas

from pitotbench.logbook.columns import parse_header
from pitotbench.logbook.reading import read_log


def read(tmp_path, above):
    return read_log(sample.write(tmp_path / "log.csv", sample.columns(), above))


@pytest.mark.parametrize("value", ['"a"', "[]", "{}", "2026-05-04", "true", "1.5"])
def test_a_number_of_rows_that_is_none_is_a_warning(value, tmp_path):
    log = read(tmp_path, f"# rows = {value}\n")
    assert len(log) == sample.ROWS
    assert any("`rows` is not a number of rows" in text for text in log.header["warnings"])


@pytest.mark.parametrize("value", ["[[1],[2]]", "5", "{a = 1}", "[1, 2]", "2026-05-04"])
def test_warnings_that_are_not_texts_are_left_out_with_a_warning(value, tmp_path):
    log = read(tmp_path, f"# warnings = {value}\n")
    assert log.header["warnings"] == ["the header's `warnings` holds entries that are not text; they are ignored"]


@pytest.mark.parametrize(("value", "kept"), [('"one"', ["one"]), ('["one", "two"]', ["one", "two"])])
def test_warnings_that_are_texts_are_kept(value, kept, tmp_path):
    assert read(tmp_path, f"# warnings = {value}\n").header["warnings"] == kept


@pytest.mark.parametrize("text", ["x = " + "[" * 3000, "x = " + "1" * 5000, "[accuracy]\ntemperature_k = 1 K"])
def test_a_header_that_is_not_toml_is_kept_as_text(text, tmp_path):
    assert parse_header(text)[0] == {"comments": text.splitlines()}
    above = "".join(f"# {line}\n" for line in text.splitlines())
    assert "not TOML" in read(tmp_path, above).header["warnings"][0]


@pytest.mark.parametrize(
    "text", ['airframe_info, log_version="1.00", mode=NORMAL, ', "Flown by the club, runway 05"]
)
def test_a_remark_above_the_columns_is_kept_without_a_word(text, tmp_path):
    header = read(tmp_path, f"# {text}\n").header
    assert header["comments"] == [text.strip()]
    assert "warnings" not in header


@pytest.mark.parametrize("mark", [";", "\t"])
def test_decimal_commas_are_read(mark, tmp_path):
    table, lines = with_decimal_commas(mark)
    path = tmp_path / "log.csv"
    path.write_text("\n".join(lines))
    np.testing.assert_allclose(read_log(path).impact_pressure, table["impact_pressure_pa"])


@pytest.mark.parametrize("rate", [0.11, 1.0, 2000.0])
def test_a_rate_that_a_recorder_may_have_is_taken(rate, tmp_path):
    table = sample.columns()
    table["time_s"] = np.arange(sample.ROWS) / rate
    assert len(read_log(sample.write(tmp_path / "log.csv", table))) == sample.ROWS


def test_a_gap_of_an_hour_is_taken(tmp_path):
    table = sample.columns()
    table["time_s"] = table["time_s"] + np.where(np.arange(sample.ROWS) < 300, 0.0, 3600.0)
    assert len(read_log(sample.write(tmp_path / "hour.csv", table))) == sample.ROWS
