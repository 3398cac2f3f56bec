"""A verdict as JSON and as text."""

from typing import Any

from rich.console import Console

from pitotbench.records.gap import Account, FlownAgain
from pitotbench.records.verdict import Candidate, Closure, Verdict
from pitotbench.show.terminal import outside

SAID = {
    "named": "named",
    "one_of": "one of these",
    "unknown": "a gap with a cause that is not in the table",
    "no_gap": "no significant gap",
}
SHOWN = 6


def verdict_json(verdict: Verdict) -> dict[str, Any]:
    """The verdict as plain data; the gap as sums of squares in units of the noise."""
    held = verdict.closure_holdout
    return {
        "verdict": verdict.kind,
        "effects": [_effect(effect) for effect in verdict.effects],
        "alternatives": [list(names) for names in verdict.alternatives],
        "candidates": [{"name": c.name, "score": c.score, "plausible": c.plausible} for c in verdict.candidates],
        "gap_before": verdict.closure.before,
        "gap_after": verdict.closure.after,
        "gap_noise": verdict.closure.noise,
        "closure": _share(verdict, verdict.closure),
        "closure_holdout": _share(verdict, held),
        "located": [
            {"channel": p.channel, "phase": p.phase, "variable": p.variable, "significance": p.significance}
            for p in verdict.located
        ],
        "checks": [{"name": c.name, "status": c.status, "why": c.why} for c in verdict.checks],
        "advice": list(verdict.advice),
        "smallest_detectable": [
            {"effect": d.effect, "parameter": d.parameter, "size": d.size} for d in verdict.smallest_detectable
        ],
        "notes": list(verdict.notes),
    }


def account_json(account: Account) -> dict[str, Any]:
    """The verdict with the rounds that followed and the card flown again, as plain data."""
    return verdict_json(account.rounds[0].verdict) | {
        "rounds": [
            {"verdict": r.verdict.kind, "added": list(r.added), "closure": _share(r.verdict, r.verdict.closure)}
            for r in account.rounds
        ],
        "waterfall": [{"effect": step.effect, "left": step.left} for step in account.waterfall],
        "flown_again": _flown(account.flown),
        "flown_again_holdout": _flown(account.flown_holdout),
        "null_flights": account.null_flights,
    }


def _flown(flown: FlownAgain) -> dict[str, Any]:
    return {
        "skipped": flown.skipped or None,
        "within_tolerance": [
            {
                "quantity": t.quantity,
                "half_width": t.half_width,
                "unit": t.unit,
                "before": t.before,
                "after": t.after,
                "by_chance": t.by_chance,
            }
            for t in flown.tolerances
        ],
    }


def print_account(account: Account, console: Console) -> None:
    """Print the verdict, then what each further look at the log said."""
    print_verdict(account.rounds[0].verdict, console)
    for number, each in enumerate(account.rounds[1:], start=2):
        added = f": {', '.join(each.added)}" if each.added else ""
        console.print(outside(f"look {number}, with that in the model: {SAID[each.verdict.kind]}{added}"))
    for flown, which in ((account.flown, "flown again"), (account.flown_holdout, "held-out card flown again")):
        for t in flown.tolerances:
            told = f"{100 * t.before:.0f} % before, {100 * t.after:.0f} % with the patch"
            chance = f"{100 * t.by_chance:.0f} % between two flights of one airplane"
            console.print(outside(f"{which}: {t.quantity} within {t.half_width:g} {t.unit}: {told}, {chance}"))


def _share(verdict: Verdict, closed: Closure | None) -> float | None:
    return closed.share if closed is not None and verdict.effects else None


def _effect(effect: Candidate) -> dict[str, Any]:
    sizes = [{"name": s.name, "value": s.value, "two_sigma": s.two_sigma} for s in effect.sizes]
    return {"name": effect.name, "parameters": sizes, "score": effect.score}


def print_verdict(verdict: Verdict, console: Console) -> None:
    """Print the answer first, then why, then what next."""
    console.print(f"[bold]{SAID[verdict.kind]}[/bold]")
    for effect, others in zip(verdict.effects, verdict.alternatives, strict=True):
        sizes = ", ".join(f"{s.name} {s.value:.4g} ± {s.two_sigma:.2g}" for s in effect.sizes)
        like = f"; or {', '.join(others)}" if others else ""
        console.print(outside(f"  {effect.name}: {sizes} (2σ), {effect.score:.1f}σ{like}"))
    if verdict.effects:
        console.print(f"  closes {100.0 * verdict.closure.share:.0f} % of the explainable gap of this log")
    if verdict.closure_holdout is not None:
        console.print(f"  and {100.0 * verdict.closure_holdout.share:.0f} % of that of the log held out")
    console.print("where:")
    for place in verdict.located[:SHOWN]:
        console.print(outside(f"  {place.channel:26s} {place.where:22s} {place.significance:+6.1f}σ"))
    for check in verdict.checks:
        if check.status == "failed":
            console.print(outside(f"check {check.name}: {check.why}"))
    for line in verdict.advice:
        console.print(outside(f"next: {line}"))
    for line in verdict.notes:
        console.print(outside(f"note: {line}"))
