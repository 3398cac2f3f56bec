"""Fly the null flights of a card and learn their distribution, or take it from the cache."""

from dataclasses import replace
from functools import partial
from itertools import count

from pitotbench.bench.fleet import open_fleet, require_all
from pitotbench.bench.reconcile import Progress
from pitotbench.bench.reconcile.aircraft_models import aircraft_model
from pitotbench.bench.reconcile.null_cache import cache_entry, read_entry, write_entry
from pitotbench.reconcile.null_flights.learning import learn_null_distribution
from pitotbench.reconcile.null_flights.null_distribution import NullDistribution
from pitotbench.reconcile.residuals.free_parameters import AnalysisSetting
from pitotbench.reconcile.residuals.layout import Layout, lay_out
from pitotbench.records.case import Case
from pitotbench.sense import record
from pitotbench.simulate import fly

NULL_FLIGHTS = 8  # one or two minutes on two cores; the thresholds include the error of so small a number
NULL_SEED = 730_001  # truth and sensor seeds of null flights count up from here


def null_distribution_of(
    card: Case,
    flights: int = NULL_FLIGHTS,
    progress: Progress | None = None,
    setting: AnalysisSetting | None = None,
    keep: bool = True,
) -> NullDistribution:
    """Return the null distribution of a card, for logs that are judged in this setting.

    It is kept in `cache_folder()` under a digest of its inputs, so that a card is flown once. Without `keep` the
    flights are always flown, and the cache is neither read nor written. Two runs that need the same entry at the
    same time both fly. Their flights are the same bit for bit, so it does not matter which one writes last, and no
    lock is needed.
    """
    card = replace(card, effects=(), truth_seed=1, sensor_seed=1)
    setting = setting or AnalysisSetting(day_known=True)
    say = progress or (lambda text: None)
    place = cache_entry(card, flights, setting)
    kept = read_entry(place, flights, say) if keep else None
    if kept is not None:
        return kept
    say(f"first use of this card: {flights} flights without an effect ({card.maneuver}, {card.das.label})")
    done = count(1)
    with open_fleet(tasks=flights) as fleet:
        layouts = fleet.perform(
            partial(_null_layout, card, setting),
            range(flights),
            step=lambda: say(f"null flight {next(done)} of {flights}"),
        )
        null = learn_null_distribution(
            require_all(layouts), lambda work, each: require_all(fleet.perform(work, each))
        )
    if keep:
        write_entry(place, null, say)
    return null


def _null_layout(card: Case, setting: AnalysisSetting, number: int) -> Layout:
    seed = NULL_SEED + number
    flight = fly(replace(card, truth_seed=seed, sensor_seed=seed))
    return lay_out(record(flight, card.das, seed), aircraft_model(card.aircraft), setting)
