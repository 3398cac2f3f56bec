"""A log is read block by block into its arrays: the same numbers and messages as read whole, in
memory once.
"""

import tracemalloc

import numpy as np
import pytest
from tests.logbook import sample_log as sample

from pitotbench import BadInputError, read_log
from pitotbench.logbook import csv as csv_format
from pitotbench.logbook.csv import read_csv
from pitotbench.logbook.formats import read_parquet, write_parquet

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


def whole(path, monkeypatch):
    with monkeypatch.context() as patch:
        patch.setattr(csv_format, "read_blocks", lambda *_: None)
        return read_csv(path)


def by_blocks(path, monkeypatch):
    """Fails where the file is read as a whole."""
    with monkeypatch.context() as patch:
        patch.setattr(csv_format, "_parse", None)
        return read_csv(path)


@pytest.mark.usefixtures("small_blocks")
@pytest.mark.parametrize("last", ["", "41.0,1"], ids=["complete", "cut"])
def test_a_table_read_by_blocks_is_that_read_whole(tmp_path, monkeypatch, last):
    path = written(tmp_path, PLAIN, last)
    blocks, expected = by_blocks(path, monkeypatch), whole(path, monkeypatch)
    assert blocks.names == expected.names
    assert blocks.warnings == expected.warnings
    assert len(blocks.warnings) == bool(last)
    for name in blocks.names:
        mine, theirs = blocks.column(name), expected.column(name)
        assert mine.dtype == theirs.dtype, name
        np.testing.assert_array_equal(mine, theirs, err_msg=name)
        assert mine.base is None, name


@pytest.mark.usefixtures("small_blocks")
@pytest.mark.parametrize(
    ("name", "cell"),
    [
        ("whole", "x"),
        ("empty", "late"),
        ("flag", ""),
        ("flag", "3"),
        ("gaps", "2026-05-04"),
        ("whole", "0x1F"),
    ],
)
def test_a_column_that_changes_its_type_late_is_read_whole(tmp_path, monkeypatch, name, cell):
    path = written(tmp_path, {**PLAIN, name: [*PLAIN[name][:-1], cell]})
    found, expected = read_csv(path).column(name), whole(path, monkeypatch).column(name)
    assert found.dtype == expected.dtype
    np.testing.assert_array_equal(found, expected)


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


def test_a_minus_zero_is_zero(tmp_path, monkeypatch):
    """arctan2(−0, −1) is −π, arctan2(0, −1) is π: a sign from rounding must not turn a track."""
    path = written(tmp_path, PLAIN)
    write_parquet(tmp_path / "log.parquet", {"minus": np.full(5, -0.0)}, {})
    for table in (
        by_blocks(path, monkeypatch),
        whole(path, monkeypatch),
        read_parquet(tmp_path / "log.parquet"),
    ):
        assert not np.signbit(table.column("minus")).any()


def memory_of(path, minutes):
    """Bytes of the arrays of a log, and the most that was in memory while it was read."""
    columns = {name: np.tile(values, minutes) for name, values in sample.columns().items()}
    columns["time_s"] = np.arange(len(columns["time_s"])) / sample.RATE
    sample.write(path, columns)
    tracemalloc.start()
    log = read_log(path)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return sum(array.nbytes for array in log.channels().values()), peak


def test_a_log_is_in_memory_once(tmp_path, monkeypatch):
    """With each row the memory grows by the arrays of the log and some columns for the checks. The
    thirty blocks of text that are read ahead do not grow; here they are small, so that both files
    are longer."""
    monkeypatch.setattr(csv_format, "BLOCK", 2**15)
    _, (few, low), (many, high) = (
        memory_of(tmp_path / "log.csv", minutes) for minutes in (1, 50, 150)
    )
    assert high - low < 1.8 * (many - few)
