"""Every effect of the table as a hypothesis: its signature is what the effect's own code does to the residuals.

One mechanism for all. An effect on the sensors acts on the clean track, an effect in the air adds its wind, an effect
on the aircraft changes what the force meter says; the residuals with it less those without it, for each size.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pitotbench.catalog import Catalog
from pitotbench.effects import AircraftEffect, AirEffect, Baseline, Effect, Overlay, SensorEffect, Signals
from pitotbench.reconcile.channels import Frame, Residuals, residuals
from pitotbench.reconcile.grid import Grid
from pitotbench.reconcile.nuisance import in_triangle
from pitotbench.reconcile.replay import COARSE, Replay, answer, motion_of, replay_rows, spread
from pitotbench.reconcile.track import Track
from pitotbench.records.motion import Motion, Reaction
from pitotbench.units import Array

ReactWith = Callable[[Motion, Overlay], Reaction]  # an aircraft with an overlay on it as a force meter


@dataclass(frozen=True, slots=True)
class Scene:
    """All that a signature is computed from; `react` and `baseline` are None where there is no aircraft model."""

    clean: Track
    grid: Grid
    frame: Frame
    model: Replay | None
    base: Residuals  # of the clean track
    react: ReactWith | None
    baseline: Baseline | None


@dataclass(frozen=True, slots=True)
class Signature:
    """What one unit of a parameter of an effect does to the residuals, (n, c), in whose linearization at `size`."""

    effect: str
    parameter: str
    size: float
    column: Array


def signatures(scene: Scene, effects: Catalog[Effect]) -> tuple[Signature, ...]:
    """A signature for each size of each effect that this log can show."""
    return tuple(s for effect in effects.values() for s in _of_effect(scene, effect))


def _of_effect(scene: Scene, effect: Effect) -> Iterator[Signature]:
    for parameter in effect.parameters:
        if not parameter.shape:
            found = signature(scene, effect, parameter.name, parameter.typical)
            if found is not None:
                yield found


def signature(scene: Scene, effect: Effect, parameter: str, size: float) -> Signature | None:
    """The signature of one parameter at a size, the effect's other sizes zero and its shapes typical; None where
    this log cannot show it (a channel it changes is missing, or nothing moves)."""
    sizes = {p.name: p.typical if p.shape else 0.0 for p in effect.parameters} | {parameter: size}
    moved = change(scene, effect, sizes)
    if moved is None or not np.any(np.abs(moved) > 0.0):
        return None
    return Signature(effect.name, parameter, size, moved / size)


def change(scene: Scene, effect: Effect, sizes: dict[str, float]) -> Array | None:
    """What an effect of these sizes changes in the residuals, (n, c); None where this log cannot show it."""
    if isinstance(effect, SensorEffect):
        return _sensed(scene, effect, sizes)
    if isinstance(effect, AirEffect):
        return _blown(scene, effect, sizes)
    return _felt(scene, effect, sizes) if isinstance(effect, AircraftEffect) else None


def _sensed(scene: Scene, effect: SensorEffect, sizes: dict[str, float]) -> Array | None:
    clean = scene.clean
    if not all(name in clean for name in (*effect.needs, *effect.changes)):
        return None
    applied = effect.apply(Signals(clean.time, clean.channels), sizes)
    changed = {name: applied[name] for name in applied if applied[name] is not clean.channels.get(name)}
    after = residuals(clean.replaced(changed), scene.grid, scene.frame, scene.model)
    return after.values - scene.base.values


def _blown(scene: Scene, effect: AirEffect, sizes: dict[str, float]) -> Array | None:
    if effect.wind is None:
        return None
    wind = effect.wind(Signals(scene.clean.time, scene.clean.channels), sizes)
    seen = np.stack([scene.grid.smooth(np.asarray(part)) for part in wind], axis=1)
    return in_triangle(seen, scene.frame, scene.base)


def _felt(scene: Scene, effect: AircraftEffect, sizes: dict[str, float]) -> Array | None:
    """The measured motion is the same; the aircraft that felt it was another, which the model does not know."""
    if scene.model is None or scene.react is None or scene.baseline is None:
        return None
    overlay = effect.overlay(sizes, scene.baseline)
    rows = replay_rows(scene.clean, COARSE)
    motion = motion_of(scene.clean, rows)
    react = scene.react
    with_it = answer(lambda m: react(m, overlay), motion)
    without = answer(lambda m: react(m, Overlay()), motion)
    shifted = replace(scene.model, values=scene.model.values + _spread(scene.model, rows, without - with_it))
    return residuals(scene.clean, scene.grid, scene.frame, shifted).values - scene.base.values


def _spread(model: Replay, rows: NDArray[np.intp], values: Array) -> Array:
    return spread(model.rows, rows, values)
