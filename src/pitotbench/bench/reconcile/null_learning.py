"""Fly the null flights of a card and learn their distribution, or take it from the cache."""

from dataclasses import replace
from functools import partial
from itertools import count

from pitotbench.bench.fleet import require_all, run_tasks
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

NULL_FLIGHTS = 8  # a minute or two on two cores; the thresholds hold the error of so few
NULL_SEED = 730_001  # truth and sensor seeds of null flights count up from here


def null_distribution_of(
    card: Case,
    flights: int = NULL_FLIGHTS,
    progress: Progress | None = None,
    setting: AnalysisSetting | None = None,
    keep: bool = True,
) -> NullDistribution:
    """Return the null distribution of a card, for logs that are judged in this setting.

    It is kept by content in `cache_folder()`, so that a card is flown once; without `keep` the flights are flown,
    and nothing is read or written there. Two runs that need one entry at the same time both fly. Their flights are
    the same bit for bit, so that either may write last, and no lock can remain.
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
    layouts = run_tasks(
        partial(_null_layout, card, setting),
        range(flights),
        step=lambda: say(f"null flight {next(done)} of {flights}"),
    )
    null = learn_null_distribution(require_all(layouts))
    if keep:
        write_entry(place, null, say)
    return null


def _null_layout(card: Case, setting: AnalysisSetting, number: int) -> Layout:
    seed = NULL_SEED + number
    flight = fly(replace(card, truth_seed=seed, sensor_seed=seed))
    return lay_out(record(flight, card.das, seed), aircraft_model(card.aircraft), setting)
