"""The analyser of hidden causes: it sees a folder of logs and the baseline aircraft, nothing else.

A line of JSON a case, written as it comes; a run that was stopped goes on where it was. The null
flights of each card are flown once, by the first log that needs them: logs of one card are judged
one after the other. The answer is that of the whole command.
"""

import json
import os
from argparse import ArgumentParser
from collections import defaultdict
from collections.abc import Sequence
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from dataclasses import replace
from functools import partial
from math import sqrt
from multiprocessing import get_context
from pathlib import Path
from time import monotonic
from typing import Any

from pitotbench.bench.flown_card import as_flown, card_of, has_weather_report
from pitotbench.bench.null_cache import cache_entry
from pitotbench.bench.null_flights import NULL_FLIGHTS
from pitotbench.bench.workflow import FullReconciliation, NamedLog, closure_on, reconcile_fully
from pitotbench.logbook.reading import read_log
from pitotbench.models.aircraft_model import aircraft_model
from pitotbench.reconciliation.free_parameters import AnalysisSetting
from pitotbench.records import BadInputError
from pitotbench.records.case_file import write_case
from pitotbench.records.gap import FoundFormula
from pitotbench.records.verdict import SURE, Closure, Verdict
from pitotlab.experiment import OUT
from pitotlab.sealing import FURTHER, HELD

LEAST = 1e-3  # probability of a cause that is written down


def spent() -> float:
    """Processor seconds of this process and of its children."""
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


def is_warm(path: Path, aircraft: str) -> bool:
    """Whether the null flights of a log are in the cache, or none are needed."""
    if aircraft == "none":
        return True
    log = read_log(path)
    card = card_of(log.header, aircraft)
    if card is None:
        return True
    card = replace(as_flown(card, log), effects=(), truth_seed=1, sensor_seed=1)
    setting = AnalysisSetting(day_known=has_weather_report(log.header), instruments_known=True)
    return cache_entry(card, NULL_FLIGHTS, setting).is_file()


def judge(paths: Sequence[Path], aircraft: str = "", held: Path | None = None) -> dict[str, Any]:
    """Return the answer on the flights of one case. A crash of the tool is an answer as well.

    Without a name of an `aircraft` it is that of the header.

    `held` is a flight to close with what was named.
    """
    wall, processor = monotonic(), spent()
    told: dict[str, Any] = {"name": paths[0].stem, "flights": len(paths), "warm": True}
    try:
        aircraft = aircraft or _header_aircraft(paths[0])
        told["warm"] = all(is_warm(path, aircraft) for path in paths)
        made = _reconciled(paths, aircraft)
        told |= answer_in(made.verdict, made.account.formula)
    except BadInputError as error:
        told |= {"kind": "refused", "why": str(error)}
    except Exception as error:  # whatever it is, it is no answer
        told |= {"kind": "crash", "why": f"{type(error).__name__}: {error}"}
    told["wall_s"] = round(monotonic() - wall, 2)
    told["processor_s"] = round(spent() - processor, 2)
    if told["kind"] in SURE and held is not None and held.is_file():
        try:
            model, first = aircraft_model(aircraft), made.logs[0]
            closed = closure_on(read_log(held), model, first, made.judged.fitted)
            if closed is not None:
                told["held_out"] = _share(closed)
        except Exception as error:
            told["held_out_why"] = f"{type(error).__name__}: {error}"
    return told


def _reconciled(paths: Sequence[Path], aircraft: str) -> FullReconciliation:
    """One log or several as the command judges them."""
    logs = [NamedLog(f"flight {i}", read_log(path)) for i, path in enumerate(paths, start=1)]
    return reconcile_fully(logs, aircraft, refly=False)


def answer_in(verdict: Verdict, formula: FoundFormula | None) -> dict[str, Any]:
    """The answer with its gaps, each as its most probable effect and the others of its set.

    `scores` are those of causes by themselves [σ], `significance` that of the whole gap [σ].
    """
    scored = (*verdict.candidates, *(each for gap in verdict.gaps for each in gap.causes))
    return {
        "kind": verdict.kind,
        "effects": [effect.name for effect in verdict.effects],
        "alternatives": list(map(list, verdict.alternatives)),
        "sizes": {
            e.name: {s.name: [s.value, s.two_sigma] for s in e.sizes} for e in verdict.effects
        },
        "probabilities": {c: round(p, 5) for c, p in verdict.probabilities.items() if p > LEAST},
        "parts": {part: round(p, 5) for part, p in verdict.parts.items()},
        "named_parts": list(verdict.named_parts),
        "log_bayes_factor": round(verdict.log_bayes_factor, 2),
        "scores": {each.name: round(each.score, 2) for each in scored},
        "significance": round(sqrt(max(0.0, verdict.closure.before - verdict.closure.noise)), 2),
        "remains": verdict.remains,
        "closure": _share(verdict.closure),
        "doubts": list(verdict.doubts),
        "free": [[each.name, each.value, each.two_sigma] for each in verdict.free],
        "notes": list(verdict.notes),
        "advice": list(verdict.advice),
        "located": [[p.channel, p.where, round(p.significance, 1)] for p in verdict.located[:4]],
        **_formula(verdict, formula),
    }


