"""Judge a log again with the named effects in the model."""

from collections.abc import Mapping
from dataclasses import replace
from functools import reduce
from operator import add
from typing import Any

import numpy as np

from pitotbench.effects import EFFECTS, AircraftEffect, AirEffect, Overlay, SensorEffect
from pitotbench.reconcile.decide.judgment import judge
from pitotbench.reconcile.decide.naming import Naming
from pitotbench.reconcile.null_flights.null_distribution import NullDistribution
from pitotbench.reconcile.residuals.free_parameters import AnalysisSetting
from pitotbench.reconcile.residuals.layout import Layout, lay_out
from pitotbench.reconcile.residuals.scene import AircraftModel
from pitotbench.reconcile.signatures.hypotheses import COUNTED
from pitotbench.reconcile.signatures.refine import without_sensor_effect
from pitotbench.reconcile.signatures.signatures import moves_levers, residual_change
from pitotbench.records.log import FlightLog
from pitotbench.records.motion import Motion, Reaction, UnitForces
from pitotbench.records.verdict import Verdict

Entries = Mapping[str, Mapping[str, float]]  # effects with their sizes and shapes


def look_again(
    log: FlightLog,
    aircraft: AircraftModel | None,
    null: NullDistribution,
    setting: AnalysisSetting,
    entries: Entries,
) -> tuple[Verdict, Naming]:
    """Return the verdict on a log once effects are in the model.

    Effects of the aircraft go on the force meter; those of the sensors and the air are subtracted from the
    residuals. Effects that are counted and not fitted stay in the verdict.
    """
    fitted = {n: s for n, s in entries.items() if n not in COUNTED}
    not_on_model = {n: s for n, s in fitted.items() if force_meter_overlay(aircraft, n, s) is None}
    layout = lay_out(log, patched_aircraft(aircraft, fitted), setting)
    return judge(without_effects(layout, not_on_model), null)


def patched_aircraft(aircraft: AircraftModel | None, entries: Entries) -> AircraftModel | None:
    """Return the aircraft with the overlays of the effects that act on it."""
    if aircraft is None:
        return None
    overlays = [o for n, s in entries.items() if (o := force_meter_overlay(aircraft, n, s)) is not None]
    if not overlays:
        return aircraft
    patch, react, unit_forces = reduce(add, overlays), aircraft.react, aircraft.unit_forces

    def with_patch(motion: Motion, overlay: Overlay, *engines: Any) -> Reaction:
        return react(motion, patch + overlay, *engines)

    def units_with_patch(motion: Motion, overlay: Overlay, paths: frozenset[str]) -> UnitForces:
        return unit_forces(motion, patch + overlay, paths)

    return replace(aircraft, react=with_patch, unit_forces=units_with_patch)


def force_meter_overlay(aircraft: AircraftModel | None, name: str, sizes: Mapping[str, float]) -> Overlay | None:
    """Return the overlay that an effect puts on the force meter.

    None for effects of the sensors and the air, and for a lever that does not stand where its throttle plate does:
    the log holds the plates.
    """
    effect = EFFECTS[name]
    if aircraft is None or not isinstance(effect, AircraftEffect) or isinstance(effect, AirEffect):
        return None
    overlay = effect.overlay(sizes, aircraft.baseline)
    return None if moves_levers(overlay) else overlay


def without_effects(layout: Layout, entries: Entries) -> Layout:
    """Return a layout with the changes by some effects, in the order given, subtracted from its residuals."""
    original, changes = layout, np.zeros_like(layout.residuals.values)
    for name, sizes in entries.items():
        effect = EFFECTS[name]
        if isinstance(effect, SensorEffect):
            layout = without_sensor_effect(layout, original, name, sizes)
        change = residual_change(effect, layout.scene, effect.complete(sizes))
        changes = changes if change is None else changes + change
    return replace(layout, residuals=replace(layout.residuals, values=layout.residuals.values - changes))
