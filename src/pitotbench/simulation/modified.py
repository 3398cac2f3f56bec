"""Put the effects of a case into its aircraft and its air, and load the aircraft to a mass."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache, reduce
from operator import add
from pathlib import Path
from typing import Any

import tomli_w

from pitotbench.effects import chosen, effect_of
from pitotbench.effects.airframe import MASS
from pitotbench.effects.effect import RECORDING_START, AircraftEffect, Choice
from pitotbench.effects.overlay import MassPoint, Overlay, product
from pitotbench.records import BadInputError
from pitotbench.records.case import Case, EffectSpec
from pitotbench.records.intake import read_toml
from pitotbench.records.motion import PatchErrors
from pitotbench.simulation.aircraft import OWN, find_aircraft, known_aircraft
from pitotbench.simulation.baseline import read_baseline
from pitotbench.simulation.plant import Plant
from pitotbench.simulation.variant import ORIGIN, overlay_text, write_variant
from pitotbench.units import POUND

FORM = 0.05  # 1σ of the form of a patched effect, as a share of it


def overlay_of(case: Case) -> Overlay:
    """Return what a case adds to its aircraft and its air by effects.

    Package `sensing` applies those on sensors.

    Raises UnknownNameError for an unknown effect, BadInputError for impossible parameters or for an
    aircraft that lacks the part that an effect changes.
    """
    return _overlay(case.aircraft, chosen(case.effects))


def _overlay(aircraft: str, choices: Sequence[Choice]) -> Overlay:
    acting = [(c.effect, c.sizes) for c in choices if isinstance(c.effect, AircraftEffect)]
    if not acting:
        return Overlay()
    baseline = read_baseline(find_aircraft(aircraft))
    return reduce(add, (effect.overlay(sizes, baseline) for effect, sizes in acting))


def install_variant(
    aircraft: str,
    variant: str,
    effects: Sequence[EffectSpec],
    provenance: Mapping[str, Any] | None = None,
    shelf: Path | None = None,
    anew: bool = False,
) -> Path:
    """Write an aircraft with effects as `<aircraft>+<variant>`, and return its folder.

    The folder stands in `./aircraft` unless another `shelf` is given. Its `variant.toml` names the
    effects and their origin (`provenance`, any TOML table). Raises BadInputError for effects that
    do not act on an aircraft, for a name with forbidden characters, and for a variant that exists:
    nothing is overwritten, unless it is to be written `anew`.
    """
    _require_name(variant)
    foreign = [entry.name for entry in effects if effect_of(entry.name).acts_on != "aircraft"]
    if foreign:
        raise BadInputError(
            f"{', '.join(foreign)}: no effect of an aircraft; write it into the case file"
        )
    overlay = _overlay(aircraft, chosen(effects))
    if overlay.is_empty():
        raise BadInputError("a variant needs at least one effect of a size other than zero")
    entries = [{"name": entry.name, "parameters": dict(entry.parameters)} for entry in effects]
    table = {"aircraft": aircraft, "provenance": dict(provenance or {}), "effects": entries}
    return write_variant(
        find_aircraft(aircraft),
        shelf or OWN.resolve(),
        f"{aircraft}+{variant}",
        overlay,
        origin=tomli_w.dumps(table),
        anew=anew,
    )


def patch_errors(aircraft: str) -> PatchErrors:
    """Return what the patches of an aircraft may be off by, as its `variant.toml` states it.

    Without a patch that is nothing. A patch that states no covariance has that of its bounds. What
    two patches change alike adds up.
    """
    table = _origin(aircraft)
    if table is None:
        return PatchErrors()
    origin, before = table.get("provenance", {}), patch_errors(table["aircraft"])
    bounds = origin.get("two_sigma", {})
    sizes = {
        (entry["name"], key): float(value)
        for entry in table["effects"]
        for key, value in entry["parameters"].items()
        if key in bounds.get(entry["name"], {})
    }
    bound = {key: (0.5 * float(bounds[key[0]][key[1]])) ** 2 for key in sizes}
    covariance = {
        (a, b): float(origin.get("covariance", {}).get(f"{' '.join(a)}, {' '.join(b)}", fallback))
        for a in sizes
        for b in sizes
        for fallback in (bound[a] if a == b else 0.0,)
    }
    form = origin.get("form", {})
    return PatchErrors(
        _sum(before.sizes, sizes),
        _sum(before.covariance, covariance),
        dict(before.forms) | {key: float(form.get(key[0], FORM)) for key in sizes},
    )


def _origin(aircraft: str) -> dict[str, Any] | None:
    """The `variant.toml` of an aircraft; None of one without a patch."""
    place = known_aircraft().get(aircraft)
    if place is None or not (place / ORIGIN).is_file():
        return None
    return read_toml(place / ORIGIN, "the origin of a variant")


def patched_sizes(aircraft: str) -> dict[tuple[str, str], float]:
    """Return the sizes that an aircraft's patches add up to, by effect and parameter."""
    table = _origin(aircraft)
    if table is None:
        return {}
    own = {
        (e["name"], key): value for e in table["effects"] for key, value in e["parameters"].items()
    }
    return _sum(patched_sizes(table["aircraft"]), own)


def unpatched(aircraft: str) -> str:
    """Return the airplane before the patches that logs showed, itself where it has none.

    A patch that logs showed states bounds in its `variant.toml`.
    """
    table = _origin(aircraft)
    if table is None or "two_sigma" not in table.get("provenance", {}):
        return aircraft
    return unpatched(table["aircraft"])


