"""What gusts add to the airspeed on average, against draws of gusts."""

import numpy as np
import pytest

from pitotbench import air
from pitotbench.calibrate.gls.linearized_problem import Gusts, mean_excess

PRESSURE, TEMPERATURE = 60000.0, 260.0
STIFF = 1e-6  # m: gusts so short that no airplane follows them


@pytest.mark.parametrize("airspeed", [60.0, 150.0, 240.0])
def test_of_gusts_that_do_not_carry_the_airplane_it_is_the_mean_over_draws(airspeed):
    sigma = 0.05 * airspeed  # large, so that draws show it
    half = sigma * np.random.default_rng(3).standard_normal((400_000, 3))
    gusts = np.concatenate([half, -half])  # pairs: what is linear in a gust cancels
    through = np.array([airspeed, 0.0, 0.0]) - gusts
    sound = float(air.sound_speed(TEMPERATURE))
    felt = air.impact_pressure_from_mach(np.linalg.norm(through, axis=1) / sound, PRESSURE)
    still = float(air.impact_pressure_from_mach(np.array(airspeed / sound), PRESSURE))
    step = 0.01
    ends = air.impact_pressure_from_mach(np.array([airspeed - step, airspeed + step]) / sound, PRESSURE)
    drawn = float(np.mean(felt - still)) / (float(np.diff(ends)[0]) / (2.0 * step))
    found = mean_excess(Gusts(sigma, STIFF), np.array([airspeed]), np.array([airspeed / sound]))
    assert found[0] == pytest.approx(drawn, rel=0.02)


def test_for_a_light_twin_it_is_near_that_of_gusts_across_alone():
    """0.85 of σ²/V, from the covariances of gusts and velocity in simulated flights: ρ of 0.45 and 0.2."""
    found = mean_excess(Gusts(0.6, 533.0), np.array([65.0]), np.array([0.2]))
    assert found[0] == pytest.approx(0.85 * 0.6**2 / 65.0, rel=0.05)


def test_gusts_so_long_that_they_carry_the_airplane_add_less():
    lengths = [100.0, 533.0, 3000.0]
    found = [mean_excess(Gusts(0.6, length), np.array([65.0]), np.array([0.2]))[0] for length in lengths]
    assert found[0] > found[1] > found[2]
