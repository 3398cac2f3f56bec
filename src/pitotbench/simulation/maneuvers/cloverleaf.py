"""Cloverleaf: at each speed three short legs 120° apart that cross over one place, joined by steep turns."""

from dataclasses import dataclass
from math import degrees

from pitotbench.simulation.card import Card, quantity
from pitotbench.simulation.pilot import Cockpit, Ticks, decelerate, leg, set_up, turn
from pitotbench.units import KNOT


@dataclass(frozen=True, slots=True, kw_only=True)
class CloverleafCard(Card):
    """Ours: the cloverleaf that flight-test handbooks fly at one speed, with legs on three headings that cross
    over one place, each followed by a turn of 240° to the right; then the same at a lower speed. ±2 KCAS, ±5°
    and ±50 ft on the legs.

    The legs calibrate the airplane with wings level, as it is normally flown. The turns are data as well: they
    pass every heading, and gusts average out in them.
    """

    speeds: tuple[float, ...] = quantity((160.0, 130.0, 100.0), "kt")
    headings: tuple[float, ...] = quantity((0.0, 240.0, 120.0), "deg")
    dwells: tuple[float, ...] = quantity((3.0, 3.0, 3.0), "s")
    turn_rate: float = quantity(15.0, "degps")
    bank_limit: float = quantity(45.0, "deg")
    roll_rate_limit: float = quantity(15.0, "degps")
    airspeed_rate_limit: float = quantity(1.5, "kt")
    airspeed_tolerance: float = quantity(2.0, "kt")
    heading_tolerance: float = quantity(5.0, "deg")

    def __post_init__(self) -> None:
        Card.__post_init__(self)
        self.require_decreasing_speeds()
        self.require_one_each("dwells", "speeds")


def fly(cockpit: Cockpit, card: CloverleafCard) -> Ticks:
    """Fly the card: set up unrecorded; at each speed a leg and a turn for each heading; slow down between."""
    first = card.headings[0]
    yield from set_up(cockpit, card.speeds[0], first)
    for index, (speed, dwell) in enumerate(zip(card.speeds, card.dwells, strict=True)):
        if index:
            what = f"{speed / KNOT:.0f} kt {degrees(first):03.0f}°"
            yield from decelerate(cockpit, speed, f"slow to {what}")
        for here, following in zip(card.headings, (*card.headings[1:], first), strict=True):
            cockpit.targets.heading = here
            yield from leg(cockpit, dwell)
            yield from turn(cockpit, following)
