"""The committed tables of the coverage and of foreign airplanes: complete, and no bound that is too
small.
"""

import csv
from itertools import product
from pathlib import Path

import pandas as pd
import pytest

import pitotlab
from pitotbench.sensing.sampling import SYSTEMS
from pitotbench.simulation.maneuvers import PAPER_MANEUVERS
from pitotlab.coverage import SCORINGS, TURBULENCE

RESULTS = Path(pitotlab.__file__).parent / "results"


@pytest.fixture(scope="module")
def cells():
    every = pd.read_csv(RESULTS / "coverage.csv")
    whole = [name for name, scoring in SCORINGS.items() if scoring.systems == (*SYSTEMS,)]
    return every[every.scoring.isin(whole)]


@pytest.fixture(scope="module")
def airplanes():
    with (RESULTS / "aircraft-flights.csv").open(encoding="utf-8") as file:
        return [row for row in csv.DictReader(file) if row["maneuver"] == "all"]


def test_every_cell_is_there_with_as_many_flights(cells):
    scored = sorted(set(cells.scoring))
    assert len(scored) == 2
    assert "constant wind" in scored
    wanted = [*product(scored, PAPER_MANEUVERS, TURBULENCE, SYSTEMS)]
    found = zip(cells.scoring, cells.maneuver, cells.turbulence, cells.das, strict=True)
    assert sorted(found) == sorted(wanted)
    assert cells.flights.nunique() == 1


def test_no_bound_is_too_small(cells):
    """95 − 2 % of the curve, two standard errors allowed, in every cell."""
    short = cells[cells.coverage_percent + 2.0 * cells.coverage_se_percent < 93.0]
    assert short.empty, short.to_string()


def test_white_bounds_are(cells):
    rough = cells[(cells.scoring == "constant wind") & (cells.turbulence != "none")]
    assert rough.white_coverage_percent.max() < 50.0


def test_enough_airplanes_flew_every_flight(airplanes):
    assert len(airplanes) >= 6
    assert all(int(row["flights"]) >= 10 for row in airplanes)
    assert sum(int(row["failed"]) for row in airplanes) == 0


def test_no_bound_of_a_foreign_airplane_is_too_small(airplanes):
    for row in airplanes:
        share, error = float(row["coverage_percent"]), float(row["coverage_se_percent"])
        assert share + 2.0 * error >= 93.0, row["aircraft"]
