"""The air: directions, seeds and the strength of turbulence."""

import numpy as np
import pytest
from tests.simulation.plant_record import record_channels

from pitotbench.catalog import UnknownNameError
from pitotbench.records.case import Case, Wind
from pitotbench.simulation.plant import Plant
from pitotbench.simulation.properties import LARGEST_SEED, Air, turbulence_seed
from pitotbench.units import DEGREE, FOOT, KNOT


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
