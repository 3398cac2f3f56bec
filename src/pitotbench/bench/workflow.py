"""Run one reconciliation, from the logs to the content of its report."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any

from pitotbench.bench.next_flight import advice_of, next_flight_after
from pitotbench.bench.null_flights import Progress, aircraft_model, as_flown, card_of
from pitotbench.bench.reflight import as_the_log_shows, fly_again
from pitotbench.bench.rounds import (
    Looks,
    NamedLog,
    Reconciliation,
    closure_checked,
    first_pass,
    iterate,
    patch_of,
    reconcile_logs,
    with_calibrated_probabilities,
)
from pitotbench.effects.stability import OWN_TERMS
from pitotbench.reconciliation.formula import closure_on, find_formula, free_sizes_beside
from pitotbench.reconciliation.free_parameters import AnalysisSetting
from pitotbench.reconciliation.layout import Layout
from pitotbench.reconciliation.patches import Patch, name_in_case
from pitotbench.reconciliation.pictures import calibration_change, clearest_channel, gap_map, traces, waterfall
from pitotbench.reconciliation.renewal import lay_out_with
from pitotbench.records.calibration import Estimate
from pitotbench.records.case import Case, EffectSpec
from pitotbench.records.gap import Account, FlownAgain, FoundFormula
from pitotbench.records.log import FlightLog
from pitotbench.records.verdict import SURE, AdvisedFlight, Candidate, JoinedFlight, Verdict

if TYPE_CHECKING:
    from pandas import DataFrame

HOLD_OUT_LEAST = 0.5  # closure of a held-out log below which a formula is shown, but not put into the model


@dataclass(frozen=True, slots=True)
class BeyondTable:
    """The passes of a reconciliation, with the formula of what they leave; None where nothing is left to describe.

    Where a formula alone says more than names with a formula beside them, the names are withdrawn.
    `free_sizes` are the free parameters of the log beside the formula, by name.
    """

    looks: Looks
    formula: FoundFormula | None = None
    free_sizes: Mapping[str, float] = field(default_factory=dict)

    @property
    def entries(self) -> tuple[Candidate, ...]:
        """The formula as effects for the patch; empty where it is refused."""
        if self.formula is None or self.formula.refused:
            return ()
        sizes: dict[str, list[Estimate]] = {}
        for term in self.formula.terms:
            sizes.setdefault(term.effect, []).append(term.size)
        ratio = self.formula.held_out_ratio
        return tuple(Candidate(name, tuple(each), 0.0, ratio, True) for name, each in sizes.items())


def beyond_the_table(
    aircraft: str, looks: Looks, holdout: FlightLog | None, progress: Progress | None = None
) -> BeyondTable:
    """Describe what the named effects leave of the gap; `holdout` is a log on which the formula is to hold as well.

    Raises BadInputError for a held-out log that cannot be compared.
    """
    first = looks.first
    if not looks.remains:
        return BeyondTable(looks)
    if progress is not None:
        progress("looking for a formula of what the table does not explain")
    names = dict(patch_of(looks, (), "", "").entries)
    formula = find_formula(_remaining(looks), first.null)
    if set(names) - OWN_TERMS:
        alone = find_formula(first.naming.layout, first.null)
        if alone is not None and _is_simpler(alone, formula, names):
            why = f"a formula explains more than {', '.join(names)} with a formula beside it"
            first = replace(first, checks=replace(first.checks, formula=why))
            looks, formula, names = first_pass(first), alone, {}
    if formula is None:
        return BeyondTable(looks)
    formula = replace(formula, beside=tuple(names))
    free = free_sizes_beside(_remaining(looks), first.null, formula)
    if holdout is not None:
        formula = _held_out(formula, aircraft, first, holdout, names)
    return BeyondTable(looks, formula, free)


def _remaining(looks: Looks) -> Layout:
    """The layout of the last look, with what it named subtracted."""
    naming = looks.last
    if looks.rounds[-1].verdict.kind not in SURE:
        return naming.layout
    columns = [naming.layout.signatures[c].column for c in naming.fit.columns]
    return naming.layout.without(columns, naming.fit.sizes)


def _is_simpler(alone: FoundFormula, beside: FoundFormula | None, names: Mapping[str, Mapping[str, float]]) -> bool:
    """Whether a formula alone leaves no more of the gap than names with a formula, and has fewer sizes."""
    if beside is None:
        return False
    sizes = sum(map(len, names.values())) + len(beside.terms)
    return len(alone.terms) < sizes and alone.closure.after <= beside.closure.after


def _held_out(
    formula: FoundFormula,
    aircraft: str,
    first: Reconciliation,
    holdout: FlightLog,
    names: Mapping[str, Mapping[str, float]],
) -> FoundFormula:
    layout = lay_out_with(holdout, aircraft_model(aircraft), first.layout.setting, names)
    closed = closure_on(layout, first.null, formula)
    why = (
        f"it closes only {closed.share:.0%} of the gap of the held-out log" if closed.share < HOLD_OUT_LEAST else ""
    )
    return replace(formula, closure_holdout=closed, refused=why)


@dataclass(frozen=True, slots=True)
class FullReconciliation:
    """The reconciliation of one or several logs, its account for a report, and its patch.

    It shows itself in a notebook as its account does: in words, as a picture and as a table of the causes.
    """

    reconciliation: Reconciliation
    account: Account
    patch: Patch

    @property
    def verdict(self) -> Verdict:
        """The answer."""
        return self.account.rounds[0].verdict

    @property
    def probabilities(self) -> Mapping[str, float]:
        """The probability of each cause, given a gap."""
        return self.verdict.probabilities

    @property
    def sizes(self) -> Mapping[str, tuple[Estimate, ...]]:
        """The sizes of the named effects, each with its 2σ, in the units of the effects table."""
        return {effect.name: effect.sizes for effect in self.verdict.effects}

    @property
    def flights(self) -> tuple[JoinedFlight, ...]:
        """What each flight says."""
        return self.account.flights

    @property
    def next_flight(self) -> AdvisedFlight | None:
        """The flight that would part the causes that are left; None where none is needed, or none was asked for."""
        return self.account.next_flight

    def to_frame(self) -> "DataFrame":
        """Return the causes as a table, the most probable first."""
        return self.account.to_frame()

    def plot(self, axes: Any = None) -> Any:
        """Draw the probabilities of the causes on matplotlib's axes, or in a new figure; return the figure."""
        return self.account.plot(axes)

    def _repr_html_(self) -> str:
        return self.account._repr_html_()

    def __repr__(self) -> str:
        return repr(self.account).replace(type(self.account).__name__, type(self).__name__, 1)


