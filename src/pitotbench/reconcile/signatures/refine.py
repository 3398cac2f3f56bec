"""Renew signatures at the size that was fitted, and at the time when the effect happened."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pitotbench.effects import Effect, SensorEffect, Signals
from pitotbench.reconcile.decide.normal_equations import equations_from, inner_products
from pitotbench.reconcile.decide.scoring import merit
from pitotbench.reconcile.residuals.clean import clean_track
from pitotbench.reconcile.residuals.free_parameters import FreeParameters, free_parameters_of
from pitotbench.reconcile.residuals.layout import Layout, mean_wind_of
from pitotbench.reconcile.residuals.scene import Scene
from pitotbench.reconcile.residuals.whitening import NoiseModel
from pitotbench.reconcile.signatures.hypotheses import FITTED, searched_shapes
from pitotbench.reconcile.signatures.signatures import Signature, residual_change
from pitotbench.units import Array, Seconds

EVENT_TRIALS = 14  # times over the log at which an event is tried first: one every 10 to 30 s
TRIAL_FACTORS = np.array([0.6, 0.8, 1.2, 1.4])  # times the typical value of a shape that is not a time
HALVINGS = 3  # of the steps around the best shape
LINEAR_WITHIN = {
    "sensors": 0.1,
    "air": 0.1,
    "aircraft": 0.6,
}  # change of a size, as a share, without a new signature
SMALLEST = 0.05  # of the typical size; signatures of smaller sizes would be differences of rounded numbers

Shapes = dict[str, float]


def at_sizes(layout: Layout, sizes: Mapping[tuple[str, str], float]) -> Layout:
    """Return the layout with signatures renewed at fitted sizes, keyed by effect and parameter.

    Sizes outside the plausible range are taken at its end.
    """
    signatures = list(layout.signatures)
    for i, old in enumerate(signatures):
        if (old.effect, old.parameter) in sizes:
            signatures[i] = _renewed(layout.scene, old, sizes[old.effect, old.parameter])
    if all(new is old for new, old in zip(signatures, layout.signatures, strict=True)):
        return layout
    return replace(layout, signatures=tuple(signatures))


def without_sensor_effect(layout: Layout, original: Layout, name: str, sizes: Mapping[str, float]) -> Layout:
    """Return the layout with an effect on the sensors subtracted from its clean track.

    `original` is the layout before any effect was subtracted. Signatures of the other effects on the sensors are
    then computed from signals without that effect. A large effect would otherwise bend all of them.
    """
    effect, old = FITTED[name], original.scene
    if not isinstance(effect, SensorEffect) or not sizes:
        return layout if layout.scene is old else _in_scene(layout, old, original.free)
    applied = effect.apply(Signals(old.clean.time, old.clean.channels), sizes)
    undone = {n: 2.0 * v - applied[n] for n, v in old.clean.channels.items() if applied[n] is not v}
    track = layout.track.replaced({n: layout.track[n] + undone[n] - old.clean[n] for n in undone})
    clean = clean_track(track, mean_wind_of(track))
    new = replace(old, clean=clean, base=old.residuals_of(clean))
    return _in_scene(layout, new, free_parameters_of(new, layout.setting, layout.shapes))


def _in_scene(layout: Layout, scene: Scene, free: FreeParameters) -> Layout:
    """The layout with its signatures computed from another scene."""
    signatures = tuple(_from_scene(scene, s) for s in layout.signatures)
    return replace(layout, scene=scene, free=free, signatures=signatures)


def _from_scene(scene: Scene, old: Signature) -> Signature:
    """The signature from another clean track, which changes effects on the sensors only."""
    effect = FITTED[old.effect]
    if not isinstance(effect, SensorEffect):
        return old
    moved = residual_change(effect, scene, effect.complete({**old.shapes, old.parameter: old.size}))
    return old if moved is None else replace(old, column=moved / old.size)


def _renewed(scene: Scene, old: Signature, size: float) -> Signature:
    effect = FITTED[old.effect]
    parameter = effect.parameter(old.parameter)
    least = SMALLEST * abs(parameter.typical)
    size = float(np.clip(size, parameter.low, parameter.high))
    size = float(np.copysign(max(abs(size), least), size))
    if abs(size - old.size) < max(least, LINEAR_WITHIN[effect.acts_on] * abs(old.size)):
        return old
    moved = residual_change(effect, scene, effect.complete({**old.shapes, old.parameter: size}))
    if moved is None or not np.any(moved):
        return old
    return replace(old, size=size, column=moved / size)


def placed_in_time(layout: Layout, noise: NoiseModel) -> Layout:
    """Return the layout with every effect that has shapes (a time, a damping) at the best-fitting ones."""
    signatures, trials = list(layout.signatures), Trials(layout, noise)
    for effect in FITTED.values():
        columns = [i for i, s in enumerate(signatures) if s.effect == effect.name]
        if columns and searched_shapes(effect):
            best = _search(trials, effect, [signatures[i] for i in columns])
            for i, renewed in zip(columns, best, strict=True):
                signatures[i] = renewed
    return replace(layout, signatures=tuple(signatures))


@dataclass(frozen=True, slots=True)
class Trial:
    """An effect at some shapes: its signatures and their merit."""

    shapes: Shapes
    signatures: list[Signature]
    merit: float


def _search(trials: "Trials", effect: Effect, start: Sequence[Signature]) -> list[Signature]:
    """Search the shapes of an effect: the first one in coarse steps, then all in halved steps around the best.

    A first shape that is a time is tried over the whole log.
    """
    shapes = searched_shapes(effect)
    first = shapes[0]
    best = trials.at(effect, start, {p.name: p.typical for p in shapes})
    steps = {p.name: p.typical for p in shapes}
    if first.name.endswith("_s"):
        time = trials.time
        ladder = np.linspace(time[0], time[-1], EVENT_TRIALS + 2)[1:-1]
    else:
        ladder = np.clip(first.typical * TRIAL_FACTORS, first.low, first.high)
    steps[first.name] = float(ladder[1] - ladder[0])
    candidates = [{**best.shapes, first.name: float(t)} for t in ladder]
    for _ in range(HALVINGS + 1):
        for candidate in candidates:
            trial = trials.at(effect, start, candidate)
            best = trial if trial.merit > best.merit else best
        steps = {name: 0.5 * step for name, step in steps.items()}
        candidates = [
            {**best.shapes, p.name: float(np.clip(best.shapes[p.name] + sign * steps[p.name], p.low, p.high))}
            for p in shapes
            for sign in (-1.0, 1.0)
        ]
    return best.signatures


def _with_shapes(scene: Scene, effect: Effect, old: Signature, shapes: Shapes) -> Signature:
    moved = residual_change(effect, scene, effect.complete({**shapes, old.parameter: old.size}))
    column = np.zeros_like(old.column) if moved is None else moved / old.size
    return replace(old, column=column, shapes=dict(shapes))


class Trials:
    """The merit of signatures that are not in the layout, which is whitened and fitted once."""

    def __init__(self, layout: Layout, noise: NoiseModel) -> None:
        self._layout = layout
        self._whiten = noise.whitener(layout.grid, layout.residuals.slack)
        residual = self._whiten(layout.residuals.values)
        self._known = np.concatenate([self._whiten(layout.free.columns), residual[:, :, None]], axis=2)
        self._products = inner_products(self._known, residual, blocks=1)[0, :-1, :-1]

    @property
    def time(self) -> Seconds:
        """Time of the instants from the start of the log [s], (n,)."""
        return np.asarray(self._layout.track.time[self._layout.grid.rows] - self._layout.track.time[0])

    def at(self, effect: Effect, start: Sequence[Signature], shapes: Shapes) -> Trial:
        """Return an effect at some shapes."""
        signatures = [_with_shapes(self._layout.scene, effect, s, shapes) for s in start]
        return Trial(shapes, signatures, self._merit([s.column for s in signatures]))

    def _merit(self, columns: Sequence[Array]) -> float:
        new = self._whiten(np.stack(columns, axis=2)).reshape(-1, len(columns))
        across = self._known.reshape(len(new), -1).T @ new
        free, k = self._layout.free, len(columns)
        first = len(free.names)  # of the new columns, which stand between the free parameters and the residual
        order = [*range(first), *range(first + 1, first + 1 + k), first]
        products = np.block([[self._products, across], [across.T, new.T @ new]])[np.ix_(order, order)]
        return merit(equations_from(products[None], first, free.deviations).fit(range(k)))
