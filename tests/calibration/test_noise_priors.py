"""What is taken for likely of gusts before a log is read."""

from dataclasses import replace

import numpy as np
import pytest
from tests.calibration import trajectories as fixture

from pitotbench.calibration.covering import GUST_LENGTH, Structure, log_prior_of
from pitotbench.calibration.observations import observe
from pitotbench.calibration.options import CalibrationOptions
from pitotbench.calibration.prediction import PredictionModel
from pitotbench.pressure_error import MODELS, REFERENCE_PRESSURE

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
