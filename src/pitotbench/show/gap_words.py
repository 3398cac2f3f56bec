"""A verdict in plain sentences: the missing effects, their sizes, the evidence, and the effect of the patch."""

from pitotbench.records.gap import Account
from pitotbench.records.verdict import SURE, Candidate, Closure, Located, Verdict
from pitotbench.show.formula_words import formula_sentences
from pitotbench.show.quantity_words import listed, size_words, words


def effect_words(effect: Candidate) -> str:
    """An effect with its sizes."""
    return f"{words(effect.name)} ({'; '.join(size_words(s.name, s.value, s.two_sigma) for s in effect.sizes)})"


def place_words(place: Located) -> str:
    """A place of the gap: channel, phase or variable, and significance."""
    within = "in " if place.phase else ""
    return f"{words(place.channel)} {within}{words(place.where)} ({place.significance:+.0f}σ)"


def sentences(account: Account) -> list[str]:
    """The answer in plain sentences, the most important first."""
    verdict = account.rounds[0].verdict
    lines = [_answer(verdict, account.null_flights)]
    if verdict.kind != "no_gap" and verdict.located:
        lines.append(f"The gap is largest in {listed([place_words(p) for p in verdict.located[:3]])}.")
    if verdict.kind in SURE:
        if verdict.remains:
            lines.append("Something remains beside it that no effect of the table explains.")
        lines.append(_closed(verdict, account.holdout))
        lines += _later_passes(account)
    if account.formula is not None:
        lines += formula_sentences(account.formula, account.holdout)
    return lines


def _answer(verdict: Verdict, null_flights: int) -> str:
    if verdict.kind == "no_gap":
        return f"Simulation and measurement agree: no significant gap. {_compared(null_flights)}"
    if verdict.kind == "unknown":
        gap = "There is a significant gap, and no effect of the table explains it."
        return f"{gap} {_best(verdict)}{_compared(null_flights)}"
    candidates = {candidate.name: candidate for candidate in verdict.candidates}
    effects = []
    for effect, others in zip(verdict.effects, verdict.alternatives, strict=True):
        rivals = [effect_words(candidates[n]) if n in candidates else words(n) for n in others]
        effects.append(effect_words(effect) + (f" or, less probably, {listed(rivals, 'or')}" if rivals else ""))
    sets = any(verdict.alternatives)
    lead = "The model lacks one of these: " if sets and len(effects) == 1 else "The model lacks "
    return f"{lead}{listed(effects)}; ± is 2σ. {_compared(null_flights)}"


def _best(verdict: Verdict) -> str:
    """The best candidate of an unknown cause, with the reason why it is refused; empty without a candidate."""
    if not verdict.candidates:
        return ""
    best = verdict.candidates[0]
    return (
        f"The best candidate, {effect_words(best)}, with a score of {best.score:.0f}σ, leaves a gap or does not "
        "explain parts of the log that it was not fitted to. "
    )


def _compared(null_flights: int) -> str:
    if null_flights:
        return f"The thresholds come from {null_flights} simulated flights of the same card without an effect."
    return (
        "There were no simulated flights without an effect to compare with: the noise level is that of this log, "
        "and the thresholds are half as high again. Repeat the flight before you believe a size of a few σ."
    )


def _closed(verdict: Verdict, holdout: str) -> str:
    line = f"Adding it closes {closure_percent(verdict.closure)} of the explainable gap of this log"
    if verdict.closure_holdout is not None:
        line += f", and {closure_percent(verdict.closure_holdout)} of that of {holdout}, which was not used"
    return line + "."


def closure_percent(closed: Closure) -> str:
    """A closure in percent."""
    return f"{100.0 * closed.share:.0f} %"


def _later_passes(account: Account) -> list[str]:
    if len(account.rounds) < 2:
        return []
    more = [words(name) for each in account.rounds[1:] for name in each.added]
    added = f"A further pass added {listed(more)}. " if more else ""
    end = {
        "no_gap": "With that in the model, no significant gap remains.",
        "unknown": "With that in the model, a gap remains that no effect of the table explains.",
    }
    more_possible = "More may remain: the number of passes over one log is limited."
    return [added + end.get(account.rounds[-1].verdict.kind, more_possible)]
