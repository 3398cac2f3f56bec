"""Fly the card that the tool advised for cases whose cause it could not name, with the same hidden effects.

python -m tests.blind.advised --results out/blind/results.jsonl --logs out/blind/logs --most 20
This stands between the analyser and the truth: it reads the card of the answer and writes `<case>-advised.parquet`.
Then `python -m tests.blind.analyze --advised --results out/blind/advised.jsonl` judges both flights together.
"""

import argparse
import json
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from tests.blind.drawn import HiddenCase, HiddenEffect
from tests.blind.flown import Environment
from tests.blind.score import opened
from tests.blind.settings import SETTINGS, Setting
from tests.blind.written import APART, bend_of, log_of

from pitotbench.bench.fleet import require_all, run_tasks
from pitotbench.logbook import write_log
from pitotbench.records.case import Case
from pitotbench.records.case_file import read_case

ADVISED = 5  # number of the flight
BANDS = ("above 7", "4 to 7")


def card_in(answer: Mapping[str, Any]) -> Case | None:
    """The card that an answer advises by forecast; none where it asked for none, or where no card can part."""
    return read_case(answer["advised"]) if answer.get("advised") else None


def case_of(told: Mapping[str, Any]) -> HiddenCase:
    """The hidden case of an entry of the truth."""
    effects = tuple(
        HiddenEffect(e["name"], e["sizes"], tuple(e["strengths"]), tuple(e["part"]) if e["part"] else None)
        for e in told["effects"]
    )
    return HiddenCase(told["kind"], tuple(told["settings"]), effects, Environment(**told["environment"]))


def setting_with(setting: Setting, card: Case) -> Setting:
    """The setting of the first flight with another card: the same day, pilot, loading and data system."""
    changes = {"maneuver": card.maneuver, "card": card.card}
    return Setting(replace(setting.flown, **changes), replace(setting.told, **changes))


def _write(logs: Path, work: tuple[Mapping[str, Any], Case]) -> None:
    told, card = work
    setting = setting_with(SETTINGS[told["settings"][0]], card)
    log = log_of(case_of(told), setting, told["seed"] + APART * ADVISED, bend_of(told["seed"]))
    write_log(log, logs / f"{told['name']}-advised.parquet")


def fly_advised(results: Path, logs: Path, seal: Path, most: int, jobs: int) -> int:
    """Fly the advised cards of the first `most` cases that were not named; returns how many were flown."""
    answers = {each["name"]: each for each in map(json.loads, results.read_text("utf-8").splitlines())}
    todo = []
    for told in opened(seal)["cases"]:
        answer = answers.get(told["name"], {})
        asked = told["kind"] in BANDS and len(told["settings"]) == 1 and answer.get("kind") == "one_of"
        if asked and (card := card_in(answer)) is not None:
            todo.append((told, card))
    require_all(run_tasks(partial(_write, logs), todo[:most], jobs))
    return len(todo[:most])


if __name__ == "__main__":
    made = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    made.add_argument("--results", type=Path, default=Path("out/blind/results.jsonl"))
    made.add_argument("--logs", type=Path, default=Path("out/blind/logs"))
    made.add_argument("--seal", type=Path, default=Path("out/blind/seal"))
    made.add_argument("--most", type=int, default=20)
    made.add_argument("--jobs", type=int, default=1)
    print(f"flown: {fly_advised(**vars(made.parse_args()))}")
