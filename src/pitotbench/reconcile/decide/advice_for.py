"""Advise what to fly next, to separate two explanations or to sharpen a size."""

from collections.abc import Sequence

from pitotbench.effects import FORMS

DIAGNOSTIC = "diagnostic (climb, descent, steady sideslips, turn, idle and back: 6 minutes)"


def flights_to_fly(kind: str, groups: Sequence[Sequence[str]]) -> tuple[str, ...]:
    """Return the sentences of advice for a verdict of a kind.

    Each of `groups` holds the name of an effect that was found, then the names of those that fit equally well.
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
    """The advice for effects that fit equally well, or for a single one."""
    shown_by = list(dict.fromkeys(str(FORMS[name].shows_in) for name in names))
    if len(names) == 1:
        return f"to sharpen {names[0]}: {shown_by[0]}"
    listed = ", ".join(names)
    if len(shown_by) == 1:
        alike = f"{listed} act alike in any maneuver of this kind"
        return f"{alike}; look at the airplane, or sharpen both by: {shown_by[0]}"
    return f"to tell {listed} apart: fly {DIAGNOSTIC}; or " + "; or ".join(shown_by)
