"""A card flown again: the same airplane is within every tolerance, and a difference shows in its
unit.
"""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pitotbench import Case, FlightLog, air, fly, sense
from pitotbench.bench.flights import true_correction
from pitotbench.bench.null_flights import aircraft_model
from pitotbench.bench.workflow import as_the_log_shows, error_curve_of, fly_again
from pitotbench.catalog import Catalog
from pitotbench.effects import EFFECTS
from pitotbench.reconciliation.card_comparison import compare_cards, features_of, hand_apart
from pitotbench.reconciliation.free_parameters import AnalysisSetting, fit_free_parameters
from pitotbench.reconciliation.layout import DAY, lay_out
from pitotbench.records.case import DataSystem, PressureErrorSpec
from pitotbench.units import DEGREE, FOOT, INCH_OF_MERCURY, KNOT, Array

LEG, DECEL = "leg 150 kt 000°", "decel 1"


def log(rate: float = -1.0, pitch: float = 2.0, noise: int = 0, segments: bool = True) -> FlightLog:
    """A leg of 40 s at 150 kt, then 30 s of slowing down at a rate [kt/s], 10 Hz."""
    time = np.arange(700) / 10.0
    speed = 150.0 + rate * np.maximum(time - 40.0, 0.0)
    speed = speed + np.random.default_rng(noise).normal(0.0, 0.05, time.shape)
    zero = np.zeros_like(time)
    return FlightLog(
        time=time,
        impact_pressure=air.impact_pressure(speed * KNOT),
        static_pressure=zero + 80_000.0,
        velocity_north=speed * KNOT,
        velocity_east=zero,
        roll=zero,
        pitch=zero + pitch * DEGREE,
        heading=zero,
        manifold_pressure_left=zero + 28.0 * INCH_OF_MERCURY,
        segment=np.where(time < 40.0, LEG, DECEL) if segments else None,
    )


def cards(first: float = -1.0, second: float = -1.0) -> tuple[list[FlightLog], list[FlightLog]]:
    """The card flown twice by the model, and twice by the patched one, at rates of slowing down
    [kt/s].
    """
    return [log(first, noise=1), log(first, noise=2)], [log(second, noise=3), log(second, noise=4)]


def test_the_same_airplane_is_within_every_tolerance():
    flown = compare_cards(log(noise=9), *cards())
    assert [t.quantity for t in flown.tolerances] == [
        "indicated airspeed",
        "pitch",
        "bank",
        "heading",
    ]
    assert all(t.before == t.after == t.by_chance == 1.0 for t in flown.tolerances)
    assert not flown.skipped
    decel = next(
        h for h in flown.histories if h.quantity == "indicated airspeed" and h.time[0] > 1.0
    )
    assert decel.time[0] == pytest.approx(40.0)  # at the time of the log
    assert decel.measured[0] == pytest.approx(150.0, abs=0.5)
    pitch = compare_cards(log(pitch=3.0), *cards()).tolerances[1]
    assert (pitch.half_width, pitch.before, pitch.after) == (
        pytest.approx(0.6),
        0.0,
        0.0,
    )  # degrees
    assert "segments" in compare_cards(log(segments=False), *cards()).skipped


def test_a_steeper_deceleration_leaves_the_tolerance_and_is_a_feature():
    flown = compare_cards(log(-1.2, noise=9), *cards(-1.0, -1.2))
    airspeed = flown.tolerances[0]
    # 1.2 kt apart after 6 of the 30 s in which it slows down, of 70 s in all
    assert airspeed.before == pytest.approx(46 / 70, abs=0.02)
    assert airspeed.after == 1.0
    slowing = next(
        f for f in flown.features if (f.segment, f.name) == (DECEL, "change of airspeed")
    )
    assert slowing.measured == pytest.approx(-1.2, abs=0.01)
    assert slowing.simulated == pytest.approx(-1.0, abs=0.01)
    assert abs(slowing.measured - slowing.simulated) > 10.0 * slowing.deviation
    assert abs(slowing.measured - slowing.patched) < 5.0 * slowing.deviation


def test_a_turn_has_bank_beyond_that_of_its_turn_rate():
    speed, bank = 70.0, 30.0 * DEGREE
    part = log().select(np.arange(200))
    angle = 9.80665 * np.tan(bank) / speed * part.time
    turning = replace(
        part,
        roll=np.full(200, bank + 1.0 * DEGREE),
        heading=angle % (2 * np.pi),
        velocity_north=speed * np.cos(angle),
        velocity_east=speed * np.sin(angle),
        segment=None,
    )
    found = features_of(turning)
    assert found["bank beyond that of the turn rate", "°"] == pytest.approx(1.0, abs=0.01)


def shown_as(layout: Any, sizes: Array) -> Any:
    """A flight without effects: a layout and the sizes of its free parameters."""
    equations = SimpleNamespace(free_sizes=lambda columns: sizes)
    block = SimpleNamespace(layout=layout, equations=equations)
    return SimpleNamespace(block=block, fit=SimpleNamespace(columns=()))


@pytest.mark.parametrize("parameters", [(-0.060, 0.006, 0.060), (0.10, -0.02, -0.08)])
def test_a_card_is_flown_with_the_error_curve_that_the_log_shows(
    parameters: tuple[float, ...],
) -> None:
    """The curve of a log of 80 to 160 kt, an analyst's own, is within 0.4 kt of the one that was
    flown.
    """
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


def test_the_hand_is_told_by_what_moves_to_and_fro():
    still = log(noise=1)
    time = still.time

    def moved(amplitude: float) -> FlightLog:
        wave = amplitude * DEGREE * np.sin(2.0 * np.pi * time / 9.0)
        return replace(still, roll=wave, pitch=still.pitch + wave, heading=wave)

    assert hand_apart(moved(1.0), [moved(1.0), moved(1.0)]) == pytest.approx(0.0, abs=1e-9)
    assert hand_apart(moved(1.0), [moved(0.5), moved(0.5)]) == pytest.approx(np.log(2.0), abs=1e-6)
    assert hand_apart(still, [still]) == 0.0
    assert hand_apart(log(segments=False), [still]) == 0.0
    # Both logs must be long enough.
    assert hand_apart(log(), [log().select(np.arange(420))]) >= 0.0
    assert hand_apart(log().select(np.arange(52)), [log().select(np.arange(48))]) == 0.0


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
