"""Fly the card of a log again in the simulator, without and with the patch."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from math import atan2, hypot, pi

import numpy as np

from pitotbench import air
from pitotbench.campaigns.fleet import require_all, run_tasks
from pitotbench.campaigns.flights import flown as fly_case
from pitotbench.reconciliation.card_comparison import (
    compare_cards,
    control_activity_difference,
    gust_difference,
)
from pitotbench.reconciliation.free_parameters import curve_of
from pitotbench.reconciliation.layout import DAY, Layout, below_range_end, mean_wind_of
from pitotbench.reconciliation.recording_checks import check_log
from pitotbench.reconciliation.shown_flight import ShownFlight
from pitotbench.reconciliation.track import track_of
from pitotbench.records import BadInputError
from pitotbench.records.case import PILOTS, Case, EffectSpec, PressureErrorSpec, Wind, rates_for
from pitotbench.records.gap import FlownAgain
from pitotbench.records.log import FlightLog
from pitotbench.records.maneuver import Maneuvers

# Difference from which another pilot is tried: two flights of one pilot differ by some 0.15.
OTHER_PILOT = 0.3
# difference of the logarithms below which other gusts are no reason for another motion
SAME_GUSTS = 0.25
# Of each airplane, unpatched and patched, so that the differences between flights show chance.
FLIGHTS = 3
# The free parameters of the temperature, where no header states it: by its effect on the airplane,
# and as measured
TEMPERATURE_SIZE, MEASURED_TEMPERATURE_SIZE = f"{DAY} warmer_k", "temperature offset"
CURVE_POINTS = 96  # of the error curve: lines between them are within 0.01 kt of it, for errors of up to 0.15 q_c
SEED = 760_001  # truth and sensor seeds count up from here


def fly_again(
    log: FlightLog | Maneuvers, card: Case | None, effects: Sequence[EffectSpec]
) -> FlownAgain:
    """Compare a log with its card as the simulator flies it, in the log's wind.

    The card is flown without the effects and with them.

    Where the airplane of the log moves to and fro as under another hand than that of the card, in
    gusts of the same strength, the card is flown by the pilot whose hand is nearest in one flight
    with the effects. Returns only a reason where there is no card, or where it cannot be flown.
    """
    if isinstance(log, Maneuvers):
        return FlownAgain(skipped="maneuvers have no card")
    if card is None:
        return FlownAgain(
            skipped="no card: the header of the log holds none and --card was not given"
        )
    if log.segment is None:
        return FlownAgain(
            skipped="the log has no column `segment`: its parts cannot be matched to those of the "
            "card"
        )
    # Means of segments are compared, and the slowest rate gives them too.
    slow = rates_for(card.das.air_rate)[0]
    base = replace(card, wind=wind_of_log(log), effects=(), integration_rate=slow)
    trial, others = range(SEED, SEED + 1), range(SEED + 1, SEED + FLIGHTS)
    try:
        tried = {base.pilot: _flights(base, effects, trial)}
        if (
            control_activity_difference(log, tried[base.pilot]) > OTHER_PILOT
            and gust_difference(log, tried[base.pilot]) < SAME_GUSTS
        ):
            for other in set(PILOTS) - {base.pilot}:
                with suppress(BadInputError):  # a card may be too hard for another pilot
                    tried[other] = _flights(replace(base, pilot=other), effects, trial)
        pilot = min(tried, key=lambda p: control_activity_difference(log, tried[p]))
        flown = replace(base, pilot=pilot)
        after = [*tried[pilot], *_flights(flown, effects, others)]
        before = _flights(flown, (), range(SEED, SEED + FLIGHTS)) if effects else after
    except BadInputError as error:
        return FlownAgain(skipped=f"the card cannot be flown: {error}")
    compared = compare_cards(log, before, after)
    return compared if pilot == base.pilot else replace(compared, pilot=pilot)


def _flights(card: Case, effects: Sequence[EffectSpec], numbers: Sequence[int]) -> list[FlightLog]:
    """Flights of a card with some effects, a number of seeds each."""
    cases = [replace(card, truth_seed=n, sensor_seed=n, effects=tuple(effects)) for n in numbers]
    return require_all(run_tasks(fly_case, cases, jobs=1))


def as_the_log_shows(card: Case | None, shown: ShownFlight) -> Case | None:
    """Return a card with the error curve of a log, and its temperature if the day is not stated.

    The free parameters say how much warmer the air is than on the card.
    """
    if card is None:
        return card
    layout = shown.block.layout
    free = shown.block.equations.free_sizes(shown.fit.columns)
    sizes = dict(zip(layout.free.names, free.tolist(), strict=True))
    card = replace(card, pressure_error=error_curve_of(layout, sizes))
    if TEMPERATURE_SIZE not in sizes:
        return card
    # A card counts from the standard day at its geometric height, a log from that at its pressure
    # height. In warmer air a pressure lies higher, where the standard day is cooler.
    height = air.pressure_altitude(layout.reference.clean["static_pressure"])
    steeper = air.SEA_LEVEL_TEMPERATURE / float(np.mean(air.standard_temperature(height)))
    measured = sizes.get(MEASURED_TEMPERATURE_SIZE, 0.0)  # a log may lack the thermometer
    return replace(
        card,
        temperature_offset=card.temperature_offset + sizes[TEMPERATURE_SIZE] + steeper * measured,
    )


def error_curve_of(layout: Layout, sizes: Mapping[str, float]) -> PressureErrorSpec:
    """Return the error curve that a log shows, with `sizes` of its free parameters.

    The curve spans the airspeeds of the log as they are after correction, and is constant beyond
    them.
    """
    shown = layout.reference.clean["impact_pressure"][layout.measured]
    indicated = np.linspace(float(shown.min()), float(shown.max()), CURVE_POINTS)
    share = curve_of(indicated, (*layout.curves, sizes))
    location = "static" if layout.setting.static_error else "impact"
    speeds = air.calibrated_airspeed(indicated).tolist()
    return PressureErrorSpec(
        "table", airspeed=tuple(speeds), values=tuple(share.tolist()), location=location
    )


def wind_of_log(log: FlightLog) -> Wind:
    """Return the mean wind of a log: ground velocity less velocity through the air."""
    track = track_of(log, check_log(log).fresh)
    north, east, _ = mean_wind_of(track, below_range_end(track, log))
    return Wind(hypot(north, east), (atan2(-east, -north)) % (2.0 * pi), 0.0)
