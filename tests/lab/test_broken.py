"""The table of broken pitots goes on where it ends."""

from pitotlab.broken.measure import BrokenRow, _kept, _write


def test_a_measurement_that_was_stopped_goes_on_where_its_table_ends(tmp_path):
    rows = [
        BrokenRow("broken", "iced", ".csv", 7, "named", says="--to 2:30"),
        BrokenRow("scale", "base", ".ulg", 9, "inside", 1.25, 1.24, 0.02),
    ]
    _write(rows, tmp_path / "table.csv", "# head")
    kept = list(_kept(tmp_path / "table.csv", "# head"))
    assert [row.key for row in kept] == [("broken", "iced", 7), ("scale", "", 9)]
    assert kept[1] == rows[1]
    assert list(_kept(tmp_path / "table.csv", "# another")) == []
