"""Drawn gusts have the spectra of MIL-F-8785C and change nothing but what the air data see."""

from dataclasses import replace

import numpy as np
import pytest

from pitotbench.bench.planner import _dryden, gust_deviation, with_gusts
from pitotbench.records.case import Case
from pitotbench.units import FOOT

RATE, STEP = 0.15, 0.2  # V/L [1/s], s


@pytest.fixture(scope="module")
def gusts():
    time = np.arange(60_000) * STEP
    return _dryden(time, np.full(len(time), RATE), np.random.default_rng(1))


def correlation(gust, lag):
    n = round(lag / STEP)
    return float(np.mean(gust[n:] * gust[:-n]))


def test_both_gusts_have_unit_variance_at_steps_of_any_length(gusts):
    rng = np.random.default_rng(2)
    time = np.cumsum(rng.exponential(5.0, 20_000))
    uneven = _dryden(time, np.full(len(time), RATE), rng)
    np.testing.assert_allclose([np.var(gust) for gust in (*gusts, *uneven)], 1.0, rtol=0.05)


@pytest.mark.parametrize("lag", [2.0, 6.0, 12.0])
def test_correlations_are_drydens(gusts, lag):
    """Longitudinal exp(−a τ), lateral (1 − a τ/2) exp(−a τ): Hoblit (1988), eqs. for f and g."""
    along, across = gusts
    decay = np.exp(-RATE * lag)
    assert correlation(along, lag) == pytest.approx(decay, abs=0.05)
    assert correlation(across, lag) == pytest.approx((1.0 - 0.5 * RATE * lag) * decay, abs=0.05)


@pytest.mark.parametrize("turbulence", ["light", "moderate"])
def test_level_is_that_of_the_simulator(turbulence, light_flights):
    """The level by the standard's figure, against the simulator's own turbulence at the same height."""
    from pitotbench import bench

    case = Case(maneuver="circle", turbulence=turbulence)
    flight = light_flights["circle"] if turbulence == "light" else bench.fly(case)
    mean = bench.wind_toward(case.wind)
    parts = [flight[f"wind_{axis}"] - w for axis, w in zip(("north", "east"), mean, strict=False)]
    assert np.sqrt(np.mean(np.square(parts))) == pytest.approx(gust_deviation(case), rel=0.25)
    # Still air has no gusts, and high air fewer.
    assert gust_deviation(Case(turbulence="none")) == 0.0
    low, high = (gust_deviation(replace(case, altitude=h * FOOT, turbulence="moderate")) for h in (3000.0, 9000.0))
    assert low > high > 0.0


def test_stirring_moves_the_airspeed_and_nothing_else(smooth_flights):
    flight = smooth_flights["circle"]
    rough = with_gusts(flight, "moderate", 3)
    moved = {name for name in flight.channels if not np.array_equal(flight[name], rough[name])}
    assert moved == {"true_airspeed", "total_pressure"}
    change = rough["true_airspeed"] - flight["true_airspeed"]
    assert np.std(change) == pytest.approx(gust_deviation(rough.case), rel=0.35)
    assert np.array_equal(rough["total_pressure"], with_gusts(flight, "moderate", 3)["total_pressure"])
    assert np.array_equal(with_gusts(flight, "none", 3)["total_pressure"], flight["total_pressure"])


def test_one_draw_serves_flights_of_any_rate(smooth_flights):
    flight = smooth_flights["circle"]
    half = replace(
        flight,
        channels={name: values[::2] for name, values in flight.channels.items()},
        segment=flight.segment[::2],
        on_condition=flight.on_condition[::2],
    )
    gusts, again = (with_gusts(f, "light", 3)["true_airspeed"] - f["true_airspeed"] for f in (flight, half))
    np.testing.assert_allclose(again, gusts[::2], atol=1e-12)
