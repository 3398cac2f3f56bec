"""Renew signatures at the size that was fitted, and at the time when the effect happened."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from pitotbench.effects import Effect, SensorEffect, Signals
from pitotbench.reconcile.decide.normal_equations import equations_from, inner_products
from pitotbench.reconcile.decide.scoring import merit
from pitotbench.reconcile.residuals.clean import clean_track
from pitotbench.reconcile.residuals.free_parameters import FreeParameters, free_parameters_of
from pitotbench.reconcile.residuals.layout import FITTED, Layout, mean_wind, searched
from pitotbench.reconcile.residuals.predicted_channels import channel_residuals
from pitotbench.reconcile.residuals.whitening import NoiseModel
from pitotbench.reconcile.signatures.signatures import Scene, Signature, change
from pitotbench.units import Array

LOOKS = 14  # times over the log at which an event is tried first
STEPS = np.array([0.6, 0.8, 1.2, 1.4])  # times the typical value of a shape that is no time
HALVINGS = 3
LINEAR_WITHIN = {"sensors": 0.1, "air": 0.1, "aircraft": 0.6}  # share of a size over which its signature serves
SMALLEST = 0.05  # of the typical size: below it a signature is taken at this size


def at_sizes(layout: Layout, sizes: Mapping[tuple[str, str], float]) -> Layout:
    """Return the study with signatures renewed at fitted sizes, keyed by effect and parameter.

    Sizes outside the plausible range are taken at its end.
    """
    found = list(layout.signatures)
    for i, old in enumerate(found):
        if (old.effect, old.parameter) in sizes:
            found[i] = _renewed(layout.scene, old, sizes[old.effect, old.parameter])
    if all(new is old for new, old in zip(found, layout.signatures, strict=True)):
        return layout
    return replace(layout, signatures=tuple(found))


def without(layout: Layout, seen: Layout, name: str, sizes: Mapping[str, float]) -> Layout:
    """Return the study with an effect on the sensors taken out of its clean track; `seen` is the study as laid out.

    Signatures of the other effects on the sensors are then computed from signals without that effect. A large
    effect would otherwise bend all of them.
    """
    effect, old = FITTED[name], seen.scene
    if not isinstance(effect, SensorEffect) or not sizes:
        return layout if layout.scene is old else _from(layout, old, seen.nuisance)
    applied = effect.apply(Signals(old.clean.time, old.clean.channels), sizes)
    undone = {n: 2.0 * v - applied[n] for n, v in old.clean.channels.items() if applied[n] is not v}
    track = layout.track.replaced({n: layout.track[n] + undone[n] - old.clean[n] for n in undone})
    clean = clean_track(track, mean_wind(track))
    base = channel_residuals(clean, old.grid, old.frame, old.model)
    new = replace(old, clean=clean, base=base)
    unknown = free_parameters_of(clean, old.grid, old.frame, old.model, base, layout.known, layout.shapes)
    return _from(layout, new, unknown)


def _from(layout: Layout, scene: Scene, unknown: FreeParameters) -> Layout:
    """The study with its signatures computed from another scene."""
    found = tuple(_seen_from(scene, s) for s in layout.signatures)
    return replace(layout, scene=scene, nuisance=unknown, signatures=found)


def _seen_from(scene: Scene, old: Signature) -> Signature:
    """The signature from another clean track; it changes for effects on the sensors only."""
    effect = FITTED[old.effect]
    if not isinstance(effect, SensorEffect):
        return old
    moved = change(scene, effect, effect.complete({**old.shapes, old.parameter: old.size}))
    return old if moved is None else replace(old, column=moved / old.size)


def _renewed(scene: Scene, old: Signature, size: float) -> Signature:
    effect = FITTED[old.effect]
    parameter = effect.parameter(old.parameter)
    least = SMALLEST * abs(parameter.typical)
    size = float(np.clip(size, parameter.low, parameter.high))
    size = float(np.copysign(max(abs(size), least), size))
    if abs(size - old.size) < max(least, LINEAR_WITHIN[effect.acts_on] * abs(old.size)):
        return old
    moved = change(scene, effect, effect.complete({**old.shapes, old.parameter: size}))
    if moved is None or not np.any(moved):
        return old
    return replace(old, size=size, column=moved / size)


def placed_in_time(layout: Layout, noise: NoiseModel) -> Layout:
    """Return the study with every effect that has shapes (a time, a damping) at the best-fitting ones."""
    found, judged = list(layout.signatures), _Judge(layout, noise)
    for effect in FITTED.values():
        own = [i for i, s in enumerate(found) if s.effect == effect.name]
        if own and searched(effect):
            for i, renewed in zip(own, _search(layout, judged, effect, [found[i] for i in own]), strict=True):
                found[i] = renewed
    return replace(layout, signatures=tuple(found))


def _search(layout: Layout, judged: "_Judge", effect: Effect, own: Sequence[Signature]) -> list[Signature]:
    """Search the shapes of an effect: the first one in coarse steps, then all in halved steps around the best.

    A first shape that is a time is tried over the whole log.
    """
    shapes = searched(effect)
    time = layout.track.time[layout.grid.rows] - layout.track.time[0]
    first = shapes[0]
    best = {p.name: p.typical for p in shapes}

    def look(trial: Mapping[str, float]) -> tuple[float, list[Signature]]:
        columns = [_shaped(layout.scene, effect, s, trial) for s in own]
        return judged.merit([c.column for c in columns]), columns

    value, kept = look(best)
    steps = {p.name: p.typical for p in shapes}
    if first.name.endswith("_s"):
        ladder = np.linspace(time[0], time[-1], LOOKS + 2)[1:-1]
    else:
        ladder = np.clip(first.typical * STEPS, first.low, first.high)
    steps[first.name] = float(ladder[1] - ladder[0])
    trials = [{**best, first.name: float(t)} for t in ladder]
    for _ in range(HALVINGS + 1):
        for trial in trials:
            there, columns = look(trial)
            if there > value:
                value, kept, best = there, columns, dict(trial)
        steps = {name: 0.5 * step for name, step in steps.items()}
        trials = [
            {**best, p.name: float(np.clip(best[p.name] + sign * steps[p.name], p.low, p.high))}
            for p in shapes
            for sign in (-1.0, 1.0)
        ]
    return kept


def _shaped(scene: Scene, effect: Effect, old: Signature, shapes: Mapping[str, float]) -> Signature:
    moved = change(scene, effect, effect.complete({**shapes, old.parameter: old.size}))
    column = np.zeros_like(old.column) if moved is None else moved / old.size
    return replace(old, column=column, shapes=dict(shapes))


class _Judge:
    """Computes the merit of columns that are not in the study yet."""

    def __init__(self, layout: Layout, noise: NoiseModel) -> None:
        self._layout, self._noise = layout, noise
        self._nuisances = self._white(layout.nuisance.columns)
        self._residual = self._white(layout.residuals.values)

    def _white(self, values: Array) -> Array:
        return self._noise.whiten(values, self._layout.grid, self._layout.residuals.slack)

    def merit(self, columns: Sequence[Array]) -> float:
        """Return the merit of some columns together."""
        new = self._white(np.stack(columns, axis=2))
        products = inner_products(np.concatenate([self._nuisances, new], axis=2), self._residual, blocks=1)
        k = self._nuisances.shape[2]
        return merit(equations_from(products, k, self._layout.nuisance.deviations).fit(range(len(columns))))
