"""Renew signatures at the size that was fitted, and at the time when the effect happened."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pitotbench.channels import CHANNELS
from pitotbench.effects import Effect, Overlay, SensorEffect, Signals, effect_of
from pitotbench.reconcile.decide.normal_equations import equations_from, inner_products
from pitotbench.reconcile.decide.scoring import merit
from pitotbench.reconcile.residuals.clean import clean_track
from pitotbench.reconcile.residuals.free_parameters import free_parameters_of
from pitotbench.reconcile.residuals.layout import Layout, mean_wind_of, without_error_curve
from pitotbench.reconcile.residuals.predicted_channels import channel_residuals
from pitotbench.reconcile.residuals.replay import answer, motion_of
from pitotbench.reconcile.residuals.scene import ForceModel, Scene
from pitotbench.reconcile.residuals.track import Track
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

UNDOINGS = 2  # rounds of taking effects out of a track: what they add depends on the track without them

Shapes = dict[str, float]
Entries = Mapping[str, Mapping[str, float]]  # effects with their sizes and shapes


def at_sizes(layout: Layout, sizes: Mapping[tuple[str, str], float], shapes: Entries | None = None) -> Layout:
    """Return the layout with signatures renewed at fitted sizes, keyed by effect and parameter.

    Sizes outside the plausible range are taken at its end. `shapes` holds the shapes by effect, where they are not
    those of the signatures.
    """
    signatures = list(layout.signatures)
    for i, old in enumerate(signatures):
        if (old.effect, old.parameter) in sizes:
            own = (shapes or {}).get(old.effect, old.shapes)
            signatures[i] = _renewed(layout.scene, old, sizes[old.effect, old.parameter], own)
    if all(new is old for new, old in zip(signatures, layout.signatures, strict=True)):
        return layout
    return replace(layout, signatures=tuple(signatures))


def without_sensor_effects(original: Layout, entries: Entries) -> Layout:
    """Return the layout around the log without some effects on the sensors, at sizes that were fitted.

    The effects are taken out of the channels of the log, with the error curve that they feigned, and the model is
    moved along the corrected track. So its answer is exact there: no slope tells that a propeller meets its stop
    a second later. Signatures, free parameters and residuals are those of the corrected log. The change that the
    effects make is added to the residuals again, so that the sizes to be fitted stay whole sizes.
    `original` is the layout before any effect was taken out, but with those that are in the model. Effects that are
    not on the sensors change nothing.
    """
    corrected = with_corrected_track(original, entries)
    if corrected is original:
        return original
    values = corrected.residuals.values + sensor_change(corrected.scene, entries)
    return replace(corrected, track=original.track, residuals=replace(corrected.residuals, values=values))


def with_corrected_track(original: Layout, entries: Entries) -> Layout:
    """Return the layout of the log from whose channels some effects on the sensors were taken out.

    Effects that are not on the sensors change nothing.
    """
    if not any(isinstance(effect_of(name), SensorEffect) and sizes for name, sizes in entries.items()):
        return original
    old = original.scene
    track, clean, curves = original.track, old.clean, original.curves
    for _ in range(UNDOINGS):
        shift = _shift(clean, entries)
        undone = {name: original.track[name] - moved for name, moved in shift.items()}
        bare = original.track.replaced(undone)
        track, further = without_error_curve(bare, original.measured, original.setting)
        curves = (*original.curves, *further)
        clean = clean_track(track, mean_wind_of(track, original.measured))
    scene = replace(old, clean=clean, force_model=_moved_along(track, old.force_model))
    scene = replace(scene, base=channel_residuals(clean, scene.grid, scene.frame, scene.replay))
    values = scene.residuals_of(track).values - original.subtracted
    free = free_parameters_of(scene, original.setting, original.shapes)
    return replace(
        original,
        track=track,
        scene=scene,
        residuals=replace(original.residuals, values=values),
        free=free.with_columns(original.free.beyond(free.names)),
        signatures=tuple(_from_scene(scene, s) for s in original.signatures),
        curves=curves,
    )


def sensor_change(scene: Scene, entries: Entries) -> Array:
    """Return the change of the residuals by effects on the sensors together, (n, c); other effects do not count."""
    clean = scene.clean
    return scene.change_by(clean.replaced({n: clean[n] + moved for n, moved in _shift(clean, entries).items()}))


def _shift(clean: Track, entries: Entries) -> dict[str, Array]:
    """What effects on the sensors, one after the other, add to each channel of a clean track that they change.

    Effects that need a channel which the track lacks do not act.
    """
    signals = Signals(clean.time, clean.channels)
    for name, sizes in entries.items():
        effect = effect_of(name)
        if isinstance(effect, SensorEffect) and all(n in signals for n in (*effect.needs, *effect.changes)):
            signals = effect.apply(signals, sizes)
    changed = [name for name in signals if signals[name] is not clean[name]]
    turns = 2.0 * np.pi  # an angle that starts again at a full turn has not moved by one
    return {
        n: np.mod(signals[n] - clean[n] + np.pi, turns) - np.pi if CHANNELS[n].wraps else signals[n] - clean[n]
        for n in changed
    }


def _moved_along(track: Track, model: ForceModel | None) -> ForceModel | None:
    """The force model with its answer along another track; its slopes are those of the log."""
    if model is None:
        return None
    react, old = model.aircraft.react, model.replay
    motion = motion_of(track, old.rows)
    values = answer(lambda states: react(states, Overlay(), True), motion)
    return replace(model, replay=replace(old, motion=motion, values=values))


def _from_scene(scene: Scene, old: Signature) -> Signature:
    """The signature from another clean track, which changes effects on the sensors only."""
    effect = FITTED[old.effect]
    if not isinstance(effect, SensorEffect):
        return old
    moved = residual_change(effect, scene, effect.complete({**old.shapes, old.parameter: old.size}))
    return old if moved is None else replace(old, column=moved / old.size)


def _renewed(scene: Scene, old: Signature, size: float, shapes: Mapping[str, float]) -> Signature:
    effect = FITTED[old.effect]
    parameter = effect.parameter(old.parameter)
    least = SMALLEST * abs(parameter.typical)
    size = float(np.clip(size, parameter.low, parameter.high))
    size = float(np.copysign(max(abs(size), least), size))
    near = abs(size - old.size) < max(least, LINEAR_WITHIN[effect.acts_on] * abs(old.size))
    if near and shapes == old.shapes:
        return old
    moved = residual_change(effect, scene, effect.complete({**shapes, old.parameter: size}))
    if moved is None or not np.any(moved):
        return old if shapes == old.shapes else replace(old, column=np.zeros_like(old.column), shapes=dict(shapes))
    return replace(old, size=size, column=moved / size, shapes=dict(shapes))


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
