"""Lay a log out for judgment: residuals, free parameters, and the signatures of the effects."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from pitotbench.catalog import Catalog
from pitotbench.effects import additional_terms
from pitotbench.effects.effect import Effect, Parameter
from pitotbench.effects.overlay import Overlay
from pitotbench.logbook.plausible_air import at_ceiling
from pitotbench.reconciliation.cells import Cell, cells, is_examined
from pitotbench.reconciliation.flight_path import (
    ATTITUDE,
    VELOCITY,
    air_velocity,
    with_path_flow,
)
from pitotbench.reconciliation.free_parameters import (
    ANGLE_SCALE,
    VANE_PARAMETERS,
    AnalysisSetting,
    FreeParameters,
    fit_free_parameters,
    free_parameters_of,
    with_vane_angles,
    without_curve,
    without_vane_angles,
)
from pitotbench.reconciliation.noise import UNUSABLE
from pitotbench.reconciliation.recording_checks import CheckedLog, check_log
from pitotbench.reconciliation.replay import lacking, replay_motion
from pitotbench.reconciliation.residuals import (
    AircraftModel,
    ChannelResiduals,
    ReferenceState,
    reference_state,
    slack,
)
from pitotbench.reconciliation.signatures import (
    WHOLE_FLIGHT,
    Signature,
    parameter_of,
    reads_gusts,
    signatures_of,
)
from pitotbench.reconciliation.track import MARGIN, Grid, Track, mach_number, track_of
from pitotbench.records import BadInputError
from pitotbench.records.log import FlightLog
from pitotbench.records.motion import PatchErrors
from pitotbench.records.verdict import Located
from pitotbench.units import DEGREE, Array, Booleans

PASCAL_A_METER = 10.0  # of height near the ground, rounded
VANE_ROUNDS = 3  # Gauss-Newton steps
VANE_MOVED = 0.001  # rad (rms) of a vane, from which the force meter follows it: 2 % of its scale
VANE_SHOWN = 3.0  # deviations from which the error of a vane is one
MOST_OFF = {"bias": 10.0 * DEGREE, "scale": 0.5}  # of a vane: the ranges of its effects
CURVE_ROUNDS = 2  # the error curve is linearized, so that a large one needs a second round
# a gap where the day is stated; a free parameter where it is not
DAY = "nonstandard_temperature"
USUAL_DAYS = {"warmer_k": 10.0}  # prior deviation of its sizes: days of the temperate zone
Curves = tuple[Mapping[str, float], ...]
FEWEST_INSTANTS = 40  # of a log: three times the memory of its noise


@dataclass(frozen=True, slots=True)
class Line:
    """An error of a channel with a period of its own [s].

    `score` [σ] is beyond null flights, and `power` is a sum of squares.
    """

    channel: str
    period: float
    score: float
    power: float

    @property
    def place(self) -> Located:
        """The line as a place where model and log differ."""
        return Located(self.channel, "", f"a period of {self.period:.0f} s", self.score)


@dataclass(frozen=True, slots=True)
class Layout:
    """A log laid out, before its noise is known.

    `residuals` are measured less predicted, `free` the free parameters, `signatures` the
    hypotheses; `cells` are the places to examine, and `shapes` (n, k) the values that each cell has
    at the instants. `measured` marks the rows of the track whose air data lie below the end of
    their sensor's range. `curves` are the sizes of the error curves that were taken out of the
    track, one after the other. `angles` are the sizes of the free parameters of the vanes that were
    taken out of the track and stay in the residuals, to first order. `lines` are errors with a
    period of their own, whose waves are free parameters.
    """

    checked: CheckedLog
    track: Track
    measured: Booleans
    reference: ReferenceState
    residuals: ChannelResiduals
    free: FreeParameters
    signatures: tuple[Signature, ...]
    cells: tuple[Cell, ...]
    shapes: Array
    setting: AnalysisSetting
    curves: Curves = ()
    angles: Mapping[str, float] = field(default_factory=dict)
    lines: tuple[Line, ...] = ()

    @property
    def grid(self) -> Grid:
        """The instants."""
        return self.reference.grid

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The parameter of each signature, for the airplane of the log."""
        return tuple(parameter_of(self.reference, (s.effect, s.parameter)) for s in self.signatures)

    @property
    def used(self) -> Booleans:
        """Whether the comparison uses each channel at each instant, (n, c).

        What is at the end of a sensor's range is not used.
        """
        used: Booleans = self.residuals.slack < UNUSABLE
        return used

    @property
    def places(self) -> tuple[tuple[int, Cell], ...]:
        """The cells that are examined, each with its column in the normal equations."""
        return tuple(
            (i, c) for i, c in enumerate(self.cells, start=len(self.signatures)) if is_examined(c)
        )

    @property
    def examined(self) -> list[int]:
        """The columns of the cells that are examined."""
        return [i for i, _ in self.places]

    def without(self, columns: Sequence[Array], sizes: Sequence[float] | Array) -> "Layout":
        """Return the layout with columns (n, c) at their sizes subtracted from the residuals."""
        each = (column * size for column, size in zip(columns, sizes, strict=True))
        values = self.residuals.values - sum(each, np.zeros_like(self.residuals.values))
        return replace(self, residuals=replace(self.residuals, values=values))

    def with_angles(self, angles: Mapping[str, float]) -> "Layout":
        """Return the layout with vane errors, which its track lacks, in its residuals, linearly."""
        sizes = [angles.get(name, 0.0) for name in self.free.names]
        residuals = replace(
            self.residuals, values=self.residuals.values + self.free.columns @ np.array(sizes)
        )
        return replace(self, residuals=residuals, angles=angles)


