"""Instants: on the samples where rates allow, between them where not, never across a gap."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pitotbench.sensing.sampling import flight_rate, schedule

TIME = 5.0 + np.arange(1001) / 100.0
GAPPED = np.where(np.arange(1001) < 400, TIME, TIME + 12.34)


def test_flight_rate_ignores_gaps():
    assert flight_rate(GAPPED) == pytest.approx(100.0)


@pytest.mark.parametrize(("air", "gps"), [(100, 100), (50, 50), (50, 10), (20, 1), (100, 1)])
def test_whole_ratios_fall_on_samples(air, gps):
    when = schedule(TIME, air, gps)
    assert not when.rows.weight.any()
    np.testing.assert_allclose(when.rows.of(TIME), when.time, atol=1e-12)
    np.testing.assert_allclose(np.diff(when.time), 1.0 / air, rtol=1e-6)
    assert when.fresh.sum() == len(when.gps.below) == 10 * gps + 1
    held = when.gps.of(TIME)[when.fix]
    assert np.all((when.time - held > -1e-9) & (when.time - held < 1.0 / gps - 0.5 / air))


@given(st.floats(1.5, 100.0), st.floats(0.01, 1.0))
def test_any_ratio(air, share):
    """A linear channel is interpolated exactly; each row holds the latest fix and none of the future."""
    when = schedule(TIME, air, air * share)
    np.testing.assert_allclose(when.rows.of(TIME), when.time, atol=1e-6)
    age = when.time - when.gps.of(TIME)[when.fix]
    assert age.min() > -1e-6
    assert age.max() < 1.0 / (air * share) + 1e-6
    assert when.fresh[0]
    np.testing.assert_array_equal(when.fresh[1:], np.diff(when.fix) > 0)


def test_a_gap_is_not_bridged():
    when = schedule(GAPPED, 20.0, 1.0)
    inside = (when.time <= GAPPED[399]) | (when.time >= GAPPED[400])
    assert inside.all()
    first = int(np.searchsorted(when.time, GAPPED[400]))
    assert when.time[first] == GAPPED[400]
    assert when.fresh[first]
    assert when.gps.of(GAPPED)[when.fix][first] == GAPPED[400]


def test_latency_shows_the_past():
    when = schedule(TIME, 50.0, 50.0, air_latency=0.125, gps_latency=0.5)
    late = when.time > TIME[0] + 0.5
    np.testing.assert_allclose((when.time - when.air.of(TIME))[late], 0.125, atol=1e-9)
    np.testing.assert_allclose((when.time - when.gps.of(TIME)[when.fix])[late], 0.5, atol=1e-9)
    assert when.air.of(TIME)[0] == TIME[0]
