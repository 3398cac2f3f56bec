"""A solar airplane's log (PX4, 1 Hz pressure and GPS): no truth beside it, but scale, zero and
bound are stable.

A robust fit of the same log with scale, zero and lag, published with the data, leaves a zero near
100 Pa.
"""

from dataclasses import replace

import numpy as np
import pytest
from tests.shared_data import real_log

from pitotbench.calibration import calibrate
from pitotbench.calibration.options import CalibrationOptions, options_from
from pitotbench.logbook.mapping import find_mapping
from pitotbench.logbook.reading import read_log
from pitotbench.records.log import AT_REST
from pitotbench.units import KNOT


@pytest.fixture(scope="module")
def log():
    return read_log(real_log("seaway", "differential_pressure_0.csv"), mapping="seaway")


def _options() -> CalibrationOptions:
    return options_from({**find_mapping("seaway").calibrate, "latency": "checked"})


def _without_rest(log):
    """The log without what its rows at rest say of the zero."""
    return replace(log, header={k: v for k, v in log.header.items() if k != AT_REST})


def _scale_and_zero(log):
    result = calibrate(log, _options())
    zero = next(s.estimate for s in result.shares if s.name == "impact_pressure_zero_pa")
    return result, result.parameters[0], zero


def test_scale_zero_latency_and_bound_are_reported(log):
    result, scale, zero = _scale_and_zero(log)
    print(
        f"scale k1 {scale.value:+.3f} ± {scale.two_sigma:.3f}, zero {zero.value:.0f} ± "
        f"{zero.two_sigma:.0f} Pa (2σ)"
    )
    latency = result.diagnostics.latency
    print(f"latency {latency.value:+.2f} ± {latency.two_sigma:.2f} s (2σ)")
    assert zero.value == pytest.approx(100.0, abs=15.0)
    assert abs(scale.value) < scale.two_sigma + 0.1


def test_stable_under_halving_the_data(log):
    """Every second sample agrees with the whole within its own bounds, which are no smaller and of
    the same size.

    The gusts found here last a second. Half of the samples hardly resolve them, and the prior of
    the length then has more say.
    """
    log = _without_rest(log)
    flown = np.flatnonzero(np.hypot(log.velocity_north, log.velocity_east) > 5.0)
    _, whole_scale, whole_zero = _scale_and_zero(log)
    for half in (0, 1):
        _, scale, zero = _scale_and_zero(log.select(flown[half::2]))
        print(f"half {half}: k1 {scale.value:+.3f} ± {scale.two_sigma:.3f}")
        print(f"half {half}: zero {zero.value:.0f} ± {zero.two_sigma:.0f} Pa")
        assert abs(scale.value - whole_scale.value) < scale.two_sigma
        assert abs(zero.value - whole_zero.value) < zero.two_sigma
        assert whole_scale.two_sigma < scale.two_sigma < 2.0 * whole_scale.two_sigma


def test_the_rest_shows_the_zero_that_the_flight_shows(log):
    """Ten minutes on the ground and the flight alone agree, and both together know it better."""
    (_, _, flown), (_, _, both) = (_scale_and_zero(each) for each in (_without_rest(log), log))
    readings = [each["reading_pa"] for each in log.header[AT_REST]]
    print(f"at rest {readings}, flown {flown.value:.0f} ± {flown.two_sigma:.0f} Pa")
    assert np.all(np.abs(np.array(readings) - flown.value) < 1.5 * flown.two_sigma)
    assert both.two_sigma < 0.8 * flown.two_sigma


def test_the_correction_is_for_the_raw_reading(log):
    """33 kt indicated hold a zero offset near 100 Pa: the airplane flies about 12 kt slower."""
    result = calibrate(log, _options())
    curve = result.curve
    correction, bound = (
        np.interp(33.0 * KNOT, curve.indicated_airspeed, values) / KNOT
        for values in (curve.correction, curve.two_sigma)
    )
    print(f"at 33 kt indicated add {correction:+.1f} ± {bound:.1f} kt (2σ)")
    assert correction == pytest.approx(-12.0, abs=1.0)
    assert 0.3 < bound < 2.0
