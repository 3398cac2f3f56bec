"""Lay out a log for judgment: its residuals, its free parameters, and the signatures of the effects."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from pitotbench.catalog import Catalog
from pitotbench.effects import Effect, Overlay
from pitotbench.logbook.ceiling import at_ceiling
from pitotbench.reconcile.decide.locate import Cell, cells, is_examined
from pitotbench.reconcile.log_checks import CheckedLog, check_log
from pitotbench.reconcile.residuals.free_parameters import (
    AnalysisSetting,
    FreeParameters,
    free_parameters_of,
    without_curve,
)
from pitotbench.reconcile.residuals.grid import MARGIN, Grid
from pitotbench.reconcile.residuals.parameter_fit import fit_free_parameters
from pitotbench.reconcile.residuals.predicted_channels import ChannelResiduals, air_velocity, slack
from pitotbench.reconcile.residuals.replay import can_replay, replay_motion
from pitotbench.reconcile.residuals.scene import AircraftModel, Scene, set_scene
from pitotbench.reconcile.residuals.track import Track, mach_number, track_of
from pitotbench.reconcile.residuals.whitening import UNUSABLE
from pitotbench.reconcile.signatures.hypotheses import WHOLE_FLIGHT
from pitotbench.reconcile.signatures.signatures import Signature, signatures_of
from pitotbench.records.errors import BadInputError
from pitotbench.records.log import FlightLog
from pitotbench.units import Array, Booleans

PASCAL_A_METER = 10.0  # of height near the ground, rounded
CURVE_ROUNDS = 2  # the error curve is linearized, so that a large one needs a second round
DAY = "nonstandard_temperature"  # a gap where the day is told; a free parameter where nobody told it
USUAL_DAYS = {"warmer_k": 10.0}  # prior deviation of its sizes: days of the temperate zone
Curves = tuple[Mapping[str, float], ...]
FEWEST_INSTANTS = 40  # of a log: three times the memory of its noise


@dataclass(frozen=True, slots=True)
class Layout:
    """A log laid out, before its noise is known.

    `residuals` are measured less predicted, `free` the free parameters, `signatures` the hypotheses; `cells` are
    the places to examine, and `shapes` (n, k) the values that each cell has at the instants. `measured` marks the
    rows of the track whose air data lie below the end of their sensor's range. `subtracted` is what the residuals
    were before, less what they are, by effects that are in the model and that neither the track nor the scene
    holds, (n, c) or 0. `in_model` holds the sizes of the effects in the model, by effect and parameter. `curves`
    are the sizes of the error curves that were taken out of the track, one after the other.
    """

    checked: CheckedLog
    track: Track
    measured: Booleans
    scene: Scene
    residuals: ChannelResiduals
    free: FreeParameters
    signatures: tuple[Signature, ...]
    cells: tuple[Cell, ...]
    shapes: Array
    setting: AnalysisSetting
    subtracted: Array | float = 0.0
    in_model: Mapping[tuple[str, str], float] = field(default_factory=dict)
    curves: Curves = ()

    @property
    def grid(self) -> Grid:
        """The instants."""
        return self.scene.grid

    @property
    def used(self) -> Booleans:
        """Whether the comparison uses each channel at each instant, (n, c): not at the end of a sensor's range."""
        used: Booleans = self.residuals.slack < UNUSABLE
        return used

    @property
    def places(self) -> tuple[tuple[int, Cell], ...]:
        """The cells that are examined, each with its column in the normal equations."""
        return tuple((i, c) for i, c in enumerate(self.cells, start=len(self.signatures)) if is_examined(c))

    def without(self, columns: Sequence[Array], sizes: Sequence[float] | Array) -> "Layout":
        """Return the layout with columns (n, c) at their sizes subtracted from the residuals."""
        explained = np.zeros_like(self.residuals.values)
        for column, size in zip(columns, sizes, strict=True):
            explained = explained + column * size
        return replace(self, residuals=replace(self.residuals, values=self.residuals.values - explained))


def lay_out(
    log: FlightLog,
    aircraft: AircraftModel | None,
    setting: AnalysisSetting,
    effects: Catalog[Effect] = WHOLE_FLIGHT,
) -> Layout:
    """Lay out a log. Without an aircraft its sensors are judged alone; `effects` are the hypotheses.

    Raises BadInputError for a log without attitude, or one that cannot be compared.
    """
    _require_attitude(log)
    checked = check_log(log)
    track = track_of(log, checked.fresh)
    measured = below_range_end(track, log)
    track, curves = without_error_curve(track, measured, setting)
    return replace(_laid_out(checked, track, measured, aircraft, setting, effects), curves=curves)


def with_aircraft(layout: Layout, aircraft: AircraftModel, kept: Mapping[Overlay, Array] | None = None) -> Layout:
    """Return the layout of the same log with another aircraft, with all hypotheses.

    `kept` holds the changes of the reaction by overlays that are the same on both aircraft.
    """
    checked, track, measured = layout.checked, layout.track, layout.measured
    laid = _laid_out(checked, track, measured, aircraft, layout.setting, WHOLE_FLIGHT, kept)
    return replace(laid, curves=layout.curves)


