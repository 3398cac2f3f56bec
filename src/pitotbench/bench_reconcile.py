"""The conductor of reconciliation: flies null flights, lends the aircraft as a force meter, keeps what was
learned."""

import json
import os
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import cache, partial
from hashlib import sha256
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from pitotbench.effects import Overlay
from pitotbench.reconcile.hypotheses import AircraftModel
from pitotbench.reconcile.judge import hold_out, judge, with_hold_out
from pitotbench.reconcile.name import Naming
from pitotbench.reconcile.nuisance import Setting as Setting
from pitotbench.reconcile.null import Knowledge, ignorance, learn
from pitotbench.reconcile.study import Study, own_noise, study
from pitotbench.reconcile.whitening import NoiseModel
from pitotbench.records.case import Case
from pitotbench.records.case_file import read_case, write_case
from pitotbench.records.log import FlightLog
from pitotbench.records.motion import Motion, Reaction
from pitotbench.records.toml_text import write_toml
from pitotbench.records.verdict import Verdict
from pitotbench.sense import record
from pitotbench.simulate import fly
from pitotbench.simulate.baseline import read_baseline
from pitotbench.simulate.force_meter import FREE, loaded_mass, measure
from pitotbench.simulate.hangar import PACKAGE, find_aircraft
from pitotbench.simulate.plant import Plant

NULL_FLIGHTS = 8
NULL_SEED = 730_001  # truth and sensor seeds of null flights count up from here
COARSE_RATE, FINE_RATE = 25.0, 100.0  # Hz: what an effect changes in a held state differs by less than 1 %
JUDGED_BY = ("reconcile", "effects", "simulate", "sense")  # rooms whose code decides what null flights teach

Progress = Callable[[str], None]


@dataclass(frozen=True, slots=True)
class Reconciliation:
    """A verdict with all that a page or a patch needs: the naming behind it and the card it was judged by."""

    verdict: Verdict
    naming: Naming
    known: Knowledge
    card: Case | None


def aircraft_model(name: str) -> AircraftModel | None:
    """An aircraft of the hangar as the analyst's model; None for `none`. Raises UnknownNameError."""
    if name == "none":
        return None
    return AircraftModel(name, partial(_react, name), read_baseline(find_aircraft(name)))


@cache
def _mass(name: str) -> float:
    return loaded_mass(name)


def _react(name: str, motion: Motion, overlay: Overlay | None = None, engines_run: bool = True) -> Reaction:
    coarse = len(motion.time) > 1 and float(np.median(np.diff(motion.time))) > FREE
    plant = Plant.load(name, COARSE_RATE if coarse else FINE_RATE, overlay)
    return measure(plant, motion, _mass(name), engines_run)


def card_of(header: Mapping[str, Any], aircraft: str) -> Case | None:
    """The case that a log's header tells, as a null flight of an aircraft: without effects, its hidden parts as
    usual.

    None where the header tells none (a foreign log).
    """
    table = header.get("case")
    if not isinstance(table, Mapping):
        return None
    told = {key: value for key, value in table.items() if key != "das"}
    das = {key: value for key, value in table.get("das", {}).items() if key != "name"}
    return replace(read_case(write_toml({**told, "das": das}) + "\n"), aircraft=aircraft)


def reconcile(
    log: FlightLog,
    aircraft: str = "navajo",
    holdout: FlightLog | None = None,
    card: Case | None = None,
    null_flights: int = NULL_FLIGHTS,
    progress: Progress | None = None,
    setting: Setting | None = None,
) -> Reconciliation:
    """Find where a measured log and the model of an aircraft disagree, and name the effect that is missing.

    `aircraft` is a name of the hangar, or `none` for the sensors alone. `card` says what was flown; if not given,
    the log's header does. Without either the log's own noise sets the thresholds, which then are wider.
    Raises BadInputError for a log that cannot be used.
    """
    model = aircraft_model(aircraft)
    flown = card or (card_of(log.header, aircraft) if model is not None else None)
    known = knowledge(flown, null_flights, progress) if flown is not None else None
    setting = replace(setting or Setting(), day_known=flown is not None)
    layout = study(log, model, setting)
    known = _fitting(known, layout)
    verdict, named = judge(layout, known)
    if holdout is not None and named.chosen:
        verdict = with_hold_out(verdict, hold_out(holdout, model, known, named, setting))
    return Reconciliation(verdict, named, known, flown)


