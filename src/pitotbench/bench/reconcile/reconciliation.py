"""Reconcile one or several logs: find their cards, fly the null flights, and reach a verdict."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from pitotbench.bench.reconcile import Progress
from pitotbench.bench.reconcile.aircraft_models import aircraft_model
from pitotbench.bench.reconcile.log_card import as_flown, card_of, tells_the_day
from pitotbench.bench.reconcile.null_learning import NULL_FLIGHTS, null_distribution_of
from pitotbench.reconcile.decide.joint_judgment import JointVerdict, judge_together
from pitotbench.reconcile.decide.judgment import for_channels, hold_out, with_hold_out
from pitotbench.reconcile.decide.naming import Naming
from pitotbench.reconcile.null_flights.null_distribution import NullDistribution
from pitotbench.reconcile.residuals.free_parameters import AnalysisSetting as AnalysisSetting
from pitotbench.reconcile.residuals.layout import Layout, lay_out
from pitotbench.reconcile.residuals.scene import AircraftModel
from pitotbench.reconcile.signatures.hypotheses import returns
from pitotbench.records.case import Case
from pitotbench.records.errors import BadInputError
from pitotbench.records.joined_flight import JoinedFlight
from pitotbench.records.log import FlightLog
from pitotbench.records.verdict import Verdict


@dataclass(frozen=True, slots=True)
class NamedLog:
    """A log with its name in reports. `card` is the case that was flown; None: that in the log's header."""

    name: str
    log: FlightLog
    card: Case | None = None


@dataclass(frozen=True, slots=True)
class JudgedLog:
    """A log as it was laid out, with its null distribution, and the case that was flown (None without a card)."""

    name: str
    log: FlightLog
    layout: Layout
    null: NullDistribution
    card: Case | None


@dataclass(frozen=True, slots=True)
class Reconciliation:
    """A verdict with the data that a page or a patch needs.

    `logs` are those that were judged, `joint` their verdict before a log was held out. `shown` is the number of the
    log of which a page shows pictures: that with the largest part of the gap. `naming`, `layout`, `null` and `card`
    are those of this log.
    """

    verdict: Verdict
    joint: JointVerdict
    logs: tuple[JudgedLog, ...]
    flights: tuple[JoinedFlight, ...]

    @property
    def shown(self) -> int:
        """The number of the log with the largest part of the gap."""
        gaps = [flight.closure.before - flight.closure.noise for flight in self.flights]
        return gaps.index(max(gaps))

    @property
    def naming(self) -> Naming:
        """The fit behind the verdict."""
        return self.joint.together.namings[self.shown]

    @property
    def layout(self) -> Layout:
        """The log as it was laid out."""
        return self.logs[self.shown].layout

    @property
    def null(self) -> NullDistribution:
        """What flights of its card without an effect show."""
        return self.logs[self.shown].null

    @property
    def card(self) -> Case | None:
        """The case that was flown."""
        return self.logs[self.shown].card


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

    `card` is the case that was flown; without it, the case in the log's header is used. The other parameters are
    those of `reconcile_logs`.
    Raises BadInputError for a log that cannot be used.
    """
    named = NamedLog("measured log", log, card)
    return reconcile_logs([named], aircraft, holdout, null_flights, progress, setting, keep)


def reconcile_logs(
    logs: Sequence[NamedLog],
    aircraft: str = "navajo",
    holdout: FlightLog | None = None,
    null_flights: int = NULL_FLIGHTS,
    progress: Progress | None = None,
    setting: AnalysisSetting | None = None,
    keep: bool = True,
) -> Reconciliation:
    """Name the effect that a model lacks, from one or several logs of one airplane that lacks the same in all.

    Causes and sizes are shared; wind, error curve and sensor biases are each log's own. `aircraft` is a name of the
    hangar, or `none` to judge the sensors alone. With an aircraft model the card of each log is flown for its
    null flights, at the first mass and the height of the log. Without any card the noise of the log itself sets the
    thresholds, which are then wider. Without `keep` the cache of null flights is neither read nor written.
    Raises BadInputError without a log, or for a log that cannot be used.
    """
    if not logs:
        raise BadInputError("no log to reconcile")
    model = aircraft_model(aircraft)
    judged = [_judged(each, aircraft, model, null_flights, progress, setting, keep) for each in logs]
    joint = judge_together(
        [each.name for each in judged], [each.layout for each in judged], [each.null for each in judged]
    )
    flights = tuple(
        replace(flight, maneuver=each.card.maneuver if each.card else "")
        for flight, each in zip(joint.flights, judged, strict=True)
    )
    found = Reconciliation(joint.verdict, joint, tuple(judged), flights)
    if holdout is not None and any(map(returns, found.naming.chosen)):
        held = hold_out(holdout, model, found.null, found.naming, found.layout.setting)
        found = replace(found, verdict=with_hold_out(found.verdict, held))
    return found


def _judged(
    named: NamedLog,
    aircraft: str,
    model: AircraftModel | None,
    null_flights: int,
    progress: Progress | None,
    setting: AnalysisSetting | None,
    keep: bool,
) -> JudgedLog:
    """Lay a log out, and take the null distribution of its card."""
    flown = named.card or (card_of(named.log.header, aircraft) if model is not None else None)
    flown = as_flown(flown, named.log) if flown is not None and model is not None else flown
    setting = replace(
        setting or AnalysisSetting(),
        day_known=flown is not None and (named.card is not None or tells_the_day(named.log.header)),
        instruments_known=flown is not None,
    )
    of_card = null_distribution_of(flown, null_flights, progress, setting, keep) if flown is not None else None
    layout = lay_out(named.log, model, setting)
    return JudgedLog(named.name, named.log, layout, for_channels(of_card, layout), flown)
