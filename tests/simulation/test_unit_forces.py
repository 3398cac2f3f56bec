"""A unit of force on an axis changes the reaction as mechanics says."""

from dataclasses import replace

import numpy as np
import pytest

from pitotbench.effects.overlay import Overlay
from pitotbench.records.aircraft import Motion
from pitotbench.simulation.force_meter import AXES, measure_unit_forces, unit_overlay
from pitotbench.simulation.modified import loaded_mass
from pitotbench.simulation.plant import Plant
from pitotbench.units import POUND


def test_a_pound_of_drag_pulls_back_along_the_flow() -> None:
    one = np.ones(3)
    alpha = np.array([0.0, 0.05, 0.1])
    level = {n: 0.0 * one for n in Motion.__dataclass_fields__ if n != "temperature_offset"}
    motion = Motion(**level)
    motion = replace(
        motion,
        time=np.arange(3.0),
        static_pressure=85_000.0 * one,
        mach=0.22 * one,
        angle_of_attack=alpha,
        pitch=alpha,
        throttle_left=0.6 * one,
        throttle_right=0.6 * one,
        mass=(loaded_mass("navajo") - 20.0) * one,
    )
    plant = Plant.load("navajo", 25.0, Overlay() + unit_overlay())
    units = measure_unit_forces(plant, motion, loaded_mass("navajo"), {"aero/alpha-rad"})
    assert units.properties["aero/alpha-rad"] == pytest.approx(alpha, abs=1e-9)
    assert set(units.changes) == set(AXES)
    pull = POUND * 9.80665 / motion.mass  # m/s² a pound of force
    assert units.changes["DRAG"][:, 0] == pytest.approx(-pull * np.cos(alpha), rel=1e-5)
    assert units.changes["DRAG"][:, 2] == pytest.approx(-pull * np.sin(alpha), abs=1e-3 * pull[0])
    assert units.changes["SIDE"][:, 1] == pytest.approx(pull, rel=1e-5)
    assert np.all(units.changes["PITCH"][:, 4] > 0.0)
