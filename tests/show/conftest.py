"""A log from formulas, and its calibration: most pages and tables are drawn of these."""

import pytest
from tests.calibration import trajectories

from pitotbench import Calibration, FlightLog
from pitotbench.calibration import calibrate


@pytest.fixture(scope="session")
def log() -> FlightLog:
    return trajectories.fly(trajectories.step_decrease(10), 10, 10, trajectories.Air())


@pytest.fixture(scope="session")
def result(log: FlightLog) -> Calibration:
    return calibrate(log)
