"""The page's table of how much a growing wind moves the curve is what the bench flies."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pitotbench import Case, fly, sense
from pitotbench.calibration import calibrate
from pitotbench.campaigns.flights import scored
from pitotbench.units import KNOT

PAGE = Path(__file__).parents[2] / "docs" / "which-maneuver.md"
ROWS = {"step_decrease": "Step Decrease", "rapid_decel": "Rapid Decel", "circle": "Circle"}
SIX_MINUTES = 360.0  # s


def on_the_page(name):
    """Errors along and across [kt] and the change that equals the bound [kt], of a row."""
    section = PAGE.read_text("utf-8").partition("## How much the wind may change")[2]
    row = re.search(rf"^\| {name} \|(.*)\|$", section, re.MULTILINE)
    return [float(cell) for cell in row[1].split("|")][1:]


@pytest.mark.parametrize("maneuver", ROWS)
def test_a_growing_wind_moves_the_curve_as_the_page_says(maneuver):
    flight = fly(Case(maneuver=maneuver, turbulence="light", truth_seed=5, sensor_seed=5))
    log = sense(flight, "50/50")
    grown = KNOT * (log.time - log.time[0]) / SIX_MINUTES
    steady = calibrate(log).curve
    rows = scored(steady)
    moved = []
    for channel in ("velocity_north", "velocity_east"):
        curve = calibrate(replace(log, **{channel: getattr(log, channel) + grown})).curve
        moved.append(np.sqrt(np.mean((curve.correction - steady.correction)[rows] ** 2)) / KNOT)
    bound = float(steady.two_sigma[rows].mean()) / KNOT
    *errors, tolerable = on_the_page(ROWS[maneuver])
    np.testing.assert_allclose(moved, errors, atol=0.01)
    assert bound / max(moved) == pytest.approx(tolerable, rel=0.1)
