"""A floor of the airspeed that is stated lets slow airplanes be calibrated."""

from dataclasses import replace

import numpy as np
import pytest
from tests.calibration import trajectories as fixture

from pitotbench import BadInputError, calibrate
from pitotbench.units import KNOT


def slow_flight():
    """Circles between 10 and 16 kt of a solar drone, in calm air, without an error."""
    log = fixture.fly(fixture.circles(2), 2, 2, fixture.Air(gust=0.1))
    share = 13.0 / float(np.median(np.hypot(log.velocity_north, log.velocity_east)) / KNOT)
    return replace(
        log,
        impact_pressure=log.impact_pressure * share**2,
        velocity_north=log.velocity_north * share,
        velocity_east=log.velocity_east * share,
        velocity_down=log.velocity_down * share,
    )


def test_a_slow_airplane_is_told_of_the_floor_and_calibrated_with_its_own():
    log = slow_flight()
    with pytest.raises(BadInputError, match="--slowest 8"):
        calibrate(log)
    curve = calibrate(log, slowest=8.0 * KNOT).curve
    assert curve.indicated_airspeed[-1] < 20.0 * KNOT
    fast = calibrate(fixture.fly(fixture.circles(2), 2, 2, fixture.Air(gust=0.1))).curve
    share = curve.indicated_airspeed[0] / fast.indicated_airspeed[0]
    assert curve.correction[0] / share == pytest.approx(fast.correction[0], abs=2.0 * KNOT)


def test_a_floor_below_zero_is_refused():
    with pytest.raises(BadInputError, match="slowest airspeed must be"):
        calibrate(slow_flight(), slowest=-1.0)
