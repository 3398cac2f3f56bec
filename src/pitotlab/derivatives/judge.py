"""Reconcile every log of a folder with the unchanged airplane of its header. It sees no truth."""

from argparse import ArgumentParser
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from time import monotonic
from typing import Any

from pitotbench.bench.workflow import NamedLog, reconcile_fully
from pitotbench.campaigns.fleet import Failure, run_tasks
from pitotbench.logbook.columns import atomic
from pitotbench.logbook.reading import read_log
from pitotbench.records import BadInputError
from pitotbench.show.columns import json_text
from pitotbench.show.verdict import account_json
from pitotlab.experiment import OUT

HELD = "-held.parquet"


def answer_of(path: Path) -> dict[str, Any]:
    """The answer of the whole command on a log, with the log held out beside it, if there is one.

    A refusal and a crash are answers as well.
    """
    begun, held = monotonic(), path.with_name(path.stem + HELD)
    try:
        log = read_log(path)
        holdout = NamedLog(held.name, read_log(held)) if held.is_file() else None
        made = reconcile_fully(
            [NamedLog(path.name, log)], log.header["case"]["aircraft"], holdout, refly=False
        )
        told = account_json(made.account)
    except BadInputError as error:
        told = {"verdict": "refused", "why": str(error)}
    except Exception as error:  # whatever it is, it is no answer
        told = {"verdict": "crash", "why": f"{type(error).__name__}: {error}"}
    return told | {"seconds": round(monotonic() - begun, 1)}


def _judge(answers: Path, path: Path) -> None:
    with atomic(answers / f"{path.stem}.json") as scratch:
        scratch.write_text(json_text(answer_of(path)), encoding="utf-8")


def judge(logs: Path, answers: Path, jobs: int = 1, only: Sequence[str] = ()) -> list[str]:
    """Judge the logs that have no answer yet, all or `only` those of some airplanes; return why
    some have none.

    The first log of each airplane is judged before the others: its null flights serve them all.
    """
    answers.mkdir(parents=True, exist_ok=True)
    paths = [path for path in sorted(logs.glob("*.parquet")) if not path.name.endswith(HELD)]
    airplanes = {path: str(read_log(path).header["case"]["aircraft"]) for path in paths}
    todo = [path for path in paths if not (answers / f"{path.stem}.json").is_file()]
    todo = [path for path in todo if not only or airplanes[path] in only]
    firsts = list({airplanes[path]: path for path in reversed(todo)}.values())
    lost: list[str] = []
    for some in (firsts, [path for path in todo if path not in firsts]):
        results: list[Any] = run_tasks(partial(_judge, answers), some, jobs, label="judged")
        for path, result in zip(some, results, strict=True):
            lost += [f"{path.stem}: {result.reason}"] if isinstance(result, Failure) else []
    return lost


def command(parser: ArgumentParser, words: Sequence[str]) -> None:
    """Reconcile every log without an answer with the unchanged airplane; write the verdicts."""
    add = parser.add_argument
    add("--out", type=Path, default=OUT / "derivatives", help="folder with the folder of the logs")
    add("--jobs", type=int, default=1)
    add("--airplanes", default="", help="only logs of these, with commas")
    options = parser.parse_args(words)
    only = [name for name in options.airplanes.split(",") if name]
    for line in judge(options.out / "logs", options.out / "answers", options.jobs, only):
        print(line)