def _formula(verdict: Verdict, found: FoundFormula | None) -> dict[str, Any]:
    """The closure of the gap by a formula, where the table leaves one."""
    if not (verdict.kind == "unknown" or verdict.doubts):
        return {}
    if found is None:
        return {"formula": None}
    terms = [term.effect for term in found.terms]
    return {"formula": {"closure": _share(verdict.closure), "terms": terms}}


def _share(closure: Closure) -> float:
    return round(closure.share, 4)


def analyze(logs: Path, results: Path, jobs: int = 1, aircraft: str = "") -> None:
    """Judge every case of a folder that has no line in the results yet."""
    told = results.read_text("utf-8").splitlines() if results.is_file() else []
    done = {json.loads(line)["name"] for line in told}
    firsts = [path for path in logs.glob("*.parquet") if not path.stem.endswith((*FURTHER, HELD))]
    flown = [flights_of(path) for path in sorted(firsts)]
    cards: dict[str, list[list[Path]]] = defaultdict(list)
    for flights in flown:
        cards[_card(flights, aircraft)].append(flights)
    todo = [[f for f in each if f[0].stem not in done] for each in cards.values()]
    work = partial(judged, aircraft)
    count, begun = sum(map(len, todo)), monotonic()
    results.parent.mkdir(parents=True, exist_ok=True)
    with (
        ProcessPoolExecutor(jobs, get_context("spawn")) as pool,
        results.open("a", encoding="utf-8") as out,
    ):
        # The first of each card learns its null flights; the others of it wait until they are
        # there.
        waiting = {pool.submit(work, each[0]): each[1:] for each in todo if each}
        finished = 0
        while waiting:
            for job in wait(waiting, return_when=FIRST_COMPLETED).done:
                out.write(json.dumps(job.result()) + "\n")
                out.flush()
                finished += 1
                minutes = (monotonic() - begun) / 60.0
                print(f"judged: {finished} of {count}, {minutes:.1f} min", flush=True)
                for flights in waiting.pop(job):
                    waiting[pool.submit(work, flights)] = []


def judged(aircraft: str, flights: Sequence[Path]) -> dict[str, Any]:
    """The answer on one case."""
    return judge(flights, aircraft, _ending(flights[0], HELD))


def flights_of(path: Path) -> list[Path]:
    """The logs of a case: its own, and those of further flights of the same airplane."""
    return [path, *(more for end in FURTHER if (more := _ending(path, end)).is_file())]


def _ending(path: Path, end: str) -> Path:
    return path.with_name(f"{path.stem}{end}{path.suffix}")


def _header_aircraft(path: Path) -> str:
    """The airplane that the header of a log names."""
    return str(read_log(path).header["case"]["aircraft"])


def _card(flights: Sequence[Path], aircraft: str) -> str:
    """The cards of a case as text, which decide its null flights; without an airplane its name."""
    told: list[str] = []
    if aircraft == "none":
        return flights[0].stem
    for path in flights:
        try:
            log = read_log(path)
            card = card_of(log.header, aircraft or _header_aircraft(path))
            told.append(write_case(as_flown(card, log)) if card is not None else "")
        except BadInputError:  # is refused when it is judged
            told.append("refused")
    return "\n".join(told)


def command(parser: ArgumentParser, words: Sequence[str], set_name: str) -> None:
    """Judge every case of a folder of logs, from the logs and the baseline aircraft alone."""
    add = parser.add_argument
    add("--logs", type=Path, default=OUT / set_name / "logs")
    add("--results", type=Path, default=OUT / set_name / "results.jsonl")
    add("--jobs", type=int, default=2)
    add("--aircraft", default="", help="the baseline, or none (default: that of the header)")
    analyze(**vars(parser.parse_args(words)))


def blind_command(parser: ArgumentParser, words: Sequence[str]) -> None:
    """Judge every log of the blind test."""
    command(parser, words, "blind")


def derivatives_command(parser: ArgumentParser, words: Sequence[str]) -> None:
    """Judge every log of an edited airplane by the unchanged one."""
    command(parser, words, "derivatives")
