"""Each piece of a sensor alone."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pitotbench.records.case import DataSystem, PressureErrorSpec
from pitotbench.sensing.recorder import (
    add_noise,
    indicated_impact_pressure,
    known_curve,
    noise_stream,
    quantize,
    saturate,
)

DAS = DataSystem()


@given(st.lists(st.floats(-1e5, 1e5), min_size=1), st.sampled_from([0.01, 0.2, 0.3, 1.0, 1.5, 5.0]))
def test_quantize_rounds_to_the_nearest_step(values, resolution):
    rounded = quantize(np.array(values), resolution)
    assert np.all(np.abs(rounded - values) <= resolution * (0.5 + 1e-6))
    np.testing.assert_allclose(rounded / resolution, np.rint(rounded / resolution), atol=1e-6)
    np.testing.assert_array_equal(quantize(rounded, resolution), rounded)


def test_ends_steps_and_a_table_by_hand():
    assert [repr(float(v)) for v in quantize(np.array([0.12341, 1630.37]), 0.001)] == ["0.123", "1630.37"]
    np.testing.assert_array_equal(saturate(np.array([-3.0, 5.0, 99.0]), 0.0, 10.0), [0.0, 5.0, 10.0])
    spec = PressureErrorSpec("table", airspeed=(40.0, 80.0), values=(0.1, 0.1))
    assert indicated_impact_pressure(np.array([1000.0]), known_curve(spec)) == pytest.approx(900.0)


def test_noise_has_its_deviation_and_is_white():
    noise = add_noise(np.zeros(200_000), 12.0, noise_stream(1, "impact_pressure", DAS))
    assert noise.std() == pytest.approx(12.0, rel=0.01)
    assert abs(noise.mean()) < 0.1
    assert abs(np.corrcoef(noise[1:], noise[:-1])[0, 1]) < 0.01


def test_streams_are_independent_and_repeatable():
    def draw(seed=1, channel="roll", das=DAS):
        return noise_stream(seed, channel, das).standard_normal(5000)

    np.testing.assert_array_equal(draw(), draw())
    slow = DataSystem(air_rate=20.0, gps_rate=1.0)
    for other in (draw(seed=2), draw(channel="pitch"), draw(das=slow)):
        assert abs(np.corrcoef(draw(), other)[0, 1]) < 0.05
