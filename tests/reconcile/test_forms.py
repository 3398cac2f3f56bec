"""The form of a cause that fitted is the form in the answer; the plain form only where it fits as well."""

import numpy as np
import pytest

from pitotbench.effects import EFFECTS
from pitotbench.reconcile.decide.explanations import Explanations
from pitotbench.reconcile.decide.normal_equations import NormalEquations
from pitotbench.reconcile.null_flights.null_distribution import theoretical_distribution
from pitotbench.reconcile.residuals.whitening import NoiseModel
from pitotbench.reconcile.signatures.signatures import Signature

QUIET = NoiseModel(("impact_pressure",), np.zeros((1, 0)), np.ones(1), np.eye(1))
CREEP, WATER = 192.0, 205.0  # merits: water has a size more, and fits a little better


def table(plain: float) -> Explanations:
    """A log whose gap is explained by water in the line, and almost as well by creep; its plain form, hysteresis,
    has the merit that is given."""
    share = plain / CREEP
    along = {
        ("water_in_line", "lag_s"): [1.0, 0.0, 0.0],
        ("water_in_line", "column_m"): [0.0, 1.0, 0.0],
        ("creep", "fraction"): [1.0, 0.0, 0.0],
        ("hysteresis", "width_pa"): [np.sqrt(share), 0.0, np.sqrt(1.0 - share)],
    }
    extra = WATER + 6.0 - CREEP  # a further size costs 6
    residual = np.array([np.sqrt(CREEP), np.sqrt(extra), 0.0])
    typical = [EFFECTS[effect].parameter(name).typical for effect, name in along]
    columns = np.array(list(along.values())) * 10.0 / np.array(typical)[:, None]  # sizes of the typical order
    every = np.vstack([columns, residual])
    inner = every @ every.T
    signatures = [Signature(effect, name, 1.0, np.zeros((3, 1))) for effect, name in along]
    return Explanations(
        NormalEquations(inner[None], 0, np.zeros(0), inner), signatures, theoretical_distribution(QUIET)
    )


def test_a_cause_that_fits_in_another_form_only_is_named_in_that_form() -> None:
    assert table(plain=97.0).choose() == ("creep",)


def test_a_cause_is_named_in_its_plain_form_where_that_fits_as_well() -> None:
    assert table(plain=190.0).choose() == ("hysteresis",)


@pytest.mark.parametrize("plain", [97.0, 190.0])
def test_an_equivalent_explanation_is_listed_by_its_cause(plain: float) -> None:
    assert table(plain).equivalents(("water_in_line",), 0) == ("hysteresis",)
