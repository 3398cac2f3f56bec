"""Lay a log out again with the named effects in the model."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import reduce
from operator import add
from typing import Any

from pitotbench.catalog import Catalog
from pitotbench.effects import AircraftEffect, AirEffect, Effect, Overlay, SensorEffect, effect_of
from pitotbench.reconcile.residuals.free_parameters import AnalysisSetting
from pitotbench.reconcile.residuals.layout import Layout, lay_out, with_aircraft
from pitotbench.reconcile.residuals.scene import AircraftModel
from pitotbench.reconcile.signatures.added_forces import adds_forces
from pitotbench.reconcile.signatures.hypotheses import COUNTED
from pitotbench.reconcile.signatures.refine import Entries, with_corrected_track
from pitotbench.reconcile.signatures.signatures import acts_on_engines_alone, moves_levers, residual_change
from pitotbench.records.log import FlightLog
from pitotbench.records.motion import Motion, Reaction, UnitForces
from pitotbench.units import Array

NO_EFFECTS: Catalog[Effect] = Catalog("effect", {})


def with_effects(layout: Layout, aircraft: AircraftModel | None, entries: Entries) -> Layout:
    """Return the layout of a log once effects are in the model; `layout` is that of the log without them.

    Effects of the aircraft go on the force meter; those of the sensors and the air are subtracted from the
    residuals. Effects that are counted and not fitted stay in the log.
    """
    fitted = {n: s for n, s in entries.items() if n not in COUNTED}
    overlays = {n: force_meter_overlay(aircraft, n, s) for n, s in fitted.items()}
    not_on_model = {n: s for n, s in fitted.items() if overlays[n] is None}
    patch = [overlay for overlay in overlays.values() if overlay is not None]
    if aircraft is not None and patch:
        kept = _unmoved(layout, patch)
        layout = with_aircraft(layout, patched_aircraft(aircraft, reduce(add, patch)), kept)
    sizes = {
        (name, p.name): float(given[p.name])
        for name, given in fitted.items()
        for p in effect_of(name).parameters
        if not p.shape and p.name in given
    }
    return replace(without_effects(layout, not_on_model), in_model=sizes)


def lay_out_with(
    log: FlightLog, aircraft: AircraftModel | None, setting: AnalysisSetting, entries: Entries
) -> Layout:
    """Return another log laid out with effects in the model, without any hypothesis.

    Raises BadInputError for a log that cannot be compared.
    """
    fitted = {n: s for n, s in entries.items() if n not in COUNTED}
    overlays = {n: force_meter_overlay(aircraft, n, s) for n, s in fitted.items()}
    patch = [overlay for overlay in overlays.values() if overlay is not None]
    if aircraft is not None and patch:
        aircraft = patched_aircraft(aircraft, reduce(add, patch))
    layout = lay_out(log, aircraft, setting, NO_EFFECTS)
    return without_effects(layout, {n: s for n, s in fitted.items() if overlays[n] is None})


def _unmoved(layout: Layout, patch: Sequence[Overlay]) -> dict[Overlay, Array]:
    """The changes that a patch does not move: those by the engines, where the patch only adds forces."""
    if layout.scene.force_model is None or not all(adds_forces(overlay) for overlay in patch):
        return {}
    kept = layout.scene.force_model.kept
    return {overlay: change for overlay, change in kept.items() if acts_on_engines_alone(overlay)}


def patched_aircraft(aircraft: AircraftModel, patch: Overlay) -> AircraftModel:
    """Return the aircraft with an overlay on it."""
    react, unit_forces = aircraft.react, aircraft.unit_forces

    def with_patch(motion: Motion, overlay: Overlay, *engines: Any) -> Reaction:
        return react(motion, patch + overlay, *engines)

    def units_with_patch(motion: Motion, overlay: Overlay, paths: frozenset[str]) -> UnitForces:
        return unit_forces(motion, patch + overlay, paths)

    return replace(aircraft, react=with_patch, unit_forces=units_with_patch)


def force_meter_overlay(aircraft: AircraftModel | None, name: str, sizes: Mapping[str, float]) -> Overlay | None:
    """Return the overlay that an effect puts on the force meter.

    None for effects of the sensors and the air, for those of a part of the flight, because the force meter knows no
    time, and for a lever that does not stand where its throttle plate does: the log holds the plates.
    """
    effect = effect_of(name)
    if (
        aircraft is None
        or not isinstance(effect, AircraftEffect)
        or isinstance(effect, AirEffect)
        or effect.part_of
    ):
        return None
    overlay = effect.overlay(sizes, aircraft.baseline)
    return None if moves_levers(overlay) else overlay


def without_effects(layout: Layout, entries: Entries) -> Layout:
    """Return a layout without some effects: those on the sensors are taken out of its track, together.

    The changes by others are subtracted from the residuals, and stay so when a later look moves the track.
    """
    layout = with_corrected_track(layout, entries)
    changes = layout.scene.blank()
    for name, sizes in entries.items():
        effect = effect_of(name)
        if not isinstance(effect, SensorEffect):
            change = residual_change(effect, layout.scene, effect.complete(sizes))
            changes = changes if change is None else changes + change
    return replace(
        layout,
        residuals=replace(layout.residuals, values=layout.residuals.values - changes),
        subtracted=layout.subtracted + changes,
    )
