"""The rows of the score table: shares with Wilson's intervals, against their targets."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from math import sqrt
from typing import Any

import numpy as np
from tests.blind.forms import KNOWN_AND_HIDDEN

Z = 1.959964  # of a two-sided interval of 95 %


@dataclass(frozen=True, slots=True)
class Judged:
    """One log: what was hidden and what was answered, both as read from their files."""

    truth: dict[str, Any]
    answer: dict[str, Any]

    @property
    def kind(self) -> str:
        """What kind of case it was."""
        return str(self.truth["kind"])

    @property
    def wanted(self) -> tuple[str, ...]:
        """The effects of the table to be named; a variant form counts as the effect whose cause it shares."""
        return tuple(_cause(name) for name, _ in self.truth["effects"])

    @property
    def verdict(self) -> str:
        """The kind of the answer."""
        return str(self.answer["kind"])

    @property
    def groups(self) -> list[set[str]]:
        """The cause of each effect that was answered, with those not told from it; none where nothing was named."""
        if self.verdict not in ("named", "one_of"):
            return []
        pairs = zip(self.answer["effects"], self.answer["alternatives"], strict=True)
        return [{_cause(n) for n in (name, *others)} for name, others in pairs]

    @property
    def right(self) -> bool:
        """Named, and exactly what was hidden."""
        return self.verdict == "named" and sorted(map(_cause, self.answer["effects"])) == sorted(self.wanted)

    @property
    def wrong_name(self) -> bool:
        """Some effect named for itself that was not hidden."""
        return any(len(group) == 1 and not group & set(self.wanted) for group in self.groups)

    @property
    def in_set(self) -> bool:
        """Every hidden effect stands in some reported set."""
        return all(any(name in group for group in self.groups) for name in self.wanted)


def _cause(name: str) -> str:
    return KNOWN_AND_HIDDEN[name].cause


@dataclass(frozen=True, slots=True)
class Row:
    """A line of the table; `low` and `high` bound the share at 95 %."""

    what: str
    target: str
    hits: int
    cases: int
    low: float
    high: float

    @property
    def share(self) -> float:
        """Hits over cases, nan without cases."""
        return self.hits / self.cases if self.cases else float("nan")


def row(what: str, target: str, cases: Iterable[Judged], hit: Callable[[Judged], bool]) -> Row:
    """Count a property of some cases."""
    flags = [hit(case) for case in cases]
    return Row(what, target, sum(flags), len(flags), *wilson(sum(flags), len(flags)))


def wilson(hits: int, cases: int) -> tuple[float, float]:
    """The 95 % interval of a share (Wilson 1927)."""
    if not cases:
        return 0.0, 1.0
    share, shrunk = hits / cases, 1.0 + Z * Z / cases
    center = (share + Z * Z / (2 * cases)) / shrunk
    half = Z * sqrt(share * (1.0 - share) / cases + Z * Z / (4 * cases * cases)) / shrunk
    return max(0.0, center - half), min(1.0, center + half)


def table(cases: Sequence[Judged]) -> list[Row]:
    """All rows that are shares."""
    by = {kind: [c for c in cases if c.kind == kind] for kind in {c.kind for c in cases}}
    bands = [(name, by.get(name, [])) for name in ("above 7", "4 to 7", "2 to 4")]
    single = [c for _, band in bands for c in band] + by.get("confusable", [])
    none, two, outside = by.get("none", []), by.get("two", []), by.get("outside", [])
    strong = bands[0][1]
    rows = [
        row("false alarm on none", "≤ 3 %", none, lambda c: c.verdict != "no_gap"),
        row("· of these an effect reported", "", none, lambda c: bool(c.groups)),
    ]
    for (name, band), target in zip(bands, ("≥ 97 %", "≥ 90 %", "≥ 55 %"), strict=True):
        rows.append(row(f"right name, SNR {name}", target, band, lambda c: c.right))
        rows.append(row("· right name or a set that holds it", "", band, lambda c: bool(c.groups) and c.in_set))
    reported = [c for c in single if c.groups]
    rows += [
        row("truth in the reported set, where effects are reported", "≥ 97 %", reported, lambda c: c.in_set),
        row("wrong single name, any band", "≤ 3 %", single, lambda c: c.wrong_name),
        row("confusable: right name", "", by.get("confusable", []), lambda c: c.right),
        row(
            "confusable: truth in the reported set",
            "",
            by.get("confusable", []),
            lambda c: bool(c.groups) and c.in_set,
        ),
        row("two effects: both reported", "≥ 75 %", two, lambda c: bool(c.groups) and c.in_set),
        row("two effects: at least one", "≥ 97 %", two, lambda c: any(set(c.wanted) & g for g in c.groups)),
        row("two effects: a wrong name among them", "", two, lambda c: c.wrong_name),
        row("outside the table: wrongly named", "≤ 7 %", outside, lambda c: c.wrong_name),
        row("outside the table: named or one of", "", outside, lambda c: bool(c.groups)),
        row("outside the table: abstains (unknown)", "≥ 85 %", outside, lambda c: c.verdict == "unknown"),
        row("needless abstention (unknown, no gap), SNR above 7", "≤ 5 %", strong, lambda c: not c.groups),
        row("one of several, SNR above 7", "", strong, lambda c: c.verdict == "one_of"),
        row("gusts and samples: right name", "", by.get("gusts or samples", []), lambda c: c.right),
    ]
    return [*rows, *_closures(cases), _sizes(cases), *_seconds(cases)]


def _sizes(cases: Sequence[Judged]) -> Row:
    """Sizes of right names whose error is within their bound; variant forms have other sizes."""
    inside = []
    for case in cases:
        for name, sizes in case.truth["effects"] if case.groups else []:
            found = case.answer["sizes"].get(name, {})
            inside += [abs(v - sizes[p]) <= bound for p, (v, bound) in found.items() if p in sizes]
    return Row("size within 2σ", "95 ± 3 %", sum(inside), len(inside), *wilson(sum(inside), len(inside)))


def _closures(cases: Sequence[Judged]) -> list[Row]:
    right = [c for c in cases if c.right and "held_out" in c.answer]
    forced = [f for f in map(forced_closure, cases) if f is not None]
    low = sum(f < 0.3 for f in forced)
    return [
        row(
            "held-out G of right names at least 0.95",
            "median: ≥ 50 %",
            right,
            lambda c: c.answer["held_out"] >= 0.95,
        ),
        row("held-out G of right names at least 0.8", "≥ 90 %", right, lambda c: c.answer["held_out"] >= 0.8),
        Row("a wrong effect forced in: G below 0.3", "all", low, len(forced), *wilson(low, len(forced))),
    ]


def forced_closure(case: Judged) -> float | None:
    """Closure by an effect that was neither hidden nor reported, drawn by the log's name; None without a gap."""
    hidden = {*case.wanted, *(name for group in case.groups for name in group)}
    others = sorted(n for n in case.answer["gains"] if _cause(n) not in hidden)
    if not case.right or case.answer["gap"] < 16.0 or not others:
        return None
    drawn = np.random.default_rng(int(case.answer["name"][-4:])).choice(others)
    return float(case.answer["gains"][str(drawn)] / case.answer["gap"])


def _seconds(cases: Sequence[Judged]) -> list[Row]:
    return [
        row("a case within 20 s", "median: ≥ 50 %", cases, lambda c: c.answer["wall_s"] <= 20.0),
        row("a case within 60 s", "all", cases, lambda c: c.answer["wall_s"] <= 60.0),
    ]
