"""The force meter against a flight of the same aircraft: what was felt is what it says, whatever is aboard."""

from dataclasses import replace

import numpy as np
import pytest

from pitotbench import Case, air, fly
from pitotbench.records.motion import Motion, Reaction
from pitotbench.simulate.force_meter import measure
from pitotbench.simulate.fuel_and_ballast import ballast_for, ballast_overlay, loaded_mass
from pitotbench.simulate.plant import Plant

EVERY = 10  # samples of the flight a state
STATES = (
    *("time", "static_pressure", "angle_of_attack", "sideslip", "roll", "pitch", "heading", "roll_rate"),
    *("pitch_rate", "yaw_rate", "elevator", "aileron", "rudder", "throttle_left", "throttle_right", "mass"),
)
LOADINGS = {"full tanks": {}, "40 % of the fuel": {"fuel": 0.4}, "200 kg more": {"ballast": 200.0}}


def felt_by_the_model(motion: Motion) -> Reaction:
    ballast = ballast_for("navajo", float(motion.mass.min()), float(motion.mass.max()))
    plant = Plant.load("navajo", overlay=ballast_overlay("navajo", ballast))
    return measure(plant, motion, loaded_mass("navajo") + ballast)


@pytest.fixture(scope="module", params=LOADINGS.values(), ids=LOADINGS.keys())
def pair(request):
    flight = fly(Case(maneuver="rapid_decel", turbulence="light", truth_seed=5, **request.param))
    mach = air.mach_from_impact_pressure(
        flight["total_pressure"] - flight["static_pressure"], flight["static_pressure"]
    )
    motion = Motion(**{n: flight[n][::EVERY].copy() for n in STATES}, mach=mach[::EVERY].copy())
    return flight, motion, felt_by_the_model(motion)


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
    flight, _, reaction = pair
    error = getattr(reaction, name) - flight[name][::EVERY]
    assert abs(error.mean()) < mean
    assert error.std() < deviation < flight[name].std()


def test_angular_acceleration_agrees_with_the_rates(pair) -> None:
    flight, _, reaction = pair
    turned = np.gradient(flight["roll_rate"], flight["time"])[::EVERY]
    assert np.std(reaction.roll_acceleration - turned) < 0.5 * turned.std()


def test_the_measured_mass_decides_the_force(pair) -> None:
    """40 kg are 1.5 % of the weight, so of the specific force along z in level flight."""
    _, motion, reaction = pair
    lighter = felt_by_the_model(replace(motion, mass=motion.mass - 40.0))
    expected = 40.0 / motion.mass.mean()
    assert np.mean(lighter.specific_force_z / reaction.specific_force_z) == pytest.approx(1.0 + expected, rel=2e-3)
