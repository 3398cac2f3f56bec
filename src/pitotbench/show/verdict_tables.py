"""The tables of a reconciliation: places of the gap, candidates, checks, tolerances, features, smallest sizes."""

from pitotbench.effects import EFFECTS
from pitotbench.records.gap import Account, Feature, FlownAgain, Tolerance
from pitotbench.records.verdict import Candidate, Check, Detectable, Located, Verdict
from pitotbench.show.columns import Column
from pitotbench.show.gap_words import effect_words, told_rivals
from pitotbench.show.quantity_words import size_words, with_unit, words

KIND_WORDS = {
    "named": "named",
    "one_of": "one of these",
    "unknown": "a gap with a cause that is not in the table",
    "no_gap": "no significant gap",
}
NOTICED = 2.0  # standard deviations between two flights of one airplane: only larger differences are shown

PLACE_COLUMNS: tuple[Column[Located], ...] = (
    Column("channel", lambda place: words(place.channel)),
    Column("phase or variable", lambda place: words(place.where)),
    Column("", lambda place: place.channel, key="channel"),
    Column("", lambda place: place.phase, key="phase"),
    Column("", lambda place: place.variable, key="variable"),
    Column("gap", lambda place: place.significance, "σ", "+.1f", "significance"),
)

CHECK_COLUMNS: tuple[Column[Check], ...] = (
    Column("check", lambda check: check.name, key="name"),
    Column("result", lambda check: check.status, key="status"),
    Column("reason", lambda check: check.why, key="why"),
)

DETECTABLE_COLUMNS: tuple[Column[Detectable], ...] = (
    Column("family", lambda found: EFFECTS[found.effect].family),
    Column("effect", lambda found: words(found.effect)),
    Column("smallest size", lambda found: size_words(found.parameter, found.size)),
    Column("", lambda found: found.effect, key="effect"),
    Column("", lambda found: found.parameter, key="parameter"),
    Column("", lambda found: found.size, key="size"),
)

TOLERANCE_COLUMNS: tuple[Column[Tolerance], ...] = (
    Column("quantity", lambda t: t.quantity, key="quantity"),
    Column("tolerance", lambda t: f"±{with_unit(f'{t.half_width:g}', t.unit)}"),
    Column("", lambda t: t.half_width, key="half_width"),
    Column("", lambda t: t.unit, key="unit"),
    Column("before", lambda t: t.before, "%", ".0%", "before"),
    Column("with the patch", lambda t: t.after, "%", ".0%", "after"),
    Column("two flights of one airplane", lambda t: t.by_chance, "%", ".0%", "by_chance"),
)


def _difference(each: Feature, value: float) -> float:
    """Measured minus `value`, in standard deviations between two flights of one airplane."""
    return (each.measured - value) / max(each.deviation, 1e-9)


FEATURE_COLUMNS: tuple[Column[Feature], ...] = (
    Column("segment", lambda f: f.segment),
    Column("quantity", lambda f: f"{f.name} [{f.unit}]"),
    Column("measured", lambda f: f.measured, style=".2f"),
    Column("simulated", lambda f: f.simulated, style=".2f"),
    Column("patched", lambda f: f.patched, style=".2f"),
    Column("measured − simulated", lambda f: _difference(f, f.simulated), "σ", "+.1f"),
    Column("measured − patched", lambda f: _difference(f, f.patched), "σ", "+.1f"),
)


def pilot_words(flown: FlownAgain) -> str:
    """Return who flew the card again, where it is another one than the card tells; else nothing."""
    if not flown.pilot:
        return ""
    hand = "the autopilot alone" if flown.pilot == "none" else f"a {flown.pilot} pilot"
    return f"Flown by {hand}: bank, pitch and heading of the log move to and fro as under this hand."


def noticed(features: tuple[Feature, ...]) -> list[Feature]:
    """The features that differ, with or without the patch, by more than two flights of one airplane do."""
    return [
        f
        for f in features
        if max(abs(f.measured - f.simulated), abs(f.measured - f.patched)) > NOTICED * f.deviation
    ]


def kind_words(verdict: Verdict) -> str:
    """The kind of a verdict in words. A set of which one cause alone is worth telling is a doubted name."""
    if verdict.kind == "one_of" and not any(told_rivals(verdict)):
        return "a probable cause"
    return KIND_WORDS[verdict.kind]


def candidate_columns(verdict: Verdict) -> list[Column[Candidate]]:
    """The columns of a verdict's candidates; the last one says which of them the verdict names."""
    named = {effect.name for effect in verdict.effects}
    alternatives = {name for names in verdict.alternatives for name in names}

    def result(each: Candidate) -> str:
        if each.name in named:
            return "named"
        return "cannot be distinguished" if each.name in alternatives else ""

    return [
        Column("effect", lambda each: words(each.name)),
        Column("", lambda each: each.name, key="name"),
        Column("size (± is 2σ)", _sizes),
        Column("probability", lambda each: each.probability, style=".2f", key="probability"),
        Column("score", lambda each: each.score, "σ", ".1f", "score"),
        Column("gain on held-out parts / gain on fitted parts", lambda each: each.held_out_ratio, style=".2f"),
        Column("plausible size", lambda each: each.plausible, key="plausible"),
        Column("verdict", result),
    ]


def round_columns(account: Account) -> list[Column[int]]:
    """The columns of the passes over one log, for rows that are the numbers of the passes, from 0."""

    def verdict_words(number: int) -> str:
        each = account.rounds[number]
        named = "; ".join(effect_words(effect) for effect in each.verdict.effects) if each.added else ""
        return kind_words(each.verdict) + (f": {named}" if named else "")

    def largest(number: int) -> str:
        located = account.rounds[number].verdict.located
        return f"{words(located[0].channel)}, {words(located[0].where)}" if located else ""

    def significance(number: int) -> float | None:
        located = account.rounds[number].verdict.located
        return located[0].significance if located else None

    return [
        Column("pass", lambda number: str(number + 1)),
        Column("verdict", verdict_words),
        Column("largest gap in", largest),
        Column("largest gap", significance, "σ", "+.1f"),
    ]


def _sizes(each: Candidate) -> str:
    return "; ".join(size_words(size.name, size.value, size.two_sigma) for size in each.sizes)
