"""The generator of the blind test: logs under neutral names, and the truth in a sealed file elsewhere.

python -m tests.blind.generate --cases 300 --seed 500000 --jobs 2 --logs out/blind/logs --seal out/blind/seal
The salted SHA-256 of the truth is printed and written beside it before anyone looks at a log.
"""

import argparse
import json
import secrets
from contextlib import AbstractContextManager, nullcontext
from dataclasses import asdict, replace
from functools import partial
from hashlib import sha256
from itertools import count
from pathlib import Path
from unittest.mock import patch

import numpy as np
from numpy.random import Generator
from tests.blind.cards import CARDS
from tests.blind.draw import Hidden, hidden, kinds
from tests.blind.forms import flying_them
from tests.blind.outside import FAULTS
from tests.blind.signals import PLACE

from pitotbench.bench.fleet import require_all, run_tasks
from pitotbench.effects import Overlay
from pitotbench.logbook import write_log
from pitotbench.records.case import Case, EffectSpec, PressureErrorSpec, Wind
from pitotbench.records.log import FlightLog
from pitotbench.sense import record
from pitotbench.simulate import fly
from pitotbench.simulate.plant import Plant
from pitotbench.units import KNOT, Array

DEVELOPMENT, SCORED = 10_000, 500_000  # seeds of development lie below the first, scored ones from the second
HELD_OUT_SHARE = 0.3
OTHER_STEP = 200.0  # Hz
OTHER_SPECTRUM = 3  # JSBSim's turb-type: MIL-F-8785C by forward differences (Yeager 1998)


def parser() -> argparse.ArgumentParser:
    """The command line."""
    made = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    made.add_argument("--cases", type=int, default=300)
    made.add_argument("--seed", type=int, default=SCORED, help="of the first case; below 10,000 for development")
    made.add_argument("--jobs", type=int, default=2)
    made.add_argument("--logs", type=Path, default=Path("out/blind/logs"))
    made.add_argument("--seal", type=Path, default=Path("out/blind/seal"))
    return made


def generate(cases: int, seed: int, jobs: int, logs: Path, seal: Path) -> str:
    """Seal the truth, then write the logs; returns the salted SHA-256. Raises ValueError for a seed between the
    ranges, FileExistsError where a folder holds logs."""
    if seed + cases >= DEVELOPMENT and seed < SCORED:
        raise ValueError(f"seeds of development end below {DEVELOPMENT}, scored ones begin at {SCORED}")
    logs.mkdir(parents=True)
    seal.mkdir(parents=True)
    todo = [(i, seed + i, order) for i, order in enumerate(orders(cases, seed))]
    truth = [{**asdict(order), "held_out": _is_held(number, order), "name": _name(i)} for i, number, order in todo]
    text = json.dumps({"salt": secrets.token_hex(16), "seed": seed, "cases": truth}, indent=1)
    digest = sha256(text.encode()).hexdigest()
    (seal / "truth.json").write_text(text, encoding="utf-8")
    (seal / "truth.sha256").write_text(digest + "\n", encoding="utf-8")
    print(f"sealed, SHA-256 {digest}", flush=True)
    written = count(1)

    def step() -> None:
        done = next(written)
        if done % 10 == 0 or done == cases:
            print(f"written: {done} of {cases}", flush=True)

    require_all(run_tasks(partial(_write, logs), todo, jobs, step=step))
    return digest


def orders(cases: int, seed: int) -> list[Hidden]:
    """What is hidden in each log of a set."""
    draw, signals = np.random.default_rng(seed), json.loads(PLACE.read_text(encoding="utf-8"))
    cards = [list(CARDS)[i % len(CARDS)] for i in draw.permutation(cases)]
    return [hidden(draw, kind, card, signals[card]) for kind, card in zip(kinds(draw, cases), cards, strict=True)]


def _name(number: int) -> str:
    return f"log-{number:04d}"


def _is_held(seed: int, order: Hidden) -> bool:
    return bool(order.effects) and np.random.default_rng([seed, 2]).random() < HELD_OUT_SHARE


def _write(logs: Path, work: tuple[int, int, Hidden]) -> None:
    """Fly and record one case, and a second flight of it where one is held out."""
    number, seed, order = work
    draw = np.random.default_rng([seed, 1])
    # The error curve is the airplane's: the same in both flights.
    bend = np.array(PressureErrorSpec().parameters) * draw.uniform(0.5, 1.5)
    for part in (1, 0) if _is_held(seed, order) else (0,):  # the log last: who sees it may judge it
        log = _log(_case(draw, order, 2 * seed + part, bend), order)
        write_log(_neutral(log), logs / f"{_name(number)}{'-held' if part else ''}.parquet")


def _case(draw: Generator, order: Hidden, seed: int, bend: Array) -> Case:
    """The case with its own wind and error curve."""
    effects = tuple(EffectSpec(name, sizes) for name, sizes in order.effects)
    wind = Wind(float(draw.uniform(2.0, 25.0)) * KNOT, float(draw.uniform(0.0, 2.0 * np.pi)))
    curve = PressureErrorSpec(parameters=tuple(float(v) for v in bend))
    card = CARDS[order.card]
    return replace(card, effects=effects, wind=wind, pressure_error=curve, truth_seed=seed, sensor_seed=seed)


def _log(case: Case, order: Hidden) -> FlightLog:
    with flying_them():
        with _environment(order.environment):
            flight = fly(case)
        log = record(flight, case.das, case.sensor_seed)
    return FAULTS[order.fault](log, order.fault_size) if order.fault else log


def _environment(name: str) -> AbstractContextManager[object]:
    """Another integration step, or another form of the turbulence."""
    if name == "step":
        return patch("pitotbench.simulate.sortie.Plant", _FinePlant)
    if name == "spectrum":
        return patch("pitotbench.simulate.atmosphere.MILSPEC_TUSTIN", OTHER_SPECTRUM)
    return nullcontext()


class _FinePlant(Plant):
    @classmethod
    def load(cls, aircraft: str = "navajo", rate: float = OTHER_STEP, overlay: Overlay | None = None) -> Plant:
        """The same aircraft at another rate."""
        return Plant.load(aircraft, rate, overlay)


def _neutral(log: FlightLog) -> FlightLog:
    """The log with a header that tells the card and nothing else."""
    kept = {key: log.header[key] for key in ("format", "case")}
    return replace(log, header=kept)


if __name__ == "__main__":
    generate(**vars(parser().parse_args()))
