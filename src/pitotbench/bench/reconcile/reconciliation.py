"""The conductor of reconciliation: flies null flights, lends the aircraft as a force meter, keeps what was
learned."""

import os
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from hashlib import sha256
from importlib.metadata import version
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np

from pitotbench.bench.fleet import require_all, run_tasks
from pitotbench.effects import Overlay
from pitotbench.logbook import atomic
from pitotbench.reconcile.decide.judgment import hold_out, judge, with_hold_out
from pitotbench.reconcile.decide.naming import Naming
from pitotbench.reconcile.null_flights.knowledge_text import knowledge_text, read_knowledge
from pitotbench.reconcile.null_flights.null_distribution import Knowledge, ignorance, learn
from pitotbench.reconcile.residuals.free_parameters import AnalysisSetting as AnalysisSetting
from pitotbench.reconcile.residuals.layout import Layout, lay_out, own_noise
from pitotbench.reconcile.signatures.signatures import AircraftModel
from pitotbench.records.case import Case
from pitotbench.records.case_file import read_case, write_case
from pitotbench.records.errors import BadInputError
from pitotbench.records.log import FlightLog
from pitotbench.records.motion import Motion, Reaction
from pitotbench.records.toml_text import write_toml
from pitotbench.records.verdict import Verdict
from pitotbench.sense import record
from pitotbench.simulate import fly
from pitotbench.simulate.baseline import read_baseline
from pitotbench.simulate.force_meter import FREE, measure
from pitotbench.simulate.fuel_and_ballast import (
    Loading,
    ballast_for,
    ballast_overlay,
    loaded_mass,
    loading_of,
    mass_of,
)
from pitotbench.simulate.hangar import PACKAGE, find_aircraft
from pitotbench.simulate.plant import Plant

NULL_FLIGHTS = 8
NULL_SEED = 730_001  # truth and sensor seeds of null flights count up from here
COARSE_RATE, FINE_RATE = 25.0, 100.0  # Hz: what an effect changes in a held state differs by less than 1 %
MASS_STEP = (
    10.0  # kg: cards this near in mass share null flights; 0.4 % of it, and more than is burnt before a card
)
MOST_KEPT = 100  # entries of the cache, about 40 kB each
# Packages whose code cannot change what null flights teach. All other code is part of the key of the cache: a list
# of what decides would miss what a later change adds.
NOT_DECIDING = ("cli", "evidence", "show")

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


def _react(name: str, motion: Motion, overlay: Overlay | None = None, engines_run: bool = True) -> Reaction:
    coarse = len(motion.time) > 1 and float(np.median(np.diff(motion.time))) > FREE
    ballast = ballast_for(name, float(motion.mass.min()), float(motion.mass.max()))
    added = (overlay or Overlay()) + ballast_overlay(name, ballast)
    plant = Plant.load(name, COARSE_RATE if coarse else FINE_RATE, added)
    return measure(plant, motion, loaded_mass(name) + ballast, engines_run)


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


def loaded_as(card: Case, log: FlightLog) -> Case:
    """A card with the fuel and ballast that give its aircraft the first mass of a log, in steps of `MASS_STEP`.

    The card itself where the log has no mass, or one within half a step of the card's.
    Raises BadInputError where the mass is not that of the card's aircraft.
    """
    if log.mass is None:
        return card
    told = mass_of(card.aircraft, Loading(card.fuel, card.ballast))
    steps = round((float(log.mass[0]) - told) / MASS_STEP)
    if not steps:
        return card
    loading = loading_of(card.aircraft, told + steps * MASS_STEP)
    return replace(card, fuel=loading.fuel, ballast=loading.ballast)


def reconcile(
    log: FlightLog,
    aircraft: str = "navajo",
    holdout: FlightLog | None = None,
    card: Case | None = None,
    null_flights: int = NULL_FLIGHTS,
    progress: Progress | None = None,
    setting: AnalysisSetting | None = None,
    keep: bool = True,
) -> Reconciliation:
    """Find where a measured log and the model of an aircraft disagree, and name the effect that is missing.

    `aircraft` is a name of the hangar, or `none` for the sensors alone. `card` says what was flown; if not given,
    the log's header does. With an aircraft model the card is flown at the log's first mass. Without a card the
    noise of the log itself sets the thresholds, which then are wider. Without `keep` null flights are neither
    looked up nor kept.
    Raises BadInputError for a log that cannot be used.
    """
    model = aircraft_model(aircraft)
    flown = card or (card_of(log.header, aircraft) if model is not None else None)
    flown = loaded_as(flown, log) if flown is not None and model is not None else flown
    setting = replace(setting or AnalysisSetting(), day_known=flown is not None)
    known = knowledge(flown, null_flights, progress, setting, keep) if flown is not None else None
    layout = lay_out(log, model, setting)
    known = _fitting(known, layout)
    verdict, named = judge(layout, known)
    if holdout is not None and named.chosen:
        verdict = with_hold_out(verdict, hold_out(holdout, model, known, named, setting))
    return Reconciliation(verdict, named, known, flown)


