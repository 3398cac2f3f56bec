"""The committed results of the coverage campaign: complete, of scored seeds, and no bound that is too small."""

import re
from pathlib import Path

import pandas as pd
import pytest

from pitotbench.sense import SYSTEMS
from pitotbench.simulate import MANEUVERS
from pitotlab.coverage import SCORINGS, TURBULENCE
from pitotlab.experiment import FIRST_SCORED_SEED

DOCS = Path(__file__).parents[3] / "docs"
PUBLISHED = ("four_leg", "race_track", "step_decrease", "rapid_decel", "circle")


@pytest.fixture(scope="module")
def cells():
    return pd.read_csv(DOCS / "coverage.csv")


def test_every_cell_is_there_with_as_many_flights(cells):
    assert set(PUBLISHED) <= set(MANEUVERS)
    wanted = {
        (scoring.name, maneuver, turbulence, das)
        for scoring in SCORINGS.values()
        for maneuver in PUBLISHED
        for turbulence in TURBULENCE
        for das in scoring.systems
    }
    assert set(zip(cells.scoring, cells.maneuver, cells.turbulence, cells.das, strict=True)) == wanted
    assert cells[cells.scoring == "constant wind"].shape[0] == len(PUBLISHED) * len(TURBULENCE) * len(SYSTEMS)
    for _, group in cells.groupby("scoring"):
        assert group.flights.min() >= 0.98 * group.flights.max()
    assert cells[cells.scoring != "slow wind"].flights.min() >= 400
    assert cells[cells.scoring == "slow wind"].flights.min() >= 300


def test_page_names_seeds_and_date(cells):
    page = (DOCS / "coverage.md").read_text(encoding="utf-8")
    first, last = map(int, re.search(r"Seeds (\d+) to (\d+)", page).groups())
    assert first == FIRST_SCORED_SEED
    assert last - first + 1 == cells.flights.max()
    assert re.search(r"\d{4}-\d{2}-\d{2}", page)


@pytest.mark.parametrize("scoring", ["constant wind", "systematic errors"])
def test_no_bound_is_too_small(cells, scoring):
    """95 − 2 % of the curve, two standard errors allowed, in every cell."""
    these = cells[cells.scoring == scoring]
    short = these[these.coverage_percent + 2.0 * these.coverage_se_percent < 93.0]
    assert short.empty, short[["maneuver", "turbulence", "das", "coverage_percent"]].to_string()


def test_white_bounds_are(cells):
    rough = cells[(cells.scoring == "constant wind") & (cells.turbulence != "none")]
    assert rough.white_coverage_percent.max() < 50.0
