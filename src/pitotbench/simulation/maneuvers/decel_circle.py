"""Decelerating circle: one long steep turn from fast to slow, with a dwell at each speed."""

from dataclasses import dataclass
from math import degrees

from pitotbench.simulation.card import Card, quantity
from pitotbench.simulation.pilot import Cockpit, Ticks, decelerate, require_steep_turns, set_up, settle, wait
from pitotbench.units import KNOT

JUDGED = ("airspeed", "altitude")


@dataclass(frozen=True, slots=True, kw_only=True)
class DecelCircleCard(Card):
    """Ours: the Circle of Martos et al. (2011), III.A, but steeper, and slowed down in the turn, so that only the
    first speed has to be set up. ±2 KCAS and ±50 ft in the dwells.

    Every speed is flown on every heading, so the wind and the curve are two unknowns, not one. The airplane turns
    faster than gusts decay, so gusts average out sooner than on straight legs. Half the time is at the middle
    speed and a quarter at each end: for a quadratic curve this gives the smallest mean variance.
    """

    speeds: tuple[float, ...] = quantity((160.0, 130.0, 100.0), "kt")
    dwells: tuple[float, ...] = quantity((72.0, 145.0, 72.0), "s")
    bank: float = quantity(45.0, "deg")
    heading: float = quantity(0.0, "deg")
    bank_limit: float = quantity(50.0, "deg")
    airspeed_rate_limit: float = quantity(1.5, "kt")
    airspeed_tolerance: float = quantity(2.0, "kt")
    settle: float = quantity(5.0, "s")

    def __post_init__(self) -> None:
        Card.__post_init__(self)
        self.require_decreasing_speeds()
        self.require_one_each("dwells", "speeds")
        require_steep_turns(self.bank)


def fly(cockpit: Cockpit, card: DecelCircleCard) -> Ticks:
    """Fly the card: set up unrecorded, roll in, then dwell at each speed and slow down to the next."""
    yield from set_up(cockpit, card.speeds[0], card.heading)
    cockpit.hold_bank(card.bank)
    for index, (speed, dwell) in enumerate(zip(card.speeds, card.dwells, strict=True)):
        what = f"{speed / KNOT:.0f} kt bank {degrees(card.bank):.0f}°"
        if index:
            yield from decelerate(cockpit, speed, f"slow to {what}")
        yield from settle(cockpit, f"settle {what}", JUDGED)
        cockpit.begin(f"circle {what}", *JUDGED)
        yield from wait(dwell)
