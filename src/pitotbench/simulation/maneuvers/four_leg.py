"""4-Leg: at each speed four straight legs 90° apart, each a few seconds on condition."""

from dataclasses import dataclass

from pitotbench.simulation.card import Card, quantity
from pitotbench.simulation.pilot import Cockpit, Ticks, leg, set_up, settle, turn


@dataclass(frozen=True, slots=True, kw_only=True)
class FourLegCard(Card):
    """Martos et al. (2011), III.A: 160, 140, 120 and 100 KCAS, straight legs 90° apart, 5 to 10 s on condition
    a leg, ±1 KCAS, ±2°, ±50 ft, a circuit in 5 to 7 minutes (Table 2: 21 minutes in all).

    Ours: standard-rate turns, the last of which closes the circuit; `settle` after each turn; `dwell` on condition.
    """

    headings: tuple[float, ...] = quantity((0.0, 90.0, 180.0, 270.0), "deg")
    dwell: float = quantity(10.0, "s")
    settle: float = quantity(35.0, "s")


def fly(cockpit: Cockpit, card: FourLegCard) -> Ticks:
    """Fly the card. At each speed: set up unrecorded, then leg, turn and settle on each heading."""
    for speed in card.speeds:
        yield from set_up(cockpit, speed, card.headings[0])
        for here, following in zip(card.headings, (*card.headings[1:], card.headings[0]), strict=True):
            cockpit.targets.heading = here
            yield from leg(cockpit, card.dwell)
            yield from turn(cockpit, following)
            yield from settle(cockpit)
