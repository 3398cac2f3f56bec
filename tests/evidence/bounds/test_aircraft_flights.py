"""The committed flights of foreign airplanes: as many as stated, and the bound holds."""

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
