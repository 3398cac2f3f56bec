"""Say what to fly next: what tells two explanations apart, or makes a size better known."""

from collections.abc import Sequence

from pitotbench.effects import EFFECTS

DIAGNOSTIC = "diagnostic (climb, descent, steady sideslips, turn, idle and back: 6 minutes)"


def flights_to_fly(kind: str, groups: Sequence[Sequence[str]]) -> tuple[str, ...]:
    """Return the sentences of advice for a verdict of a kind.

    Each of `groups` holds the name of an effect that was found, then the names of those that fit as well.
    """
    if kind == "no_gap":
        return ("nothing to separate; the smallest sizes that would have shown are listed",)
    if kind == "unknown":
        return (
            "repeat the maneuver: a gap that returns in the same channel and phase is the airplane's or the "
            "system's, one that does not is the day's",
        )
    return tuple(_for_group(group) for group in groups)


def _for_group(names: Sequence[str]) -> str:
    """What to fly for effects that fit as well as each other, or for a single one."""
    flown = list(dict.fromkeys(str(EFFECTS[name].shows_in) for name in names))
    if len(names) == 1:
        return f"to sharpen {names[0]}: {flown[0]}"
    listed = ", ".join(names)
    if len(flown) == 1:
        return (
            f"{listed} act alike in any maneuver of this kind; look at the airplane, or sharpen both by: {flown[0]}"
        )
    return f"to tell {listed} apart: fly {DIAGNOSTIC}; or " + "; or ".join(flown)
