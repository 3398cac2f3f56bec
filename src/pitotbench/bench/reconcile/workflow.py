"""Run one reconciliation, from the log to the content of its report."""

from dataclasses import dataclass
from datetime import UTC, datetime

from pitotbench.bench.reconcile import Progress
from pitotbench.bench.reconcile.beyond_the_table import beyond_the_table
from pitotbench.bench.reconcile.log_card import card_of, loaded_as
from pitotbench.bench.reconcile.reconciliation import AnalysisSetting, Reconciliation, reconcile_log
from pitotbench.bench.reconcile.reflight import fly_again
from pitotbench.bench.reconcile.rounds import look_until_quiet, patch_of
from pitotbench.reconcile.decide.patches import Patch, name_in_case
from pitotbench.reconcile.picture_data import gap_map, traces, waterfall
from pitotbench.reconcile.telling_data import calibration_change, telling_channel
from pitotbench.records.case import Case, EffectSpec
from pitotbench.records.gap import Account, FlownAgain
from pitotbench.records.log import FlightLog


@dataclass(frozen=True, slots=True)
class NamedLog:
    """A log with its name in reports."""

    name: str
    log: FlightLog


@dataclass(frozen=True, slots=True)
class FullReconciliation:
    """The reconciliation of a log, its account for a report, and its patch."""

    reconciliation: Reconciliation
    account: Account
    patch: Patch


def reconcile_fully(
    measured: NamedLog,
    aircraft: str = "navajo",
    holdout: NamedLog | None = None,
    card: Case | None = None,
    progress: Progress | None = None,
    setting: AnalysisSetting | None = None,
    refly: bool = True,
    refly_holdout: bool = True,
    keep: bool = True,
) -> FullReconciliation:
    """Reconcile a log, judge it again until nothing significant remains, and fly its card again.

    With `refly` the card of the log is flown again, with `refly_holdout` that of the held-out log as well. Without
    `keep` the cache of null flights is neither read nor written.
    Raises BadInputError for a log that cannot be used.
    """
    say = progress or (lambda text: None)
    other = holdout.log if holdout else None
    first = reconcile_log(measured.log, aircraft, other, card, progress=progress, setting=setting, keep=keep)
    looks = look_until_quiet(measured.log, aircraft, first, progress)
    beyond = beyond_the_table(aircraft, first, looks, other, progress)
    first, looks = beyond.first, beyond.looks
    added = (*looks.added, *beyond.entries)
    patch = patch_of(first, added, looks.shapes, measured.name, datetime.now(UTC).strftime("%Y-%m-%d"))
    effects = entries(patch)
    flown, flown_holdout = FlownAgain(skipped="not asked for"), FlownAgain(skipped="not asked for")
    if refly:
        say("flying the card again")
        flown = fly_again(measured.log, first.card, effects)
    if refly and refly_holdout and holdout is not None:
        say("flying the card of the held-out log again")
        again = card or card_of(holdout.log.header, aircraft)
        if again is not None and aircraft != "none":
            again = loaded_as(again, holdout.log)
        flown_holdout = fly_again(holdout.log, again, effects)
    account = Account(
        log=measured.name,
        aircraft=aircraft,
        holdout=holdout.name if holdout else "",
        rounds=looks.rounds,
        gap_map=gap_map(first.naming, first.null),
        waterfall=waterfall(first.naming),
        traces=traces(first.naming),
        patch=patch.text,
        flown=flown,
        flown_holdout=flown_holdout,
        null_flights=first.null.flights,
        formula=beyond.formula,
        telling=telling_channel(first.naming, first.null),
        calibration=calibration_change(first.naming),
    )
    return FullReconciliation(first, account, patch)


def entries(patch: Patch) -> tuple[EffectSpec, ...]:
    """Return a patch as effects of a case."""
    return tuple(EffectSpec(name_in_case(name), sizes) for name, sizes in patch.entries)
