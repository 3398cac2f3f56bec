"""The force meter against a flight of the same aircraft: what was felt is what it says."""

import numpy as np
import pytest

from pitotbench import Case, air, fly
from pitotbench.records.motion import Motion
from pitotbench.simulate.force_meter import loaded_mass, measure
from pitotbench.simulate.plant import Plant

EVERY = 10  # samples of the flight a state
STATES = (
    *("time", "static_pressure", "angle_of_attack", "sideslip", "roll", "pitch", "heading", "roll_rate"),
    *("pitch_rate", "yaw_rate", "elevator", "aileron", "rudder", "throttle_left", "throttle_right", "mass"),
)


@pytest.fixture(scope="module")
def pair():
    flight = fly(Case(maneuver="rapid_decel", turbulence="light", truth_seed=5))
    mach = air.mach_from_impact_pressure(
        flight["total_pressure"] - flight["static_pressure"], flight["static_pressure"]
    )
    motion = Motion(**{n: flight[n][::EVERY].copy() for n in STATES}, mach=mach[::EVERY].copy())
    return flight, measure(Plant.load("navajo"), motion, loaded_mass("navajo"))


@pytest.mark.parametrize(
    ("name", "mean", "deviation"),
    [
        ("specific_force_x", 0.002, 0.01),
        ("specific_force_y", 0.002, 0.01),
        ("specific_force_z", 0.01, 0.03),
        ("manifold_pressure_left", 50.0, 400.0),
        ("propeller_speed_right", 0.05, 0.4),
        ("fuel_flow_left", 1e-5, 1e-4),
    ],
)
def test_it_says_what_the_flight_felt(pair, name: str, mean: float, deviation: float) -> None:
    flight, reaction = pair
    error = getattr(reaction, name) - flight[name][::EVERY]
    assert abs(error.mean()) < mean
    assert error.std() < deviation < flight[name].std()


def test_angular_acceleration_agrees_with_the_rates(pair) -> None:
    flight, reaction = pair
    turned = np.gradient(flight["roll_rate"], flight["time"])[::EVERY]
    assert np.std(reaction.roll_acceleration - turned) < 0.5 * turned.std()
