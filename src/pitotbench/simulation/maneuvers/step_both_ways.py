"""Step Decrease both ways: all speeds by small power reductions on one heading, then all on the reciprocal."""

from dataclasses import dataclass
from math import pi

from pitotbench.simulation.card import Card, quantity
from pitotbench.simulation.pilot import Cockpit, Ticks, accelerate, leg, set_up, settle, step_down, turn

JUDGED = ("heading", "altitude")


@dataclass(frozen=True, slots=True, kw_only=True)
class StepBothWaysCard(Card):
    """Step Decrease of Martos et al. (2011), III.A, with every speed on both headings, so that the wind along the
    track and the curve are two unknowns, not one. ±2°, ±50 ft, no airspeed tolerance.

    Ours: all but the steps. From the first speed to the last on one heading, a turn to the reciprocal at the last
    speed, acceleration, and the same again. Larger steps keep the time at that of the paper's maneuver.
    """

    speeds: tuple[float, ...] = quantity((160.0, 100.0), "kt")
    heading: float = quantity(0.0, "deg")
    repeats: int = 2
    dwell: float = quantity(20.0, "s")
    step: float = quantity(1.5, "inhg")
    step_time: float = quantity(8.0, "s")
    settle: float = quantity(10.0, "s")

    def __post_init__(self) -> None:
        Card.__post_init__(self)
        self.require_decreasing_speeds()
        self.require_positive("repeats", "step", "step_time")


def fly(cockpit: Cockpit, card: StepBothWaysCard) -> Ticks:
    """Fly the card: set up unrecorded; then leg and power steps, with turn, acceleration and settling between."""
    heading, fast, slow = card.heading, card.speeds[0], card.speeds[-1]
    yield from set_up(cockpit, fast, heading)
    for run in range(card.repeats):
        if run:
            heading += pi
            cockpit.hold_airspeed(slow)
            yield from turn(cockpit, heading)
            yield from accelerate(cockpit, fast)
            yield from settle(cockpit)
        yield from leg(cockpit, card.dwell, *JUDGED)
        yield from step_down(cockpit, card.step, card.step_time, slow, *JUDGED)
