"""One log laid out for judgment: its residuals, its hypotheses, and the evidence that joins them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pitotbench.catalog import Catalog
from pitotbench.effects import EFFECTS, Effect, Overlay, Parameter, SensorEffect
from pitotbench.reconcile.decide.locate import Cell, cells, is_looked_at
from pitotbench.reconcile.decide.normal_equations import NormalEquations, equations_from, inner_products
from pitotbench.reconcile.log_checks import Found, check_log
from pitotbench.reconcile.residuals.free_parameters import (
    AnalysisSetting,
    FreeParameters,
    free_parameters_of,
    without_curve,
)
from pitotbench.reconcile.residuals.grid import Grid
from pitotbench.reconcile.residuals.predicted_channels import (
    ChannelResiduals,
    air_velocity,
    channel_residuals,
    slack,
)
from pitotbench.reconcile.residuals.replay import can_replay, replay_motion
from pitotbench.reconcile.residuals.track import Track, mach_number, track_of
from pitotbench.reconcile.residuals.whitening import NoiseModel, learned
from pitotbench.reconcile.signatures.signatures import AircraftModel, Scene, Signature, scene
from pitotbench.reconcile.signatures.signatures import signatures_of as all_signatures
from pitotbench.records.errors import BadInputError
from pitotbench.records.log import FlightLog
from pitotbench.units import Array, Booleans

ROUNDS = 3  # of scaling the channels against each other before the noise is known
PASCAL_A_METER = 10.0  # near the ground, rounded
MOST_NOISE = 4.0  # times that of null flights, unless a coarse step explains it
CURVES = 2  # times the error curve is taken out
WORST = 1e6  # slack of instants that say nothing
COUNTED = tuple(  # found by counting in step 0, not by fitting
    name for name, effect in EFFECTS.items() if isinstance(effect, SensorEffect) and effect.after_noise
)
FITTED: Catalog[Effect] = Catalog(
    "effect", {name: effect for name, effect in EFFECTS.items() if name not in COUNTED}
)


@dataclass(frozen=True, slots=True)
class Layout:
    """A log laid out, before its noise is known."""

    found: Found
    track: Track
    scene: Scene
    residuals: ChannelResiduals
    nuisance: FreeParameters
    signatures: tuple[Signature, ...]
    cells: tuple[Cell, ...]
    shapes: Array
    known: AnalysisSetting

    @property
    def grid(self) -> Grid:
        """The instants."""
        return self.scene.grid

    @property
    def places(self) -> tuple[tuple[int, Cell], ...]:
        """The cells that are looked at, each with its column in the evidence."""
        return tuple((i, c) for i, c in enumerate(self.cells, start=len(self.signatures)) if is_looked_at(c))


def lay_out(
    log: FlightLog, aircraft: AircraftModel | None, known: AnalysisSetting, effects: Catalog[Effect] = FITTED
) -> Layout:
    """Lay out a log; without an aircraft, its sensors alone; `effects` are the hypotheses.

    Raises BadInputError for a log without attitude.
    """
    _require_attitude(log)
    found = check_log(log)
    track = calibrated(track_of(log, found.fresh), known)
    model = (
        replay_motion(track, lambda motion: aircraft.react(motion, Overlay(), True))
        if aircraft is not None and can_replay(track)
        else None
    )
    set_up = scene(track, mean_wind(track), model, aircraft if model is not None else None)
    left = channel_residuals(track, set_up.grid, set_up.frame, model)
    loose = slack(set_up.grid, model, left.names) + _unusable(log, found, track, set_up.grid, known)[:, None]
    left = replace(left, slack=loose)
    places, shapes = cells(set_up.clean, set_up.grid, set_up.base)
    known = replace(known, pressure_step=_coarse_step(found))
    if known.pressure_step and "pressure_height" in left.names:
        # Off by up to half a step for as long as it is held.
        left.slack[:, left.names.index("pressure_height")] += known.pressure_step / PASCAL_A_METER
    unknown = free_parameters_of(set_up.clean, set_up.grid, set_up.frame, model, set_up.base, known, shapes)
    return Layout(found, track, set_up, left, unknown, all_signatures(set_up, effects), places, shapes, known)


def calibrated(track: Track, known: AnalysisSetting) -> Track:
    """The track with the error curve taken out as the wind triangle shows it, so that what is left of it is small:
    all that follows is linear in it, and forces go with the product of pressure and angles."""
    for _ in range(CURVES):
        set_up = scene(track, mean_wind(track), None, None)
        left = channel_residuals(track, set_up.grid, set_up.frame, None)
        none = np.zeros((len(set_up.grid), 0))
        unknown = free_parameters_of(set_up.clean, set_up.grid, set_up.frame, None, set_up.base, known, none)
        usable = ~_too_fast(track, set_up.grid, known)
        sizes, _ = _least_squares(left.values, unknown, np.broadcast_to(usable[:, None], left.values.shape))
        track = without_curve(track, dict(zip(unknown.names, sizes.tolist(), strict=True)), known)
    return track


def _require_attitude(log: FlightLog) -> None:
    missing = [name for name in ("roll", "pitch", "heading") if getattr(log, name) is None]
    if missing:
        raise BadInputError(
            f"reconcile needs the attitude: the log has no {', '.join(missing)}; record roll, pitch and heading"
        )


def _coarse_step(found: Found) -> float:
    """The step of a coarse quantization [Pa], 0 where there is none."""
    return next((e.sizes[0].value for e in found.effects if e.name == "quantization"), 0.0)


def mean_wind(track: Track) -> Array:
    """Ground velocity less air velocity on average, toward north, east, down [m/s], (3,)."""
    through, wind = air_velocity(track), np.zeros(3)
    for i, name in enumerate(("velocity_north", "velocity_east", "velocity_down")):
        if name in track:
            wind[i] = np.mean(track[name] - through[i])
    return wind


def _unusable(log: FlightLog, found: Found, track: Track, grid: Grid, known: AnalysisSetting) -> Array:
    """Slack of instants with a row at the ceiling or above the greatest Mach number near them, (n,)."""
    bad = np.interp(track.time, log.time, (~found.usable).astype(np.float64))
    return np.where((grid.smooth(bad) > 0.0) | _too_fast(track, grid, known), WORST, 0.0)


def _too_fast(track: Track, grid: Grid, known: AnalysisSetting) -> Booleans:
    """Instants above the greatest Mach number, (n,)."""
    fast: Booleans = grid.smooth(mach_number(track)) > known.mach_max
    return fast


def noise_residuals(layout: Layout) -> Array:
    """Residuals without nuisances, by least squares with robust scales, (n, c): what noise is learned from."""
    inside = layout.residuals.slack < WORST
    return np.where(inside, _least_squares(layout.residuals.values, layout.nuisance, inside)[1], 0.0)


def _least_squares(values: Array, unknown: FreeParameters, inside: Booleans) -> tuple[Array, Array]:
    """Sizes of the nuisances, (k,), and residuals without them, (n, c), from the instants `inside`, channels scaled
    by what is left in them."""
    columns, left, scale = unknown.columns, values, values.std(axis=0) + 1e-12
    sizes = np.zeros(columns.shape[2])
    for _ in range(ROUNDS):
        design = (columns * (inside / scale)[:, :, None]).reshape(-1, columns.shape[2])
        normal = design.T @ design + np.diag(1.0 / unknown.deviations**2)
        sizes = np.linalg.solve(normal, design.T @ (values * inside / scale).ravel())
        left = values - columns @ sizes
        scale = 1.4826 * np.median(np.abs(left - np.median(left, axis=0)), axis=0) + 1e-12
    return sizes, left


def own_noise(layout: Layout) -> NoiseModel:
    """The noise as the log itself shows it: what is left when nuisances and the cells without physics are out."""
    return learned(layout.residuals.names, [(_shapeless(layout), layout.grid, layout.residuals.slack)])


def _shapeless(layout: Layout) -> Array:
    """Residuals without nuisances and without what the cells take up, so that a gap does not count as noise, (n,
    c)."""
    left = noise_residuals(layout)
    used = (layout.residuals.slack[:, :1] < WORST).astype(np.float64)
    shapes = np.concatenate([layout.shapes, np.ones((len(left), 1))], axis=1) * used
    return np.asarray(left - shapes @ np.linalg.lstsq(shapes, left * used, rcond=1e-9)[0])


def scaled_to(noise: NoiseModel, layout: Layout) -> NoiseModel:
    """A noise model with this log's own level of innovations, by their median, where that is the higher one."""
    white = noise.innovations(_shapeless(layout), layout.grid, layout.residuals.slack)
    used = white[np.any(white != 0.0, axis=1)]
    level = 1.4826 * np.median(np.abs(used - np.median(used, axis=0)), axis=0)
    most = MOST_NOISE
    if layout.known.pressure_step:  # still for long, then a step: no median sees it
        level, most = np.maximum(level, used.std(axis=0)), np.inf
    return replace(noise, deviations=noise.deviations * np.clip(level, 1.0, most))


