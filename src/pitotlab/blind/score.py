"""The scorer of the blind test: opens the seal, holds answers against the truth, writes a page and
a table.

Cases without an answer yet (a run that was stopped) are counted and left out.
"""

from argparse import ArgumentParser
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy.stats import binomtest

from pitotlab.blind.case import NO_ANSWER, JudgedCase, model_of
from pitotlab.blind.parts import lines
from pitotlab.blind.sealed import PLACE, current_sets, files_of, judged_in, opened
from pitotlab.experiment import OUT


def wilson(hits: int, cases: int) -> tuple[float, float]:
    """Return the 95 % interval of a share (Wilson 1927); from 0 to 1 without cases."""
    if not cases:
        return 0.0, 1.0
    found = binomtest(hits, cases).proportion_ci(method="wilson")
    return float(found.low), float(found.high)


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


def seconds(cases: Sequence[JudgedCase]) -> str:
    """Processor seconds a case of one flight, with the null flights in the cache and without."""
    told = []
    answers = [c.answer for c in cases if c.flights == 1]
    for warm, name in ((True, "warm"), (False, "cold")):
        each = [a["processor_s"] for a in answers if a.get("warm") == warm]
        if each:
            most = f"most {max(each):.1f} ({len(each)} cases)"
            told.append(f"{name}: median {np.median(each):.1f}, {most}")
    return "Processor seconds a flight, " + "; ".join(told) + "."


def hidden_in(case: JudgedCase) -> str:
    """What was hidden, in words."""
    names = [model_of(e["name"]) for e in case.truth["effects"]]
    return " + ".join(sorted(names)) or "none"


def score(results: Path, seal: Path, out: Path, observed: Path | None = None) -> list[Row]:
    """Score an archive or a set in the making, write `blind.md` and `blind.csv`; returns the rows."""
    truth = opened(seal)
    cases = judged_in(seal, *([] if seal.is_file() else [results, observed]))
    rows = table(cases)
    digest = files_of(seal)["truth.sha256"].decode().strip()
    out.mkdir(parents=True, exist_ok=True)
    (out / "blind.md").write_text(_page(truth, cases, rows, digest), encoding="utf-8")
    told = pd.DataFrame(map(asdict, rows)).rename(columns={"what": "row"})
    told.insert(3, "share", [row.share for row in rows])
    ends = "\r\n"
    told.to_csv(
        out / "blind.csv", index=False, float_format="%.4f", na_rep="nan", lineterminator=ends
    )
    return rows


_PAGE = """# The blind test of reconcile

{judged} of {count} sealed cases judged, seeds from {seed}, {day}; SHA-256
of the sealed truth `{digest}`. {several} cases have two or three flights, in
{settings} settings of card, data system, air, day, pilot and loading. {formed} cases hold a form,
gusts, an integration step or a receiver of the generator's own, or an effect in a part of the
flight. The strength (SNR) is that of the difference of two flights of the generator, with wind,
curve and sensor biases taken out (`pitotlab.blind.signatures`). The ideal observer knows all forms
and the noise (`pitotlab.blind.observer`). Intervals are Wilson's, 95 %. A gear that is out and a pod
are one model and count as one cause; so do a scale of the impact pressure and a loss of total
pressure. A crash counts as a miss.

| score | found | of | share | 95 % | |
|---|---|---|---|---|---|
{rows}

{seconds}

## Probabilities and shares right

| probability | causes | mean | share right |
|---|---|---|---|
{tenths}

## Hidden against answered

| hidden | answered | cases |
|---|---|---|
{confusion}

## Every miss

| case | settings | kind | hidden (SNR) | world | answered |
|---|---|---|---|---|---|
{misses}
"""


