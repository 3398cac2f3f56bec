"""Figure eight: at each speed, steep full turns to one side and then to the other."""

from dataclasses import dataclass
from math import degrees, pi

from pitotbench.simulation.card import Card, quantity
from pitotbench.simulation.pilot import Cockpit, Ticks, decelerate, require_steep_turns, set_up, settle, sweep
from pitotbench.units import KNOT

JUDGED = ("airspeed", "altitude")


@dataclass(frozen=True, slots=True, kw_only=True)
class FigureEightCard(Card):
    """Ours: the Circle of Martos et al. (2011), III.A, steeper, to both sides, and slowed down in the turn, so
    that only the first speed has to be set up. ±2 KCAS and ±50 ft in the turns.

    An error that depends on the side of the turn (a probe at an angle to the flow, a sideslip) shows as a
    difference of the two halves and cancels in their mean. Without wind, each eight ends where it began.
    """

    speeds: tuple[float, ...] = quantity((160.0, 130.0, 100.0), "kt")
    turns: tuple[float, ...] = (0.8, 1.2, 1.0)
    bank: float = quantity(45.0, "deg")
    heading: float = quantity(0.0, "deg")
    bank_limit: float = quantity(50.0, "deg")
    roll_rate_limit: float = quantity(15.0, "degps")
    airspeed_rate_limit: float = quantity(1.5, "kt")
    airspeed_tolerance: float = quantity(2.0, "kt")
    settle: float = quantity(3.0, "s")

    def __post_init__(self) -> None:
        Card.__post_init__(self)
        self.require_decreasing_speeds()
        self.require_positive("turns")
        self.require_one_each("turns", "speeds")
        require_steep_turns(self.bank)


def fly(cockpit: Cockpit, card: FigureEightCard) -> Ticks:
    """Fly the card: set up unrecorded; at each speed turn to one side, then to the other; slow down in the turn."""
    yield from set_up(cockpit, card.speeds[0], card.heading)
    bank = -card.bank
    for index, (speed, turns) in enumerate(zip(card.speeds, card.turns, strict=True)):
        for half in range(2):
            # A new speed begins on the side where the last one ended, which saves a roll.
            bank = bank if index and not half else -bank
            cockpit.hold_bank(bank)
            what = f"{speed / KNOT:.0f} kt bank {degrees(bank):.0f}°"
            if index and not half:
                yield from decelerate(cockpit, speed, f"slow to {what}")
            yield from settle(cockpit, f"settle {what}", JUDGED)
            cockpit.begin(f"circle {what}", *JUDGED)
            yield from sweep(cockpit, 2.0 * pi * turns, bank)
