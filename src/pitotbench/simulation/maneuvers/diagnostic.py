"""Diagnostic: climb, descent, sideslip and power tell apart causes that calibrations confuse."""

from dataclasses import dataclass
from math import pi

from pitotbench.simulation.card import Card, quantity
from pitotbench.simulation.pilot import (
    Cockpit,
    Ticks,
    accelerate,
    change_height,
    leg,
    set_up,
    settle,
    slowed,
    turn,
    wait,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class DiagnosticCard(Card):
    """Ours: a maneuver that separates causes which a calibration confuses.

    At the first speed a climb and a descent at constant airspeed (they separate a slow static line
    from a slow pitot line, and height from time), steady-heading sideslips to both sides (sideslip
    error, rudder), a turn to the reciprocal (GPS against air data), and power to idle and back on
    one heading (lag against latency, drag against power).
    """

    speeds: tuple[float, ...] = quantity((150.0, 110.0), "kt", decreasing=True)
    heading: float = quantity(0.0, "deg")
    climb: float = quantity(800.0, "ft")
    sideslip: float = quantity(4.0, "deg", positive=True)
    sideslip_time: float = quantity(20.0, "s", positive=True)
    dwell: float = quantity(15.0, "s")
    settle: float = quantity(10.0, "s")
    airspeed_tolerance: float = quantity(3.0, "kt")


def fly_diagnostic(cockpit: Cockpit, card: DiagnosticCard) -> Ticks:
    """Fly the card: leg, climb, descent, sideslips, turn, power to idle and back.

    The set-up is not recorded.
    """
    fast, slow = card.speeds[0], card.speeds[-1]
    yield from set_up(cockpit, fast, card.heading)
    base = cockpit.targets.altitude
    yield from leg(cockpit, card.dwell)
    yield from change_height(cockpit, "climb", base + card.climb)
    yield from change_height(cockpit, "descent", base)
    for side, angle in (("right", card.sideslip), ("left", -card.sideslip)):
        yield from _sideslip(cockpit, f"sideslip {side}", angle, card.sideslip_time)
    yield from turn(cockpit, card.heading + pi)
    yield from settle(cockpit)
    cockpit.set_throttle(0.0)
    cockpit.begin(cockpit.name("decel"))
    yield from slowed(cockpit, slow)
    yield from accelerate(cockpit, fast)


def _sideslip(cockpit: Cockpit, label: str, angle: float, seconds: float) -> Ticks:
    """Hold a steady-heading sideslip [rad] for a time [s], then end it."""
    cockpit.hold_sideslip(angle)
    cockpit.begin(cockpit.name(label))
    yield from wait(seconds)
    cockpit.hold_sideslip(0.0)
    yield from settle(cockpit)
