"""Look again: the model with all that was named in it, against the same log."""

from collections.abc import Mapping
from dataclasses import replace
from functools import reduce
from operator import add
from typing import Any

import numpy as np

from pitotbench.effects import EFFECTS, AircraftEffect, AirEffect, Overlay, SensorEffect
from pitotbench.reconcile.decide.judgment import judge
from pitotbench.reconcile.decide.naming import Naming
from pitotbench.reconcile.null_flights.null_distribution import Knowledge
from pitotbench.reconcile.residuals.free_parameters import AnalysisSetting
from pitotbench.reconcile.residuals.layout import COUNTED, Layout, lay_out
from pitotbench.reconcile.signatures.refine import without
from pitotbench.reconcile.signatures.signatures import AircraftModel, change, moves_levers
from pitotbench.records.log import FlightLog
from pitotbench.records.motion import Motion, Reaction
from pitotbench.records.verdict import Verdict

Entries = Mapping[str, Mapping[str, float]]  # effects with their sizes and shapes


def look_again(
    log: FlightLog, aircraft: AircraftModel | None, known: Knowledge, setting: AnalysisSetting, entries: Entries
) -> tuple[Verdict, Naming]:
    """The verdict on a log once effects are in the model: those of the aircraft on the force meter, those of the
    sensors and the air taken out of the residuals. What is counted and not fitted stays in the verdict."""
    fitted = {n: s for n, s in entries.items() if n not in COUNTED}
    beside = {n: s for n, s in fitted.items() if on_model(aircraft, n, s) is None}
    return judge(explained(lay_out(log, patched(aircraft, fitted), setting), beside), known)


def patched(aircraft: AircraftModel | None, entries: Entries) -> AircraftModel | None:
    """The aircraft with the overlays of the effects that act on it."""
    if aircraft is None:
        return None
    overlays = [overlay for n, s in entries.items() if (overlay := on_model(aircraft, n, s)) is not None]
    if not overlays:
        return aircraft
    patch, react = reduce(add, overlays), aircraft.react

    def with_patch(motion: Motion, overlay: Overlay, *rest: Any) -> Reaction:
        return react(motion, patch + overlay, *rest)

    return replace(aircraft, react=with_patch)


def on_model(aircraft: AircraftModel | None, name: str, sizes: Mapping[str, float]) -> Overlay | None:
    """What an effect puts on the force meter; None for those of the sensors and the air, and for a lever that
    stands elsewhere than its plate, for the plates are measured."""
    effect = EFFECTS[name]
    if aircraft is None or not isinstance(effect, AircraftEffect) or isinstance(effect, AirEffect):
        return None
    overlay = effect.overlay(sizes, aircraft.baseline)
    return None if moves_levers(overlay) else overlay


def explained(layout: Layout, entries: Entries) -> Layout:
    """A study with what effects, in the order given, do taken out of its residuals."""
    seen, taken = layout, np.zeros_like(layout.residuals.values)
    for name, sizes in entries.items():
        effect = EFFECTS[name]
        if isinstance(effect, SensorEffect):
            layout = without(layout, seen, name, sizes)
        moved = change(layout.scene, effect, effect.complete(sizes))
        taken = taken if moved is None else taken + moved
    return replace(layout, residuals=replace(layout.residuals, values=layout.residuals.values - taken))