def reconcile_fully(
    measured: NamedLog | Sequence[NamedLog],
    aircraft: str = "navajo",
    holdout: NamedLog | None = None,
    card: Case | None = None,
    progress: Progress | None = None,
    setting: AnalysisSetting | None = None,
    refly: bool = True,
    refly_holdout: bool = True,
    keep: bool = True,
    next_flight: bool = True,
) -> FullReconciliation:
    """Reconcile logs, judge them again until nothing significant remains, and fly a card again.

    `card` is that of all logs that state none of their own. With `refly` the card of the log with the largest gap
    is flown again, with `refly_holdout` that of the held-out log as well. With `next_flight` a card is chosen that
    parts the causes between which the logs leave a doubt. Without `keep` the cache of null flights is neither read
    nor written.
    Raises BadInputError for a log that cannot be used.
    """
    say = progress or (lambda text: None)
    several = [measured] if isinstance(measured, NamedLog) else measured
    logs = [replace(each, card=each.card or card) for each in several]
    other = holdout.log if holdout else None
    first = reconcile_logs(logs, aircraft, other, progress=progress, setting=setting, keep=keep)
    advised = next_flight_after(first, progress) if next_flight else None
    if advised is not None:
        first = replace(first, checks=replace(first.checks, advice=advice_of(advised)))
    looks = closure_checked(iterate(aircraft, first, progress))
    source = ", ".join(each.name for each in logs)
    beyond = beyond_the_table(aircraft, looks, other, progress)
    looks = with_calibrated_probabilities(beyond.looks)
    first = looks.first
    patch = patch_of(looks, beyond.entries, source, datetime.now(UTC).strftime("%Y-%m-%d"))
    effects = entries(patch)
    flown, flown_holdout = FlownAgain(skipped="not asked for"), FlownAgain(skipped="not asked for")
    shown = as_the_log_shows(first.card, first.naming, beyond.free_sizes) if refly else None
    if refly:
        say("flying the card again")
        flown = fly_again(first.logs[first.shown].log, shown, effects)
    if refly and refly_holdout and holdout is not None:
        say("flying the card of the held-out log again")
        again = holdout.card or card or card_of(holdout.log.header, aircraft)
        if again is not None and aircraft != "none":
            again = as_flown(again, holdout.log)
            again = again if shown is None else replace(again, pressure_error=shown.pressure_error)
        flown_holdout = fly_again(holdout.log, again, effects)
    over_time = traces(first.naming)
    account = Account(
        log=source,
        aircraft=aircraft,
        holdout=holdout.name if holdout else "",
        rounds=looks.rounds,
        gap_map=gap_map(first.naming, first.null),
        waterfall=waterfall(first.naming),
        traces=over_time,
        patch=patch.text,
        flown=flown,
        flown_holdout=flown_holdout,
        null_flights=first.null.flights,
        formula=beyond.formula,
        flights=first.flights,
        next_flight=advised,
        telling=clearest_channel(first.naming, first.null, over_time),
        calibration=calibration_change(first.naming),
        warnings=_warnings([*logs, *([holdout] if holdout else [])]),
    )
    return FullReconciliation(first, account, patch)


def _warnings(logs: Sequence[NamedLog]) -> tuple[str, ...]:
    """Return what was said of the logs as they were read, with the log's name where there are several."""
    return tuple(
        text if len(logs) == 1 else f"{each.name}: {text}"
        for each in logs
        for text in each.log.header.get("warnings", ())
    )


def entries(patch: Patch) -> tuple[EffectSpec, ...]:
    """Return a patch as effects of a case."""
    return tuple(EffectSpec(name_in_case(name), sizes) for name, sizes in patch.entries)
