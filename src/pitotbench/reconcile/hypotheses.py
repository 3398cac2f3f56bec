"""Every effect of the table as a hypothesis: its signature is what the effect's own code does to the residuals.

One mechanism for all. An effect on the sensors acts on the clean track, an effect in the air adds its wind, an
effect on the aircraft changes what the force meter says; the residuals with it less those without it, for each
size.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from pitotbench import air
from pitotbench.catalog import Catalog
from pitotbench.effects import AircraftEffect, AirEffect, Baseline, Effect, Overlay, SensorEffect, Signals
from pitotbench.reconcile.channels import Frame, Residuals, residuals
from pitotbench.reconcile.clean import clean_track
from pitotbench.reconcile.grid import Grid, grid_of
from pitotbench.reconcile.nuisance import in_triangle
from pitotbench.reconcile.replay import COARSE, Replay, answer, motion_of, replay_rows, spread
from pitotbench.reconcile.track import Track, mach_number
from pitotbench.records.motion import Motion, Reaction
from pitotbench.units import Array

OF_THE_AIR = ("fcs/flap", "fcs/gear", "gear/")  # what is set there moves no engine
THROTTLE_BIAS = {"ap/throttle-bias-left-norm": 1.0, "ap/throttle-bias-right-norm": -1.0}

# An aircraft with an overlay on it as a force meter, its engines running along or not.
ReactWith = Callable[[Motion, Overlay, bool], Reaction]


@dataclass(frozen=True, slots=True)
class AircraftModel:
    """An aircraft as the room knows it: a force meter with overlays, and what effects must know of it."""

    name: str
    react: ReactWith
    baseline: Baseline


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
    coarse: Motion | None  # the clean track's, in coarse steps
    plain: Array | None  # what the untouched aircraft answers to it
    held: Array | None  # the same with its engines held


def scene(track: Track, wind: Array, model: Replay | None, aircraft: AircraftModel | None) -> Scene:
    """The scene of a track: wind toward north, east, down [m/s], (3,), for the clean track."""
    grid = grid_of(track)
    frame = Frame.of(track, grid)
    clean = clean_track(track, wind)
    base = residuals(clean, grid, frame, model)
    if aircraft is None:
        return Scene(clean, grid, frame, model, base, None, None, None, None, None)
    coarse = motion_of(clean, replay_rows(clean, COARSE))
    react = aircraft.react
    plain = answer(lambda motion: react(motion, Overlay(), True), coarse)
    held = answer(lambda motion: react(motion, Overlay(), False), coarse)
    return Scene(clean, grid, frame, model, base, react, aircraft.baseline, coarse, plain, held)


@dataclass(frozen=True, slots=True)
class Signature:
    """What one unit of a parameter of an effect does to the residuals, (n, c), as a share of what `size` units do;
    `shapes` are the effect's shapes where they are not typical."""

    effect: str
    parameter: str
    size: float
    column: Array
    shapes: Mapping[str, float] = field(default_factory=dict)


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
    moved = change(scene, effect, effect.complete({parameter: size}))
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
    if effect.wind is not None:
        wind = effect.wind(Signals(scene.clean.time, scene.clean.channels), sizes)
        seen = np.stack([scene.grid.smooth(np.asarray(part)) for part in wind], axis=1)
        return in_triangle(seen, scene.frame, scene.base)
    warmer = effect.overlay(sizes, scene.baseline or Baseline("none", (0.0, 0.0, 0.0))).temperature_offset
    return _warmed(scene, warmer) if warmer else None


def _warmed(scene: Scene, warmer: float) -> Array | None:
    """A warmer column of air between standard pressure at sea level and the airplane: H_p = h T₀/(T₀ + ΔT)."""
    names = scene.base.names
    if "pressure_height" not in names or "temperature" not in names:
        return None
    lower = scene.grid.smooth(scene.clean["altitude"]) * warmer / (air.SEA_LEVEL_TEMPERATURE + warmer)
    moved = np.zeros_like(scene.base.values)
    moved[:, names.index("pressure_height")] = -lower
    mach = scene.grid.smooth(mach_number(scene.clean))  # a warmer air warms more at the probe
    moved[:, names.index("temperature")] = air.total_temperature(warmer - air.LAPSE_RATE * lower, mach)
    return moved


def _felt(scene: Scene, effect: AircraftEffect, sizes: dict[str, float]) -> Array | None:
    """The measured motion is the same; the aircraft that felt it was another, which the model does not know."""
    if (
        scene.model is None
        or scene.react is None
        or scene.baseline is None
        or scene.coarse is None
        or scene.plain is None
        or scene.held is None
    ):
        return None
    overlay, react = effect.overlay(sizes, scene.baseline), scene.react
    split = _throttle_split(overlay)
    if split is not None:
        return _in_split(scene, split)
    run = not _leaves_engines(overlay)
    missed = (scene.plain if run else scene.held) - answer(lambda m: react(m, overlay, run), scene.coarse)
    rows = replay_rows(scene.clean, COARSE)
    model = replace(scene.model, values=scene.model.values + spread(scene.model.rows, rows, missed))
    return residuals(scene.clean, scene.grid, scene.frame, model).values - scene.base.values


def _leaves_engines(overlay: Overlay) -> bool:
    """Whether an overlay adds forces and moments of the air only, so that thrust falls out of the difference."""
    elsewhere = [s for s in overlay.settings if not s.path.startswith(OF_THE_AIR)]
    return not (elsewhere or overlay.masses or overlay.forces or overlay.filters)


def moves_levers(overlay: Overlay) -> bool:
    """Whether all that an overlay sets is where the plates stand against the levers."""
    return bool(overlay.settings) and all(setting.path in THROTTLE_BIAS for setting in overlay.settings)


def _throttle_split(overlay: Overlay) -> float | None:
    """Left less right throttle where an overlay moves the plates against the levers: the measured plates already
    stand where they stand, so that only their difference tells."""
    if not moves_levers(overlay):
        return None
    paths = dict.fromkeys(setting.path for setting in overlay.settings)
    values = dict(overlay.sizes).values()
    return sum(THROTTLE_BIAS[path] * value for path, value in zip(paths, values, strict=False))


def _in_split(scene: Scene, split: float) -> Array | None:
    if "throttle_split" not in scene.base.names:
        return None
    moved = np.zeros_like(scene.base.values)
    moved[:, scene.base.names.index("throttle_split")] = split
    return moved
