"""Straight legs on several headings, with turns between them.

4-Leg: at each speed four straight legs 90° apart, each a few seconds on condition. Race Track: at
each speed two long legs on reciprocal headings. Cloverleaf: at each speed three short legs 120°
apart that cross over one place, joined by steep turns.
"""

from dataclasses import dataclass
from math import degrees, pi

from pitotbench.simulation.card import Card, quantity
from pitotbench.simulation.pilot import Cockpit, Ticks, decelerate, leg, set_up, settle, turn
from pitotbench.units import KNOT


@dataclass(frozen=True, slots=True, kw_only=True)
class FourLegCard(Card):
    """4-Leg of Martos et al. (2011), III.A: straight legs 90° apart at each speed.

    160, 140, 120 and 100 KCAS, 5 to 10 s on condition a leg, ±1 KCAS, ±2°, ±50 ft, a circuit in 5
    to 7 minutes (Table 2: 21 minutes in all).

    Ours: standard-rate turns, the last of which closes the circuit; `settle` after each turn;
    `dwell` on condition.
    """

    headings: tuple[float, ...] = quantity((0.0, 90.0, 180.0, 270.0), "deg")
    dwell: float = quantity(10.0, "s")
    settle: float = quantity(35.0, "s")


def fly_four_leg(cockpit: Cockpit, card: FourLegCard) -> Ticks:
    """Fly the card. At each speed: set up unrecorded, then leg, turn and settle on each heading."""
    for speed in card.speeds:
        yield from set_up(cockpit, speed, card.headings[0])
        for here, following in zip(
            card.headings, (*card.headings[1:], card.headings[0]), strict=True
        ):
            cockpit.targets.heading = here
            yield from leg(cockpit, card.dwell)
            yield from turn(cockpit, following)
            yield from settle(cockpit)


@dataclass(frozen=True, slots=True, kw_only=True)
class RaceTrackCard(Card):
    """Race Track of Martos et al. (2011), III.A: two reciprocal legs at each speed.

    160, 140, 120 and 100 KCAS, 60 s on condition on each of two headings, ±1 KCAS, ±2°, ±50 ft, a
    circuit in 3 to 4 minutes (Table 2: 15 minutes in all).

    Ours: the second turn closes the circuit and counts in its time; `settle` follows the first
    turn.
    """

    heading: float = quantity(0.0, "deg")
    dwell: float = quantity(60.0, "s")
    turn_rate: float = quantity(4.0, "degps")
    settle: float = quantity(5.0, "s")


def fly_race_track(cockpit: Cockpit, card: RaceTrackCard) -> Ticks:
    """Fly the card. At each speed: set up unrecorded, leg out, turn, settle, leg back, turn."""
    for speed in card.speeds:
        yield from set_up(cockpit, speed, card.heading)
        yield from leg(cockpit, card.dwell)
        yield from turn(cockpit, card.heading + pi)
        yield from settle(cockpit)
        yield from leg(cockpit, card.dwell)
        yield from turn(cockpit, card.heading)


@dataclass(frozen=True, slots=True, kw_only=True)
class CloverleafCard(Card):
    """Ours: the cloverleaf that flight-test handbooks fly at one speed, at several.

    Its legs on three headings cross over one place, each followed by a turn of 240° to the right;
    then the same at a lower speed. ±2 KCAS, ±5° and ±50 ft on the legs.

    The legs calibrate the airplane with wings level, as it is normally flown. The turns are data as
    well: they pass every heading, and gusts average out in them.
    """

    speeds: tuple[float, ...] = quantity((160.0, 130.0, 100.0), "kt", decreasing=True)
    headings: tuple[float, ...] = quantity((0.0, 240.0, 120.0), "deg")
    dwells: tuple[float, ...] = quantity((3.0, 3.0, 3.0), "s", as_many_as="speeds")
    turn_rate: float = quantity(15.0, "degps")
    bank_limit: float = quantity(45.0, "deg", positive=True)
    roll_rate_limit: float = quantity(15.0, "degps")
    airspeed_rate_limit: float = quantity(1.5, "kt")
    airspeed_tolerance: float = quantity(2.0, "kt")
    heading_tolerance: float = quantity(5.0, "deg", positive=True)


def fly_cloverleaf(cockpit: Cockpit, card: CloverleafCard) -> Ticks:
    """Fly the card: at each speed a leg and a turn for each heading, then slow down.

    The set-up is not recorded.
    """
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