def _fitting(known: Knowledge | None, layout: Study) -> Knowledge:
    """What is known, where it is of the same channels; else what the log itself shows."""
    if known is not None and known.noise.names == layout.residuals.names:
        return known
    return ignorance(own_noise(layout))


def knowledge(card: Case, flights: int = NULL_FLIGHTS, progress: Progress | None = None) -> Knowledge:
    """What null flights of a card teach; kept by content, so that a card is flown once."""
    card = replace(card, effects=(), truth_seed=1, sensor_seed=1)
    place = cache_folder() / f"null-{_digest(card, flights)}.json"
    if place.is_file():
        return _from_json(json.loads(place.read_text(encoding="utf-8")))
    say = progress or (lambda text: None)
    say(f"first use of this card: {flights} flights without an effect ({card.maneuver}, {card.das.label})")
    studies: list[Study] = []
    with ProcessPoolExecutor(min(flights, os.cpu_count() or 1), get_context("spawn")) as pool:
        for number, layout in enumerate(pool.map(partial(_null_study, card), range(flights)), start=1):
            say(f"null flight {number} of {flights}")
            studies.append(layout)
    known = learn(studies)
    place.parent.mkdir(parents=True, exist_ok=True)
    place.write_text(json.dumps(_to_json(known)), encoding="utf-8")
    return known


def _null_study(card: Case, number: int) -> Study:
    seed = NULL_SEED + number
    flight = fly(replace(card, truth_seed=seed, sensor_seed=seed))
    return study(record(flight, card.das, seed), aircraft_model(card.aircraft), Setting(day_known=True))


def cache_folder() -> Path:
    """Where null flights are kept: `$PITOTBENCH_CACHE`, else the user's cache folder."""
    own = os.environ.get("PITOTBENCH_CACHE")
    if own:
        return Path(own)
    return Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "pitotbench"


def _digest(card: Case, flights: int) -> str:
    """Of the card, the aircraft's files and the code that judges."""
    parts = [write_case(card).encode(), str(flights).encode()]
    code = [file for room in JUDGED_BY for file in sorted((PACKAGE / room).rglob("*.py"))]
    aircraft = sorted(find_aircraft(card.aircraft).rglob("*.xml"))
    return sha256(b"".join([*parts, *(file.read_bytes() for file in (*code, *aircraft))])).hexdigest()[:24]


def _to_json(known: Knowledge) -> dict[str, Any]:
    noise = known.noise
    return {
        "noise": {
            "names": list(noise.names),
            "coefficients": noise.coefficients.tolist(),
            "deviations": noise.deviations.tolist(),
            "correlation": noise.correlation.tolist(),
        },
        "search": dict(known.search),
        "spread": dict(known.spread),
        "cell_mean": dict(known.cell_mean),
        "cell_spread": dict(known.cell_spread),
        "threshold": known.threshold,
        "cell_threshold": known.cell_threshold,
        "flights": known.flights,
        "gusts": {name: list(pair) for name, pair in known.gusts.items()},
        "powers": {name: list(pair) for name, pair in known.powers.items()},
        "swings": {name: list(pair) for name, pair in known.swings.items()},
    }


def _from_json(table: dict[str, Any]) -> Knowledge:
    noise = table.pop("noise")
    arrays = (np.array(noise[key]) for key in ("coefficients", "deviations", "correlation"))
    model = NoiseModel(tuple(noise["names"]), *arrays)
    gusts, powers, swings = (_pairs(table.pop(key)) for key in ("gusts", "powers", "swings"))
    return Knowledge(noise=model, gusts=gusts, powers=powers, swings=swings, **table)


def _pairs(table: Mapping[str, Sequence[float]]) -> dict[str, tuple[float, float]]:
    return {name: (pair[0], pair[1]) for name, pair in table.items()}
