"""Scale a card to the speeds of an aircraft."""

from dataclasses import replace

from pitotbench import air
from pitotbench.records.attached import Attached
from pitotbench.records.case import Case
from pitotbench.simulate.attach.record import read_record
from pitotbench.simulate.hangar import find_aircraft
from pitotbench.simulate.maneuvers import MANEUVERS
from pitotbench.simulate.maneuvers.card import Card, override
from pitotbench.units import KNOT

CARD_SPEEDS = (100.0, 160.0)  # KCAS: the slowest and the fastest of the cards, which are the paper's
ABOVE_STALL = 1.3  # times the stall speed: room for a bank of 45°
ABOVE_SLOWEST = 1.16  # times the slowest speed at which the autopilot's loops hold: the same room
SHARE = 0.76  # of the way from stall to maximum level speed: where 160 KCAS lies for the bench's own aircraft
READABLE = 280.0  # KCAS: the impact pressure of 285 is the end of the usual data system's range
SPREAD = 1.8  # largest ratio of the two speeds: more takes a jet minutes, and the paper's is 1.6


def card_of(case: Case) -> Card:
    """Return the card of a case: that of its maneuver, scaled to the speeds of its aircraft, with its overrides.

    Raises UnknownNameError for an unknown maneuver, aircraft or entry, BadInputError for a value of wrong shape.
    """
    return override(scaled_card(case.aircraft, case.maneuver), case.card)


def scaled_card(aircraft: str, maneuver: str) -> Card:
    """Return the card of a maneuver for an aircraft. The bench's own aircraft fly the cards as they are written."""
    card = MANEUVERS[maneuver].card
    record = read_record(find_aircraft(aircraft))
    if record is None:
        return card
    slow, fast = card_speeds(record)
    share = (fast - slow) / (CARD_SPEEDS[1] - CARD_SPEEDS[0])
    speeds = tuple(round(slow + (v / KNOT - CARD_SPEEDS[0]) * share) * KNOT for v in card.speeds)
    return replace(card, speeds=speeds, airspeed_rate_limit=card.airspeed_rate_limit * min(1.0, share))


def scaled_case(case: Case) -> Case:
    """Return a case whose true pressure error is scaled to its aircraft's card as the default is to 100 KCAS.

    The reference pressure becomes the impact pressure at the slowest speed of the cards. A case of the bench's own
    aircraft is returned as it is.
    """
    record = read_record(find_aircraft(case.aircraft))
    if record is None:
        return case
    reference = float(air.impact_pressure(card_speeds(record)[0] * KNOT))
    return replace(case, pressure_error=replace(case.pressure_error, reference_pressure=reference))


def speed_range(aircraft: str) -> tuple[float, float]:
    """Return the slowest and the fastest speed of the cards for an aircraft [m/s, calibrated]."""
    record = read_record(find_aircraft(aircraft))
    low, high = CARD_SPEEDS if record is None else card_speeds(record)
    return low * KNOT, high * KNOT


def card_speeds(record: Attached) -> tuple[float, float]:
    """Return the slowest and the fastest speed [kt] of the cards for an aircraft.

    They lie between the stall and the maximum level speed as 100 and 160 KCAS do for the bench's own aircraft.
    """
    slow = max(ABOVE_STALL * record.stall_kt, ABOVE_SLOWEST * record.speed_kt[0])
    fast = record.stall_kt + SHARE * (record.fastest_kt - record.stall_kt)
    return slow, min(fast, SPREAD * slow, READABLE)
