"""The scorer of the blind test: opens the seal, holds answers against the truth, writes a page and a table.

python -m tests.blind.score --results out/blind/results.jsonl --observed out/blind/observed.jsonl \
    --advised out/blind/advised.jsonl --seal out/blind/seal --out docs
Cases without an answer yet (a run that was stopped) are counted and left out.
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
from tests.blind.case import JudgedCase
from tests.blind.rows import Row, hidden_in, seconds, table, tenths


def opened(seal: Path) -> dict[str, Any]:
    """The truth, if it is the one that was sealed. Raises ValueError where it was changed."""
    text = (seal / "truth.json").read_text("utf-8")
    if sha256(text.encode()).hexdigest() != (seal / "truth.sha256").read_text("utf-8").strip():
        raise ValueError("the truth does not match its seal")
    truth: dict[str, Any] = json.loads(text)
    return truth


def joined(
    truth: dict[str, Any], results: Path, observed: Path | None = None, advised: Path | None = None
) -> list[JudgedCase]:
    """Truth, answer and observation of every case that has an answer."""
    answers, seen, more = _lines(results), _lines(observed), _lines(advised)
    return [
        JudgedCase(case, answers[name], seen.get(name, {}), more.get(name, {}))
        for case in truth["cases"]
        if (name := case["name"]) in answers
    ]


def judged_cases(description: str | None, most: str, default: int) -> tuple[Path, list[JudgedCase], int]:
    """What the command line of a measurement asks for: the folder of logs, the cases, and the value of `most`."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    for path in ("--logs", "--results", "--seal"):
        parser.add_argument(path, type=Path, required=True)
    parser.add_argument(most, dest="most", type=int, default=default)
    options = parser.parse_args()
    return options.logs, joined(opened(options.seal), options.results), options.most


def _lines(path: Path | None) -> dict[str, dict[str, Any]]:
    """Lines of JSON by name; none for a file that is not there."""
    if path is None or not path.is_file():
        return {}
    return {each["name"]: each for each in map(json.loads, path.read_text("utf-8").splitlines())}


def score(
    results: Path, seal: Path, out: Path, observed: Path | None = None, advised: Path | None = None
) -> list[Row]:
    """Score and write `blind.md` and `blind.csv`; returns the rows."""
    truth = opened(seal)
    cases = joined(truth, results, observed, advised)
    rows = table(cases)
    digest = (seal / "truth.sha256").read_text("utf-8").strip()
    out.mkdir(parents=True, exist_ok=True)
    (out / "blind.md").write_text(_page(truth, cases, rows, digest), encoding="utf-8")
    with (out / "blind.csv").open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["row", "hits", "cases", "share", "low", "high", "remark"])
        for r in rows:
            writer.writerow([r.what, r.hits, r.cases, f"{r.share:.4f}", f"{r.low:.4f}", f"{r.high:.4f}", r.remark])
    return rows


def _page(truth: dict[str, Any], cases: Sequence[JudgedCase], rows: Sequence[Row], digest: str) -> str:
    day = datetime.now(UTC).strftime("%Y-%m-%d")
    settings = len({letter for c in cases for letter in c.truth["settings"]})
    several = sum(c.flights > 1 for c in cases)
    formed = sum(c.truth["formed"] for c in cases)
    first, count = truth["seed"], len(truth["cases"])
    return "\n".join(
        [
            "# The blind test of reconcile",
            "",
            f"{len(cases)} of {count} sealed cases judged, seeds from {first}, {day}; SHA-256",
            f"of the sealed truth `{digest}`. {several} cases have two or three flights, in",
            f"{settings} settings of card, data system, air, day, pilot and loading. {formed} cases hold a form,",
            "gusts, an integration step or a receiver of the generator's own, or an effect in a part of the",
            "flight. The strength (SNR) is that of the difference of two flights of the generator, with wind,",
            "curve and sensor biases taken out (`tests/blind/signatures.py`). The ideal observer knows all forms",
            "and the noise (`tests/blind/observer.py`). Intervals are Wilson's, 95 %. A gear that is out and a pod",
            "are one model and count as one cause; so do a scale of the impact pressure and a loss of total",
            "pressure. A crash counts as a miss.",
            "",
            "| score | found | of | share | 95 % | |",
            "|---|---|---|---|---|---|",
            *map(_line, rows),
            "",
            seconds(cases),
            "",
            "## Probabilities and shares right",
            "",
            "| probability | causes | mean | share right |",
            "|---|---|---|---|",
            *(
                f"| {low:.1f} to {low + 0.1:.1f} | {n} | {mean:.2f} | {share:.2f} |"
                for low, n, mean, share in tenths([c for c in cases if c.is_single or c.kind == "two"])
            ),
            "",
            "## Hidden against answered",
            "",
            "| hidden | answered | cases |",
            "|---|---|---|",
            *(f"| {hidden} | {answer} | {n} |" for (hidden, answer), n in _confusion(cases)),
            "",
            "## Every miss",
            "",
            "| case | settings | kind | hidden (SNR) | world | answered |",
            "|---|---|---|---|---|---|",
            *(_miss(c) for c in cases if not _well(c)),
            "",
        ]
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


def _confusion(cases: Sequence[JudgedCase]) -> list[tuple[tuple[str, str], int]]:
    return sorted(Counter((hidden_in(c), _answer(c)) for c in cases).items())


def _well(case: JudgedCase) -> bool:
    if case.kind == "none":
        return case.verdict == "no_gap"
    return case.verdict == "unknown" if case.kind == "outside" else case.named


def _miss(case: JudgedCase) -> str:
    told = [f"{e['name']} ({', '.join(f'{s:.1f}' for s in e['strengths'])})" for e in case.truth["effects"]]
    usual = {"rate": 100.0, "own_gusts": False, "receiver": False, "probes": False}
    world = ", ".join(k for k, v in case.truth["environment"].items() if v != usual[k]) or "usual"
    if any(e["part"] for e in case.truth["effects"]):
        world += ", a part of the flight"
    hidden = " + ".join(told) or "none"
    columns = (case.answer["name"], "".join(case.truth["settings"]), case.kind, hidden, world, _answer(case))
    return "| " + " | ".join(columns) + " |"


if __name__ == "__main__":
    made = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    made.add_argument("--results", type=Path, default=Path("out/blind/results.jsonl"))
    made.add_argument("--observed", type=Path, default=Path("out/blind/observed.jsonl"))
    made.add_argument("--advised", type=Path, default=Path("out/blind/advised.jsonl"))
    made.add_argument("--seal", type=Path, default=Path("out/blind/seal"))
    made.add_argument("--out", type=Path, default=Path("docs"))
    for line in score(**vars(made.parse_args())):
        counted = f"{line.hits:4d} of {line.cases:4d}  {_percent(line.low)} to {_percent(line.high)}"
        print(f"{line.what:70s} {counted:28s} {line.remark}")
