"""Step Decrease: slow down by small power reductions on one heading, then on the reciprocal."""

from dataclasses import dataclass
from math import pi

from pitotbench.simulation.card import Card, quantity
from pitotbench.simulation.pilot import Cockpit, Ticks, leg, set_up, settle, step_down, turn

JUDGED = ("heading", "altitude")


@dataclass(frozen=True, slots=True, kw_only=True)
class StepDecreaseCard(Card):
    """Martos et al. (2011), III.A: from 160 KCAS less one inch of manifold pressure every 5 to 10 s until
    130 KCAS; a turn to the reciprocal; the same to 100 KCAS. ±2°, ±50 ft, no airspeed tolerance; 5 to 6
    minutes (Table 2: 6).

    Ours: `dwell` at the first speed of each heading before the power is reduced; `speeds` are those at which each
    deceleration starts and ends.
    """

    speeds: tuple[float, ...] = quantity((160.0, 130.0, 100.0), "kt")
    heading: float = quantity(0.0, "deg")
    dwell: float = quantity(40.0, "s")
    step: float = quantity(1.0, "inhg")
    step_time: float = quantity(10.0, "s")
    settle: float = quantity(30.0, "s")

    def __post_init__(self) -> None:
        Card.__post_init__(self)
        self.require_decreasing_speeds()
        self.require_positive("step", "step_time")


def fly(cockpit: Cockpit, card: StepDecreaseCard) -> Ticks:
    """Fly the card: set up unrecorded; then, for each pair of speeds, leg, power steps, turn, settle."""
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
