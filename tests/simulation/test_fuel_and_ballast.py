"""Fuel and ballast: the mass that a case states is the mass that flies."""

import pytest

from pitotbench import BadInputError, Case, fly
from pitotbench.simulation.modified import Loading, ballast_for, loaded_fuel, loaded_mass, loading_of, mass_of
from pitotbench.units import POUND

BURNT = 3.0  # kg, at most, until the card begins


def test_an_aircraft_as_loaded_weighs_its_structure_crew_and_fuel():
    """5,990 lb: 4,060 lb empty, 804 lb of crew and instruments, twice 563 lb of fuel."""
    assert loaded_mass("navajo") == pytest.approx(5990.0 * POUND, abs=0.1)
    assert loaded_fuel("navajo") == pytest.approx(2 * 563.0 * POUND)


@pytest.mark.parametrize(("fuel", "ballast"), [(1.0, 0.0), (0.4, 0.0), (1.0, 250.0), (0.5, -100.0)])
def test_a_flight_begins_at_the_mass_of_its_case(fuel: float, ballast: float) -> None:
    flight = fly(Case(maneuver="rapid_decel", turbulence="none", fuel=fuel, ballast=ballast))
    assert 0.0 < mass_of("navajo", Loading(fuel, ballast)) - flight["mass"][0] < BURNT


@pytest.mark.parametrize("mass", [2100.0, 2300.0, 2504.0, 2717.0, 2950.0])
def test_a_loading_gives_the_mass_it_was_asked_for(mass: float) -> None:
    loading = loading_of("navajo", mass)
    assert mass_of("navajo", loading) == pytest.approx(mass, abs=1e-6)
    assert 0.1 - 1e-9 <= loading.fuel <= 1.0
    # Fuel goes first, and ballast only takes what fuel cannot.
    assert mass > 2717.0 or loading.ballast == 0.0 or loading.fuel == pytest.approx(0.1)
    assert mass < 2950.0 or loading.fuel == pytest.approx(1.0)
    assert ballast_for("navajo", 2880.0, 2900.0) == pytest.approx(2900.0 - loaded_mass("navajo"))


@pytest.mark.parametrize("mass", [300.0, 5990.0])
def test_the_mass_of_another_airplane_is_refused(mass: float) -> None:
    with pytest.raises(BadInputError, match="check the unit"):
        ballast_for("navajo", mass, mass)
