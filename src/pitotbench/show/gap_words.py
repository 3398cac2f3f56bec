"""A verdict in plain sentences: what is missing, how large, how sure, and what closing it does."""

from collections.abc import Sequence

from pitotbench.effects import EFFECTS
from pitotbench.records.gap import Account
from pitotbench.records.verdict import SURE, Candidate, Closure, Detectable, Located, Verdict

UNITS = {
    "_m2": "m²",
    "_mps2": "m/s²",
    "_mps": "m/s",
    "_pa": "Pa",
    "_kt": "kt",
    "_kg": "kg",
    "_m": "m",
    "_s": "s",
    "_k": "K",
    "_deg": "°",
    "_rad": "rad",
    "_hz": "Hz",
    "_radps": "rad/s",
    "_ft": "ft",
}


def words(name: str) -> str:
    """A name of a table as words."""
    return name.replace("_", " ")


def size_words(name: str, value: float, bound: float | None = None) -> str:
    """A size with its bound and its unit: `drag area 0.12 ± 0.01 m²`."""
    suffix = max((s for s in UNITS if name.endswith(s)), key=len, default="")
    told = f"{value:.3g}" if bound is None else f"{value:.3g} ± {bound:.2g}"
    return f"{words(name.removesuffix(suffix))} {told} {UNITS.get(suffix, '')}".rstrip()


def effect_words(effect: Candidate) -> str:
    """An effect with its sizes."""
    return f"{words(effect.name)} ({'; '.join(size_words(s.name, s.value, s.two_sigma) for s in effect.sizes)})"


def place_words(place: Located) -> str:
    """A place of the gap."""
    within = "in " if place.phase else ""
    return f"{words(place.channel)} {within}{words(place.where)} ({place.significance:+.0f}σ)"


def sentences(account: Account) -> list[str]:
    """The answer in plain sentences."""
    verdict = account.rounds[0].verdict
    lines = [_answer(verdict, account.null_flights)]
    if verdict.kind != "no_gap" and verdict.located:
        lines.append(f"The gap is largest in {_listed([place_words(p) for p in verdict.located[:3]])}.")
    if verdict.kind in SURE:
        lines.append(_closed(verdict, account.holdout))
        lines.append(_looked(account))
    return lines


def _answer(verdict: Verdict, null_flights: int) -> str:
    if verdict.kind == "no_gap":
        return f"Simulation and measurement agree: no significant gap. {_sure(null_flights)}"
    if verdict.kind == "unknown":
        best = [f"{effect_words(c)}, at {c.score:.0f}σ" for c in verdict.candidates[:1]]
        tried = [f"The best of the table, {told}, leaves a gap or does not hold on other parts." for told in best]
        said = "There is a real gap, and nothing in the table of effects explains it."
        return " ".join([said, *tried, _sure(null_flights)])
    known = {candidate.name: candidate for candidate in verdict.candidates}
    effects = []
    for effect, others in zip(verdict.effects, verdict.alternatives, strict=True):
        told = [effect_words(known[n]) if n in known else words(n) for n in others]
        effects.append(effect_words(effect) + (f" or, as well, {_listed(told, 'or')}" if told else ""))
    lead = "The model lacks " if verdict.kind == "named" else "The model lacks one of these: "
    return f"{lead}{_listed(effects)}; ± is 2σ. {_sure(null_flights)}"


def _sure(null_flights: int) -> str:
    if null_flights:
        return f"Judged against {null_flights} flights of the same card without an effect."
    return (
        "No flights without an effect were there to judge by: the noise is the log's own, thresholds are half as "
        "high again, and a size of a few σ should be flown again before it is believed."
    )


def _closed(verdict: Verdict, holdout: str) -> str:
    line = f"Adding it closes {closure_percent(verdict.closure)} of the explainable gap of this log"
    if verdict.closure_holdout is not None:
        line += f", and {closure_percent(verdict.closure_holdout)} of that of {holdout}, which was not used"
    return line + "."


def closure_percent(closed: Closure) -> str:
    """A closure in percent, one digit where it is near whole."""
    return f"{100.0 * closed.share:.0f} %"


def _looked(account: Account) -> str:
    if len(account.rounds) < 2:
        return ""
    last = account.rounds[-1]
    more = [name for r in account.rounds[1:] for name in r.added]
    added = f"A further look added {_listed([words(n) for n in more])}. " if more else ""
    end = {
        "no_gap": "With that in the model nothing significant remains.",
        "unknown": "With that in the model a gap remains that nothing in the table explains.",
    }
    return added + end.get(last.verdict.kind, "More may remain: the looks at one log are limited.")


def _listed(items: Sequence[str], word: str = "and") -> str:
    return items[0] if len(items) == 1 else f"{', '.join(items[:-1])} {word} {items[-1]}"


def detectable_words(found: Detectable) -> tuple[str, str, str]:
    """Family, effect and smallest size of it that would have shown."""
    return EFFECTS[found.effect].family, words(found.effect), size_words(found.parameter, found.size)
