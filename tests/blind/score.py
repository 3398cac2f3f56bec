"""The scorer of the blind test: opens the seal, holds answers against the truth, writes a page and a table.

python -m tests.blind.score --results out/blind/results.jsonl --seal out/blind/seal --out docs
Logs without an answer (a run that was stopped) are counted and left out.
"""

import argparse
import csv
import json
from collections import Counter
from collections.abc import Sequence
from datetime import UTC, datetime
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
from tests.blind.rows import Judged, Row, table


def parser() -> argparse.ArgumentParser:
    """The command line."""
    made = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    made.add_argument("--results", type=Path, default=Path("out/blind/results.jsonl"))
    made.add_argument("--seal", type=Path, default=Path("out/blind/seal"))
    made.add_argument("--out", type=Path, default=Path("docs"))
    return made


def opened(seal: Path) -> dict[str, Any]:
    """The truth, if it is the one that was sealed. Raises ValueError where it was changed."""
    text = (seal / "truth.json").read_text("utf-8")
    if sha256(text.encode()).hexdigest() != (seal / "truth.sha256").read_text("utf-8").strip():
        raise ValueError("the truth does not match its seal")
    truth: dict[str, Any] = json.loads(text)
    return truth


def joined(truth: dict[str, Any], results: Path) -> list[Judged]:
    """Truth and answer of every log that has both."""
    answers = {a["name"]: a for a in map(json.loads, results.read_text("utf-8").splitlines())}
    return [Judged(case, answers[case["name"]]) for case in truth["cases"] if case["name"] in answers]


def score(results: Path, seal: Path, out: Path) -> list[Row]:
    """Score and write `blind.md` and `blind.csv`; returns the rows."""
    truth = opened(seal)
    cases = joined(truth, results)
    rows = table(cases)
    digest = (seal / "truth.sha256").read_text("utf-8").strip()
    out.mkdir(parents=True, exist_ok=True)
    (out / "blind.md").write_text(_page(truth, cases, rows, digest), encoding="utf-8")
    with (out / "blind.csv").open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["row", "target", "hits", "cases", "share", "low", "high"])
        writer.writerows(
            [r.what, r.target, r.hits, r.cases, f"{r.share:.4f}", f"{r.low:.4f}", f"{r.high:.4f}"] for r in rows
        )
    return rows


def _page(truth: dict[str, Any], cases: Sequence[Judged], rows: Sequence[Row], digest: str) -> str:
    first, count = truth["seed"], len(truth["cases"])
    day = datetime.now(UTC).strftime("%Y-%m-%d")
    formed = sum(
        c.truth["environment"] != "usual" or any(n not in c.wanted for n, _ in c.truth["effects"]) for c in cases
    )
    return "\n".join(
        [
            "# The blind test of reconcile",
            "",
            f"{len(cases)} of {count} sealed logs judged, seeds from {first}, {day}; SHA-256 of the sealed truth",
            f"`{digest}`.",
            f"{formed} logs hold a variant form: another form of the effect or of the turbulence, or",
            "another integration step. SNR is that of the signature with wind, curve and sensor biases taken out",
            "(`tests/blind/signals.py`). Intervals are Wilson's, 95 %. `make blind` makes this page anew. What",
            "the misses have in common: [blind-notes.md](blind-notes.md).",
            "",
            "| score | target | found | of | share | 95 % |",
            "|---|---|---|---|---|---|",
            *map(_line, rows),
            "",
            *_numbers(cases),
            "",
            "## Hidden against answered",
            "",
            "| hidden | answered | cases |",
            "|---|---|---|",
            *(f"| {hidden} | {answer} | {n} |" for (hidden, answer), n in _confusion(cases)),
            "",
            "## Every miss",
            "",
            "| log | card | kind | hidden (SNR) | form | answered |",
            "|---|---|---|---|---|---|",
            *(_miss(c) for c in cases if not _well(c)),
            "",
        ]
    )


def _line(r: Row) -> str:
    interval = f"{_percent(r.low)} to {_percent(r.high)}"
    return f"| {r.what} | {r.target} | {r.hits} | {r.cases} | {_percent(r.share)} | {interval} |"


def _percent(share: float) -> str:
    return "–" if np.isnan(share) else f"{100.0 * share:.0f} %"


def _numbers(cases: Sequence[Judged]) -> list[str]:
    wall = [c.answer["wall_s"] for c in cases]
    spent = [c.answer["processor_s"] for c in cases]
    held = [c.answer["held_out"] for c in cases if c.right and "held_out" in c.answer]
    told = f"Seconds a case: median {np.median(wall):.1f}, most {max(wall):.1f}; "
    told += f"processor seconds: median {np.median(spent):.1f}, most {max(spent):.1f}."
    return [
        told + (f" Held-out G of right names: median {np.median(held):.3f}, least {min(held):.3f}." if held else "")
    ]


def _hidden(case: Judged) -> str:
    names = [name for name, _ in case.truth["effects"]] or [case.truth["fault"]]
    return " + ".join(n for n in names if n) or "none"


def _answer(case: Judged) -> str:
    groups = [" / ".join(sorted(group)) for group in case.groups]
    return f"{case.verdict.replace('_', ' ')}: {' + '.join(groups)}" if groups else case.verdict.replace("_", " ")


def _confusion(cases: Sequence[Judged]) -> list[tuple[tuple[str, str], int]]:
    return sorted(Counter((_hidden(c), _answer(c)) for c in cases).items())


def _well(case: Judged) -> bool:
    if case.kind == "none":
        return case.verdict == "no_gap"
    return case.verdict == "unknown" if case.kind == "outside" else case.right


def _miss(case: Judged) -> str:
    strengths = ", ".join(f"{s:.1f}" for s in case.truth["strengths"])
    told = (case.answer["name"], case.truth["card"], case.kind, f"{_hidden(case)} ({strengths})")
    return "| " + " | ".join([*told, case.truth["environment"], _answer(case)]) + " |"


if __name__ == "__main__":
    for line in score(**vars(parser().parse_args())):
        counted = f"{line.hits:4d} of {line.cases:4d}  {_percent(line.low)} to {_percent(line.high)}"
        print(f"{line.what:55s} {line.target:15s} {counted}")
