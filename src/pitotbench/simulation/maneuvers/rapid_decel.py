"""Rapid Deceleration: power to idle and slow down, then the same on the reciprocal heading."""

from dataclasses import dataclass
from math import pi

from pitotbench.simulation.card import Card, quantity
from pitotbench.simulation.pilot import (
    ACCELERATION_LIMIT,
    Cockpit,
    Ticks,
    accelerate,
    leg,
    set_up,
    settle,
    turn,
    until,
)
from pitotbench.units import KNOT

JUDGED = ("heading", "altitude")


@dataclass(frozen=True, slots=True, kw_only=True)
class RapidDecelCard(Card):
    """Martos et al. (2011), III.A: at 160 KCAS power to idle, slow to 100 KCAS; a turn to the reciprocal; the
    same again. ±2°, ±50 ft, no airspeed tolerance; under 5 minutes (Table 2: 5).

    Ours: `dwell` at the first speed before the power is reduced. The turn is flown at the last speed; the aircraft
    then accelerates on the new heading, settles and repeats.
    """

    speeds: tuple[float, ...] = quantity((160.0, 100.0), "kt")
    heading: float = quantity(0.0, "deg")
    repeats: int = 2
    dwell: float = quantity(50.0, "s")
    settle: float = quantity(30.0, "s")

    def __post_init__(self) -> None:
        Card.__post_init__(self)
        self.require_decreasing_speeds()
        self.require_positive("repeats")


def fly(cockpit: Cockpit, card: RapidDecelCard) -> Ticks:
    """Fly the card: set up unrecorded; then leg and deceleration, with turn, acceleration and settling between."""
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
        cockpit.set_throttle(0.0)
        cockpit.begin(f"decel {run + 1}", *JUDGED)
        what = f"deceleration to {slow / KNOT:.0f} KCAS"
        yield from until(cockpit, lambda: cockpit.airspeed <= slow, ACCELERATION_LIMIT, what)
