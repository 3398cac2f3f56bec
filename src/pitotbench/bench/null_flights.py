"""Null flights of a log's card: fly them, learn their distribution or take it from the cache."""

import os
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import replace
from functools import partial
from hashlib import sha256
from importlib.metadata import version
from itertools import count
from pathlib import Path
from time import monotonic
from typing import Any

import numpy as np
import tomli_w

from pitotbench.campaigns.digests import NOT_DECIDING, aircraft_digest, package_digest
from pitotbench.campaigns.fleet import open_fleet, require_all
from pitotbench.logbook.columns import atomic
from pitotbench.models.aircraft_model import aircraft_model
from pitotbench.reconciliation.free_parameters import AnalysisSetting
from pitotbench.reconciliation.layout import Layout, lay_out
from pitotbench.reconciliation.null_distribution import NullDistribution, read_distribution, text_of
from pitotbench.reconciliation.null_learning import learn_null_distribution
from pitotbench.records import BadInputError
from pitotbench.records.aircraft import cache_folder
from pitotbench.records.case import Case
from pitotbench.records.case_file import read_case, write_case
from pitotbench.records.log import FlightLog
from pitotbench.sensing.recorder import record
from pitotbench.simulation.modified import (
    Loading,
    loading_of,
    mass_of,
)
from pitotbench.simulation.sortie import fly
from pitotbench.units import FOOT

# The card of a log: the case from which its null flights are flown.

# kg: cards this near in mass share null flights. It is 0.4 % of the mass, and more than is burnt
# before a card
MASS_STEP = 10.0
# m: cards this near in height share null flights. "Light" turbulence of JSBSim is 23 % stronger 500
# ft lower
HEIGHT_STEP = 250.0 * FOOT


def card_of(header: Mapping[str, Any], aircraft: str) -> Case | None:
    """Return the case of a log's header as a null flight of an aircraft: without effects.

    Parts that are not in the header have their default values. None where the header has no case (a
    foreign log).
    """
    table = header.get("case")
    if not isinstance(table, Mapping):
        return None
    entries = {key: value for key, value in table.items() if key != "das"}
    das = {key: value for key, value in table.get("das", {}).items() if key != "name"}
    return replace(read_case(tomli_w.dumps({**entries, "das": das}) + "\n"), aircraft=aircraft)


def has_weather_report(header: Mapping[str, Any]) -> bool:
    """Return whether the case of a log's header states the temperature of the day."""
    table = header.get("case")
    return isinstance(table, Mapping) and "temperature_offset_k" in table


def as_flown(card: Case, log: FlightLog) -> Case:
    """Return a card at the height and with the mass of a log: what a header planned is not always
    what was flown.

    The height is the median of the log's GPS height, to `HEIGHT_STEP`; fuel and ballast give the
    first mass of the log, to `MASS_STEP`. What the log does not have, or has within half a step,
    stays as the card says. Raises BadInputError where the mass is not that of the card's aircraft.
    """
    if log.altitude is not None:
        steps = round((float(np.nanmedian(log.altitude)) - card.altitude) / HEIGHT_STEP)
        card = replace(card, altitude=card.altitude + steps * HEIGHT_STEP) if steps else card
    if log.mass is None:
        return card
    stated = mass_of(card.aircraft, Loading(card.fuel, card.ballast))
    steps = round((float(log.mass[0]) - stated) / MASS_STEP)
    if not steps:
        return card
    loading = loading_of(card.aircraft, stated + steps * MASS_STEP)
    return replace(card, fuel=loading.fuel, ballast=loading.ballast)


Progress = Callable[[str], None]  # is called with a line about the step that begins


# The cache of null distributions: one file for each card, named by a digest of all inputs and all
# code.

MOST_KEPT = 100  # entries of the cache, about 40 kB each


def cache_entry(card: Case, flights: int, setting: AnalysisSetting) -> Path:
    """Return the file of a card's null distribution, whether it exists or not.

    Its name has a digest of all that decides it: card, setting, code, aircraft files, versions.
    """
    versions = [f"{name} {version(name)}" for name in ("jsbsim", "numpy", "scipy")]
    computes = (versions, package_digest(NOT_DECIDING), aircraft_digest(card.aircraft))
    digest = sha256(repr((write_case(card), flights, setting, computes)).encode()).hexdigest()[:24]
    return cache_folder() / f"null-{digest}.json"


