"""Fly the cases of a set and write their logs under neutral names; the truth goes to a sealed file."""

import json
import secrets
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from functools import partial
from hashlib import sha256
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
from numpy.random import Generator
from tests.blind.drawn import HiddenCase
from tests.blind.flown import flown, recorded
from tests.blind.schedule import Part
from tests.blind.settings import SETTINGS, Setting

from pitotbench.bench.fleet import require_all, run_tasks
from pitotbench.logbook import write_log
from pitotbench.records.case import Case, EffectSpec, PressureErrorSpec, Wind
from pitotbench.records.log import FlightLog
from pitotbench.sense.recorder import header
from pitotbench.units import KNOT, Array

NOT_TOLD = ("temperature_offset_k", "pilot", "fuel", "ballast_kg")
APART = 1000  # between the seeds of the flights of a case; a set has fewer cases
HELD = 4  # number of the flight held out


def name_of(number: int, flight: int = 0) -> str:
    """The name of a log: the second and third flight of a case end in b and c, the one held out in held."""
    return f"log-{number:04d}" + ("", "-b", "-c", "", "-held")[flight]


def seal(folder: Path, seed: int, cases: Sequence[HiddenCase], held: Sequence[bool]) -> str:
    """Write the truth of a set and its salted SHA-256; returns the latter."""
    told = [
        {"name": name_of(i), "seed": seed + i, "held_out": out, "formed": case.formed, **asdict(case)}
        for i, (case, out) in enumerate(zip(cases, held, strict=True))
    ]
    text = json.dumps({"salt": secrets.token_hex(16), "seed": seed, "cases": told}, indent=1)
    digest = sha256(text.encode()).hexdigest()
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "truth.json").write_text(text, encoding="utf-8")
    (folder / "truth.sha256").write_text(digest + "\n", encoding="utf-8")
    return digest


def write_cases(logs: Path, seed: int, cases: Sequence[HiddenCase], held: Sequence[bool], jobs: int) -> None:
    """Fly and write all logs that are not there yet."""
    logs.mkdir(parents=True, exist_ok=True)
    todo = [(i, seed + i, case, out) for i, (case, out) in enumerate(zip(cases, held, strict=True))]
    todo = [work for work in todo if not (logs / f"{name_of(work[0])}.parquet").is_file()]
    written = count(len(cases) - len(todo) + 1)

    def step() -> None:
        done = next(written)
        if done % 10 == 0 or done == len(cases):
            print(f"written: {done} of {len(cases)}", flush=True)

    require_all(run_tasks(partial(_write, logs), todo, jobs, step=step))


def _write(logs: Path, work: tuple[int, int, HiddenCase, bool]) -> None:
    number, seed, case, held = work
    bend = bend_of(seed)
    flights = [*((HELD, case.settings[-1]) for _ in range(held)), *reversed(list(enumerate(case.settings)))]
    for flight, letter in flights:  # the first log last: who sees it may judge it
        log = log_of(case, SETTINGS[letter], seed + APART * flight, bend)
        write_log(log, logs / f"{name_of(number, flight)}.parquet")


def bend_of(seed: int) -> Array:
    """The parameters of the error curve of a case, (3,): that of its airplane, the same in all flights."""
    return np.array(PressureErrorSpec().parameters) * np.random.default_rng([seed, 1]).uniform(0.5, 1.5)


def log_of(case: HiddenCase, setting: Setting, seed: int, bend: Array) -> FlightLog:
    """Fly and record one flight of a case; its header tells what the setting's header tells."""
    draw = np.random.default_rng([seed, 3])
    schedules = {e.name: Part(*e.part) for e in case.effects if e.part is not None}
    flight = flown(_case(draw, case, setting, seed, bend), case.environment, schedules)
    log = recorded(flight, case.environment, schedules)
    return replace(log, header=told_header(setting))


def told_header(setting: Setting) -> Mapping[str, Any]:
    """The header that a log of a setting has: the card, and nothing of the day, the pilot and the loading."""
    every = header(setting.told, setting.told.das, 0)
    case = {key: value for key, value in every["case"].items() if key not in NOT_TOLD}
    return {"format": every["format"], "case": case}


def _case(draw: Generator, case: HiddenCase, setting: Setting, seed: int, bend: Array) -> Case:
    effects = tuple(EffectSpec(e.name, e.sizes) for e in case.effects)
    wind = Wind(float(draw.uniform(2.0, 25.0)) * KNOT, float(draw.uniform(0.0, 2.0 * np.pi)))
    curve = PressureErrorSpec(parameters=tuple(float(v) for v in bend))
    return replace(
        setting.flown, effects=effects, wind=wind, pressure_error=curve, truth_seed=seed, sensor_seed=seed
    )
