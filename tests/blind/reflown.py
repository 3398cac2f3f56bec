"""Fly the cards of named cases again with the patch: how much of the gap in power, pitch and speed it closes.

python -m tests.blind.reflown --logs out/blind/logs --results out/blind/results.jsonl --seal out/blind/seal
The cases are those of one flight whose effect on the airplane was named rightly, in their order. A log that is not
in the folder is flown anew from the truth. A gap is the root mean square over the segments of the card, of measured
less simulated, in units of the chance between two flights; the chance itself is taken out.
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from tests.blind.advised import case_of
from tests.blind.case import JudgedCase
from tests.blind.outside_airplane import HIDDEN_EFFECTS
from tests.blind.score import judged_cases
from tests.blind.settings import SETTINGS
from tests.blind.written import bend_of, log_of

from pitotbench.bench.reconcile.workflow import NamedLog, reconcile_fully
from pitotbench.effects import FORMS, Effect, SensorEffect
from pitotbench.logbook import read_log, write_log
from pitotbench.records.gap import Feature
from pitotbench.records.log import FlightLog

KNOWN: Mapping[str, Effect] = {**FORMS, **HIDDEN_EFFECTS}
SHOWN = 3.0  # gap before, in units of chance, from which a case shows anything
QUANTITIES = ("manifold pressure", "pitch", "change of airspeed")


def gap(features: Sequence[Feature], patched: bool) -> float:
    """The root mean square of the differences beyond chance, which is that of all segments of a quantity."""
    ratios: list[float] = []
    for name in {f.name for f in features}:
        own = [f for f in features if f.name == name]
        chance = float(np.mean([f.deviation**2 for f in own]))
        ratios += [(f.measured - (f.patched if patched else f.simulated)) ** 2 / chance for f in own]
    return float(np.sqrt(max(0.0, np.mean(ratios) - 1.0))) if ratios else 0.0


def reflown(logs: Path, cases: Sequence[JudgedCase], most: int) -> Iterator[Mapping[str, Any]]:
    """The gap of each case before and after the patch, by quantity."""
    told = 0
    for case in cases:
        names = [e["name"] for e in case.truth["effects"]]
        if case.flights != 1 or not case.named or any(isinstance(KNOWN[n], SensorEffect) for n in names):
            continue
        name = case.truth["name"]
        full = reconcile_fully(NamedLog(name, _log(logs / f"{name}.parquet", case.truth)), next_flight=False)
        every = full.account.flown.features
        wanted = [f for f in every if f.name in QUANTITIES]
        if gap(wanted, patched=False) < SHOWN:
            continue
        told += 1
        rows = {q: [f for f in wanted if f.name == q] for q in QUANTITIES}
        yield {
            "case": name,
            "effect": names,
            "before": round(gap(wanted, patched=False), 2),
            "after": round(gap(wanted, patched=True), 2),
            **{q: [round(gap(r, patched=False), 2), round(gap(r, patched=True), 2)] for q, r in rows.items()},
        }
        if told == most:
            return


def _log(path: Path, told: Mapping[str, Any]) -> FlightLog:
    """The log of the first flight of a case, as it was written or flown anew."""
    if path.is_file():
        return read_log(path)
    bend = bend_of(told["seed"])
    log = log_of(case_of(told), SETTINGS[told["settings"][0]], told["seed"], bend)
    path.parent.mkdir(parents=True, exist_ok=True)
    write_log(log, path)
    return read_log(path)


if __name__ == "__main__":
    place, judged, asked = judged_cases(__doc__, "--most", 20)
    closed = 0
    for count, line in enumerate(reflown(place, judged, asked), start=1):
        closed += line["after"] <= 0.1 * line["before"]
        print(json.dumps(line), f"closed to a tenth: {closed} of {count}", flush=True)
