"""The steps of a display: what a steady reading hides belongs into the bound."""

from dataclasses import replace

import numpy as np
import pytest
import trajectories as fixture

from pitotbench import air
from pitotbench.bench import calibrate
from pitotbench.calibrate.display_steps import display_two_sigma
from pitotbench.units import KNOT


def test_one_reading_errs_by_half_a_step_and_many_average_out():
    log = fixture.fly(fixture.circles(1), 1, 1, fixture.CALM)
    at = np.asarray(air.calibrated_airspeed(log.impact_pressure))[:1]
    one = replace(log, velocity_north=np.full(len(log), 50.0), velocity_east=np.zeros(len(log)))
    steps = {"ground_speed_mps": KNOT}
    assert display_two_sigma(one, at, steps)[0] == pytest.approx(2.0 * KNOT / np.sqrt(12.0))
    # A full turn of 100 different readings at each airspeed.
    assert display_two_sigma(log, at, steps)[0] == pytest.approx(2.0 * KNOT / np.sqrt(1200.0), rel=0.05)
    assert display_two_sigma(log, at, {})[0] == 0.0


def test_the_bound_widens_and_says_so():
    log = fixture.fly(fixture.circles(1), 1, 1, fixture.Air(pressure=3.0))
    shown = replace(log, header={**log.header, "display": {"airspeed_mps": KNOT, "ground_speed_mps": KNOT}})
    plain, wide = calibrate(log), calibrate(shown)
    np.testing.assert_allclose(plain.curve.correction, wide.curve.correction)
    added = display_two_sigma(shown, wide.curve.indicated_airspeed, shown.header["display"])
    np.testing.assert_allclose(wide.curve.two_sigma, np.hypot(plain.curve.two_sigma, added))
    assert any("steps of the display" in warning for warning in wide.warnings)


@pytest.mark.parametrize("display", ["1 kt", {"airspeed_mps": "1"}, {"airspeed_mps": -1.0}])
def test_a_header_may_hold_anything(display):
    log = fixture.fly(fixture.circles(1), 1, 1, fixture.Air(pressure=3.0))
    odd = replace(log, header={**log.header, "display": display})
    np.testing.assert_allclose(calibrate(odd).curve.two_sigma, calibrate(log).curve.two_sigma)