def lay_out(
    log: FlightLog,
    aircraft: AircraftModel | None,
    setting: AnalysisSetting,
    effects: Catalog[Effect] | None = None,
) -> Layout:
    """Lay out a log. Without an aircraft its sensors are judged alone.

    `effects` are the hypotheses, by default those of the table and, as the setting says, the terms
    of the file.

    Raises BadInputError for a log without attitude, or one that cannot be compared.
    """
    _require_attitude(log)
    if effects is None:
        effects = hypotheses(aircraft, setting)
    checked = check_log(log)
    track = track_of(log, checked.fresh)
    measured = below_range_end(track, log)
    track, curves = without_error_curve(track, measured, setting)
    laid = _laid_out(checked, track, measured, aircraft, setting, effects)
    laid = replace(laid, curves=curves)
    for _ in range(VANE_ROUNDS):
        again = without_vane_errors(laid, vane_errors(laid))
        if again is laid:
            break
        laid = again
    return laid


def vane_errors(layout: Layout) -> dict[str, float]:
    """Return the errors of the vanes that a log shows beside the sizes of all effects.

    They go by the name of the free parameter, with 0 for those that the log does not show. Empty
    without a force meter. Without the effects, a pitch stiffness that is half off would look like a
    vane.
    """
    if layout.reference.force_model is None:
        return {}
    every = layout.free.with_columns(
        {
            f"{s.effect} {s.parameter}": (s.column, abs(size.typical))
            for s, size in zip(layout.signatures, layout.parameters, strict=True)
            if not reads_gusts(s.effect)
        }
    )
    fit = fit_free_parameters(layout.residuals.values, every, layout.used)
    return shown_vane_errors(every.names, fit.sizes, fit.deviations)


def shown_vane_errors(names: Sequence[str], sizes: Array, deviations: Array) -> dict[str, float]:
    """Return the errors of the vanes among fitted sizes, (k,), by name, 0 for those not shown.

    A size is shown that is well beyond its deviation, (k,).
    """
    shown = np.where(np.abs(sizes) > VANE_SHOWN * deviations, sizes, 0.0)
    found = dict(zip(names, shown.tolist(), strict=True))
    return {name: found[name] for name in VANE_PARAMETERS if name in found}


