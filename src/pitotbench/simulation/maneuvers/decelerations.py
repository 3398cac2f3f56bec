"""Decelerations on one heading and its reciprocal: by power steps, or with power idle.

Step Decrease: slow down by small power reductions on one heading, then on the reciprocal.
Step Decrease both ways: all speeds by small power reductions on one heading, then all on the
reciprocal.
Rapid Deceleration: power to idle and slow down, then the same on the reciprocal heading.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import pi

from pitotbench.simulation.card import Card, count, quantity
from pitotbench.simulation.pilot import (
    Cockpit,
    Ticks,
    accelerate,
    leg,
    set_up,
    settle,
    slowed,
    step_down,
    turn,
)

JUDGED = ("heading", "altitude")


@dataclass(frozen=True, slots=True, kw_only=True)
class StepDecreaseCard(Card):
    """Step Decrease of Martos et al. (2011), III.A: less power step by step.

    From 160 KCAS less one inch of manifold pressure every 5 to 10 s until 130 KCAS; a turn to the
    reciprocal; the same to 100 KCAS. ±2°, ±50 ft, no airspeed tolerance; 5 to 6 minutes (Table 2:
    6).

    Ours: `dwell` at the first speed of each heading before the power is reduced; `speeds` are those
    at which each deceleration starts and ends.
    """

    speeds: tuple[float, ...] = quantity((160.0, 130.0, 100.0), "kt", decreasing=True)
    heading: float = quantity(0.0, "deg")
    dwell: float = quantity(40.0, "s")
    step: float = quantity(1.0, "inhg")
    step_time: float = quantity(10.0, "s", positive=True)
    settle: float = quantity(30.0, "s")


def fly_step_decrease(cockpit: Cockpit, card: StepDecreaseCard) -> Ticks:
    """Fly the card: for each pair of speeds leg, power steps, turn, settle.

    The set-up is not recorded.
    """
    heading = card.heading
    yield from set_up(cockpit, card.speeds[0], heading)
    for index, floor in enumerate(card.speeds[1:]):
        if index:
            cockpit.hold_airspeed(card.speeds[index])
            heading += pi
            yield from turn(cockpit, heading)
            yield from settle(cockpit)
        yield from leg(cockpit, card.dwell, *JUDGED)
        yield from step_down(cockpit, card.step, card.step_time, floor, *JUDGED)


@dataclass(frozen=True, slots=True, kw_only=True)
class StepBothWaysCard(Card):
    """Step Decrease of Martos et al. (2011), III.A, with every speed on both headings.

    The wind along the track and the curve are then two unknowns, not one. ±2°, ±50 ft, no airspeed
    tolerance.

    Ours: all but the steps. From the first speed to the last on one heading, a turn to the
    reciprocal at the last speed, acceleration, and the same again. Larger steps keep the time at
    that of the paper's maneuver.
    """

    speeds: tuple[float, ...] = quantity((160.0, 100.0), "kt", decreasing=True)
    heading: float = quantity(0.0, "deg")
    repeats: int = count(2, positive=True)
    dwell: float = quantity(20.0, "s")
    step: float = quantity(1.5, "inhg")
    step_time: float = quantity(8.0, "s", positive=True)
    settle: float = quantity(10.0, "s")


def fly_step_both_ways(cockpit: Cockpit, card: StepBothWaysCard) -> Ticks:
    """Fly the card: leg and power steps, with turn, acceleration and settling between.

    The set-up is not recorded.
    """

    def step_by_step(_: int) -> Ticks:
        yield from step_down(cockpit, card.step, card.step_time, card.speeds[-1], *JUDGED)

    yield from _both_ways(cockpit, card, step_by_step)


@dataclass(frozen=True, slots=True, kw_only=True)
class RapidDecelCard(Card):
    """Rapid Deceleration of Martos et al. (2011), III.A.

    At 160 KCAS power to idle, slow to 100 KCAS; a turn to the reciprocal; the same again. ±2°, ±50
    ft, no airspeed tolerance; under 5 minutes (Table 2: 5).

    Ours: `dwell` at the first speed before the power is reduced. The turn is flown at the last
    speed; the aircraft then accelerates on the new heading, settles and repeats.
    """

    speeds: tuple[float, ...] = quantity((160.0, 100.0), "kt", decreasing=True)
    heading: float = quantity(0.0, "deg")
    repeats: int = count(2, positive=True)
    dwell: float = quantity(50.0, "s")
    settle: float = quantity(30.0, "s")


def fly_rapid_decel(cockpit: Cockpit, card: RapidDecelCard) -> Ticks:
    """Fly the card: leg and deceleration, with turn, acceleration and settling between.

    The set-up is not recorded.
    """

    def with_power_idle(run: int) -> Ticks:
        cockpit.set_throttle(0.0)
        cockpit.begin(f"decel {run + 1}", *JUDGED)
        yield from slowed(cockpit, card.speeds[-1])

    yield from _both_ways(cockpit, card, with_power_idle)


def _both_ways(
    cockpit: Cockpit, card: StepBothWaysCard | RapidDecelCard, slow_down: Callable[[int], Ticks]
) -> Ticks:
    """Set up unrecorded, then fly leg and deceleration on a heading and its reciprocal in turn."""
    heading = card.heading
    yield from set_up(cockpit, card.speeds[0], heading)
    for run in range(card.repeats):
        if run:
            heading += pi
            cockpit.hold_airspeed(card.speeds[-1])
            yield from turn(cockpit, heading)
            yield from accelerate(cockpit, card.speeds[0])
            yield from settle(cockpit)
        yield from leg(cockpit, card.dwell, *JUDGED)
        yield from slow_down(run)