def weigh_layout(layout: Layout, noise: NoiseModel) -> NormalEquations:
    """The evidence of a log under a noise model."""
    place = layout.grid, layout.residuals.slack
    columns = [s.column[:, :, None] for s in layout.signatures]
    dense = noise.whiten(np.concatenate([layout.nuisance.columns, *columns], axis=2), *place)
    cells = noise.whiten_alone(layout.shapes, *place)
    products = inner_products(np.concatenate([dense, cells], axis=2), noise.whiten(layout.residuals.values, *place))
    return equations_from(products, layout.nuisance.columns.shape[2], layout.nuisance.deviations)


def searched(effect: Effect) -> tuple[Parameter, ...]:
    """The shapes of an effect that are looked for: times, and whatever makes another form of a cause."""
    shapes = (p for p in effect.parameters if p.shape)
    return tuple(p for p in shapes if effect.variant_of or p.name.endswith("_s"))


def cause_of(name: str) -> str:
    """The effect of which this one is a form, else itself: a second-order line and a lag have one cause."""
    return FITTED[name].cause


def columns_of(signatures_of: Sequence[Signature]) -> Mapping[str, tuple[int, ...]]:
    """Which columns of the evidence belong to each effect."""
    found: dict[str, tuple[int, ...]] = {}
    for index, signature in enumerate(signatures_of):
        found[signature.effect] = (*found.get(signature.effect, ()), index)
    return found
