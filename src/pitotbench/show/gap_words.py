"""A verdict in plain sentences: the missing effects, their sizes, the evidence, the formula of the
rest.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.special import stdtrit

from pitotbench.effects import EFFECTS, effect_of
from pitotbench.records.gap import Account, CalibrationChange, Feature, FoundFormula
from pitotbench.records.verdict import SURE, Candidate, Closure, Verdict
from pitotbench.show.words import listed, name_and_unit, size_words, with_unit, words
from pitotbench.units import KNOT

# The symbols that need a word, each with the unit in which it enters a formula.
MEANINGS = {
    "M": "M is the Mach number",
    "q̄": "q̄ is the dynamic pressure in kPa",
    "P": "P is manifold pressure times speed over 40 inHg times 2,575 rpm",
    "h": "h is the height in 10,000 ft",
    "t": "t is the time since the first row in 10 min",
    "n": "n is the specific force in g",
    "δ": "δ is a deflection in rad",
    "α": "α is in rad",
    "β": "β is in rad",
    "p": "p is in rad/s",
    "q": "q is in rad/s",
    "r": "r is in rad/s",
}


def formula_sentences(formula: FoundFormula, holdout: str) -> list[str]:
    """What a formula says, what would do as well, and how much of the gap it closes."""
    left = (
        f"Beside {listed([words(n) for n in formula.beside])}, the gap"
        if formula.beside
        else "The gap"
    )
    meanings = [
        text
        for symbol, text in MEANINGS.items()
        if any(_holds(t.term, symbol) for t in formula.terms)
    ]
    legend = f" Here {listed(meanings)}." if meanings else ""
    lines = [f"{left} follows a formula: {'; '.join(_equations(formula))}; ± is 2σ.{legend}"]
    for term in formula.terms:
        if term.alternatives:
            others = listed(list(term.alternatives[:3]), "or")
            lines.append(
                f"In the place of {term.symbol} with {term.term}, the log is explained as well by "
                f"{others}."
            )
    closed = (
        f"The formula closes {closure_percent(formula.closure)} of the explainable gap of this log"
    )
    if formula.beside:
        closed += " that the names leave"
    if formula.closure_holdout is not None:
        closed += f", and {closure_percent(formula.closure_holdout)} of that of {holdout}, to which it was not fitted"
    lines.append(closed + ".")
    if formula.refused:
        lines.append(f"It is not put into the model: {formula.refused}.")
    return lines


def formula_closures(formula: FoundFormula) -> list[tuple[str, Closure]]:
    """The closures of a formula by the log that they are of."""
    closures = [("fitted log", formula.closure)]
    return closures + (
        [("held-out log", formula.closure_holdout)] if formula.closure_holdout is not None else []
    )


def formula_json(formula: FoundFormula | None) -> dict[str, Any] | None:
    """A formula as plain data."""
    if formula is None:
        return None
    return {
        "terms": [
            {
                "effect": term.effect,
                "parameter": term.size.name,
                "value": term.size.value,
                "two_sigma": term.size.two_sigma,
                "formula": f"{term.symbol} ~ {term.term}",
                "significance": term.significance,
                "alternatives": list(term.alternatives),
            }
            for term in formula.terms
        ],
        "beside": list(formula.beside),
        "held_out_ratio": formula.held_out_ratio,
        "closure": formula.closure.share,
        "closure_holdout": formula.closure_holdout.share
        if formula.closure_holdout is not None
        else None,
        "refused": formula.refused or None,
    }


def _equations(formula: FoundFormula) -> list[str]:
    """One equation for each quantity that is corrected."""
    groups: dict[str, list[str]] = {}
    for term in formula.terms:
        unit = name_and_unit(f"x_{term.unit}")[1] if term.unit else ""
        number = with_unit(f"({term.size.value:.3g} ± {term.size.two_sigma:.2g})", unit)
        parts = groups.setdefault(f"{term.quantity}: {term.symbol} = ", [])
        parts.append(number if term.term == "1" else f"{number} {term.term}")
    return [left + " + ".join(parts) for left, parts in groups.items()]


def _holds(term: str, symbol: str) -> bool:
    return any(word.startswith(symbol) for word in term.split()) and not (
        symbol == "q" and "q̄" in term
    )


UNTOUCHED = 0.05  # kt: no calibration flight shows less
TOLD_FROM = (
    0.02  # probability from which a further cause of a set is told: a doubted name may have none
)
DOUBTED = 0.1  # probability of causes in no form of the table, from which it is told

_WITHOUT_NULL_FLIGHTS = (
    "No simulated flights of this card were there to compare with, so that the noise is judged by "
    "this log alone. "
    "Small gaps are not told. Repeat the flight before you believe a size of a few σ."
)


def calibration_words(change: CalibrationChange) -> str:
    """What the effects do to a calibration that does not know them, in a sentence."""
    wrong = change.change / KNOT
    worst = int(np.argmax(np.abs(wrong)))
    low, high = (round(float(v / KNOT)) for v in (change.airspeed[0], change.airspeed[-1]))
    if abs(wrong[worst]) < UNTOUCHED:
        return (
            f"A calibration by this flight is not touched: it changes by less than {UNTOUCHED:g} "
            f"kt between {low} "
            f"and {high} KIAS."
        )
    way = "high" if wrong[worst] > 0.0 else "low"
    return (
        "A calibration by this flight that ignores it finds a correction up to "
        f"{abs(wrong[worst]):.1f} kt too {way} (at {change.airspeed[worst] / KNOT:.0f} KIAS; "
        f"flown {low} to {high} KIAS)."
    )


def effect_words(effect: Candidate, *more: str) -> str:
    """An effect with its clear sizes, the times at which it begins and ends, and more to be told of
    it.

    A size within its bound of zero is left out beside one that is not.
    """
    clear = [s for s in effect.sizes if abs(s.value) > s.two_sigma] or effect.sizes
    sizes = [size_words(s.name, s.value, s.two_sigma) for s in clear]
    return f"{words(effect.name)} ({'; '.join([*sizes, *(size_words(*time) for time in effect.times), *more])})"


# Parts of which a sentence needs another wording than their name with an article.
PART_WORDS = {
    "static ports and line": "the static ports or their line",
    "GPS receiver and its clock": "the GPS receiver or its clock",
    "attitude and vanes": "the attitude or the vanes",
    "controls and trim": "the controls or the trim",
    "lift, stability and damping": "the lift, the stability or the damping",
    "engine or propeller, a side": "the engine or the propeller of one side",
}


def part_words(part: str, causes: Sequence[str]) -> str:
    """A part in a sentence, with that of effects which are one model with one of its causes."""
    same = [effect.part for effect in EFFECTS.values() if effect.one_model_with in causes]
    return listed(
        [PART_WORDS.get(each, f"the {each}") for each in dict.fromkeys([part, *same])], "or"
    )


def sentences(account: Account) -> list[str]:
    """The answer in plain sentences: what, how big and how sure, what it does to a calibration,
    what is closed.
    """
    verdict = account.rounds[0].verdict
    lines = [_answer(verdict, account.aircraft)]
    if verdict.kind in SURE and account.calibration is not None:
        lines.append(calibration_words(account.calibration))
    if verdict.kind in SURE:
        if verdict.doubts:
            lines.append(f"What speaks against it: {'; '.join(verdict.doubts)}.")
        elif verdict.remains:
            lines.append("Something remains beside it that no effect of the table explains.")
        lines.append(_closed(account))
        lines += _later_passes(account)
    if account.formula is not None:
        lines += formula_sentences(account.formula, account.holdout)
    if not account.null_flights:
        lines.append(_WITHOUT_NULL_FLIGHTS)
    return lines


def evidence_words(account: Account) -> list[str]:
    """Where the gap is largest, in σ, and where the thresholds come from."""
    verdict = account.rounds[0].verdict
    lines = []
    if verdict.kind != "no_gap" and verdict.located:
        places = [
            f"{words(p.channel)} {'in ' if p.phase else ''}{words(p.where)} "
            f"({p.significance:+.0f}σ)"
            for p in verdict.located[:3]
        ]
        lines.append(f"The gap is largest in {listed(places)}.")
    if account.null_flights:
        lines.append(
            f"The thresholds come from {account.null_flights} simulated flights of the same card "
            "without an effect."
        )
    parts = [f"{part} {percent(p)}" for part, p in verdict.parts.items() if p >= TOLD_FROM]
    if verdict.kind != "no_gap" and parts:
        lines.append(f"By part: {', '.join(parts)}.")
    return lines


def _answer(verdict: Verdict, aircraft: str) -> str:
    if verdict.kind == "no_gap" and aircraft == "none":
        return "The sensors agree with one another: no significant gap."
    if verdict.kind == "no_gap":
        return "Simulation and measurement agree: no significant gap."
    if verdict.kind == "unknown":
        gap = "There is a significant gap, and no effect of the table explains it."
        return f"{gap} {_best(verdict)}".strip()
    groups: dict[str, list[tuple[Candidate, list[str]]]] = {}
    for effect, rivals in zip(verdict.effects, reported_rivals(verdict), strict=True):
        part = effect_of(effect.name).part
        groups.setdefault(part if part in verdict.named_parts else effect.name, []).append(
            (effect, rivals)
        )
    clauses = [_clause(verdict, key, members) for key, members in groups.items()]
    doubt = "" if set(groups) <= set(verdict.named_parts) else _doubt(verdict)
    return f"It is {'; and it is '.join(clauses)}; ± is 2σ.{doubt}"


def _clause(verdict: Verdict, key: str, members: Sequence[tuple[Candidate, list[str]]]) -> str:
    """A part with its causes, or a cause of no named part, each with those that would do as well."""
    candidates = {effect_of(c.name).cause: c for c in reversed(verdict.candidates)}

    def told(name: str) -> str:
        chance = percent(
            verdict.probabilities.get(
                name, candidates[name].probability if name in candidates else 0.0
            )
        )
        return (
            effect_words(candidates[name], chance)
            if name in candidates
            else f"{words(name)} ({chance})"
        )

    if key not in verdict.named_parts:
        ((effect, rivals),) = members
        names = [effect_words(effect, percent(effect.probability)), *map(told, rivals)]
        if len(names) > 1:
            return f"one of these: {names[0]} or, less probably, {listed(names[1:], 'or')}"
        return names[0] if verdict.kind == "named" else f"probably {names[0]}"
    causes, elsewhere = [], []
    for effect, rivals in members:
        names = [effect_words(effect, percent(effect.probability))]
        causes.append(
            listed([*names, *(told(n) for n in rivals if effect_of(n).part == key)], "or")
        )
        elsewhere += [told(n) for n in rivals if effect_of(n).part != key]
    less = f"; less probably, it is {listed(elsewhere, 'or')}" if elsewhere else ""
    named = part_words(key, [effect_of(effect.name).cause for effect, _ in members])
    return f"{named} ({percent(verdict.parts[key])}): {listed(causes)}{less}"


def reported_rivals(verdict: Verdict) -> list[list[str]]:
    """For each effect, the other causes of its set that are worth telling."""
    return [
        [n for n in names if verdict.probabilities.get(n, 1.0) >= TOLD_FROM]
        for names in verdict.alternatives
    ]


def _doubt(verdict: Verdict) -> str:
    """What a set leaves for causes that the table holds in no form; empty where it is little."""
    left = [
        1.0 - effect.probability - sum(verdict.probabilities.get(cause, 0.0) for cause in others)
        for effect, others in zip(verdict.effects, verdict.alternatives, strict=True)
        if others
    ]
    if max(left, default=0.0) < DOUBTED:
        return ""
    return (
        f" With {100.0 * max(left):.0f} % it is a cause that the table does not hold in this form."
    )


def percent(probability: float) -> str:
    """A probability in percent, never told as more than 99."""
    return f"{min(100.0 * probability, 99.0):.0f} %"


def _best(verdict: Verdict) -> str:
    """The best candidate of an unknown cause, with the reason why it is refused; empty without a
    candidate.
    """
    if not verdict.candidates:
        return ""
    best = verdict.candidates[0]
    return (
        f"The best candidate, {effect_words(best)}, with a score of {best.score:.0f}σ, leaves a "
        "gap or does not "
        "explain parts of the log that it was not fitted to. "
    )


def _closed(account: Account) -> str:
    verdict = account.rounds[0].verdict
    more = (
        ", with what further passes found,"
        if any(each.added for each in account.rounds[1:])
        else ""
    )
    line = (
        f"Adding it{more} closes {closure_percent(verdict.closure)} of the explainable gap of "
        "this log"
    )
    if verdict.closure_holdout is not None:
        line += f", and {closure_percent(verdict.closure_holdout)} of that of {account.holdout}, which was not used"
    return line + "."


BY_CHANCE = (
    0.05  # share of cards, flown again by one airplane, of which a characteristic number differs
)


def remaining_features(features: Sequence[Feature]) -> list[Feature]:
    """The characteristic numbers that differ with the patch by more than chance."""
    limit = features_limit(features)
    return [f for f in features if abs(f.measured - f.patched) > limit * f.deviation]


def features_limit(features: Sequence[Feature]) -> float:
    """The deviations that the largest of some characteristic numbers exceeds by chance in one card
    of twenty.

    The deviation is that of a few flights, so the numbers are Student's; there are many of them
    (Bonferroni 1936).
    """
    least = min((f.freedom for f in features), default=1)
    return float(stdtrit(least, 1.0 - 0.5 * BY_CHANCE / max(len(features), 1)))


def closure_percent(closed: Closure) -> str:
    """A closure in percent."""
    return f"{100.0 * closed.share:.0f} %"


def _later_passes(account: Account) -> list[str]:
    if len(account.rounds) < 2:
        return []
    more = [words(name) for each in account.rounds[1:] for name in each.added]
    added = f"A further pass added {listed(more)}. " if more else ""
    features = account.flown.features
    differing = len(remaining_features(features))
    beside = (
        f" in the channels; flown again, {differing} of {len(features)} characteristic numbers of "
        "the card still "
        "differ by more than chance"
    )
    end = {
        "no_gap": "With that in the model, no significant gap "
        f"remains{beside if differing else ''}.",
        "unknown": "With that in the model, a gap remains that no effect of the table explains.",
    }
    more_possible = "More may remain: the number of passes over one log is limited."
    return [added + end.get(account.rounds[-1].verdict.kind, more_possible)]
