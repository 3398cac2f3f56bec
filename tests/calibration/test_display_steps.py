"""The steps of a display: what a steady reading hides belongs into the bound."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter
from tests.calibration import trajectories as fixture

from pitotbench import air
from pitotbench.calibration import calibrate
from pitotbench.calibration.result import display_two_sigma, share_that_stays
from pitotbench.units import KNOT


def test_one_reading_errs_by_half_a_step_and_many_average_out():
    log = fixture.fly(fixture.circles(1), 1, 1, fixture.CALM)
    at = np.asarray(air.calibrated_airspeed(log.impact_pressure))[:1]
    one = replace(log, velocity_north=np.full(len(log), 50.0), velocity_east=np.zeros(len(log)))
    steps = {"ground_speed_mps": KNOT}
    assert display_two_sigma(one, at, steps)[0] == pytest.approx(2.0 * KNOT / np.sqrt(12.0))
    # A full turn of 100 different readings at each airspeed.
    assert display_two_sigma(log, at, steps)[0] == pytest.approx(
        2.0 * KNOT / np.sqrt(1200.0), rel=0.05
    )
    assert display_two_sigma(log, at, {})[0] == 0.0


def test_the_bound_widens_and_says_so():
    log = fixture.fly(fixture.circles(1), 1, 1, fixture.Air(pressure=3.0))
    shown = replace(
        log, header={**log.header, "display": {"airspeed_mps": KNOT, "ground_speed_mps": KNOT}}
    )
    plain, wide = calibrate(log), calibrate(shown)
    np.testing.assert_allclose(plain.curve.correction, wide.curve.correction)
    added = display_two_sigma(shown, wide.curve.indicated_airspeed, shown.header["display"])
    np.testing.assert_allclose(wide.curve.two_sigma, np.hypot(plain.curve.two_sigma, added))
    assert any("steps of the display" in warning for warning in wide.warnings)


TIME = np.arange(60.0)


def swung(kind, scatter, rng, seconds):
    """What moves a reading, in steps, over whole seconds."""
    if kind == "gusts":
        return lfilter([0.45], [1, -0.895], scatter * rng.standard_normal(seconds + 60))[
            60:
        ]  # 9 s correlation
    if kind == "noise":
        return scatter * rng.standard_normal(seconds)
    return (
        scatter
        * np.sqrt(2.0)
        * np.sin(2.0 * np.pi * np.arange(seconds) / 20.0 + rng.uniform(0.0, 6.3))
    )


@pytest.mark.parametrize("kind", ["noise", "gusts", "swing"])
@pytest.mark.parametrize("scatter", [0.0, 0.1, 0.2, 0.3, 0.5, 0.8])
def test_the_share_that_stays_is_not_below_the_mean_rounding_error(kind, scatter):
    """Steady legs of a minute: against the mean rounding error over an hour, with the level
    anywhere in a step.
    """
    rng = np.random.default_rng(7)
    errors, shares = [], []
    for _ in range(200):
        level = rng.uniform()
        true = level + swung(kind, scatter, rng, 3600)
        errors.append(np.mean(np.round(true) - true))
        shares.append(np.mean(share_that_stays(TIME, np.round(true[: len(TIME)]))))
    assert np.sqrt(np.mean(shares) / 12.0) > 0.9 * np.std(errors)


def test_a_reading_at_rest_keeps_its_error_and_one_in_gusts_loses_it():
    rng = np.random.default_rng(8)
    np.testing.assert_allclose(share_that_stays(TIME, np.full(60, 120.0)), 1.0)
    np.testing.assert_allclose(
        share_that_stays(4.0 * TIME, np.round(120.0 + rng.standard_normal(60))), 1.0
    )
    shares = share_that_stays(TIME, np.round(120.4 + rng.standard_normal(60)))
    assert np.mean(shares) < 0.15
    # The second half at rest keeps its error: one window does not speak for another.
    halves = np.where(TIME < 30.0, np.round(120.4 + rng.standard_normal(60)), 130.0)
    assert np.mean(share_that_stays(TIME, halves)) == pytest.approx(0.5, abs=0.15)


@pytest.mark.parametrize("display", ["1 kt", {"airspeed_mps": "1"}, {"airspeed_mps": -1.0}])
def test_a_header_may_hold_anything(display):
    log = fixture.fly(fixture.circles(1), 1, 1, fixture.Air(pressure=3.0))
    odd = replace(log, header={**log.header, "display": display})
    np.testing.assert_allclose(calibrate(odd).curve.two_sigma, calibrate(log).curve.two_sigma)
