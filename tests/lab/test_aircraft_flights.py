"""The committed flights of foreign airplanes: as many as stated, the page agrees with them, and the bound holds."""

import csv
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[3] / "docs"


@pytest.fixture(scope="module")
def rows():
    with (DOCS / "aircraft-flights.csv").open(encoding="utf-8") as file:
        return [row for row in csv.DictReader(file) if row["maneuver"] == "all"]


def test_enough_airplanes_flew_every_flight(rows):
    assert len(rows) >= 6
    assert all(int(row["flights"]) >= 10 for row in rows)
    assert sum(int(row["failed"]) for row in rows) == 0


def test_no_bound_is_too_small(rows):
    """95 − 2 % of the curve, two standard errors allowed."""
    short = [r for r in rows if float(r["coverage_percent"]) + 2.0 * float(r["coverage_se_percent"]) < 93.0]
    assert short == []


def test_the_page_shows_the_table(rows):
    page = (DOCS / "aircraft.md").read_text(encoding="utf-8")
    for row in rows:
        # The first table is that of the file; later ones are of other seeds.
        line = next(line for line in page.splitlines() if line.startswith(f"| `{row['aircraft']}` |"))
        cells = [cell.strip() for cell in line.split("|")]
        assert cells[3:5] == [row["flights"], row["failed"]]
        assert cells[5] == f"{float(row['on_condition_percent']):.1f}"
        assert cells[7].startswith(f"{float(row['coverage_percent']):.1f} ")
