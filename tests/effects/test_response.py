"""Lags and delays: exact against analytic solutions, whatever the rate, and afresh after a pause."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from pitotbench.effects.response import (
    Signals,
    delayed,
    first_order,
    first_order_varying,
    second_order,
)


def on(time: np.ndarray) -> Signals:
    return Signals(time, {"x": np.zeros_like(time)})


@pytest.mark.parametrize("rate", [1.0, 20.0, 100.0])
@pytest.mark.parametrize("lag", [0.05, 0.4, 3.0])
def test_a_ramp_is_late_by_the_lag(rate, lag):
    """To rounding, also where the lag is shorter than a sample: no half step anywhere."""
    time = np.arange(0.0, 60.0, 1.0 / rate)
    assert (time - first_order(on(time), time, lag))[-1] == pytest.approx(lag, rel=1e-6)
    assert (time - second_order(on(time), time, lag, 0.6))[-1] == pytest.approx(lag, rel=1e-6)
    assert (time - first_order_varying(on(time), time, np.full_like(time, lag)))[
        -1
    ] == pytest.approx(lag, rel=1e-6)


def test_the_whole_response_to_a_ramp_is_the_analytic_one():
    time = np.arange(0.0, 5.0, 0.05)
    exact = time - 0.7 * (1.0 - np.exp(-time / 0.7))
    np.testing.assert_allclose(first_order(on(time), time, 0.7), exact, atol=1e-12)
    np.testing.assert_allclose(
        first_order_varying(on(time), time, np.full_like(time, 0.7)), exact, atol=1e-12
    )


def test_the_second_order_line_against_integration():
    """Integrated from sample to sample: no step of the integration may cross a kink of the drive."""
    time = np.arange(0.0, 8.0, 0.02)
    lag, damping = 0.6, 0.4
    w = 2.0 * damping / lag
    drive = np.sin(time)

    def rates(t: float, x: np.ndarray, start: float, value: float, slope: float) -> list[float]:
        return [x[1], w * w * (value + slope * (t - start) - x[0]) - 2.0 * damping * w * x[1]]

    states = [np.zeros(2)]
    slopes = np.diff(drive) / np.diff(time)
    for span, *sample in zip(pairwise(time), time[:-1], drive[:-1], slopes, strict=True):
        found = solve_ivp(rates, span, states[-1], "DOP853", rtol=1e-9, atol=1e-12, args=sample)
        states.append(found.y[:, -1])
    exact = np.array(states)[:, 0]
    np.testing.assert_allclose(
        second_order(on(time), drive, lag, damping), exact, rtol=0.0, atol=1e-8
    )


@pytest.mark.parametrize(
    "respond", [lambda s, x: first_order(s, x, 1.0), lambda s, x: second_order(s, x, 1.0, 0.6)]
)
def test_a_pause_begins_anew_and_settled(respond):
    time = np.concatenate([np.arange(0.0, 10.0, 0.1), np.arange(200.0, 210.0, 0.1)])
    values = np.where(time < 100.0, 1.0, 5.0) + 0.0 * time
    np.testing.assert_allclose(respond(on(time), values), values, atol=1e-12)


def test_a_delay_moves_a_ramp_by_itself_holds_at_the_start_and_passes_north_the_short_way():
    time = np.arange(0.0, 10.0, 0.05)
    out = delayed(on(time), time, 0.33)
    np.testing.assert_allclose(out[7:], time[7:] - 0.33, atol=1e-12)
    assert (out[:7] == 0.0).all()
    out = delayed(on(time), np.mod(6.0 + 0.1 * time, 2 * np.pi), 0.5, angle=True)
    assert np.abs(np.sin(out[20:] - 6.0 - 0.1 * (time[20:] - 0.5))).max() < 1e-9
