"""Circle: a full turn at constant bank and airspeed, one for each airspeed."""

from dataclasses import dataclass
from math import degrees, pi

from pitotbench.simulate.maneuvers.card import Card, quantity
from pitotbench.simulate.maneuvers.cockpit import Cockpit
from pitotbench.simulate.maneuvers.phases import Ticks, require_steep_turns, set_up, settle, sweep
from pitotbench.units import KNOT

JUDGED = ("airspeed", "altitude")


@dataclass(frozen=True, slots=True, kw_only=True)
class CircleCard(Card):
    """Martos et al. (2011), III.A: 30° of bank, 160, 140, 120 and 100 KCAS, ±2 KCAS and ±50 ft; flown in the
    simulator only (Table 2: 6 minutes).

    Ours: `settle` in the turn, then `circles` full turns on condition; the roll-out belongs to the set-up.
    """

    bank: float = quantity(30.0, "deg")
    heading: float = quantity(0.0, "deg")
    circles: float = 1.0
    bank_limit: float = quantity(35.0, "deg")
    settle: float = quantity(10.0, "s")
    airspeed_tolerance: float = quantity(2.0, "kt")

    def __post_init__(self) -> None:
        Card.__post_init__(self)
        self.require_positive("circles")
        require_steep_turns(self.bank)


def fly(cockpit: Cockpit, card: CircleCard) -> Ticks:
    """Fly the card. At each speed: set up unrecorded, roll in, settle, circle."""
    for speed in card.speeds:
        yield from set_up(cockpit, speed, card.heading)
        cockpit.hold_bank(card.bank)
        what = f"{speed / KNOT:.0f} kt bank {degrees(card.bank):.0f}°"
        yield from settle(cockpit, f"settle {what}", JUDGED)
        cockpit.begin(f"circle {what}", *JUDGED)
        yield from sweep(cockpit, 2.0 * pi * card.circles, card.bank)
