"""Fly the card of a log again in the simulator, without and with the patch."""

import os
from collections.abc import Sequence
from dataclasses import replace
from math import atan2, hypot, pi

from pitotbench.bench.fleet import require_all, run_tasks
from pitotbench.bench.flights import flown  # of a light module: each worker loads it
from pitotbench.reconcile.card_comparison import compare_cards
from pitotbench.reconcile.decide.naming import Naming
from pitotbench.reconcile.residuals.layout import DAY, below_range_end, mean_wind_of
from pitotbench.reconcile.residuals.track import track_of
from pitotbench.records.case import Case, EffectSpec, Wind
from pitotbench.records.errors import BadInputError
from pitotbench.records.gap import FlownAgain
from pitotbench.records.log import FlightLog

FLIGHTS = 3  # of each airplane, unpatched and patched, so that the differences between flights show chance
# The free parameters of the temperature, where no header tells it: by its effect on the airplane, and as measured
WARMER = (f"{DAY} warmer_k", "temperature offset")
SEED = 760_001  # truth and sensor seeds count up from here


def fly_again(log: FlightLog, card: Case | None, effects: Sequence[EffectSpec]) -> FlownAgain:
    """Compare a log with its card as the simulator flies it, in the wind of the log, without and with effects.

    Returns only a reason where there is no card, or where it cannot be flown.
    """
    if card is None:
        return FlownAgain(skipped="no card: the header of the log holds none and --card was not given")
    if log.segment is None:
        return FlownAgain(
            skipped="the log has no column `segment`: its parts cannot be matched to those of the card"
        )
    base = replace(card, wind=wind_of_log(log), effects=())
    cases = [replace(base, truth_seed=SEED + i, sensor_seed=SEED + i) for i in range(FLIGHTS)]
    patched = [replace(case, effects=tuple(effects)) for case in cases] if effects else []
    try:
        logs = require_all(run_tasks(flown, [*cases, *patched], min(os.cpu_count() or 1, FLIGHTS)))
    except BadInputError as error:
        return FlownAgain(skipped=f"the card cannot be flown: {error}")
    return compare_cards(log, logs[:FLIGHTS], logs[FLIGHTS:] or logs[:FLIGHTS])


def on_its_day(card: Case | None, naming: Naming) -> Case | None:
    """Return a card in the temperature that a log shows, where the header of the log does not tell the day.

    The free parameters beside the named effects tell how much warmer the air is than the card says.
    """
    sizes = dict(zip(naming.layout.free.names, naming.equations.free_sizes(naming.fit.columns), strict=True))
    if card is None or WARMER[0] not in sizes:
        return card
    warmer = sum(float(sizes[name]) for name in WARMER if name in sizes)  # a log may lack the thermometer
    return replace(card, temperature_offset=card.temperature_offset + warmer)


def wind_of_log(log: FlightLog) -> Wind:
    """Return the mean wind of a log: ground velocity less velocity through the air."""
    track = track_of(log)
    north, east, _ = mean_wind_of(track, below_range_end(track, log))
    return Wind(hypot(north, east), (atan2(-east, -north)) % (2.0 * pi), 0.0)
