"""The report of a reconciliation: one self-contained page, which opens offline."""

from pitotbench.effects import effect_of
from pitotbench.records.gap import Account, FlownAgain
from pitotbench.records.verdict import SURE, Candidate
from pitotbench.show.columns import html_table
from pitotbench.show.flight_tables import CARD_COLUMNS, FLIGHT_COLUMNS, LISTED_CARDS
from pitotbench.show.formula_words import formula_closures
from pitotbench.show.gap_panels import before_after_panel, history_panels, map_panels, trace_panels, waterfall_panel
from pitotbench.show.gap_words import evidence_words, sentences
from pitotbench.show.markup import render
from pitotbench.show.quantity_words import size_words, words
from pitotbench.show.report import page_version
from pitotbench.show.style import Panel
from pitotbench.show.telling_panels import telling_panels
from pitotbench.show.unused_instants import unused_words
from pitotbench.show.verdict_tables import (
    CHECK_COLUMNS,
    DETECTABLE_COLUMNS,
    FEATURE_COLUMNS,
    TOLERANCE_COLUMNS,
    candidate_columns,
    kind_words,
    noticed,
    pilot_words,
    round_columns,
)


def account_page(account: Account) -> str:
    """The HTML of an account."""
    verdict = account.rounds[0].verdict
    return render(
        "reconcile.html",
        title=f"Reconcile: {account.log} against {account.aircraft}",
        subtitle=kind_words(verdict).capitalize(),
        sentences=sentences(account),
        warnings=account.warnings,
        verdict=verdict,
        sizes=[_sizes(effect) for effect in verdict.effects],
        telling=telling_panels(account.telling) if account.telling else [],
        evidence=evidence_words(account),
        maps=map_panels(account.gap_map),
        traces=trace_panels(account.traces, verdict.located),
        unused=unused_words(account.traces),
        closing=_closing(account),
        rounds=html_table(round_columns(account), range(len(account.rounds))),
        flights=html_table(FLIGHT_COLUMNS, account.flights) if len(account.flights) > 1 else "",
        cards=html_table(CARD_COLUMNS, account.next_flight.ranked[:LISTED_CARDS]) if account.next_flight else "",
        next_case=account.next_flight.case if account.next_flight else "",
        candidates=html_table(candidate_columns(verdict), verdict.candidates),
        flown=[_flown(name, flown) for name, flown in _flights(account)],
        checks=html_table(CHECK_COLUMNS, verdict.checks),
        detectable=html_table(DETECTABLE_COLUMNS, verdict.smallest_detectable),
        patch=account.patch if (verdict.effects and verdict.kind in SURE) or _has_formula(account) else "",
        version=page_version(),
    )


def _has_formula(account: Account) -> bool:
    return account.formula is not None and not account.formula.refused


def _sizes(effect: Candidate) -> tuple[str, str, list[str]]:
    """Name, description and sizes of an effect, in words."""
    sizes = [size_words(s.name, s.value, s.two_sigma) for s in effect.sizes]
    sizes += [size_words(*time) for time in effect.times]
    return words(effect.name), effect_of(effect.name).what, sizes


def _closing(account: Account) -> list[Panel]:
    verdict = account.rounds[0].verdict
    if account.formula is not None and not verdict.effects:
        return [before_after_panel(formula_closures(account.formula))]
    if not account.waterfall:
        return []
    closures = [("fitted log", verdict.closure)]
    if verdict.closure_holdout is not None:
        closures.append(("held-out log", verdict.closure_holdout))
    if len(account.flights) > 1:  # the steps are of the flight with the largest gap, the closure is of all
        return [before_after_panel(closures)]
    return [waterfall_panel(account), before_after_panel(closures)]


def _flights(account: Account) -> list[tuple[str, FlownAgain]]:
    flights = [("the fitted log", account.flown)]
    if account.holdout:
        flights.append((f"the held-out log, {account.holdout}", account.flown_holdout))
    return flights


def _flown(name: str, flown: FlownAgain) -> dict[str, object]:
    """The content of the section on a card flown again."""
    features = noticed(flown.features)
    return {
        "name": name,
        "skipped": flown.skipped,
        "pilot": pilot_words(flown),
        "tolerances": html_table(TOLERANCE_COLUMNS, flown.tolerances),
        "panels": history_panels(flown.histories),
        "features": html_table(FEATURE_COLUMNS, features) if features else "",
        "noticed": len(features),
        "compared": len(flown.features),
    }