def _page(
    truth: Mapping[str, Any], cases: Sequence[JudgedCase], rows: Sequence[Row], digest: str
) -> str:
    of_table = [c for c in cases if c.is_single or c.kind == "two"]
    confusion = Counter((hidden_in(c), _answer(c)) for c in cases)
    return _PAGE.format(
        judged=len(cases),
        count=len(truth["cases"]),
        seed=truth["seed"],
        day=datetime.now(UTC).strftime("%Y-%m-%d"),
        digest=digest,
        several=sum(c.flights > 1 for c in cases),
        settings=len({letter for c in cases for letter in c.truth["settings"]}),
        formed=sum(c.truth["formed"] for c in cases),
        rows="\n".join(map(_line, rows)),
        seconds=seconds(cases),
        tenths="\n".join(
            f"| {low:.1f} to {low + 0.1:.1f} | {n} | {mean:.2f} | {share:.2f} |"
            for low, n, mean, share in tenths(of_table)
        ),
        confusion="\n".join(f"| {h} | {a} | {n} |" for (h, a), n in sorted(confusion.items())),
        misses="\n".join(_miss(c) for c in cases if not _well(c)),
    )


def _line(r: Row) -> str:
    interval = f"{_percent(r.low)} to {_percent(r.high)}" if r.cases else "–"
    return f"| {r.what} | {r.hits} | {r.cases} | {_percent(r.share)} | {interval} | {r.remark} |"


def _percent(share: float) -> str:
    return "–" if np.isnan(share) else f"{100.0 * share:.0f} %"


def _answer(case: JudgedCase) -> str:
    groups = [" / ".join(sorted(group)) for group in case.groups]
    word = case.verdict.replace("_", " ")
    return f"{word}: {' + '.join(groups)}" if groups else word


def _well(case: JudgedCase) -> bool:
    if case.kind == "none":
        return case.verdict == "no_gap"
    return case.verdict == "unknown" if case.kind == "outside" else case.named


def _miss(case: JudgedCase) -> str:
    truth = case.truth
    told = [
        f"{e['name']} ({', '.join(f'{s:.1f}' for s in e['strengths'])})" for e in truth["effects"]
    ]
    usual = {"rate": 100.0, "own_gusts": False, "receiver": False, "probes": False}
    world = ", ".join(k for k, v in truth["environment"].items() if v != usual[k]) or "usual"
    if any(e["part"] for e in truth["effects"]):
        world += ", a part of the flight"
    hidden, settings = " + ".join(told) or "none", "".join(truth["settings"])
    columns = (case.answer["name"], settings, case.kind, hidden, world, _answer(case))
    return "| " + " | ".join(columns) + " |"


def command(parser: ArgumentParser, words: Sequence[str]) -> None:
    """Open the seal, hold the answers against the truth, print the table and write the page."""
    add = parser.add_argument
    add("--results", type=Path, default=PLACE / "results.jsonl")
    add("--observed", type=Path, default=PLACE / "observed.jsonl")
    add("--seal", type=Path, default=PLACE / "seal", help="a folder, or an archive that holds all")
    add("--out", type=Path, default=OUT)
    for line in score(**vars(parser.parse_args(words))):
        interval = f"{_percent(line.low)} to {_percent(line.high)}"
        print(f"{line.what:70s} {line.hits:4d} of {line.cases:4d}  {interval:14s} {line.remark}")


def pooled_command(parser: ArgumentParser, words: Sequence[str]) -> None:
    """Score several sets together, each against its seal: those of today's judge, or those named."""
    parser.add_argument("sets", type=Path, nargs="*", help="archives (default: of today's judge)")
    places = parser.parse_args(words).sets or current_sets()
    cases = [case for place in places for case in judged_in(place)]
    print(f"{len(cases)} cases")
    for row in table(cases):
        print(f"{row.what:76s} {row.hits:5d} of {row.cases:5d}  {row.remark}")
    print(*lines(cases), sep="\n")
    for low, count, mean, share in tenths([c for c in cases if c.is_single or c.kind == "two"]):
        told = f"{count:4d} causes, mean {mean:.3f}, share right {share:.3f}"
        print(f"{low:.1f} to {low + 0.1:.1f}: {told}")
