"""Turn every effect of the table into a hypothesis, with a signature: what the effect does to the residuals.

A signature is the residuals with the effect less those without it, computed by the effect's code itself. An effect
on the sensors acts on the clean track, an effect in the air adds its wind, and an effect on the aircraft changes
the reaction of the force meter.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from pitotbench import air
from pitotbench.catalog import Catalog
from pitotbench.effects import AircraftEffect, AirEffect, Baseline, Effect, Overlay, SensorEffect, Signals
from pitotbench.reconcile.residuals.clean import clean_track
from pitotbench.reconcile.residuals.free_parameters import in_triangle
from pitotbench.reconcile.residuals.grid import Grid, grid_of
from pitotbench.reconcile.residuals.predicted_channels import ChannelResiduals, Frame, channel_residuals
from pitotbench.reconcile.residuals.replay import COARSE, Replay, answer, motion_of, replay_rows, spread
from pitotbench.reconcile.residuals.track import Track, mach_number
from pitotbench.records.motion import Motion, Reaction
from pitotbench.units import Array

OF_THE_AIR = ("fcs/flap", "fcs/gear", "gear/")  # settings of these paths move no engine
THROTTLE_BIAS = {"ap/throttle-bias-left-norm": 1.0, "ap/throttle-bias-right-norm": -1.0}

# The force meter: a motion, the overlay to put on the aircraft, and whether the engines run along.
ReactWith = Callable[[Motion, Overlay, bool], Reaction]


@dataclass(frozen=True, slots=True)
class AircraftModel:
    """An aircraft of the analyst: a force meter that takes overlays, and the data that effects need of it."""

    name: str
    react: ReactWith
    baseline: Baseline


@dataclass(frozen=True, slots=True)
class Scene:
    """The data that signatures are computed from; `react` and `baseline` are None without an aircraft model."""

    clean: Track
    grid: Grid
    frame: Frame
    model: Replay | None
    base: ChannelResiduals  # of the clean track
    react: ReactWith | None
    baseline: Baseline | None
    coarse: Motion | None  # of the clean track, in coarse steps
    plain: Array | None  # reaction of the untouched aircraft to it
    held: Array | None  # the same reaction with the engines held


def scene(track: Track, wind: Array, model: Replay | None, aircraft: AircraftModel | None) -> Scene:
    """Return the scene of a track; `wind` toward north, east, down [m/s], (3,), is that of the clean track."""
    grid = grid_of(track)
    frame = Frame.of(track, grid)
    clean = clean_track(track, wind)
    base = channel_residuals(clean, grid, frame, model)
    if aircraft is None:
        return Scene(clean, grid, frame, model, base, None, None, None, None, None)
    coarse = motion_of(clean, replay_rows(clean, COARSE))
    react = aircraft.react
    plain = answer(lambda motion: react(motion, Overlay(), True), coarse)
    held = answer(lambda motion: react(motion, Overlay(), False), coarse)
    return Scene(clean, grid, frame, model, base, react, aircraft.baseline, coarse, plain, held)


@dataclass(frozen=True, slots=True)
class Signature:
    """The change of the residuals by one unit of a parameter, `column` (n, c).

    It is the change by `size` units, divided by `size`, as effects are not quite linear. `shapes` holds the shapes
    of the effect that are not typical.
    """

    effect: str
    parameter: str
    size: float
    column: Array
    shapes: Mapping[str, float] = field(default_factory=dict)


def signatures_of(scene: Scene, effects: Catalog[Effect]) -> tuple[Signature, ...]:
    """Return a signature for each size parameter of each effect that this log can show."""
    return tuple(s for effect in effects.values() for s in _of_effect(scene, effect))


def _of_effect(scene: Scene, effect: Effect) -> Iterator[Signature]:
    for parameter in effect.parameters:
        if not parameter.shape:
            found = signature(scene, effect, parameter.name, parameter.typical)
            if found is not None:
                yield found


def signature(scene: Scene, effect: Effect, parameter: str, size: float) -> Signature | None:
    """Return the signature of one parameter at a size, the other sizes zero and the shapes typical.

    None where this log cannot show it: a channel that it changes is missing, or no residual moves.
    """
    moved = change(scene, effect, effect.complete({parameter: size}))
    if moved is None or not np.any(np.abs(moved) > 0.0):
        return None
    return Signature(effect.name, parameter, size, moved / size)


def change(scene: Scene, effect: Effect, sizes: dict[str, float]) -> Array | None:
    """Return the change of the residuals by an effect of these sizes, (n, c); None where the log cannot show it."""
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
    after = channel_residuals(clean.replaced(changed), scene.grid, scene.frame, scene.model)
    return after.values - scene.base.values


def _blown(scene: Scene, effect: AirEffect, sizes: dict[str, float]) -> Array | None:
    if effect.wind is not None:
        wind = effect.wind(Signals(scene.clean.time, scene.clean.channels), sizes)
        seen = np.stack([scene.grid.smooth(np.asarray(part)) for part in wind], axis=1)
        return in_triangle(seen, scene.frame, scene.base)
    warmer = effect.overlay(sizes, scene.baseline or Baseline("none", (0.0, 0.0, 0.0))).temperature_offset
    return _warmed(scene, warmer) if warmer else None


def _warmed(scene: Scene, warmer: float) -> Array | None:
    """The change by a warmer column of air from standard pressure at sea level up: H_p = h T₀/(T₀ + ΔT)."""
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
    """The change by an effect of the aircraft: the reaction with it less that without, to the same motion."""
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
    return channel_residuals(scene.clean, scene.grid, scene.frame, model).values - scene.base.values


def _leaves_engines(overlay: Overlay) -> bool:
    """Whether an overlay adds only forces and moments of the air, so that thrust cancels in the difference."""
    elsewhere = [s for s in overlay.settings if not s.path.startswith(OF_THE_AIR)]
    return not (elsewhere or overlay.masses or overlay.forces or overlay.filters)


def moves_levers(overlay: Overlay) -> bool:
    """Whether an overlay sets nothing but the offset of the throttle plates from the levers."""
    return bool(overlay.settings) and all(setting.path in THROTTLE_BIAS for setting in overlay.settings)


def _throttle_split(overlay: Overlay) -> float | None:
    """The left less the right offset of the throttle plates; None where an overlay does not set them.

    The log holds the positions of the plates, so that only their difference shows the offset.
    """
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
