"""The report of a reconciliation: one page, self-contained, opens offline."""

from pitotbench.effects import EFFECTS
from pitotbench.records.gap import Account, Feature, FlownAgain
from pitotbench.records.verdict import SURE, Candidate, Verdict
from pitotbench.show.gap_panels import before_after_panel, history_panels, map_panels, trace_panels, waterfall_panel
from pitotbench.show.gap_words import closure_percent, detectable_words, effect_words, sentences, size_words, words
from pitotbench.show.markup import render
from pitotbench.show.report import page_version
from pitotbench.show.style import Panel
from pitotbench.show.verdict_text import SAID

NOTICED = 2.0  # times chance: a feature that differs by more is in bold


def account_page(account: Account) -> str:
    """The HTML of an account."""
    verdict = account.rounds[0].verdict
    return render(
        "reconcile.html",
        title=f"Reconcile: {account.log} against {account.aircraft}",
        subtitle=SAID[verdict.kind].capitalize(),
        sentences=[text for text in sentences(account) if text],
        verdict=verdict,
        sizes=[_size_rows(effect) for effect in verdict.effects],
        rounds=_rounds(account),
        maps=map_panels(account.gap_map),
        closing=_closing(account),
        traces=trace_panels(account.traces, verdict.located),
        candidates=[_candidate(each, verdict) for each in verdict.candidates],
        flown=[(name, flown, _rows(flown), history_panels(flown.histories)) for name, flown in _flown(account)],
        detectable=[detectable_words(found) for found in verdict.smallest_detectable],
        patch=account.patch if verdict.effects and verdict.kind in SURE else "",
        version=page_version(),
    )


def _size_rows(effect: Candidate) -> tuple[str, str, list[str]]:
    described = EFFECTS[effect.name]
    sizes = [size_words(s.name, s.value, s.two_sigma) for s in effect.sizes]
    return words(effect.name), described.what, sizes


def _rounds(account: Account) -> list[tuple[str, str, str]]:
    """Look, verdict, and what was largest then."""
    found = []
    for number, each in enumerate(account.rounds, start=1):
        verdict = each.verdict
        named = "; ".join(effect_words(e) for e in verdict.effects) if each.added else ""
        place = verdict.located[0] if verdict.located else None
        at = f"{words(place.channel)}, {words(place.where)}" if place else ""
        largest = f"{at}: {place.significance:+.1f}σ" if place else ""
        found.append((f"{number}", SAID[verdict.kind] + (f": {named}" if named else ""), largest))
    return found


def _closing(account: Account) -> list[Panel]:
    verdict = account.rounds[0].verdict
    if not account.waterfall:
        return []
    closures = [("fitted log", verdict.closure)]
    if verdict.closure_holdout is not None:
        closures.append(("held-out log", verdict.closure_holdout))
    return [waterfall_panel(account), before_after_panel(closures)]


def _candidate(each: Candidate, verdict: Verdict) -> tuple[str, ...]:
    """Name, sizes, score, held-out ratio, plausible, and what became of it."""
    named = {effect.name for effect in verdict.effects}
    beside = {name for names in verdict.alternatives for name in names}
    fate = "named" if each.name in named else "not told from it" if each.name in beside else ""
    sizes = "; ".join(size_words(s.name, s.value, s.two_sigma) for s in each.sizes)
    plausible = "yes" if each.plausible else "no"
    return words(each.name), sizes, f"{each.score:.1f}", f"{each.held_out_ratio:.2f}", plausible, fate


def _flown(account: Account) -> list[tuple[str, FlownAgain]]:
    found = [("the fitted log", account.flown)]
    return [*found, (f"the held-out log, {account.holdout}", account.flown_holdout)] if account.holdout else found


def _rows(flown: FlownAgain) -> list[tuple[str, ...]]:
    """Features: segment, what, measured, simulated, patched, both differences in units of chance."""
    return [
        (
            f.segment,
            f"{f.name} [{f.unit}]",
            *(f"{value:.2f}" for value in (f.measured, f.simulated, f.patched)),
            *(_apart(f, value) for value in (f.simulated, f.patched)),
        )
        for f in flown.features
        if max(abs(f.measured - f.simulated), abs(f.measured - f.patched)) > NOTICED * f.deviation
    ]


def _apart(feature: Feature, value: float) -> str:
    return f"{(feature.measured - value) / max(feature.deviation, 1e-9):+.1f}"


def closure_words(verdict: Verdict) -> str:
    """G on the fitted and on the held-out log."""
    held = verdict.closure_holdout
    return closure_percent(verdict.closure) + (f", held out {closure_percent(held)}" if held is not None else "")
