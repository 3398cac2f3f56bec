"""Add: what was named, as data that a case file takes, each number with its bound and where it came from."""

from collections.abc import Sequence
from dataclasses import dataclass

from pitotbench.effects import EFFECTS
from pitotbench.records.verdict import Candidate

DIGITS = 5


@dataclass(frozen=True, slots=True)
class Patch:
    """Effects with sizes, as entries of a case file; `text` is TOML with bounds and provenance as comments."""

    entries: tuple[tuple[str, dict[str, float]], ...]
    text: str


def patch(effects: Sequence[Candidate], source: str, date: str) -> Patch:
    """The patch for some effects. `source` names the log, `date` says when it was made.

    Sizes outside the plausible range are brought to its edge, and shapes left out keep what is typical.
    """
    entries, lines = [], [f"# found in {source}", f"# {date}"]
    for effect in effects:
        parameters = {p.name: p for p in EFFECTS[effect.name].parameters}
        sizes = {}
        lines += ["", "[[effects]]", f'name = "{effect.name}"', "", "[effects.parameters]"]
        for size in effect.sizes:
            limits = parameters[size.name]
            sizes[size.name] = float(f"{min(max(size.value, limits.low), limits.high):.{DIGITS}g}")
            lines.append(f"{size.name} = {sizes[size.name]!r}  # ± {size.two_sigma:.2g} (2σ)")
        entries.append((effect.name, sizes))
    return Patch(tuple(entries), "\n".join(lines) + "\n")
