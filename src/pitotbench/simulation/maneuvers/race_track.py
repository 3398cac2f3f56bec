"""Race Track: at each speed two long legs on reciprocal headings."""

from dataclasses import dataclass
from math import pi

from pitotbench.simulation.card import Card, quantity
from pitotbench.simulation.pilot import Cockpit, Ticks, leg, set_up, settle, turn


@dataclass(frozen=True, slots=True, kw_only=True)
class RaceTrackCard(Card):
    """Martos et al. (2011), III.A: 160, 140, 120 and 100 KCAS, 60 s on condition on each of two reciprocal
    headings, ±1 KCAS, ±2°, ±50 ft, a circuit in 3 to 4 minutes (Table 2: 15 minutes in all).

    Ours: the second turn closes the circuit and counts in its time; `settle` follows the first turn.
    """

    heading: float = quantity(0.0, "deg")
    dwell: float = quantity(60.0, "s")
    turn_rate: float = quantity(4.0, "degps")
    settle: float = quantity(5.0, "s")


def fly(cockpit: Cockpit, card: RaceTrackCard) -> Ticks:
    """Fly the card. At each speed: set up unrecorded, leg out, turn, settle, leg back, turn."""
    for speed in card.speeds:
        yield from set_up(cockpit, speed, card.heading)
        yield from leg(cockpit, card.dwell)
        yield from turn(cockpit, card.heading + pi)
        yield from settle(cockpit)
        yield from leg(cockpit, card.dwell)
        yield from turn(cockpit, card.heading)