def read_entry(place: Path, flights: int, say: Progress) -> NullDistribution | None:
    """Return an entry of the cache and mark it as used; None where there is none, or where it
    cannot be used.
    """
    try:
        null = read_distribution(place.read_bytes())
        if null.flights != flights:
            raise ValueError(f"of {null.flights} flights instead of {flights}")
    except FileNotFoundError:
        return None
    except (OSError, ValueError):
        say(f"{place} cannot be used: its null flights are flown again")
        return None
    with suppress(OSError):  # a read-only cache can be used as well
        os.utime(place)
    return null


def write_entry(place: Path, null: NullDistribution, say: Progress) -> None:
    """Write an entry completely or not at all, and remove the entries whose last use is longest
    ago.
    """
    try:
        place.parent.mkdir(parents=True, exist_ok=True)
        with atomic(place) as scratch:
            scratch.write_text(text_of(null), encoding="utf-8")
        _prune(place.parent)
    except (OSError, ValueError, BadInputError) as error:  # the log can be judged all the same
        say(f"the null flights are not kept: {error}")


def _prune(folder: Path) -> None:
    """Remove all but the `MOST_KEPT` entries used last. Partial files of a stopped run count as
    entries.
    """
    files = [file for pattern in ("null-*.json", ".null-*.part") for file in folder.glob(pattern)]
    for file in sorted(files, key=_last_used, reverse=True)[MOST_KEPT:]:
        file.unlink(missing_ok=True)


def _last_used(file: Path) -> float:
    """When a file was last used [s]; 0 where another run has just removed it."""
    try:
        return file.stat().st_mtime
    except FileNotFoundError:
        return 0.0


NULL_FLIGHTS = (
    8  # one or two minutes on two cores; the thresholds include the error of so small a number
)
NULL_SEED = 730_001  # truth and sensor seeds of null flights count up from here


def null_distribution_of(
    card: Case,
    flights: int = NULL_FLIGHTS,
    progress: Progress | None = None,
    setting: AnalysisSetting | None = None,
    keep: bool = True,
) -> NullDistribution:
    """Return the null distribution of a card, for logs that are judged in this setting.

    It is kept in `cache_folder()` under a digest of its inputs, so that a card is flown once.
    Without `keep` the flights are always flown, and the cache is neither read nor written. Two runs
    that need the same entry at the same time both fly. Their flights are the same bit for bit, so
    it does not matter which one writes last, and no lock is needed.
    """
    card = replace(card, effects=(), truth_seed=1, sensor_seed=1)
    setting = setting or AnalysisSetting(day_known=True)
    say = progress or (lambda text: None)
    place = cache_entry(card, flights, setting)
    kept = read_entry(place, flights, say) if keep else None
    if kept is not None:
        return kept
    say(
        f"first use of this card: {flights} flights without an effect ({card.maneuver}, "
        f"{card.das.label})"
    )
    with open_fleet(tasks=flights) as fleet:
        layouts = fleet.perform(
            partial(_null_layout, card, setting),
            range(flights),
            step=announce_flights(flights, say),
        )
        null = learn_null_distribution(
            require_all(layouts), lambda work, each: require_all(fleet.perform(work, each))
        )
    if keep:
        write_entry(place, null, say)
    return null


def announce_flights(
    flights: int, say: Progress, clock: Callable[[], float] = monotonic
) -> Callable[[], None]:
    """Return a function that announces each flight of some, and the time that the others will
    take [s].
    """
    done, begun = count(1), clock()

    def announce() -> None:
        number = next(done)
        left = (clock() - begun) / number * (flights - number)
        say(
            f"null flight {number} of {flights}"
            + (f", about {left:.0f} s left" if number < flights else "")
        )

    return announce


def _null_layout(card: Case, setting: AnalysisSetting, number: int) -> Layout:
    seed = NULL_SEED + number
    flight = fly(replace(card, truth_seed=seed, sensor_seed=seed))
    return lay_out(record(flight, card.das, seed), aircraft_model(card.aircraft), setting)
