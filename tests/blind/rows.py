"""The rows of the score table: shares with Wilson's intervals."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from tests.blind.case import NO_ANSWER, JudgedCase, model_of
from tests.blind.wilson import wilson

SMALLEST_P = 0.02  # of a cause that counts in the calibration
FEWEST = 10  # probabilities in a tenth, below which its difference is not looked at
CLOSED = 0.8  # share of a gap


@dataclass(frozen=True, slots=True)
class Row:
    """A line of the table; `low` and `high` bound the share at 95 %. `remark` stands beside it."""

    what: str
    hits: int
    cases: int
    low: float
    high: float
    remark: str = ""

    @property
    def share(self) -> float:
        """Hits over cases, nan without cases."""
        return self.hits / self.cases if self.cases else float("nan")


def row(what: str, flags: Iterable[bool], remark: str = "") -> Row:
    """Count flags."""
    each = [bool(flag) for flag in flags]
    return Row(what, sum(each), len(each), *wilson(sum(each), len(each)), remark)


def table(cases: Sequence[JudgedCase]) -> list[Row]:
    """All rows that are shares."""
    answered = [c for c in cases if c.verdict != "not scored"]  # a crash counts as a miss
    one = [c for c in answered if c.is_single and c.flights == 1]
    several = [c for c in answered if c.is_single and c.flights > 1]
    none, two, outside, counted = (
        [c for c in answered if c.kind == k] for k in ("none", "two", "outside", "counted")
    )
    single = one + several
    named = [c for c in single if c.verdict == "named"]
    return [
        *_calibration(answered),
        *_strong("above 7, one flight", [c for c in one if c.band == "above 7"]),
        *_weak("4 to 7, one flight", [c for c in one if c.band == "4 to 7"]),
        *_weak("2 to 4, one flight", [c for c in one if c.band == "2 to 4"]),
        *_strong("above 7, two flights", [c for c in several if c.band == "above 7" and c.flights == 2]),
        *_strong("above 7, three flights", [c for c in several if c.band == "above 7" and c.flights == 3]),
        *_weak("4 to 7, two or three flights", [c for c in several if c.band == "4 to 7"]),
        *_advised(one),
        row("a second effect that was not hidden, of single effects named", (len(c.groups) > 1 for c in named)),
        row("wrong name, any band", (c.wrong_name for c in single)),
        row("nothing hidden: an answer other than no gap", (c.verdict != "no_gap" for c in none)),
        row("nothing hidden: an effect reported", (bool(c.groups) for c in none)),
        row("two at once: both in the answer", (c.in_set for c in two)),
        row("two at once: at least one", (any(c.wanted & g for g in c.groups) for c in two)),
        row("two at once: both named cleanly", (c.named for c in two)),
        row("two at once: a wrong name", (c.wrong_name for c in two)),
        row("outside the table: wrongly named", (c.wrong_name for c in outside)),
        row("outside the table: named or one of", (bool(c.groups) for c in outside)),
        row("outside the table: detected", (c.verdict != "no_gap" for c in outside)),
        *_formulas(outside),
        row("counted faults and gusts: named", (c.named for c in counted)),
        _sizes(single),
        row("crash, refusal or no answer", (c.verdict in ("crash", "refused") for c in cases)),
        *_held_out(single),
    ]  # fmt: skip


def tenths(cases: Sequence[JudgedCase]) -> list[tuple[float, int, float, float]]:
    """The calibration: lower end of each tenth, number of causes, mean probability, share right."""
    pairs = [
        (p, cause in c.wanted)
        for c in cases
        if c.verdict not in ("no_gap", *NO_ANSWER)
        for cause, p in c.probabilities.items()
        if p > SMALLEST_P
    ]
    found = []
    for low in np.arange(0.0, 1.0, 0.1):
        inside = [(p, right) for p, right in pairs if low <= p < low + 0.1 or (low > 0.85 and p >= 1.0)]
        if inside:
            p, right = np.array(inside, dtype=float).T
            found.append((float(low), len(inside), float(p.mean()), float(right.mean())))
    return found


def _calibration(cases: Sequence[JudgedCase]) -> list[Row]:
    of_table = [c for c in cases if c.is_single or c.kind == "two"]
    worst = max((abs(mean - share) for _, n, mean, share in tenths(of_table) if n >= FEWEST), default=float("nan"))
    sure = [
        cause in c.wanted
        for c in of_table
        if c.verdict not in ("no_gap", *NO_ANSWER)
        for cause, p in c.probabilities.items()
        if p > 0.9
    ]
    remark = f"largest difference of a tenth: {worst:.2f}"
    return [row("probabilities above 0.9 that are right, the cause being in the table", sure, remark)]


def _strong(what: str, cases: Sequence[JudgedCase]) -> list[Row]:
    sizes = [len(set().union(*c.groups)) for c in cases if c.groups]
    remark = f"mean size of the reported sets: {np.mean(sizes):.1f}" if sizes else ""
    return [
        row(f"{what}: named cleanly", (c.named for c in cases), _ceiling(cases)),
        row(f"{what}: truth named or in the set", (c.in_set for c in cases), remark),
        row(f"{what}: wrong name", (c.wrong_name for c in cases)),
    ]


def _weak(what: str, cases: Sequence[JudgedCase]) -> list[Row]:
    return [
        row(f"{what}: detected", (c.verdict != "no_gap" for c in cases)),
        row(f"{what}: first in the ranking", (c.first for c in cases)),
        row(f"{what}: named cleanly", (c.named for c in cases), _ceiling(cases)),
        row(f"{what}: truth named or in the set", (c.in_set for c in cases)),
    ]


def _ceiling(cases: Sequence[JudgedCase]) -> str:
    seen = [c for c in cases if c.observed]
    if not seen:
        return ""
    ideal, tool = sum(c.observer_names for c in seen), sum(c.named for c in seen)
    ratio = f", ratio {tool / ideal:.2f}" if ideal else ""
    return f"ideal observer: {ideal} of {len(seen)}{ratio}"


def _advised(cases: Sequence[JudgedCase]) -> list[Row]:
    rows = []
    for band in ("above 7", "4 to 7"):
        flown = [c for c in cases if c.band == band and c.advised]
        before = sum(c.named for c in flown)
        remark = f"before it: {before}" if flown else "not scored"
        named = (replace(c, answer=c.advised).named for c in flown)
        rows.append(row(f"{band}, with the flight advised: named cleanly", named, remark))
    return rows


def _formulas(cases: Sequence[JudgedCase]) -> list[Row]:
    asked = [c for c in cases if "formula" in c.answer]
    found = (bool(c.answer["formula"]) and c.answer["formula"]["closure"] >= CLOSED for c in asked)
    return [row("outside the table: a formula closes at least 0.8", found, "" if asked else "not scored")]


def _sizes(cases: Sequence[JudgedCase]) -> Row:
    """Sizes of right names within their bounds, where the whole flight has the plain form of the effect."""
    inside = []
    for case in cases:
        hidden: dict[str, Any] = {e["name"]: e for e in case.truth["effects"] if e["part"] is None}
        for name, sizes in case.answer.get("sizes", {}).items() if case.in_set else ():
            for parameter, (value, bound) in sizes.items():
                if name in hidden and parameter in hidden[name]["sizes"]:
                    inside.append(abs(value - hidden[name]["sizes"][parameter]) <= bound)
    return row("size within 2σ of the truth", inside)


def _held_out(cases: Sequence[JudgedCase]) -> list[Row]:
    closed = [c.answer["held_out"] for c in cases if c.named and "held_out" in c.answer]
    remark = (
        f"median {np.median(closed):.3f}, a tenth below {np.quantile(closed, 0.1):.3f}" if closed else "not scored"
    )
    return [
        row(
            "closure of the flight held out at least 0.8, of names that are right",
            (g >= CLOSED for g in closed),
            remark,
        )
    ]


def seconds(cases: Sequence[JudgedCase]) -> str:
    """Processor seconds a case of one flight, with the null flights in the cache and without."""
    told = []
    for warm, name in ((True, "warm"), (False, "cold")):
        each = [c.answer["processor_s"] for c in cases if c.flights == 1 and c.answer.get("warm") == warm]
        if each:
            told.append(f"{name}: median {np.median(each):.1f}, most {max(each):.1f} ({len(each)} cases)")
    return "Processor seconds a flight, " + "; ".join(told) + "."


def hidden_in(case: JudgedCase) -> str:
    """What was hidden, in words."""
    names = [model_of(e["name"]) for e in case.truth["effects"]]
    return " + ".join(sorted(names)) or "none"
