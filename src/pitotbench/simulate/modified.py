"""The aircraft and the air of a case with its effects in them."""

import re
from collections.abc import Mapping, Sequence
from functools import reduce
from operator import add
from pathlib import Path
from typing import Any

from pitotbench.effects import EFFECTS, AircraftEffect, Choice, Overlay, chosen
from pitotbench.effects.air.recorded_time import RECORDING_START
from pitotbench.records.case import Case, EffectSpec
from pitotbench.records.errors import BadInputError
from pitotbench.records.toml_text import write_toml
from pitotbench.simulate.baseline import read_baseline
from pitotbench.simulate.hangar import OWN, find_aircraft, known_aircraft
from pitotbench.simulate.plant import Plant
from pitotbench.simulate.variant import overlay_text, write_variant


def overlay_of(case: Case) -> Overlay:
    """What the effects of a case put on its aircraft and its air; those on the sensors are left to `sense`.

    Raises UnknownNameError for an unknown effect, BadInputError for parameters that cannot be or an aircraft that
    lacks what an effect changes.
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
) -> Path:
    """Write an aircraft with effects in it as a new one, `<aircraft>+<variant>`, which flies by that name.

    It goes to `./aircraft` unless another shelf is given; `variant.toml` in its folder says which effects it holds
    and where they come from (`provenance`, any TOML table). Returns the folder.
    Raises BadInputError for effects that are not the aircraft's, for a bad name, and where the variant is there
    already: nothing is overwritten.
    """
    if not re.fullmatch(r"[A-Za-z0-9_.-]+", variant):
        raise BadInputError(f"variant {variant!r}: use letters, digits, dots, dashes and underscores")
    foreign = [entry.name for entry in effects if EFFECTS[entry.name].acts_on != "aircraft"]
    if foreign:
        raise BadInputError(f"{', '.join(foreign)}: no effect of an aircraft; write it into the case file")
    overlay = _overlay(aircraft, chosen(effects))
    if overlay.is_empty():
        raise BadInputError("a variant needs at least one effect of a size other than zero")
    folder = write_variant(find_aircraft(aircraft), shelf or OWN.resolve(), f"{aircraft}+{variant}", overlay)
    told = [{"name": entry.name, "parameters": dict(entry.parameters)} for entry in effects]
    table = {"aircraft": aircraft, "provenance": dict(provenance or {}), "effects": told}
    (folder / "variant.toml").write_text(write_toml(table), encoding="utf-8")
    return folder


def overlay_xml(aircraft: str, effects: Sequence[EffectSpec]) -> str:
    """What effects add to the JSBSim file of an aircraft, as XML; empty where none of them acts on it."""
    overlay = _overlay(aircraft, chosen([e for e in effects if EFFECTS[e.name].acts_on == "aircraft"]))
    return "" if overlay.is_empty() else overlay_text(find_aircraft(aircraft), overlay)


def require_free(aircraft: str, variant: str) -> None:
    """Raise BadInputError where a variant cannot be written: a bad name, or one that is taken."""
    if not re.fullmatch(r"[A-Za-z0-9_.-]+", variant):
        raise BadInputError(f"variant {variant!r}: use letters, digits, dots, dashes and underscores")
    name = f"{aircraft}+{variant}"
    if name in known_aircraft():
        raise BadInputError(f"{known_aircraft()[name]} is there already; choose another name for the variant")


def mark_recording(plant: Plant) -> None:
    """Tell effects that count time from the first recorded sample that it comes with the next step."""
    if plant.serves(RECORDING_START):
        plant.set(RECORDING_START, plant.get("time") + plant.time_step)