def patched_mass(aircraft: str) -> float:
    """Return the mass that the patches of an aircraft add to that of its weight sheet [kg]."""
    return patched_sizes(aircraft).get((MASS.name, "mass_kg"), 0.0)


def _sum(first: Mapping[Any, float], second: Mapping[Any, float]) -> dict[Any, float]:
    return {k: first.get(k, 0.0) + second.get(k, 0.0) for k in (*first, *second)}


def overlay_xml(aircraft: str, effects: Sequence[EffectSpec]) -> str:
    """Return the XML that effects add to the JSBSim file of an aircraft; empty where none does."""
    overlay = _overlay(
        aircraft, chosen([e for e in effects if effect_of(e.name).acts_on == "aircraft"])
    )
    return "" if overlay.is_empty() else overlay_text(find_aircraft(aircraft), overlay)


def require_free(aircraft: str, variant: str) -> None:
    """Raise BadInputError for a variant of no aircraft, of a forbidden name or of a taken one."""
    if aircraft == "none":
        raise BadInputError("--aircraft none has no aircraft to patch: name the aircraft")
    _require_name(variant)
    if place := known_aircraft().get(f"{aircraft}+{variant}"):
        raise BadInputError(f"{place} is there already; choose another name for the variant")


def _require_name(variant: str) -> None:
    if not re.fullmatch(r"[A-Za-z0-9_.-]+", variant):
        raise BadInputError(
            f"variant {variant!r}: use letters, digits, dots, dashes and underscores"
        )


def mark_recording(plant: Plant) -> None:
    """Set the time of the first recorded sample, which comes with the next step.

    Effects such as a wind drift count their time from it.
    """
    if plant.serves(RECORDING_START):
        plant.set(RECORDING_START, plant.get("time") + plant.time_step)


TANKS = ("propulsion/tank/contents-lbs", "propulsion/tank[1]/contents-lbs")
# of what the file loads: half an hour of cruise, so that no card is flown with empty tanks
LEAST_FUEL = 0.1
MOST_BALLAST = 1000.0  # kg: beyond it the mass is that of another airplane, or in another unit


@dataclass(frozen=True, slots=True)
class Loading:
    """The loading of an aircraft: the share of fuel in its file (0 to 1), and ballast [kg]."""

    fuel: float = 1.0
    ballast: float = 0.0


@cache
def loaded_mass(aircraft: str) -> float:
    """Return the mass [kg] of an aircraft on its weight sheet, with its file's load and fuel.

    A patched mass is an error of the sheet: the sheet lacks it, as the mass column of a log does.
    """
    plant = Plant.load(aircraft)
    plant.run_initial_conditions()  # until then JSBSim's mass lacks the fuel
    return plant.get("mass") - patched_mass(aircraft)


@cache
def loaded_fuel(aircraft: str) -> float:
    """Return the mass of the fuel in an aircraft's file [kg]."""
    plant = Plant.load(aircraft)
    return sum(plant.get(tank) for tank in tanks(plant)) * POUND


def tanks(plant: Plant) -> tuple[str, ...]:
    """Return the properties of the fuel [lb] in an aircraft's tanks, at most the first two."""
    return tuple(tank for tank in TANKS if plant.serves(tank))


def mass_of(aircraft: str, loading: Loading) -> float:
    """Return the mass of an aircraft with a loading [kg]."""
    return loaded_mass(aircraft) - (1.0 - loading.fuel) * loaded_fuel(aircraft) + loading.ballast


def loading_of(aircraft: str, mass: float) -> Loading:
    """Return the loading that gives an aircraft a mass [kg]: fuel in its tanks, then ballast.

    Raises BadInputError where the mass cannot be that of this aircraft.
    """
    ballast = ballast_for(aircraft, mass, mass)
    return Loading(1.0 - (loaded_mass(aircraft) + ballast - mass) / loaded_fuel(aircraft), ballast)


def ballast_for(aircraft: str, lightest: float, heaviest: float) -> float:
    """Return the ballast [kg] with which fuel alone makes the `lightest` and `heaviest` mass [kg].

    It is negative where the aircraft is lighter than its file says with `LEAST_FUEL` in the tanks.
    Raises BadInputError where more than `MOST_BALLAST` would be needed.
    """
    full = loaded_mass(aircraft)
    least = full - (1.0 - LEAST_FUEL) * loaded_fuel(aircraft)
    ballast = max(0.0, heaviest - full) + min(0.0, lightest - least)
    if abs(ballast) > MOST_BALLAST:
        raise BadInputError(
            f"mass_kg goes from {lightest:.0f} to {heaviest:.0f} kg, and {aircraft} weighs "
            f"{least:.0f} to {full:.0f} kg: check the unit of the column, or name another aircraft"
        )
    return ballast


def ballast_overlay(aircraft: str, ballast: float) -> Overlay:
    """Return an overlay with ballast [kg] at the aircraft's center of gravity; empty for none."""
    if not ballast:
        return Overlay()
    place = read_baseline(find_aircraft(aircraft)).center_of_gravity
    # Times one: an expression must be XML, and a bare number is not.
    return Overlay(masses=(MassPoint(product(float(ballast) / POUND, 1.0), place),))


def load_fuel(plant: Plant, share: float) -> None:
    """Reduce the fuel in the tanks to a share of the load. Call it before the plant starts."""
    for tank in tanks(plant) if share != 1.0 else ():
        plant.set(tank, share * plant.get(tank))
