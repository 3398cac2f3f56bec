"""What is taken for likely before a log is read: of a law its family, departures of a size, gusts of a length."""

from dataclasses import replace

import numpy as np
import pytest
from tests.calibration import trajectories as fixture

from pitotbench.calibration.covering import GUST_LENGTH, Structure, log_prior_of
from pitotbench.calibration.model_evidence import DEPARTURES, LEVEL, hypotheses
from pitotbench.calibration.observations import observe
from pitotbench.calibration.options import CalibrationOptions
from pitotbench.calibration.prediction import PredictionModel
from pitotbench.pressure_error import MODELS, REFERENCE_PRESSURE

X = np.geomspace(1.0, 2.65, 61)
LAWS = [model for name, model in MODELS.items() if name != "spline"]


def covariance_of(name, size):
    return next(t.covariance for t in hypotheses(LAWS, X) if (t.name, t.departure) == (name, size))


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


def test_probabilities_sum_to_one_half_are_lawless_and_the_scale_of_the_terms_does_not_matter():
    thoughts = hypotheses(LAWS, X)
    assert sum(t.probability for t in thoughts) == pytest.approx(1.0)
    assert sum(t.probability for t in thoughts if t.name == "spline") == pytest.approx(0.5)
    assert sum(t.probability for t in hypotheses([], X)) == pytest.approx(1.0)
    linear = MODELS["linear"]
    stretched = replace(linear, terms=(linear.terms[0], (lambda x: 1000.0 * x, lambda x: 1000.0 + 0.0 * x)))
    one, other = (np.stack([t.covariance for t in hypotheses([law], X)]) for law in (linear, stretched))
    np.testing.assert_allclose(one, other, atol=1e-10)


STRUCTURE = Structure(PredictionModel(MODELS["inverse+"], REFERENCE_PRESSURE), (), drifting=False)


def log_prior_at(height_pressure):
    """The prior of a log at one static pressure."""
    log = fixture.fly(fixture.step_decrease(10), 10, 10, fixture.Air())
    log = replace(log, static_pressure=np.full(len(log), height_pressure))
    return log_prior_of(STRUCTURE, observe(log, CalibrationOptions()))


@pytest.mark.parametrize(("height_pressure", "factor"), [(81200.0, 2.5), (69000.0, 4.0), (30000.0, 4.0)])
def test_a_length_one_factor_off_is_one_standard_deviation_off(height_pressure, factor):
    """2.5 low, 4 above 10,000 ft (69,682 Pa): gusts of 2,000 m are then nothing unusual."""
    log_prior = log_prior_at(height_pressure)
    usual = log_prior(np.log([0.5, GUST_LENGTH, 0.05]))
    for length in (GUST_LENGTH * factor, GUST_LENGTH / factor):
        assert log_prior(np.log([0.5, length, 0.05])) - usual == pytest.approx(-0.5, abs=1e-9)


@pytest.mark.parametrize("level", [1e-4, 1e-2])
def test_of_small_gusts_every_size_is_as_likely_as_the_next(level):
    """Jeffreys' prior: ten times less is no less likely, so that calm air may be found calm."""
    log_prior = log_prior_at(81200.0)
    more, less = (log_prior(np.log([size, GUST_LENGTH, 0.05])) for size in (level, 0.1 * level))
    assert more == pytest.approx(less, abs=1e-4)