def without_vane_errors(layout: Layout, angles: Mapping[str, float]) -> Layout:
    """Return a layout along the track without errors of the vanes of these sizes.

    Where that moves no vane, or where one is beyond what a vane can have, it is the same object,
    and so without a force meter. Forces are not linear in the angles: two degrees of a vane's zero
    would otherwise look like drag. The force meter and the signatures follow the corrected track;
    the errors stay in the residuals, so that the sizes to be fitted stay whole sizes.
    """
    model = layout.reference.force_model
    if model is None:
        return layout
    bare = without_vane_angles(with_vane_angles(layout.track, layout.angles), angles)
    moved = [np.sqrt(np.mean((bare[n] - layout.track[n]) ** 2)) for n in ANGLE_SCALE if n in bare]
    possible = all(abs(v) < MOST_OFF[VANE_PARAMETERS[name][1]] for name, v in angles.items())
    if not possible or all(each <= VANE_MOVED for each in moved):
        return layout
    effects = hypotheses(model.aircraft, layout.setting)
    laid = _laid_out(layout.checked, bare, layout.measured, model.aircraft, layout.setting, effects)
    shown = {each.effect for each in layout.signatures}
    signatures = tuple(each for each in laid.signatures if each.effect in shown)
    return replace(
        laid.with_angles(angles),
        curves=layout.curves,
        signatures=signatures,
        free=laid.free.with_columns(layout.free.beyond(laid.free.names)),
        lines=layout.lines,
    )


def hypotheses(aircraft: AircraftModel | None, setting: AnalysisSetting) -> Catalog[Effect]:
    """Return the effects of the table and, as a setting says, the terms of an aircraft's file."""
    own = additional_terms(aircraft.baseline) if aircraft is not None and setting.terms else ()
    return Catalog("effect", {**WHOLE_FLIGHT, **{term.name: term for term in own}})


def _laid_out(
    checked: CheckedLog,
    track: Track,
    measured: Booleans,
    aircraft: AircraftModel | None,
    setting: AnalysisSetting,
    effects: Catalog[Effect],
) -> Layout:
    wind, replay = mean_wind_of(track, measured), None
    if aircraft is not None and not lacking(track, aircraft.controls):
        track = with_path_flow(track, wind, aircraft.mass)
        replay = replay_motion(
            track, lambda motion: aircraft.react(motion, Overlay(), True), aircraft.split
        )
    reference = reference_state(track, wind, replay, aircraft)
    if len(reference.grid) < FEWEST_INSTANTS:
        needed = (FEWEST_INSTANTS + 2) * reference.grid.step + 2.0 * MARGIN
        raise BadInputError(
            f"the log gives {len(reference.grid)} instants to compare, and {FEWEST_INSTANTS} are "
            f"needed: give at least {needed:.0f} s without a pause or an outage"
        )
    setting = replace(setting, pressure_step=_coarse_step(checked))
    residuals = _residuals(reference, track, measured, setting)
    places, shapes = cells(reference.clean, reference.grid, reference.base)
    free, signatures = (
        free_parameters_of(reference, setting, shapes),
        signatures_of(reference, effects),
    )
    if not setting.day_known:
        days = [s for s in signatures if s.effect == DAY]
        free = free.with_columns(
            {f"{DAY} {s.parameter}": (s.column, USUAL_DAYS[s.parameter]) for s in days}
        )
        signatures = tuple(s for s in signatures if s.effect != DAY)
    free = free.with_columns(of_patch(aircraft, signatures, shapes))
    return Layout(
        checked, track, measured, reference, residuals, free, signatures, places, shapes, setting
    )


def of_patch(
    aircraft: AircraftModel | None, signatures: Sequence[Signature], shapes: Array
) -> dict[str, tuple[Array, float]]:
    """Return what the patches of an aircraft may be off by, as free parameters by name.

    A parameter has the change of the residuals, (n, c), and the deviation: the sizes with their
    covariance, and each form, which may follow any of the cells' shapes, (n, k). Each size stays a
    hypothesis: what is beyond its error is a gap of its own.
    """
    patch = PatchErrors() if aircraft is None else aircraft.errors
    columns = {(s.effect, s.parameter): s.column for s in signatures}
    keys = [key for key in patch.sizes if key in columns]
    if not keys:
        return {}
    joint = np.array([[patch.covariance.get((a, b), 0.0) for b in keys] for a in keys])
    power, turns = np.linalg.eigh(joint)
    each = np.stack([columns[key] for key in keys], axis=2) @ turns
    found = {
        f"sizes of the patch {i}": (each[:, :, i], float(np.sqrt(p)))
        for i, p in enumerate(power)
        if p > 0.0
    }
    for key in keys:
        whole, share = patch.sizes[key] * columns[key], patch.forms[key] / np.sqrt(shapes.shape[1])
        for i, shape in enumerate(shapes.T):
            found[f"form of the patched {key[0]} {i}"] = whole * shape[:, None], float(share)
    return found


