"""The patch: the named effects as entries of a case file; and the advice what to fly next."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from pitotbench.effects import FORMS, effect_of
from pitotbench.records import BadInputError
from pitotbench.records.verdict import Candidate, Gap

DIGITS = 5  # significant ones of a size: more than any bound needs
Shapes = Mapping[str, Mapping[str, float]]  # by effect: the time of an event, and the like


@dataclass(frozen=True, slots=True)
class Patch:
    """Effects with sizes, as entries of a case file; `entries` have the names of their forms.

    `text` is TOML with the bounds and the source as comments.
    """

    entries: tuple[tuple[str, dict[str, float]], ...]
    text: str


def patch_of_effects(
    effects: Sequence[Candidate],
    source: str,
    date: str,
    shapes: Shapes | None = None,
    others: Sequence[Sequence[Candidate]] = (),
) -> Patch:
    """Return the patch for some effects.

    `source` names the log, `date` is the date of the patch, and `shapes` are those that were
    fitted. `others` hold, for each effect, the effects that the log cannot separate from it; they
    stand in comments, ready to replace it. A case takes no size outside the plausible range: one
    that may lie there by chance is set to its end, and a comment says so. Shapes without an entry
    keep their typical value.
    """
    entries, lines = [], [f"# found in {source}", f"# {date}"]
    for number, effect in enumerate(effects):
        sizes = _sizes(effect) | _shapes(effect.name, shapes or {})
        entries.append((effect.name, sizes))
        lines += ["", *_entry(effect, sizes)]
        for other in others[number] if number < len(others) else ():
            alternative = _entry(other, _sizes(other))
            lines += [
                "",
                "# the log does not tell it from:",
                *(f"# {line}".rstrip() for line in alternative),
            ]
    return Patch(tuple(entries), "\n".join(lines) + "\n")


def require_choice(gaps: Sequence[Gap], chosen: str) -> None:
    """Raise BadInputError where a chosen cause is in no set of an answer."""
    told = [c.name for gap in gaps if not gap.named for c in gap.causes if c.sizes]
    if chosen and chosen not in told:
        which = f"choose one of {', '.join(told)}" if told else "no set of causes is told"
        raise BadInputError(f"--choose {chosen}: the log does not hold it in a set; {which}")


def with_choice(gap: Gap, chosen: str) -> Gap:
    """Return a gap with the chosen cause as the first, where its set holds it."""
    first = [each for each in gap.causes if each.name == chosen]
    return replace(gap, causes=(*first, *(c for c in gap.causes if c not in first)))


def is_settled(gap: Gap, chosen: str) -> bool:
    """Whether the cause of a gap is named, or was chosen."""
    return gap.named or gap.causes[0].name == chosen


def beyond_range(cause: Candidate) -> Iterator[str]:
    """Return a sentence for each size of a cause beyond its range: it is not patched."""
    for size in cause.sizes:
        end = effect_of(cause.name).parameter(size.name).within(size.value)
        if end != size.value:
            yield (
                f"{cause.name} is told and not patched: {size.name} comes out at "
                f"{size.value:.3g} ± {size.two_sigma:.2g}, and its range ends at {end:.3g}"
            )


def not_told(gaps: Sequence[Gap], chosen: str, flown: Sequence[str] = ()) -> str:
    """Return which causes of the airplane are not patched, and what to fly.

    The log does not tell them from others. Empty where there are none.
    """
    groups = [
        [cause.name for cause in gap.causes]
        for gap in gaps
        if not is_settled(with_choice(gap, chosen), chosen)
        and any(effect_of(cause.name).acts_on == "aircraft" for cause in gap.causes)
    ]
    if not groups:
        return ""
    names = "; ".join(", ".join(group) for group in groups)
    advice = "; ".join(flights_to_fly("one_of", groups, flown))
    return f"not patched, since the log does not tell which: {names}; {advice}; or --choose one"


def name_in_case(name: str) -> str:
    """Return an effect's name in a case file, that of the whole effect for a form in time."""
    return effect_of(name).part_of or name


def _entry(effect: Candidate, sizes: Mapping[str, float]) -> list[str]:
    found = {size.name: size for size in effect.sizes}
    lines = ["[[effects]]", f'name = "{name_in_case(effect.name)}"', "", "[effects.parameters]"]
    for name, value in sizes.items():
        lines.append(f"{name} = {value!r}")
        if name in found:
            shown = _rounded(found[name].value)
            end = "" if shown == value else f"the end of its range, for {shown!r} "
            lines[-1] += f"  # {end}± {found[name].two_sigma:.2g} (2σ)"
    return lines


def _sizes(effect: Candidate) -> dict[str, float]:
    """Return the sizes that were fitted, and 0 for those that a case must state."""
    own = effect_of(effect.name)
    limited = {s.name: own.parameter(s.name).within(s.value) for s in effect.sizes}
    stated = {p.name: 0.0 for p in own.parameters if not (p.shape or p.may_be_missing)}
    return stated | {name: _rounded(value) for name, value in limited.items()}


def _shapes(name: str, shapes: Shapes) -> dict[str, float]:
    return {key: _rounded(value) for key, value in shapes.get(name, {}).items()}


def _rounded(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")


DIAGNOSTIC = "diagnostic (climb, descent, steady sideslips, turn, idle and back: 6 minutes)"


def flights_to_fly(
    kind: str, groups: Sequence[Sequence[str]], flown: Sequence[str] = ()
) -> tuple[str, ...]:
    """Return the sentences of advice for a verdict of a kind.

    Each of `groups` holds the name of an effect that was found, then the names of those that fit
    equally well. `flown` are the maneuvers of the logs: they did not distinguish these, so none of
    them is advised for it.
    """
    if kind == "no_gap":
        return ("nothing to separate; the smallest sizes that would have shown are listed",)
    if kind == "unknown":
        return (
            "repeat the maneuver: a gap that returns in the same channel and phase is the "
            "airplane's or the "
            "system's, one that does not is the day's",
        )
    return tuple(_for_group(group, flown) for group in groups)


def maneuver_to_fly(groups: Sequence[Sequence[str]], flown: Sequence[str] = ()) -> str:
    """Return the first maneuver of the advice of `flights_to_fly` not flown, "" for none."""
    advised = [maneuver for names in groups for way, _ in _ways(names, flown) for maneuver in way]
    return next((each for each in advised if each not in flown), "")


def _ways(names: Sequence[str], flown: Sequence[str]) -> list[tuple[tuple[str, ...], str]]:
    """Return the maneuvers, with words, that show an effect or distinguish several."""
    shown_by = list(dict.fromkeys(FORMS[name].shows_in for name in names))
    if len(shown_by) == 1:
        return [(each.maneuvers, str(each)) for each in shown_by]
    others = [(w.maneuvers, str(w)) for w in shown_by if not set(w.maneuvers) & set(flown)]
    return others if "diagnostic" in flown else [(("diagnostic",), DIAGNOSTIC), *others]


def _for_group(names: Sequence[str], flown: Sequence[str]) -> str:
    """The advice for effects that fit equally well, or for a single one."""
    ways, listed = [words for _, words in _ways(names, flown)], ", ".join(names)
    if len(names) == 1:
        return f"to sharpen {listed}: {ways[0]}"
    if len({FORMS[name].shows_in for name in names}) == 1:
        alike = f"{listed} act alike in any maneuver of this kind"
        return f"{alike}; look at the airplane, or sharpen both by: {ways[0]}"
    if not ways:
        return f"{listed}: the maneuvers that show them were flown; look at the airplane"
    return f"to tell {listed} apart: fly " + "; or ".join(ways)
