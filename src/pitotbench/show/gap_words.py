"""A verdict in plain sentences: missing effects, sizes, evidence, and the rest's formula."""

from collections.abc import Sequence

import numpy as np
from scipy.special import stdtrit

from pitotbench.effects import EFFECTS, effect_of
from pitotbench.records.gap import Account, CalibrationChange, Closing, Feature, FoundFormula
from pitotbench.records.verdict import (
    REPORTED_FROM,
    SURE,
    Candidate,
    FreeSize,
    Gap,
    Located,
    Verdict,
)
from pitotbench.show.words import heading, listed, name_and_unit, size_words, with_unit, words
from pitotbench.units import KNOT, percent_text

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


def formula_sentences(formula: FoundFormula) -> list[str]:
    """What a formula says, and what would do as well."""
    left = (
        f"Beside {listed([words(n) for n in formula.effects])}, the gap"
        if formula.effects
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
    return lines


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
DOUBTED = 0.1  # probability of causes in no form of the table, from which it is reported

_WITHOUT_NULL_FLIGHTS = (
    "No simulated flights of this card were there to compare with, so that the noise is judged by "
    "this log alone. Small gaps are not told. Repeat the flight before you believe a size of a few "
    "σ."
)


_YAWING = "left against right: together a yawing moment, which another cause may give as well"


def calibration_words(change: CalibrationChange) -> str:
    """What the effects do to a calibration that does not know them, in a sentence."""
    wrong = change.change / KNOT
    worst = int(np.argmax(np.abs(wrong)))
    low, high = (round(float(v / KNOT)) for v in (change.airspeed[0], change.airspeed[-1]))
    if abs(wrong[worst]) < UNTOUCHED:
        return (
            f"The airspeed calibration stays the same, within {UNTOUCHED:g} kt from {low} to "
            f"{high} KIAS."
        )
    way = "high" if wrong[worst] > 0.0 else "low"
    return (
        "A calibration by this flight that ignores it finds a correction up to "
        f"{abs(wrong[worst]):.1f} kt too {way} (at {change.airspeed[worst] / KNOT:.0f} KIAS; "
        f"flown {low} to {high} KIAS)."
    )


def effect_words(effect: Candidate, *more: str) -> str:
    """An effect with its clear sizes, the times at which it begins and ends, and more to say of it.

    A size within its bound of zero is left out where another is not. Opposite signs on the two
    sides are one yawing moment, whatever gives it.
    """
    clear = [s for s in effect.sizes if abs(s.value) > s.two_sigma] or effect.sizes
    sizes = [size_words(s.name, s.value, s.two_sigma) for s in clear]
    sides = {size.name.split("_")[0]: size.value for size in clear}
    if sides.get("left", 0.0) * sides.get("right", 0.0) < 0.0:
        sizes.append(_YAWING)
    return f"{words(effect.name)} ({'; '.join([*sizes, *(size_words(*time) for time in effect.times), *more])})"


# Parts of which a sentence needs another wording than their name with an article.
PART_WORDS = {
    "static ports and line": "the static ports or their line",
    "GPS receiver and its clock": "the GPS receiver or its clock",
    "attitude and inertial unit": "the attitude or the inertial unit",
    "flow vanes": "a flow vane",
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
    """Return the answer in sentences: what, how big, how sure, what it changes, what is closed.

    The change is that of a calibration.
    """
    verdict = account.verdict
    lines = [_answer(verdict, account.aircraft)]
    if verdict.kind in SURE and account.calibration is not None:
        lines.append(calibration_words(account.calibration))
    if verdict.kind in SURE:
        if verdict.doubts:
            lines.append(f"What speaks against it: {'; '.join(verdict.doubts)}.")
        elif verdict.remains:
            lines.append(
                f"Something remains beside it that no effect of the table explains{_most(verdict)}."
            )
    lines += map(free_words, verdict.free)
    if verdict.closure.share > 0.0 and any(gap.causes for gap in verdict.gaps):
        lines.append(_closed(account))
    closing = account.closing
    quiet = closing is None or closing.verdict.kind == "no_gap" or not closing.closed
    if verdict.kind in SURE and quiet and not (verdict.remains or verdict.doubts):
        lines.append("With that in the model, no significant gap remains.")
    if account.chosen:
        lines.append(
            f"The log does not tell its cause: {words(account.chosen)} was chosen by the user."
        )
    if account.formula is not None:
        lines += formula_sentences(account.formula)
    if not account.null_flights:
        lines.append(_WITHOUT_NULL_FLIGHTS)
    return lines


def evidence_words(account: Account) -> list[str]:
    """Where the gap is largest, in σ, and where the thresholds come from."""
    verdict = account.verdict
    lines = []
    if verdict.kind != "no_gap" and verdict.located:
        places = [_place_words(place) for place in verdict.located[:3]]
        lines.append(f"The gap is largest in {listed(places)}.")
    if account.null_flights:
        lines.append(
            f"The thresholds come from {account.null_flights} simulated flights of the same card "
            "without an effect."
        )
    parts = [f"{part} {percent(p)}" for part, p in verdict.parts.items() if p >= REPORTED_FROM]
    if verdict.kind != "no_gap" and parts:
        lines.append(f"By part: {', '.join(parts)}.")
    return lines


def _most(verdict: Verdict) -> str:
    """Where the most of what no effect explains stands, to be added to a sentence."""
    return f", most of it in {_place_words(verdict.located[0])}" if verdict.located else ""


def _place_words(place: Located) -> str:
    within = "in " if place.phase else ""
    return f"{words(place.channel)} {within}{words(place.where)} ({place.significance:+.0f}σ)"


def _answer(verdict: Verdict, aircraft: str) -> str:
    if verdict.kind == "no_gap" and aircraft == "none":
        return "The sensors agree with one another: no significant gap."
    if verdict.kind == "no_gap":
        return "Simulation and measurement agree: no significant gap."
    if verdict.kind == "unknown":
        gap = f"There is a significant gap, and no effect of the table explains it{_most(verdict)}."
        return f"{gap} {_best(verdict)}".strip()
    reported = [_gap_words(gap) for gap in verdict.explained]
    if len(reported) == 1:
        return f"It is {reported[0]}; ± is 2σ.{_doubt(verdict)}"
    numbered = "; ".join(f"{number}, {text}" for number, text in enumerate(reported, start=1))
    return (
        f"There are {len(reported)} gaps beside one another: {numbered}; ± is 2σ.{_doubt(verdict)}"
    )


def _gap_words(gap: Gap) -> str:
    """A gap: its part with the causes of it, or its causes where no part is named."""
    first, *others = gap.causes
    reported = [
        first,
        *(each for each in others if each.probability >= REPORTED_FROM or not each.sizes),
    ]
    names = {each.name: effect_words(each, percent(each.probability)) for each in reported}
    if not gap.part_named:
        best, *rivals = names.values()
        if rivals:
            return f"one of these: {best} or, less probably, {listed(rivals, 'or')}"
        return best if gap.named else f"probably {best}"
    inside = [text for name, text in names.items() if effect_of(name).part == gap.part]
    beyond = [text for name, text in names.items() if effect_of(name).part != gap.part]
    less = f"; less probably, it is {listed(beyond, 'or')}" if beyond else ""
    named = part_words(gap.part, [effect_of(first.name).cause])
    return f"{named} ({percent(gap.probability)}): {listed(inside, 'or')}{less}"


def free_words(each: FreeSize) -> str:
    """An unknown of the log that lies far beyond its prior, in a sentence."""
    return (
        f"The log's own {words(each.name)} comes out at {each.value:+.3g} ± {each.two_sigma:.2g}, "
        f"where {each.prior:.2g} is usual (1σ): look at it, for it takes a part of the gap."
    )


def reported_rivals(verdict: Verdict) -> list[list[str]]:
    """For each gap, the other causes of its set that are worth telling."""
    return [
        [c.name for c in gap.causes[1:] if c.probability >= REPORTED_FROM]
        for gap in verdict.explained
    ]


def _doubt(verdict: Verdict) -> str:
    """What the gaps leave for causes that the table holds in no form; empty where it is little."""
    left = [1.0 - sum(c.probability for c in gap.causes) for gap in verdict.explained]
    if max(left, default=0.0) < DOUBTED:
        return ""
    return (
        f" With {percent_text(max(left))} it is a cause that the table does not hold in this form."
    )


def percent(probability: float) -> str:
    """A probability in percent, never reported as more than 99."""
    return percent_text(min(probability, 0.99))


def _best(verdict: Verdict) -> str:
    """Return an unknown cause's best candidate and why it is refused; "" for none."""
    if not verdict.candidates:
        return ""
    best = verdict.candidates[0]
    return (
        f"The best candidate, {effect_words(best)}, with a score of {best.score:.0f}σ, leaves a "
        "gap or does not explain parts of the log that it was not fitted to. "
    )


def _closed(account: Account) -> str:
    verdict = account.verdict
    line = (
        f"Adding it closes {percent_text(verdict.closure.share)} of the explainable gap of this log"
    )
    if verdict.closure_holdout is not None:
        line += (
            f", and {percent_text(verdict.closure_holdout.share)} of that of {account.holdout}, "
            "which was not used"
        )
    return line + "."


_NO_PROOF = (
    "That does not prove the names, for a wrong set may fit this log as well: judge a flight of "
    "another maneuver with it."
)


def closing_sentences(closing: Closing) -> list[str]:
    """What closing the loop came to: what was patched, what it closes, and what stays unknown."""
    verdict, name = closing.verdict, closing.aircraft
    cut = [f"{heading(each)}." for each in (*closing.cut, closing.not_told) if each]
    if not closing.closed:
        none = "No gap of the airplane is told that closes 1 % held out"
        return [*cut, f"{name} is not written." if cut else f"{none}: {name} is not written."]
    line = f"{name} is the airplane with what was found of it (rounds: {len(closing.closed)}). "
    line += f"Its patch closes {percent_text(min(1.0, closing.closed[-1]))} of the gap held out"
    if closing.closure_holdout is not None:
        line += f", and {percent_text(closing.closure_holdout)} of that of the held-out log"
    if verdict.kind == "no_gap":
        quiet = "Judged again with it, the log shows no significant gap."
        return [f"{line}.", *cut, f"{quiet} {_NO_PROOF}"]
    lines = [f"{line}.", *cut, f"Judged again with it: {_answer(verdict, name)}"]
    if verdict.located and (verdict.remains or not closing.reported):
        places = [f"{words(p.channel)} {words(p.where)}" for p in verdict.located[:3]]
        lines.append(f"What stays unknown is largest in {listed(places)}.")
    return lines


# share of cards, flown again by one airplane, of which a characteristic number differs
BY_CHANCE = 0.05


def remaining_features(features: Sequence[Feature]) -> list[Feature]:
    """The characteristic numbers that differ with the patch by more than chance."""
    limit = features_limit(features)
    return [f for f in features if abs(f.measured - f.patched) > limit * f.deviation]


def features_limit(features: Sequence[Feature]) -> float:
    """Return by how many deviations chance moves the largest of some features in one card of 20.

    The deviation is that of a few flights, so the numbers are Student's; there are many of them
    (Bonferroni 1936).
    """
    least = min((f.freedom for f in features), default=1)
    return float(stdtrit(least, 1.0 - 0.5 * BY_CHANCE / max(len(features), 1)))
