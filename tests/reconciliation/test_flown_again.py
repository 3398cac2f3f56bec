"""A card flown again: the same airplane is within every tolerance, and a difference shows in its
unit.
"""

from dataclasses import replace

import numpy as np
import pytest

from pitotbench import FlightLog, air
from pitotbench.reconciliation.card_comparison import (
    compare_cards,
    control_activity_difference,
    features_of,
)
from pitotbench.units import DEGREE, INCH_OF_MERCURY, KNOT

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


def test_the_hand_is_told_by_what_moves_to_and_fro():
    still = log(noise=1)
    time = still.time

    def moved(amplitude: float) -> FlightLog:
        wave = amplitude * DEGREE * np.sin(2.0 * np.pi * time / 9.0)
        return replace(still, roll=wave, pitch=still.pitch + wave, heading=wave)

    assert control_activity_difference(moved(1.0), [moved(1.0), moved(1.0)]) == pytest.approx(
        0.0, abs=1e-9
    )
    assert control_activity_difference(moved(1.0), [moved(0.5), moved(0.5)]) == pytest.approx(
        np.log(2.0), abs=1e-6
    )
    assert control_activity_difference(still, [still]) == 0.0
    assert control_activity_difference(log(segments=False), [still]) == 0.0
    # Both logs must be long enough.
    assert control_activity_difference(log(), [log().select(np.arange(420))]) >= 0.0
    assert (
        control_activity_difference(log().select(np.arange(52)), [log().select(np.arange(48))])
        == 0.0
    )
