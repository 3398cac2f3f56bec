"""What a log shows of its flight is what its card is flown with again: error curve, temperature, hand."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pitotbench import Case, fly, sense
from pitotbench.bench.fly_again import as_the_log_shows, error_curve_of, fly_again
from pitotbench.campaigns.flights import true_correction
from pitotbench.catalog import Catalog
from pitotbench.effects import EFFECTS
from pitotbench.models.aircraft_model import aircraft_model
from pitotbench.reconciliation.free_parameters import AnalysisSetting, fit_free_parameters
from pitotbench.reconciliation.layout import DAY, lay_out
from pitotbench.records.case import DataSystem, PressureErrorSpec
from pitotbench.units import FOOT, KNOT, Array


def shown_as(layout: Any, sizes: Array) -> Any:
    """A flight without effects: a layout and the sizes of its free parameters."""
    equations = SimpleNamespace(free_sizes=lambda columns: sizes)
    block = SimpleNamespace(layout=layout, equations=equations)
    return SimpleNamespace(block=block, fit=SimpleNamespace(columns=()))


@pytest.mark.parametrize("parameters", [(-0.060, 0.006, 0.060), (0.10, -0.02, -0.08)])
def test_a_card_is_flown_with_the_error_curve_that_the_log_shows(
    parameters: tuple[float, ...],
) -> None:
    """The curve of an analyst's log of 80 to 160 kt is within 0.4 kt of the one flown."""
    error = PressureErrorSpec(parameters=parameters)
    case = Case(maneuver="rapid_decel", turbulence="none", pressure_error=error, truth_seed=4713)
    layout = lay_out(sense(fly(case), "20/20"), None, AnalysisSetting(), Catalog("effect", {}))
    free = layout.free
    fit = fit_free_parameters(layout.residuals.values, free, layout.used)
    found = error_curve_of(layout, dict(zip(free.names, fit.sizes.tolist(), strict=True)))
    indicated = np.linspace(found.airspeed[2], found.airspeed[-3], 9)
    apart = true_correction(found, indicated) - true_correction(error, indicated)
    assert np.abs(true_correction(error, indicated)).max() > 0.5 * KNOT
    assert np.abs(apart).max() < 0.4 * KNOT


@pytest.mark.parametrize(("offset", "feet"), [(14.0, 8000.0), (-12.0, 4000.0)])
def test_a_card_is_flown_in_the_temperature_of_the_flight(offset: float, feet: float) -> None:
    """Counted from the standard day at the pressure height, the temperature was 0.3 and 0.8 K off."""
    case = Case(
        maneuver="rapid_decel", turbulence="none", altitude=feet * FOOT, temperature_offset=offset
    )
    untold = AnalysisSetting()
    layout = lay_out(
        sense(fly(case), "20/20"),
        aircraft_model("navajo"),
        untold,
        Catalog("effect", {DAY: EFFECTS[DAY]}),
    )
    fit = fit_free_parameters(layout.residuals.values, layout.free, layout.used)
    shown = as_the_log_shows(replace(case, temperature_offset=0.0), shown_as(layout, fit.sizes))
    assert shown.temperature_offset == pytest.approx(offset, abs=0.1)


@pytest.mark.parametrize(
    ("air", "pilot", "found"),
    [("light", "none", ""), ("light", "busy", "busy"), ("moderate", "none", "")],
)
def test_the_card_is_flown_by_the_hand_that_the_log_shows(air: str, pilot: str, found: str):
    """The header tells of no pilot, and the log was flown by one; other gusts are no other hand."""
    card = Case(
        maneuver="circle",
        turbulence="light",
        das=DataSystem(20.0, 20.0),
        card={"speeds_kt": [150.0, 120.0]},
    )
    flight = sense(fly(replace(card, turbulence=air, pilot=pilot, truth_seed=36_001)), "20/20")
    again = fly_again(flight, card, ())
    assert again.pilot == found
    bank = next(t for t in again.tolerances if t.quantity == "bank")
    assert air == "moderate" or bank.before > 0.8 * bank.by_chance
