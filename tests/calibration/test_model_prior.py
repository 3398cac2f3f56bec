"""The prior of curves: of a law its family, whatever the scale of its terms; departures of the stated size."""

from dataclasses import replace

import numpy as np
import pytest

from pitotbench.calibration.model_evidence import DEPARTURES, LEVEL, hypotheses
from pitotbench.pressure_error import MODELS

X = np.geomspace(1.0, 2.65, 61)
LAWS = [model for name, model in MODELS.items() if name != "spline"]


def covariance_of(name, size):
    return next(t.covariance for t in hypotheses(LAWS, X) if (t.name, t.departure) == (name, size))


def test_probabilities_sum_to_one_and_half_are_lawless():
    thoughts = hypotheses(LAWS, X)
    assert sum(t.probability for t in thoughts) == pytest.approx(1.0)
    assert sum(t.probability for t in thoughts if t.name == "spline") == pytest.approx(0.5)
    assert sum(t.probability for t in hypotheses([], X)) == pytest.approx(1.0)


@pytest.mark.parametrize("name", [law.name for law in LAWS])
def test_departure_has_its_size(name):
    """What two sizes differ by is departure alone; its mean square over ln x is the size's square."""
    small, large = (covariance_of(name, size) for size in DEPARTURES[:2])
    extra = np.trapezoid(np.diag(large - small), np.log(X)) / np.log(X[-1] / X[0])
    assert extra == pytest.approx(DEPARTURES[1] ** 2 - DEPARTURES[0] ** 2, rel=0.05)


def test_law_has_its_family_and_no_more():
    for law in LAWS:
        family = covariance_of(law.name, DEPARTURES[0]) - (
            covariance_of("bias", DEPARTURES[0]) - LEVEL**2 * np.ones((61, 61))
        )
        assert np.linalg.matrix_rank(family, tol=1e-9) == len(law.parameter_names)
        basis = law.basis(X)
        rest = family - basis @ np.linalg.lstsq(basis, family)[0]
        assert np.max(np.abs(rest)) < 1e-9


def test_scale_of_the_terms_does_not_matter():
    linear = MODELS["linear"]
    stretched = replace(linear, terms=(linear.terms[0], (lambda x: 1000.0 * x, lambda x: 1000.0 + 0.0 * x)))
    for a, b in zip(hypotheses([linear], X), hypotheses([stretched], X), strict=True):
        np.testing.assert_allclose(a.covariance, b.covariance, atol=1e-10)
