"""A log is read block by block into its arrays: the same numbers and messages as read whole, in
memory once.
"""

import tracemalloc
from csv import reader as rows_of_csv

import numpy as np
import pyarrow as pa
import pytest
from tests.logbook import sample_log as sample
from tests.logbook.bad_logs import repeated_text

from pitotbench import BadInputError, read_log
from pitotbench.logbook import csv as csv_format
from pitotbench.logbook.csv import read_csv
from pitotbench.logbook.parquet import read_parquet, write_parquet

ROWS = 400
PLAIN = {
    "time_s": [f"{0.1 * row:.1f}" for row in range(ROWS)],
    "whole": [str(row) for row in range(ROWS)],
    "whole, then not": [str(row) if row < 300 else f"{row}.5" for row in range(ROWS)],
    "gaps": ["" if row % 7 == 3 else f"{row}.25" for row in range(ROWS)],
    "late": ["" if row < 200 else "nan" if row == 250 else "1e3" for row in range(ROWS)],
    "empty": [""] * ROWS,
    "flag": ["true" if row % 3 else "false" for row in range(ROWS)],
    "label": ["leg \"1\"" if row < 150 else "" if row < 160 else "Kurve, links" for row in range(ROWS)],
    "text": [f"word {row}" for row in range(ROWS)],
    "minus": ["-0.0"] * ROWS,
}  # fmt: skip


def written(tmp_path, columns, last=""):
    quoted = [['"' + cell.replace('"', '""') + '"' if "," in cell or '"' in cell else cell for cell in cells]
              for cells in columns.values()]  # fmt: skip
    lines = [
        ",".join(f'"{name}"' for name in columns),
        *(",".join(row) for row in zip(*quoted, strict=True)),
    ]
    path = tmp_path / "log.csv"
    path.write_text("# rows = 400\n" + "\n".join(lines) + "\n" + last, encoding="utf-8")
    return path


@pytest.fixture
def small_blocks(monkeypatch):
    monkeypatch.setattr(csv_format, "BLOCK", 2000)  # bytes: some twenty rows


def read_by_python(path):
    """The columns as Python's own reader and its conversions have them."""
    with path.open(newline="", encoding="utf-8") as file:
        names, *rows = rows_of_csv(line for line in file if not line.startswith("#"))
    cells = zip(*(row for row in rows if len(row) == len(names)), strict=True)
    return dict(zip(names, map(converted, cells), strict=True))


def converted(cells):
    empty = [cell in ("", "nan") for cell in cells]
    try:
        return np.array([np.nan if gap else float(c) for c, gap in zip(cells, empty, strict=True)])
    except ValueError:
        if set(cells) <= {"true", "false"}:
            return np.array([cell == "true" for cell in cells])
        return np.array([None if gap else c for c, gap in zip(cells, empty, strict=True)], object)


@pytest.mark.usefixtures("small_blocks")
@pytest.mark.parametrize("last", ["", "41.0,1"], ids=["complete", "cut"])
def test_a_table_read_by_blocks_is_that_of_its_cells(tmp_path, last):
    path = written(tmp_path, PLAIN, last)
    table, expected = read_csv(path), read_by_python(path)
    assert table.names == tuple(PLAIN)
    assert len(table.warnings) == bool(last)
    for name in table.names:
        mine, theirs = table.column(name), expected[name]
        assert mine.dtype == theirs.dtype, name
        np.testing.assert_array_equal(mine, theirs, err_msg=name)
        assert mine.base is None or mine.dtype == np.bool_, name


@pytest.mark.usefixtures("small_blocks")
@pytest.mark.parametrize(
    ("name", "cell"),
    [("whole", "x"), ("empty", "late"), ("gaps", "2026-05-04"), ("gaps", "0x1F")],
)
def test_a_column_that_changes_its_type_late_has_the_last_one(tmp_path, name, cell):
    path = written(tmp_path, {**PLAIN, name: [*PLAIN[name][:-1], cell]})
    found, expected = read_csv(path).column(name), read_by_python(path)[name]
    assert found.dtype == expected.dtype == object
    np.testing.assert_array_equal(found, expected)


