"""Reconcile one log: find its card, fly the null flights, and reach a verdict."""

from dataclasses import dataclass, replace

from pitotbench.bench.reconcile import Progress
from pitotbench.bench.reconcile.aircraft_models import aircraft_model
from pitotbench.bench.reconcile.log_card import card_of, loaded_as, tells_the_day
from pitotbench.bench.reconcile.null_learning import NULL_FLIGHTS, null_distribution_of
from pitotbench.reconcile.decide.judgment import hold_out, judge, with_hold_out
from pitotbench.reconcile.decide.naming import Naming
from pitotbench.reconcile.null_flights.null_distribution import NullDistribution, theoretical_distribution
from pitotbench.reconcile.residuals.free_parameters import AnalysisSetting as AnalysisSetting
from pitotbench.reconcile.residuals.layout import Layout, lay_out
from pitotbench.reconcile.residuals.layout_noise import noise_of_log
from pitotbench.reconcile.signatures.hypotheses import lasts
from pitotbench.records.case import Case
from pitotbench.records.log import FlightLog
from pitotbench.records.verdict import Verdict


@dataclass(frozen=True, slots=True)
class Reconciliation:
    """A verdict with the data that a page or a patch needs.

    `naming` is the fit behind the verdict, `layout` the log as it was laid out, `null` the null distribution, and
    `card` the case that was flown for it (None for a log without a card).
    """

    verdict: Verdict
    naming: Naming
    layout: Layout
    null: NullDistribution
    card: Case | None


def reconcile_log(
    log: FlightLog,
    aircraft: str = "navajo",
    holdout: FlightLog | None = None,
    card: Case | None = None,
    null_flights: int = NULL_FLIGHTS,
    progress: Progress | None = None,
    setting: AnalysisSetting | None = None,
    keep: bool = True,
) -> Reconciliation:
    """Find where a measured log and the model of an aircraft disagree, and name the effect that is missing.

    `aircraft` is a name of the hangar, or `none` to judge the sensors alone. `card` is the case that was flown;
    without it, the case in the log's header is used, and where this does not tell the temperature of the day, the
    day's air is free. With an aircraft model the card is flown at the log's first mass. Without any card the noise
    of the log itself sets the thresholds, which are then wider. Without `keep` the cache of null flights is neither
    read nor written.
    Raises BadInputError for a log that cannot be used.
    """
    model = aircraft_model(aircraft)
    flown = card or (card_of(log.header, aircraft) if model is not None else None)
    flown = loaded_as(flown, log) if flown is not None and model is not None else flown
    setting = replace(
        setting or AnalysisSetting(),
        day_known=flown is not None and (card is not None or tells_the_day(log.header)),
        instruments_known=flown is not None,
    )
    of_card = null_distribution_of(flown, null_flights, progress, setting, keep) if flown is not None else None
    layout = lay_out(log, model, setting)
    null = _for_channels(of_card, layout)
    verdict, naming = judge(layout, null)
    if holdout is not None and any(map(lasts, naming.chosen)):
        verdict = with_hold_out(verdict, hold_out(holdout, model, null, naming, setting))
    return Reconciliation(verdict, naming, layout, null, flown)


def _for_channels(of_card: NullDistribution | None, layout: Layout) -> NullDistribution:
    """Return the null distribution of the card if it has the channels of the log; else one from the log itself."""
    if of_card is not None and of_card.noise.names == layout.residuals.names:
        return of_card
    return theoretical_distribution(noise_of_log(layout))
