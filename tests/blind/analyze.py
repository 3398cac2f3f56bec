"""The analyser of the blind test: it sees a folder of logs and the baseline aircraft, nothing else.

python -m tests.blind.analyze --logs out/blind/logs --results out/blind/results.jsonl --jobs 2
A line of JSON a case, written as it comes; a run that was stopped goes on where it was. The null flights of each
card are flown once, by the first log that needs them: logs of one card are judged one after the other.
"""

import argparse
import json
from collections import defaultdict
from collections.abc import Sequence
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from time import monotonic
from typing import Any
from zlib import crc32

from tests.blind.judged import judge

from pitotbench.bench.reconcile.log_card import as_flown, card_of
from pitotbench.logbook import read_log
from pitotbench.records.case_file import write_case
from pitotbench.records.errors import BadInputError

FURTHER = ("-b", "-c", "-advised")  # ends of the names of the further flights of a case


def parser() -> argparse.ArgumentParser:
    """The command line."""
    made = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    made.add_argument("--logs", type=Path, default=Path("out/blind/logs"))
    made.add_argument("--results", type=Path, default=Path("out/blind/results.jsonl"))
    made.add_argument("--jobs", type=int, default=2)
    made.add_argument("--part", default="1/1", help="which part of the cards, for several machines: 2/3")
    made.add_argument("--aircraft", default="navajo")
    made.add_argument("--advised", action="store_true", help="judge only the cases with an advised flight")
    made.add_argument("--advise", type=int, default=0, help="percent of the cases that ask for the next flight")
    return made


def analyze(
    logs: Path,
    results: Path,
    jobs: int = 1,
    aircraft: str = "navajo",
    part: str = "1/1",
    advised: bool = False,
    advise: int = 0,
) -> None:
    """Judge every case of a folder that has no line in the results yet."""
    told = results.read_text("utf-8").splitlines() if results.is_file() else []
    done = {json.loads(line)["name"] for line in told}
    flown = [flights_of(path) for path in sorted(logs.glob("log-????.parquet"))]
    if advised:
        flown = [[*flights, extra] for flights in flown if (extra := _ending(flights[0], "-advised")).is_file()]
    cards: dict[str, list[list[Path]]] = defaultdict(list)
    for flights in flown:
        cards[_card(flights, aircraft)].append(flights)
    mine, parts = (int(number) for number in part.split("/"))
    cards = {key: each for key, each in cards.items() if crc32(key.encode()) % parts == mine - 1}
    todo = [[f for f in each if f[0].stem not in done] for each in cards.values()]
    work = partial(judged, aircraft, advise)
    count, begun = sum(map(len, todo)), monotonic()
    results.parent.mkdir(parents=True, exist_ok=True)
    with ProcessPoolExecutor(jobs, get_context("spawn")) as pool, results.open("a", encoding="utf-8") as out:
        # The first of each card learns its null flights; the others of it wait until they are there.
        waiting = {pool.submit(work, each[0]): each[1:] for each in todo if each}
        finished = 0
        while waiting:
            for job in wait(waiting, return_when=FIRST_COMPLETED).done:
                out.write(json.dumps(job.result()) + "\n")
                out.flush()
                finished += 1
                print(f"judged: {finished} of {count}, {(monotonic() - begun) / 60.0:.1f} min", flush=True)
                for flights in waiting.pop(job):
                    waiting[pool.submit(work, flights)] = []


def judged(aircraft: str, advise: int, flights: Sequence[Path]) -> dict[str, Any]:
    """The answer on one case."""
    asks = crc32(flights[0].stem.encode()) % 100 < advise
    return judge(flights, aircraft, _ending(flights[0], "-held"), asks)


def flights_of(path: Path) -> list[Path]:
    """The logs of a case: its own, and those of further flights of the same airplane."""
    return [path, *(more for end in FURTHER[:2] if (more := _ending(path, end)).is_file())]


def _ending(path: Path, end: str) -> Path:
    return path.with_name(f"{path.stem}{end}{path.suffix}")


def _card(flights: Sequence[Path], aircraft: str) -> str:
    """The cards of a case as text: what decides its null flights; without an airplane there are none."""
    told: list[str] = []
    if aircraft == "none":
        return flights[0].stem
    for path in flights:
        try:
            log = read_log(path)
            card = card_of(log.header, aircraft)
            told.append(write_case(as_flown(card, log)) if card is not None else "")
        except BadInputError:  # is refused when it is judged
            told.append("refused")
    return "\n".join(told)


if __name__ == "__main__":
    analyze(**vars(parser().parse_args()))
