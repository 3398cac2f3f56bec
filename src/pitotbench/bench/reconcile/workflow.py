"""One reconciliation from the log to all that a report shows."""

from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime

from pitotbench.bench.reconcile.reconciliation import AnalysisSetting, Reconciliation, card_of, loaded_as, reconcile
from pitotbench.bench.reconcile.reflight import fly_again
from pitotbench.bench.reconcile.rounds import look_until_quiet, patch_of
from pitotbench.reconcile.decide.patches import Patch
from pitotbench.reconcile.picture_data import gap_map, traces, waterfall
from pitotbench.records.case import Case, EffectSpec
from pitotbench.records.gap import Account, FlownAgain
from pitotbench.records.log import FlightLog

Progress = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class NamedLog:
    """A log with the name it is told by."""

    name: str
    log: FlightLog


@dataclass(frozen=True, slots=True)
class FullReconciliation:
    """A reconciliation, the account of it, and its patch."""

    found: Reconciliation
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
    """Reconcile, look again until nothing significant is left, fly the cards again (unless told not to).

    Without `keep` null flights are neither looked up nor kept.
    Raises BadInputError for a log that cannot be used.
    """
    say = progress or (lambda text: None)
    other = holdout.log if holdout else None
    found = reconcile(measured.log, aircraft, other, card, progress=progress, setting=setting, keep=keep)
    rounds, more, shapes = look_until_quiet(measured.log, aircraft, found, setting, progress)
    made = patch_of(found, more, shapes, measured.name, datetime.now(UTC).strftime("%Y-%m-%d"))
    effects = entries(made)
    flown, flown_holdout = FlownAgain(skipped="not asked for"), FlownAgain(skipped="not asked for")
    if refly:
        say("flying the card again")
        flown = fly_again(measured.log, found.card, effects)
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
        rounds=rounds,
        gap_map=gap_map(found.naming, found.known),
        waterfall=waterfall(found.naming),
        traces=traces(found.naming),
        patch=made.text,
        flown=flown,
        flown_holdout=flown_holdout,
        null_flights=found.known.flights,
    )
    return FullReconciliation(found, account, made)


def entries(made: Patch) -> tuple[EffectSpec, ...]:
    """A patch as effects of a case."""
    return tuple(EffectSpec(name, sizes) for name, sizes in made.entries)
