"""Null flights of a log's card: fly them, learn their distribution or take it from the cache."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from itertools import count
from time import monotonic

from pitotbench.bench.null_cache import Progress, cache_entry, read_entry, write_entry
from pitotbench.bench.null_tables import read_table
from pitotbench.campaigns.fleet import open_fleet, require_all
from pitotbench.models.aircraft_model import aircraft_model
from pitotbench.reconciliation.free_parameters import AnalysisSetting
from pitotbench.reconciliation.layout import Layout, lay_out
from pitotbench.reconciliation.null_distribution import NullDistribution
from pitotbench.reconciliation.null_learning import learn_null_distribution
from pitotbench.records.case import Case
from pitotbench.sensing.recorder import record
from pitotbench.simulation.sortie import fly

# one or two minutes on two cores; the thresholds include the error of so small a number
NULL_FLIGHTS = 8
NULL_SEED = 730_001  # truth and sensor seeds of null flights count up from here


def null_distribution_of(
    card: Case,
    flights: int = NULL_FLIGHTS,
    progress: Progress | None = None,
    setting: AnalysisSetting | None = None,
    keep: bool = True,
) -> NullDistribution:
    """Return the null distribution of a card, for logs that are judged in this setting.

    A stock card's is shipped with the package. Any other is kept in `cache_folder()` under a digest
    of its inputs, so that a card is flown once. Without `keep` the flights are always flown, the
    shipped table is not read, and the cache is neither read nor written. Two runs that need the
    same entry at the same time both fly. Their flights are the same bit for bit, so it does not
    matter which one writes last, and no lock is needed.
    """
    card = replace(card, effects=(), truth_seed=1, sensor_seed=1)
    setting = setting or AnalysisSetting(day_known=True)
    say = progress or (lambda text: None)
    place = cache_entry(card, flights, setting)
    kept = (read_table(card, flights, setting) or read_entry(place, flights, say)) if keep else None
    if kept is not None:
        return kept
    say(
        f"first use of this card: {flights} flights without an effect ({card.maneuver}, "
        f"{card.das.label})"
    )
    with open_fleet(tasks=flights) as fleet:
        layouts = fleet.perform(
            partial(_null_layout, card, setting),
            range(flights),
            step=announce_flights(flights, say),
        )
        null = learn_null_distribution(
            require_all(layouts), lambda work, each: require_all(fleet.perform(work, each))
        )
    if keep:
        write_entry(place, null, say)
    return null


def announce_flights(
    flights: int, say: Progress, clock: Callable[[], float] = monotonic
) -> Callable[[], None]:
    """Return a function that announces each of some flights and the time the rest will take [s]."""
    done, begun = count(1), clock()

    def announce() -> None:
        number = next(done)
        left = (clock() - begun) / number * (flights - number)
        say(
            f"null flight {number} of {flights}"
            + (f", about {left:.0f} s left" if number < flights else "")
        )

    return announce


def _null_layout(card: Case, setting: AnalysisSetting, number: int) -> Layout:
    seed = NULL_SEED + number
    flight = fly(replace(card, truth_seed=seed, sensor_seed=seed))
    return lay_out(record(flight, card.das, seed), aircraft_model(card.aircraft), setting)
