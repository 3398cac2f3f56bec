"""The scorer of the blind test: holds the answers against the truth of a sealed set.

Cases without an answer yet (a run that was stopped) are left out.
"""

from argparse import ArgumentParser
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pitotlab.blind.case import NO_ANSWER, JudgedCase
from pitotlab.blind.parts import lines, named_parts, strong_causes, summed
from pitotlab.blind.sealed import judged_in, kept_sets
from pitotlab.sets import wilson
from pitotlab.tables import write_figures

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


def row(what: str, flags: Iterable[bool], remark: str = "") -> Row:
    """Count flags."""
    each = [bool(flag) for flag in flags]
    return Row(what, sum(each), len(each), *wilson(sum(each), len(each)), remark)


def table(cases: Sequence[JudgedCase]) -> list[Row]:
    """All rows that are shares. A crash counts as a miss."""
    one = [c for c in cases if c.is_single and c.flights == 1]
    several = [c for c in cases if c.is_single and c.flights > 1]
    none, two, outside, counted = (
        [c for c in cases if c.kind == k] for k in ("none", "two", "outside", "counted")
    )
    single = one + several
    named = [c for c in single if c.verdict == "named"]
    return [
        *_calibration(cases),
        *_strong("above 7, one flight", [c for c in one if c.band == "above 7"]),
        *_weak("4 to 7, one flight", [c for c in one if c.band == "4 to 7"]),
        *_weak("2 to 4, one flight", [c for c in one if c.band == "2 to 4"]),
        *_strong("above 7, two flights", [c for c in several if c.band == "above 7" and c.flights == 2]),
        *_strong("above 7, three flights", [c for c in several if c.band == "above 7" and c.flights == 3]),
        *_weak("4 to 7, two or three flights", [c for c in several if c.band == "4 to 7"]),
        row("a second effect that was not hidden, of single effects "
            "named", (len(c.groups) > 1 for c in named)),
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


def _told(cases: Sequence[JudgedCase], above: float) -> list[tuple[float, bool]]:
    """Each probability above a limit where a gap is told, and whether its cause is hidden."""
    gaps = [case for case in cases if case.verdict not in ("no_gap", *NO_ANSWER)]
    pairs = [(c, cause, p) for c in gaps for cause, p in c.probabilities.items()]
    return [(p, cause in case.wanted) for case, cause, p in pairs if p > above]


def tenths(cases: Sequence[JudgedCase]) -> list[tuple[float, int, float, float]]:
    """The calibration: lower end of each tenth, number of causes, mean probability, share right."""
    pairs = _told(cases, SMALLEST_P)
    found = []
    for low in np.arange(0.0, 1.0, 0.1):
        end = low + 0.1 if low < 0.85 else np.inf
        inside = [(p, right) for p, right in pairs if low <= p < end]
        if inside:
            p, right = np.array(inside, dtype=float).T
            found.append((float(low), len(inside), float(p.mean()), float(right.mean())))
    return found


def _calibration(cases: Sequence[JudgedCase]) -> list[Row]:
    of_table = [c for c in cases if c.is_single or c.kind == "two"]
    off = [abs(mean - share) for _, n, mean, share in tenths(of_table) if n >= FEWEST]
    sure = (right for _, right in _told(of_table, 0.9))
    remark = f"largest difference of a tenth: {max(off, default=float('nan')):.2f}"
    what = "probabilities above 0.9 that are right, the cause being in the table"
    return [row(what, sure, remark)]


def _strong(what: str, cases: Sequence[JudgedCase]) -> list[Row]:
    sizes = [len(set().union(*c.groups)) for c in cases if c.groups]
    remark = f"mean size of the reported sets: {np.mean(sizes):.1f}" if sizes else ""
    return [
        row(f"{what}: named cleanly", (c.named for c in cases)),
        row(f"{what}: truth named or in the set", (c.in_set for c in cases), remark),
        row(f"{what}: wrong name", (c.wrong_name for c in cases)),
    ]


def _weak(what: str, cases: Sequence[JudgedCase]) -> list[Row]:
    return [
        row(f"{what}: detected", (c.verdict != "no_gap" for c in cases)),
        row(f"{what}: first in the ranking", (c.first for c in cases)),
        row(f"{what}: named cleanly", (c.named for c in cases)),
        row(f"{what}: truth named or in the set", (c.in_set for c in cases)),
    ]


def _formulas(cases: Sequence[JudgedCase]) -> list[Row]:
    asked = [c for c in cases if "formula" in c.answer]
    found = (bool(c.answer["formula"]) and c.answer["formula"]["closure"] >= CLOSED for c in asked)
    what = "outside the table: a formula closes at least 0.8"
    return [row(what, found, "" if asked else "not scored")]


def _sizes(cases: Sequence[JudgedCase]) -> Row:
    """Sizes of right names within their bounds, where the whole flight has the plain form."""
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
    told = "not scored"
    if closed:
        told = f"median {np.median(closed):.3f}, a tenth below {np.quantile(closed, 0.1):.3f}"
    what = "closure of the flight held out at least 0.8, of names that are right"
    return [row(what, (g >= CLOSED for g in closed), told)]


def pooled_command(parser: ArgumentParser, words: Sequence[str]) -> None:
    """Score several sets together, each against its seal: those that are kept, or those named.

    `--page` writes the named parts into docs/how-good-is-it.md.
    """
    add = parser.add_argument
    add("sets", type=Path, nargs="*", help="archives, or folders of a set in the making")
    add("--page", action="store_true", help="write the numbers into the page")
    options = parser.parse_args(words)
    cases = [case for place in options.sets or kept_sets() for case in judged_in(place)]
    print(f"{len(cases)} cases")
    for each in table(cases):
        interval = f"{100.0 * each.low:3.0f} to {100.0 * each.high:3.0f} %"
        print(
            f"{each.what:76s} {each.hits:5d} of {each.cases:5d}  {interval}  {each.remark}".rstrip()
        )
    print(*lines(cases), sep="\n")
    for low, count, mean, share in tenths([c for c in cases if c.is_single or c.kind == "two"]):
        told = f"{count:4d} causes, mean {mean:.3f}, share right {share:.3f}"
        print(f"{low:.1f} to {low + 0.1:.1f}: {told}")
    if options.page:
        found = named_parts(strong_causes(cases), summed)
        numbers = {"part share": f"{100.0 * found.right / found.cases:.0f}"}
        numbers |= {"parts right": str(found.right), "parts": str(found.cases)}
        write_figures(numbers | {"parts wrong": str(found.wrong)})
