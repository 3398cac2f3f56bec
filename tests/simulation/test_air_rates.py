"""The rates of the flow angles that the aerodynamics read are those against the air, in any wind."""

import numpy as np
import pytest

from pitotbench.axes import earth_to_body
from pitotbench.effects.overlay import evaluate
from pitotbench.simulation.plant import Air, Plant
from pitotbench.simulation.variant import AIR_RATES
from pitotbench.units import DEGREE, FOOT, KNOT

STEP = 1e-4  # s


def body(time: float) -> tuple[np.ndarray, np.ndarray]:
    """The velocity over ground and the wind in body axes of an airplane that turns steadily."""
    angles = np.array([0.3, 0.05, 1.0]) + np.array([0.2, 0.0, 0.05]) * time
    ground = np.array([200.0, 8.0 - 3.0 * time, 12.0 + 5.0 * time])
    wind = earth_to_body(np.array([[25.0], [-18.0], [3.0]]), *angles[:, None])
    return ground, np.array(wind)[:, 0]


def flow(time: float) -> np.ndarray:
    """The angles of attack and of sideslip."""
    ground, wind = body(time)
    u, v, w = ground - wind
    return np.array([np.arctan2(w, u), np.arctan2(v, np.hypot(u, w))])


def test_the_rates_are_those_of_the_angles():
    ground, wind = body(0.0)
    (u, v, w), level = ground - wind, np.hypot(*(ground - wind)[[0, 2]])
    du, dv, dw = (body(STEP)[0] - body(-STEP)[0]) / (2.0 * STEP)  # as JSBSim has them
    speed = np.hypot(level, v)
    jsbsim = {
        "aero/alphadot-rad_sec": (u * dw - w * du) / level**2,
        "aero/betadot-rad_sec": (dv * speed**2 - v * (u * du + v * dv + w * dw))
        / (speed**2 * level),
    }
    # Euler rates to body rates.
    roll, pitch, turn = 0.2, 0.0, 0.05
    phi, theta = 0.3, 0.05
    rates = (
        roll - turn * np.sin(theta),
        pitch * np.cos(phi) + turn * np.sin(phi) * np.cos(theta),
        turn * np.cos(phi) * np.cos(theta) - pitch * np.sin(phi),
    )
    properties = {
        **jsbsim,
        **{f"velocities/{n}-rad_sec": x for n, x in zip("pqr", rates, strict=True)},
        **{f"velocities/{n}-fps": x for n, x in zip("uvw", ground, strict=True)},
        **{f"velocities/{n}-aero-fps": x for n, x in zip("uvw", ground - wind, strict=True)},
    }
    true = (flow(STEP) - flow(-STEP)) / (2.0 * STEP)
    found = [float(evaluate(AIR_RATES[path][1], properties)) for path in jsbsim]
    assert found == pytest.approx(true, rel=1e-6)
    assert np.abs(np.array(list(jsbsim.values())) - true).min() > 0.005  # what JSBSim has is not


@pytest.mark.parametrize(("aircraft", "wind"), [("navajo", 15.0), ("c172x", 15.0), ("navajo", 0.0)])
def test_an_airplane_that_rolls_in_wind_has_the_rate_of_its_angle_of_attack(aircraft, wind):
    plant = Plant.load(aircraft)
    plant.start(6000 * FOOT, 100 * KNOT, 0.0, Air(0.0, wind))
    plant.set("heading_target", 90 * DEGREE)
    rows = []
    for _ in range(400):
        plant.run(plant.time_step)
        names = ("angle_of_attack", "air/alphadot-rad_sec", "aero/alphadot-rad_sec")
        rows.append([plant.get(name) for name in names])
    angle, air, ground = np.array(rows).T
    true = np.gradient(angle, plant.time_step)[1:-1]
    assert air[1:-1] == pytest.approx(true, abs=0.1 * DEGREE)
    off = np.abs(ground[1:-1] - true).max()
    assert off > 0.5 * DEGREE if wind else np.array_equal(air, ground)