def _laid_out(
    checked: CheckedLog,
    track: Track,
    measured: Booleans,
    aircraft: AircraftModel | None,
    setting: AnalysisSetting,
    effects: Catalog[Effect],
    kept: Mapping[Overlay, Array] | None = None,
) -> Layout:
    replay = (
        replay_motion(track, lambda motion: aircraft.react(motion, Overlay(), True))
        if aircraft is not None and can_replay(track)
        else None
    )
    scene = set_scene(track, mean_wind_of(track, measured), replay, aircraft, kept)
    if len(scene.grid) < FEWEST_INSTANTS:
        raise BadInputError(
            f"the log gives {len(scene.grid)} instants to compare, and {FEWEST_INSTANTS} are needed: give at least "
            f"{(FEWEST_INSTANTS + 2) * scene.grid.step + 2.0 * MARGIN:.0f} s without a pause or an outage"
        )
    setting = replace(setting, pressure_step=_coarse_step(checked))
    residuals = scene.residuals_of(track)
    unusable = np.where(_usable(track, measured, scene.grid, setting), 0.0, UNUSABLE)
    loose = slack(scene.grid, replay, residuals.names) + unusable[:, None]
    if setting.pressure_step and "pressure_height" in residuals.names:
        # Off by up to half a step for as long as it is held.
        loose[:, residuals.names.index("pressure_height")] += setting.pressure_step / PASCAL_A_METER
    residuals = replace(residuals, slack=loose)
    places, shapes = cells(scene.clean, scene.grid, scene.base)
    free, signatures = free_parameters_of(scene, setting, shapes), signatures_of(scene, effects)
    if not setting.day_known:
        days = [s for s in signatures if s.effect == DAY]
        free = free.with_columns({f"{DAY} {s.parameter}": (s.column, USUAL_DAYS[s.parameter]) for s in days})
        signatures = tuple(s for s in signatures if s.effect != DAY)
    return Layout(checked, track, measured, scene, residuals, free, signatures, places, shapes, setting)


def without_error_curve(track: Track, measured: Booleans, setting: AnalysisSetting) -> tuple[Track, Curves]:
    """Return the track without the error curve that its wind triangle shows on the rows `measured`, (m,).

    The second is what was taken out. All later steps are linear in the remaining curve. Forces follow the product
    of pressure and angles, so that a large curve would otherwise look like drag.
    """
    curves: list[Mapping[str, float]] = []
    for _ in range(CURVE_ROUNDS):
        scene = set_scene(track, mean_wind_of(track, measured), None, None)
        values = scene.residuals_of(track).values
        free = free_parameters_of(scene, setting, np.zeros((len(scene.grid), 0)))
        usable = _usable(track, measured, scene.grid, setting)
        sizes = fit_free_parameters(values, free, np.broadcast_to(usable[:, None], values.shape)).sizes
        curves.append(dict(zip(free.names, sizes.tolist(), strict=True)))
        track = without_curve(track, curves[-1], setting)
    return track, tuple(curves)


def below_range_end(track: Track, log: FlightLog) -> Booleans:
    """Return the rows of a log's track whose impact pressure lies below the end of its sensor's range, (m,)."""
    ceiling = at_ceiling(log.impact_pressure).astype(np.float64)
    rows: Booleans = np.interp(track.time, log.time, ceiling) == 0.0
    return rows


def mean_wind_of(track: Track, measured: Booleans) -> Array:
    """Return the mean wind over the rows `measured`, (m,), toward north, east, down [m/s], (3,).

    It is the ground velocity less the velocity through the air.
    """
    through, wind = air_velocity(track), np.zeros(3)
    for i, name in enumerate(("velocity_north", "velocity_east", "velocity_down")):
        if name in track:
            wind[i] = np.mean((track[name] - through[i])[measured])
    return wind


def _require_attitude(log: FlightLog) -> None:
    missing = [name for name in ("roll", "pitch", "heading") if getattr(log, name) is None]
    if missing:
        raise BadInputError(
            f"reconcile needs the attitude: the log has no {', '.join(missing)}; record roll, pitch and heading"
        )


def _coarse_step(checked: CheckedLog) -> float:
    """The step of a coarse quantization [Pa], 0 for none."""
    return next((e.sizes[0].value for e in checked.effects if e.name == "quantization"), 0.0)


def _usable(track: Track, measured: Booleans, grid: Grid, setting: AnalysisSetting) -> Booleans:
    """Instants that are not near a row at the ceiling, and not above the greatest Mach number, (n,)."""
    at_ceiling = grid.smooth((~measured).astype(np.float64)) > 0.0
    usable: Booleans = ~at_ceiling & (grid.smooth(mach_number(track)) <= setting.mach_max)
    return usable
