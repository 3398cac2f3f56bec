"""Put the effects of a case into its aircraft and its air, or write them as an aircraft variant."""

import re
from collections.abc import Mapping, Sequence
from functools import reduce
from operator import add
from pathlib import Path
from typing import Any

import tomli_w

from pitotbench.effects import AircraftEffect, Choice, Overlay, chosen, effect_of
from pitotbench.effects.air.recorded_time import RECORDING_START
from pitotbench.records.case import Case, EffectSpec
from pitotbench.records.errors import BadInputError
from pitotbench.simulate.baseline import read_baseline
from pitotbench.simulate.hangar import OWN, find_aircraft, known_aircraft
from pitotbench.simulate.plant import Plant
from pitotbench.simulate.variant import overlay_text, write_variant


def overlay_of(case: Case) -> Overlay:
    """Return what the effects of a case add to its aircraft and its air. Package `sense` applies those on sensors.

    Raises UnknownNameError for an unknown effect, BadInputError for impossible parameters or for an aircraft that
    lacks the part that an effect changes.
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
    """Write an aircraft with effects as a new aircraft, `<aircraft>+<variant>`, and return its folder.

    The folder stands in `./aircraft` unless another `shelf` is given. Its `variant.toml` names the effects and
    their origin (`provenance`, any TOML table).
    Raises BadInputError for effects that do not act on an aircraft, for a name with forbidden characters, and for
    a variant that exists: nothing is overwritten.
    """
    if not re.fullmatch(r"[A-Za-z0-9_.-]+", variant):
        raise BadInputError(f"variant {variant!r}: use letters, digits, dots, dashes and underscores")
    foreign = [entry.name for entry in effects if effect_of(entry.name).acts_on != "aircraft"]
    if foreign:
        raise BadInputError(f"{', '.join(foreign)}: no effect of an aircraft; write it into the case file")
    overlay = _overlay(aircraft, chosen(effects))
    if overlay.is_empty():
        raise BadInputError("a variant needs at least one effect of a size other than zero")
    folder = write_variant(find_aircraft(aircraft), shelf or OWN.resolve(), f"{aircraft}+{variant}", overlay)
    entries = [{"name": entry.name, "parameters": dict(entry.parameters)} for entry in effects]
    table = {"aircraft": aircraft, "provenance": dict(provenance or {}), "effects": entries}
    (folder / "variant.toml").write_text(tomli_w.dumps(table), encoding="utf-8")
    return folder


def overlay_xml(aircraft: str, effects: Sequence[EffectSpec]) -> str:
    """Return as XML what effects add to the JSBSim file of an aircraft; empty where none acts on the aircraft."""
    overlay = _overlay(aircraft, chosen([e for e in effects if effect_of(e.name).acts_on == "aircraft"]))
    return "" if overlay.is_empty() else overlay_text(find_aircraft(aircraft), overlay)


def require_free(aircraft: str, variant: str) -> None:
    """Raise BadInputError where a variant cannot be written: forbidden characters, or a name that is taken."""
    if not re.fullmatch(r"[A-Za-z0-9_.-]+", variant):
        raise BadInputError(f"variant {variant!r}: use letters, digits, dots, dashes and underscores")
    name = f"{aircraft}+{variant}"
    if name in known_aircraft():
        raise BadInputError(f"{known_aircraft()[name]} is there already; choose another name for the variant")


def mark_recording(plant: Plant) -> None:
    """Set the time of the first recorded sample, which comes with the next step.

    Effects such as a wind drift count their time from it.
    """
    if plant.serves(RECORDING_START):
        plant.set(RECORDING_START, plant.get("time") + plant.time_step)
