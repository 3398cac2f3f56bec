"""The plant and its air: starts where asked, says what it refuses, and turns silent failures into
errors.
"""

import math

import numpy as np
import pytest
from tests.simulation.plant_record import record_channels

from pitotbench.catalog import UnknownNameError
from pitotbench.records.case import Case, Wind
from pitotbench.simulation.aircraft_files import SimulationError
from pitotbench.simulation.plant import LARGEST_SEED, Air, Plant, check_table, turbulence_seed
from pitotbench.simulation.properties import PROPERTIES, Property
from pitotbench.units import DEGREE, FOOT, KNOT


@pytest.fixture
def plant() -> Plant:
    plant = Plant.load("navajo")
    plant.start(6000 * FOOT, 140 * KNOT, 90 * DEGREE)
    return plant


@pytest.mark.parametrize("speed", [100, 160])
@pytest.mark.parametrize("wind", [(0.0, 0.0), (20.0, -15.0)])
def test_start_reaches_level_flight(speed, wind):
    plant = Plant.load("navajo")
    plant.start(6000 * FOOT, speed * KNOT, 90 * DEGREE, Air(*wind))
    assert plant.get("calibrated_airspeed") / KNOT == pytest.approx(speed, abs=0.5)
    assert plant.get("altitude") / FOOT == pytest.approx(6000, abs=15)
    assert plant.get("heading") == pytest.approx(90 * DEGREE, abs=1 * DEGREE)


def test_level_flight_reads_minus_one_g(plant):
    found = record_channels(plant, 2.0)
    assert len(found["time"]) == 200
    assert np.diff(found["time"]) == pytest.approx(0.01)
    assert found["specific_force_z"].mean() == pytest.approx(-9.79, abs=0.05)
    assert found["mass"].mean() == pytest.approx(2717, rel=0.02)


def test_controls_move_the_autopilot(plant):
    plant.set("heading_target", 120 * DEGREE)
    plant.set("airspeed_target", 130 * KNOT)
    plant.run(40.0)
    assert plant.get("heading") == pytest.approx(120 * DEGREE, abs=2 * DEGREE)
    assert plant.get("calibrated_airspeed") == pytest.approx(130 * KNOT, abs=1.5 * KNOT)


def test_unknown_and_read_only_names_are_refused(plant):
    with pytest.raises(UnknownNameError, match="Did you mean 'altitude'"):
        plant.get("altitud")
    with pytest.raises(UnknownNameError, match="h-sl-ft"):
        plant.get("position/h-sl-feet")
    with pytest.raises(UnknownNameError, match="read-only"):
        plant.set("calibrated_airspeed", 70.0)
    with pytest.raises(SimulationError, match="finite"):
        plant.set("airspeed_target", math.nan)


def test_the_table_is_checked_when_an_aircraft_is_loaded():
    catalog = {line.path: "RW" for line in PROPERTIES.values()}
    check_table("some", catalog)
    with pytest.raises(UnknownNameError, match=r"'some' does not serve 'mass'.*inertia/mass-slugs"):
        check_table(
            "some", {path: access for path, access in catalog.items() if "mass" not in path}
        )
    with pytest.raises(UnknownNameError, match="read-only"):
        check_table("some", {"ap/x": "R"}, [Property("x", "ap/x", writable=True)])


def test_a_departure_and_the_ground_are_errors(plant):
    plant.set("lateral_mode", 0)
    plant.set("fcs/aileron-cmd-norm", 1.0)
    with pytest.raises(SimulationError, match="departed"):
        plant.run(30.0)
    low = Plant.load("navajo")
    low.start(500 * FOOT, 140 * KNOT)
    low.set("pitch_mode", 3)
    low.set("pitch_target", -10 * DEGREE)
    with pytest.raises(SimulationError, match="ground"):
        low.run(60.0)


def test_plants_do_not_disturb_each_other():
    alone = Plant.load("navajo")
    alone.start(6000 * FOOT, 120 * KNOT, air=Air(severity=1, seed=7))
    alone.run(3.0)
    one, other = Plant.load("navajo"), Plant.load("navajo")
    one.start(6000 * FOOT, 120 * KNOT, air=Air(severity=1, seed=7))
    other.start(6000 * FOOT, 150 * KNOT, air=Air(severity=1, seed=8))
    for _ in range(30):
        one.run(0.1)
        other.run(0.1)
    assert one.get("true_airspeed") == alone.get("true_airspeed")


def test_wind_from_the_west_blows_east():
    air = Air.of(Case(wind=Wind(10.0, 270 * DEGREE, up=2.0)))
    assert (air.north, air.east, air.down) == pytest.approx((0.0, 10.0, -2.0))
    with pytest.raises(UnknownNameError, match="none, light, moderate"):
        Air.of(Case(turbulence="severe"))


def test_seeds_are_in_range_and_differ():
    seeds = [turbulence_seed(seed) for seed in range(200)]
    assert len(set(seeds)) == 200
    assert min(seeds) >= 1
    assert max(seeds) <= LARGEST_SEED


def test_turbulence_grows_with_severity_and_changes_with_the_seed():
    gusts = {}
    for severity, seed in ((0, 5), (1, 5), (1, 6), (2, 5)):
        plant = Plant.load("navajo")
        plant.start(6000 * FOOT, 140 * KNOT, air=Air(severity=severity, seed=seed))
        gusts[severity, seed] = record_channels(plant, 60.0)["wind_down"]
    strength = {key: float(np.std(gust)) for key, gust in gusts.items()}
    assert strength[0, 5] == 0.0
    assert 0.05 < strength[1, 5] < 0.6
    assert strength[2, 5] > 1.5 * strength[1, 5]
    assert (gusts[1, 5] != gusts[1, 6]).any()