@pytest.mark.usefixtures("small_blocks")
@pytest.mark.parametrize(("cell", "last"), [("", None), ("3", "3")])
def test_a_flag_with_another_cell_keeps_its_words(tmp_path, cell, last):
    path = written(tmp_path, {**PLAIN, "flag": [*PLAIN["flag"][:-1], cell]})
    found = read_csv(path).column("flag")
    assert found.dtype == object
    assert found[-1] == last


@pytest.mark.usefixtures("small_blocks")
@pytest.mark.parametrize(
    ("name", "row", "cell", "message"),
    [
        ("static_pressure_pa", 500, "err", r"'static_pressure_pa', row 501: 'err' is not a number"),
        (
            "on_condition",
            500,
            "perhaps",
            r"'on_condition', row 501: 'perhaps' is not true or false",
        ),
        ("time_s", 500, "14:03:06", r"'time_s', row 501: '14:03:06' is a clock time"),
        ("segment", 500, "\udcff", r"line 502 is not UTF-8 text"),
    ],
)
def test_a_bad_cell_far_below_is_named_with_its_row(tmp_path, name, row, cell, message):
    columns = sample.columns()
    columns[name] = columns[name].astype(object)
    columns[name][row] = "MARK"
    path = sample.write(tmp_path / "log.csv", columns)
    path.write_bytes(
        path.read_bytes().replace(b"MARK", cell.encode("utf-8", errors="surrogateescape"))
    )
    with pytest.raises(BadInputError, match=message):
        read_log(path)


def test_a_minus_zero_is_zero(tmp_path):
    """arctan2(−0, −1) is −π, arctan2(0, −1) is π: a sign from rounding must not turn a track."""
    path = written(tmp_path, PLAIN)
    write_parquet(tmp_path / "log.parquet", {"minus": np.full(5, -0.0)}, {})
    for table in (read_csv(path), read_parquet(tmp_path / "log.parquet")):
        assert not np.signbit(table.column("minus")).any()


def test_a_text_that_repeats_is_in_memory_once(tmp_path):
    """It would take 10 GB, from a file of some kilobytes, a text a row."""
    rows = 500_000
    path = repeated_text(tmp_path, rows, "remark")
    pool, before = pa.proxy_memory_pool(pa.default_memory_pool()), pa.default_memory_pool()
    pa.set_memory_pool(pool)
    table = read_parquet(path)
    pa.set_memory_pool(before)
    assert set(table.column("remark")) == {"x" * 20_000}
    assert len(table) == rows
    assert pool.max_memory() < 400 * rows


def memory_of(path, minutes):
    """Bytes of the arrays of a log, the most that was in memory of Python while it was read, and
    the most of Arrow, whose columns go as those of Python come.
    """
    columns = {name: np.tile(values, minutes) for name, values in sample.columns().items()}
    columns["time_s"] = np.arange(len(columns["time_s"])) / sample.RATE
    sample.write(path, columns)
    pool = pa.proxy_memory_pool(pa.default_memory_pool())
    before = pa.default_memory_pool()
    pa.set_memory_pool(pool)
    tracemalloc.start()
    log = read_log(path)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    pa.set_memory_pool(before)
    return np.array(
        [sum(array.nbytes for array in log.channels().values()), peak, pool.max_memory()]
    )


def test_a_log_is_in_memory_once(tmp_path, monkeypatch):
    """With each row the memory grows by the arrays of the log and some columns for the checks. The
    thirty blocks of text that are read ahead do not grow; here they are small, so that both files
    are longer."""
    monkeypatch.setattr(csv_format, "BLOCK", 2**14)
    _, short, long = (memory_of(tmp_path / "log.csv", minutes) for minutes in (1, 25, 75))
    arrays, python, arrow = long - short
    assert python < 1.8 * arrays
    assert arrow < 1.1 * arrays


def test_a_line_without_an_end_is_refused_before_it_is_in_memory(tmp_path):
    path = tmp_path / "flight.csv"
    with path.open("wb") as file:
        file.truncate(64 << 20)
    tracemalloc.start()
    with pytest.raises(BadInputError, match="line 1 has more than a megabyte"):
        read_csv(path)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 16 << 20