def _residuals(
    reference: ReferenceState, track: Track, measured: Booleans, setting: AnalysisSetting
) -> ChannelResiduals:
    """Return a track's residuals, with the slack that tells how far each is beyond noise.

    The slack also tells whether a residual is used.
    """
    residuals = reference.residuals_of(track)
    unusable = np.where(_usable(track, measured, reference.grid, setting), 0.0, UNUSABLE)
    loose = slack(reference.grid, reference.replay, residuals.names) + unusable[:, None]
    if setting.pressure_step and "pressure_height" in residuals.names:
        # Off by up to half a step for as long as it is held.
        loose[:, residuals.names.index("pressure_height")] += setting.pressure_step / PASCAL_A_METER
    return replace(residuals, slack=loose)


def without_error_curve(
    track: Track, measured: Booleans, setting: AnalysisSetting
) -> tuple[Track, Curves]:
    """Return the track without the error curve that its wind triangle shows, and that curve.

    Only the rows `measured`, (m,), show it. All later steps are linear in the remaining curve.
    Forces follow the product of pressure and angles, so that a large curve would otherwise look
    like drag.
    """
    curves: list[Mapping[str, float]] = []
    for _ in range(CURVE_ROUNDS):
        reference = reference_state(track, mean_wind_of(track, measured), None, None)
        values = reference.residuals_of(track).values
        free = free_parameters_of(reference, setting, np.zeros((len(reference.grid), 0)))
        usable = _usable(track, measured, reference.grid, setting)
        sizes = fit_free_parameters(
            values, free, np.broadcast_to(usable[:, None], values.shape)
        ).sizes
        curves.append(dict(zip(free.names, sizes.tolist(), strict=True)))
        track = without_curve(track, curves[-1], setting)
    return track, tuple(curves)


def below_range_end(track: Track, log: FlightLog) -> Booleans:
    """Return the rows of a track whose impact pressure is below the end of its range, (m,)."""
    ceiling = at_ceiling(log.impact_pressure).astype(np.float64)
    rows: Booleans = np.interp(track.time, log.time, ceiling) == 0.0
    return rows


def mean_wind_of(track: Track, measured: Booleans) -> Array:
    """Return the mean wind over the rows `measured`, (m,), toward north, east, down [m/s], (3,).

    The wind is the ground velocity less the velocity through the air.
    """
    through, wind = air_velocity(track), np.zeros(3)
    for i, name in enumerate(VELOCITY):
        if name in track:
            wind[i] = np.mean((track[name] - through[i])[measured])
    return wind


def _require_attitude(log: FlightLog) -> None:
    missing = [name for name in ATTITUDE if getattr(log, name) is None]
    if missing:
        raise BadInputError(
            f"reconcile needs the attitude: the log has no {', '.join(missing)}; record roll, "
            "pitch and heading"
        )


def _coarse_step(checked: CheckedLog) -> float:
    """The step of a coarse quantization [Pa], 0 for none."""
    return next((e.sizes[0].value for e in checked.effects if e.name == "quantization"), 0.0)


def _usable(track: Track, measured: Booleans, grid: Grid, setting: AnalysisSetting) -> Booleans:
    """Instants that are not near a row at the ceiling nor beyond the greatest Mach number, (n,)."""
    at_ceiling = grid.smooth((~measured).astype(np.float64)) > 0.0
    usable: Booleans = ~at_ceiling & (grid.smooth(mach_number(track)) <= setting.mach_max)
    return usable
