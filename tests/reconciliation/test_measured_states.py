"""The states of a log in which the model is put: the temperature of another day."""

import numpy as np
import pytest

from pitotbench import air
from pitotbench.reconciliation.track import Track, varied_states


@pytest.mark.parametrize("warmer", [-15.0, 0.0, 8.0, 20.0])
def test_the_offset_of_a_day_is_that_of_its_air_at_every_height(warmer: float) -> None:
    """The air is made from its own law: hydrostatic balance through a standard lapse with an offset."""
    height = np.linspace(1000.0, 2500.0, 400)
    temperature = air.SEA_LEVEL_TEMPERATURE + warmer - air.LAPSE_RATE * height
    exponent = air.GRAVITY / (air.GAS_CONSTANT * air.LAPSE_RATE)
    pressure = air.SEA_LEVEL_PRESSURE * (temperature / (air.SEA_LEVEL_TEMPERATURE + warmer)) ** exponent
    still = np.zeros_like(height)
    channels = {
        "static_pressure": pressure,
        "impact_pressure": np.full_like(height, 3000.0),
        "air_temperature": temperature,
        "angle_of_attack": still,
        "sideslip": still,
    }
    time = 0.1 * np.arange(len(height))
    track = Track(time, channels, (0, len(time)), np.arange(len(time)), 0.1, 0.1)
    found = varied_states(track, np.arange(0, len(time), 5))["temperature_offset"]
    assert found == pytest.approx(warmer, abs=1e-6)