def _fitting(known: Knowledge | None, layout: Layout) -> Knowledge:
    """What is known, where it is of the same channels; else what the log itself shows."""
    if known is not None and known.noise.names == layout.residuals.names:
        return known
    return ignorance(own_noise(layout))


def knowledge(
    card: Case,
    flights: int = NULL_FLIGHTS,
    progress: Progress | None = None,
    setting: AnalysisSetting | None = None,
    keep: bool = True,
) -> Knowledge:
    """What null flights of a card teach, laid out in the setting of the log that is to be judged.

    Kept by content in `cache_folder()`, so that a card is flown once; without `keep` the flights are flown, and
    nothing is read or written there. Two runs that need one entry at a time both fly: the flights are the same bit
    for bit, so whichever writes last changes nothing, and no lock can be left behind.
    """
    card, setting = (
        replace(card, effects=(), truth_seed=1, sensor_seed=1),
        setting or AnalysisSetting(day_known=True),
    )
    say = progress or (lambda text: None)
    place = cache_folder() / f"null-{_digest(card, flights, setting)}.json"
    kept = _kept(place, flights, say) if keep else None
    if kept is not None:
        return kept
    say(f"first use of this card: {flights} flights without an effect ({card.maneuver}, {card.das.label})")
    done = count(1)
    studies = run_tasks(
        partial(_null_study, card, setting),
        range(flights),
        step=lambda: say(f"null flight {next(done)} of {flights}"),
    )
    known = learn(require_all(studies))
    if keep:
        _keep(place, known, say)
    return known


def _null_study(card: Case, setting: AnalysisSetting, number: int) -> Layout:
    seed = NULL_SEED + number
    flight = fly(replace(card, truth_seed=seed, sensor_seed=seed))
    return lay_out(record(flight, card.das, seed), aircraft_model(card.aircraft), setting)


def cache_folder() -> Path:
    """Where null flights are kept: `$PITOTBENCH_CACHE`, else the user's cache folder."""
    own = os.environ.get("PITOTBENCH_CACHE")
    if own:
        return Path(own)
    return Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "pitotbench"


def _kept(place: Path, flights: int, say: Progress) -> Knowledge | None:
    """An entry of the cache, marked as used; None where there is none, or where it cannot be right."""
    try:
        known = read_knowledge(place.read_bytes())
        if known.flights != flights:
            raise ValueError(f"of {known.flights} flights instead of {flights}")
    except FileNotFoundError:
        return None
    except (OSError, ValueError):
        say(f"{place} cannot be used: its null flights are flown again")
        return None
    with suppress(OSError):  # a cache that may only be read serves as well
        os.utime(place)
    return known


def _keep(place: Path, known: Knowledge, say: Progress) -> None:
    """Write an entry, whole or not at all, and let the ones go that have not been used for longest."""
    try:
        place.parent.mkdir(parents=True, exist_ok=True)
        with atomic(place) as scratch:
            scratch.write_text(knowledge_text(known), encoding="utf-8")
        _prune(place.parent)
    except (OSError, ValueError, BadInputError) as error:  # the log can be judged all the same
        say(f"the null flights are not kept: {error}")


def _prune(folder: Path) -> None:
    """Remove all but the `MOST_KEPT` entries used last; what a stopped run has half written counts as well."""
    files = [file for pattern in ("null-*.json", ".null-*.part") for file in folder.glob(pattern)]
    for file in sorted(files, key=_last_used, reverse=True)[MOST_KEPT:]:
        file.unlink(missing_ok=True)


def _last_used(file: Path) -> float:
    """When a file was last used [s]; 0 where another run has just removed it."""
    try:
        return file.stat().st_mtime
    except FileNotFoundError:
        return 0.0


def _digest(card: Case, flights: int, setting: AnalysisSetting) -> str:
    """Of all that decides what null flights teach: card, setting, code, the aircraft's files, versions."""
    code = [f for f in sorted(PACKAGE.rglob("*.py")) if f.relative_to(PACKAGE).parts[0] not in NOT_DECIDING]
    folder = find_aircraft(card.aircraft)
    aircraft = [file for file in sorted(folder.rglob("*")) if file.is_file()]
    versions = [f"{name} {version(name)}" for name in ("jsbsim", "numpy", "scipy")]
    digest = sha256(repr((write_case(card), flights, setting, versions)).encode())
    for root, file in (*((PACKAGE, f) for f in code), *((folder, f) for f in aircraft)):
        digest.update(repr((file.relative_to(root).as_posix(), file.read_bytes())).encode())
    return digest.hexdigest()[:24]
