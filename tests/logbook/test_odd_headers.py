"""Headers that hold something else than ours do, and cells that are no numbers: a warning or one clear error."""

import numpy as np
import pytest
from tests.logbook import sample_log as sample

from pitotbench.logbook.columns import parse_header
from pitotbench.logbook.reading import read_log
from pitotbench.records import BadInputError


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


@pytest.mark.parametrize("text", ["x = " + "[" * 3000, "x = " + "1" * 5000, "no TOML"])
def test_a_header_that_is_not_toml_is_kept_as_text(text, tmp_path):
    assert parse_header(text)[0] == {"comments": [text]}
    assert "not TOML" in read(tmp_path, f"# {text}\n").header["warnings"][0]


def with_decimal_commas(mark):
    table = sample.columns()
    del table["segment"], table["on_condition"]
    rows = [mark.join(str(value).replace(".", ",") for value in row) for row in zip(*table.values(), strict=True)]
    return table, [mark.join(table), *rows]


@pytest.mark.parametrize("mark", [";", "\t"])
def test_decimal_commas_are_read(mark, tmp_path):
    table, lines = with_decimal_commas(mark)
    path = tmp_path / "log.csv"
    path.write_text("\n".join(lines))
    np.testing.assert_allclose(read_log(path).impact_pressure, table["impact_pressure_pa"])


@pytest.mark.parametrize("mark", [";", "\t"])
def test_a_mixture_of_decimal_marks_is_refused(mark, tmp_path):
    _, lines = with_decimal_commas(mark)
    path = tmp_path / "log.csv"
    path.write_text("\n".join([lines[0], lines[1].replace(",", "."), *lines[2:]]))
    with pytest.raises(BadInputError, match=r"has a decimal comma; write decimal points in the whole file"):
        read_log(path)


def test_decimal_commas_between_commas_are_asked_for(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("time_s,static_pressure_pa\n0,1,81200,5\n0,2,81200,5\n")
    with pytest.raises(BadInputError, match=r"row 1 has 4 columns, the first line names 2 \(decimal commas\?"):
        read_log(path)


@pytest.mark.parametrize("rate", [0.11, 1.0, 2000.0])
def test_a_rate_that_a_recorder_may_have_is_taken(rate, tmp_path):
    table = sample.columns()
    table["time_s"] = np.arange(sample.ROWS) / rate
    assert len(read_log(sample.write(tmp_path / "log.csv", table))) == sample.ROWS


@pytest.mark.parametrize(
    ("column", "step", "says"),
    [
        ("time_s", 50.0, r"rows are 50 s apart.*50 between rows would fit a column named time_ms"),
        ("time_ms", 0.05, r"0\.05 between rows would fit a column named time_s"),
        ("time_s", 1e6, r"check the unit of the clock"),
    ],
)
def test_a_rate_that_no_recorder_has_names_the_unit_that_fits(column, step, says, tmp_path):
    table = sample.columns()
    del table["time_s"]
    with pytest.raises(BadInputError, match=says):
        read_log(sample.write(tmp_path / "log.csv", {column: np.arange(sample.ROWS) * step, **table}))


def test_a_gap_of_an_hour_is_taken_and_a_jump_of_days_is_refused(tmp_path):
    table = sample.columns()
    table["time_s"] = table["time_s"] + np.where(np.arange(sample.ROWS) < 300, 0.0, 3600.0)
    assert len(read_log(sample.write(tmp_path / "hour.csv", table))) == sample.ROWS
    table["time_s"] = table["time_s"] + np.where(np.arange(sample.ROWS) < 300, 0.0, 1e9)
    with pytest.raises(BadInputError, match=r"'time_s', row 301: time jumps from 29.9 to 1e\+09 s; cut the log"):
        read_log(sample.write(tmp_path / "days.csv", table))


def test_several_rows_that_break_off_are_no_cut_file(tmp_path):
    lines = sample.write(tmp_path / "log.csv", sample.columns()).read_text().splitlines()
    (tmp_path / "log.csv").write_text("\n".join([*lines[:-2], *(line[:20] for line in lines[-2:])]))
    with pytest.raises(BadInputError, match=f"row {sample.ROWS - 1} has . columns, the first line names 14; corr"):
        read_log(tmp_path / "log.csv")
