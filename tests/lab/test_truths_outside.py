"""Truths outside the table: they are what they claim to be, and a row of the result says how auto
did on them.
"""

import numpy as np
import pandas as pd
import pytest

from pitotbench import air
from pitotbench.pressure_error import MODELS
from pitotbench.sensing.recorder import known_curve
from pitotbench.units import KNOT
from pitotlab.auto import TRUTHS, over_seeds, score_outside, truth_of
from pitotlab.experiment import Trial

PRESSURE = air.impact_pressure(np.linspace(100.0, 160.0, 61) * KNOT)


def missed(name, law, seed):
    """How far the nearest curve of a law stays from a truth, as a largest Δp/q_c."""
    truth, basis = (
        known_curve(truth_of(name, seed)).normalized(PRESSURE),
        MODELS[law].basis(PRESSURE / 1630.28),
    )
    return np.max(np.abs(truth - basis @ np.linalg.lstsq(basis, truth)[0]))


def test_inverse_plus_is_inside_and_bumps_are_outside():
    assert (
        max(missed("inverse+", "inverse+", seed) for seed in range(20)) < 1e-4
    )  # a table is linear in between
    assert min(missed("bump", "inverse+", seed) for seed in range(20)) > 5e-4


@pytest.mark.parametrize("name", list(TRUTHS))
def test_truths_can_be_flown_and_repeat(name):
    curve = known_curve(truth_of(name, 3))
    np.testing.assert_allclose(
        curve.impact_pressure(curve.indicated_impact_pressure(PRESSURE)), PRESSURE, rtol=1e-9
    )
    assert truth_of(name, 3) == truth_of(name, 3) != truth_of(name, 4)


def test_scores_of_one_flight():
    rows = score_outside(Trial("rapid_decel", "none", 2), ("bump",), "20/1")
    table = over_seeds(pd.DataFrame(rows), ("maneuver", "truth", "model"))
    assert list(table["model"]) == ["auto", "inverse+"]
    assert (table["answers"] == 1).all()
    assert table["curve inside 2σ [%]"].between(0.0, 100.0).all()
    assert (table["rms error [kt]"] < 0.5).all()
