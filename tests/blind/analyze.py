"""The analyser of the blind test: it sees a folder of logs and the baseline aircraft, nothing else.

python -m tests.blind.analyze --logs out/blind/logs --results out/blind/results.jsonl --jobs 2
A line of JSON a log, written as it comes; a run that was stopped goes on where it was.
"""

import argparse
import json
import time
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import suppress
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any
from zlib import crc32

from pitotbench.bench.reconcile.aircraft_models import aircraft_model
from pitotbench.bench.reconcile.log_card import card_of
from pitotbench.bench.reconcile.null_learning import null_distribution_of
from pitotbench.bench.reconcile.reconciliation import AnalysisSetting, Reconciliation, reconcile_log
from pitotbench.logbook import read_log
from pitotbench.reconcile.decide.judgment import hold_out
from pitotbench.reconcile.signatures.signatures import columns_of
from pitotbench.records.case_file import write_case
from pitotbench.records.errors import BadInputError
from pitotbench.records.verdict import Closure

REFUSED: dict[str, Any] = {
    "kind": "refused",
    "effects": [],
    "alternatives": [],
    "sizes": {},
    "gap": 0.0,
    "gains": {},
}


def parser() -> argparse.ArgumentParser:
    """The command line."""
    made = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    made.add_argument("--logs", type=Path, default=Path("out/blind/logs"))
    made.add_argument("--results", type=Path, default=Path("out/blind/results.jsonl"))
    made.add_argument("--jobs", type=int, default=2)
    made.add_argument("--part", default="1/1", help="which part of the logs, for several machines: 2/3")
    made.add_argument("--aircraft", default="navajo")
    return made


def analyze(logs: Path, results: Path, jobs: int, aircraft: str, part: str = "1/1") -> None:
    """Judge every log of a folder that has no line in the results yet."""
    done = (
        {json.loads(line)["name"] for line in results.read_text("utf-8").splitlines()}
        if results.is_file()
        else set()
    )
    found = sorted(p for p in logs.glob("*.parquet") if not p.stem.endswith("-held"))
    mine, parts = (int(number) for number in part.split("/"))
    found = [p for p in found if crc32(p.stem.encode()) % parts == mine - 1]  # the same while logs still come
    todo = [p for p in found if p.stem not in done]
    if aircraft != "none":
        _learn(todo, aircraft)
    results.parent.mkdir(parents=True, exist_ok=True)
    begun = time.monotonic()
    with ProcessPoolExecutor(jobs, get_context("spawn")) as pool, results.open("a", encoding="utf-8") as out:
        work = [pool.submit(partial(judged, aircraft), path) for path in todo]
        for number, job in enumerate(as_completed(work), start=1):
            out.write(json.dumps(job.result()) + "\n")
            out.flush()
            minutes = (time.monotonic() - begun) / 60.0
            print(f"judged: {number + len(found) - len(todo)} of {len(found)}, {minutes:.1f} min", flush=True)


def _learn(paths: list[Path], aircraft: str) -> None:
    """Fly the null flights of every card once, before the logs share them."""
    cards, card = {}, None
    for path in paths:
        with suppress(BadInputError):  # refused below
            card = card_of(read_log(path).header, aircraft)
        if card is not None:
            cards[write_case(card)] = card
    for card in cards.values():
        null_distribution_of(card, progress=lambda text: print(text, flush=True))


def judged(aircraft: str, path: Path) -> dict[str, Any]:
    """The verdict on one log as plain data, with the seconds it took."""
    wall, processor = time.monotonic(), time.process_time()
    try:
        made = reconcile_log(read_log(path), aircraft)
    except BadInputError as error:  # a log that the reader refuses is an answer as well
        return {"name": path.stem, "wall_s": 0.0, "processor_s": 0.0, **REFUSED, "why": str(error)}
    seconds = (time.monotonic() - wall, time.process_time() - processor)
    held = path.with_name(f"{path.stem}-held.parquet")
    told = {"name": path.stem, "wall_s": round(seconds[0], 2), "processor_s": round(seconds[1], 2), **_told(made)}
    if held.is_file() and made.naming.chosen:
        with suppress(BadInputError):
            told["held_out"] = _share(_closed(made, held, aircraft))
    return told


def _closed(made: Reconciliation, held: Path, aircraft: str) -> Closure:
    """What was named, on the flight held out."""
    setting = AnalysisSetting(day_known=True)
    return hold_out(read_log(held), aircraft_model(aircraft), made.null, made.naming, setting)


def _told(made: Reconciliation) -> dict[str, Any]:
    verdict, naming = made.verdict, made.naming
    closure = verdict.closure
    sizes = {e.name: {s.name: [s.value, s.two_sigma] for s in e.sizes} for e in verdict.effects}
    gains = {n: naming.equations.fit(c).gain for n, c in columns_of(naming.layout.signatures).items()}
    return {
        "kind": verdict.kind,
        "effects": [e.name for e in verdict.effects],
        "alternatives": [list(names) for names in verdict.alternatives],
        "sizes": sizes,
        "closure": _share(closure),
        "gap": closure.before - closure.noise,
        "gains": {name: round(gain, 2) for name, gain in gains.items()},
        "candidates": [
            [c.name, round(c.score, 2), round(c.held_out_ratio, 2), c.plausible] for c in verdict.candidates[:6]
        ],
        "located": [[p.channel, p.phase, p.variable, round(p.significance, 1)] for p in verdict.located[:4]],
        "thresholds": [made.null.threshold, made.null.cell_threshold],
    }


def _share(closure: Closure) -> float:
    return round(closure.share, 4)


if __name__ == "__main__":
    analyze(**vars(parser().parse_args()))
