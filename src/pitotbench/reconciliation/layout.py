"""Check a log and lay it out for judgment: residuals, free parameters, signatures, cells of the
gap.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from pitotbench.catalog import Catalog
from pitotbench.channels import numbers_from
from pitotbench.effects import terms_beside
from pitotbench.effects.effect import Effect
from pitotbench.effects.overlay import Overlay
from pitotbench.logbook.plausible_air import at_ceiling
from pitotbench.reconciliation.flight_path import (
    ATTITUDE,
    VELOCITY,
    air_velocity,
    true_airspeed_along,
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
from pitotbench.reconciliation.replay import lacking, replay_motion
from pitotbench.reconciliation.residuals import (
    AircraftModel,
    ChannelResiduals,
    ReferenceState,
    reference_state,
    slack,
)
from pitotbench.reconciliation.signatures import WHOLE_FLIGHT, Signature, signatures_of
from pitotbench.reconciliation.thresholds import THRESHOLDS
from pitotbench.reconciliation.track import MARGIN, Grid, Track, mach_number, track_of
from pitotbench.records import BadInputError
from pitotbench.records.aircraft import PatchErrors
from pitotbench.records.calibration import Estimate
from pitotbench.records.log import FlightLog
from pitotbench.records.verdict import Candidate, Check, where
from pitotbench.timeline import gaps, in_outage, interval
from pitotbench.units import DEGREE, FOOT, INCH_OF_MERCURY, Array, Booleans

# Check a log without a model: repeated samples, gaps, clock, quantization, ceilings. A recording
# fault that is found here is named here and does not enter the comparison: repeated samples are not
# new ones, and rows at the ceiling hold no measurement.

AIR_DATA = numbers_from("air")
PRESSURES = ("impact_pressure", "static_pressure")
SLOW_BUS = 2.0  # rows between new pressures, from which a slower bus is told
LISTED = 3  # outages of the GPS whose times are told


@dataclass(frozen=True, slots=True)
class CheckedLog:
    """The result of the checks.

    `effects` are the recording faults that were counted. `fresh` marks the rows with new air data.
    """

    checks: tuple[Check, ...]
    effects: tuple[Candidate, ...]
    fresh: Booleans


def check_log(log: FlightLog) -> CheckedLog:
    """Check a log for faults of its recording."""
    repeated = _repeats(log)
    hold, held = _hold(log, repeated)
    step, stepped = _steps(log, repeated)
    ceiling, capped = _ceiling(log)
    return CheckedLog(
        (_clock(log), _gaps(log), hold, step, ceiling, _gps(log)),
        (*held, *stepped, *capped),
        ~repeated,
    )


def _counted(effect: str, size: Estimate) -> Candidate:
    return Candidate(effect, (size,), THRESHOLDS.counted_score)


def _repeats(log: FlightLog) -> Booleans:
    """Rows on which every air-data channel repeats its previous value, where that is more often
    than by chance.

    The two pressures count as one: a slow bus, or a static pressure that both are made with,
    repeats them together. A temperature that comes in coarse steps repeats at its own times, and a
    constant one says nothing.
    """
    present = {name: values for name in AIR_DATA if (values := getattr(log, name)) is not None}
    each = {name: np.diff(values) == 0.0 for name, values in present.items()}
    pressures = [each.pop(name) for name in PRESSURES]
    varying = [same for same in each.values() if not same.all()]
    sources = [np.all(pressures, axis=0), *varying] if varying else pressures
    same = np.all([*pressures, *each.values()], axis=0)
    rates = np.mean(sources, axis=1)
    by_chance = float(np.prod(rates)) * len(same)
    # A source that is held over k rows, k = 1/(1 - rate), gives as many independent rows less.
    spread = np.sqrt(by_chance * (1.0 - float(np.min(rates))))
    repeated: Booleans = np.concatenate([[False], same])
    surplus = THRESHOLDS.repeats_fewest + THRESHOLDS.repeats_beyond_chance * spread
    return repeated if repeated.sum() - by_chance > surplus else np.zeros_like(repeated)


def _hold(log: FlightLog, repeated: Booleans) -> tuple[Check, tuple[Candidate, ...]]:
    if not repeated.any():
        return _slow_bus(log), ()
    period = interval(log.time)
    out = in_outage(log.time, ~repeated)
    where = f"; {_outages(log, out)}" if out.any() else ""
    lengths = np.diff(np.flatnonzero(~repeated & ~out))
    typical = float(np.median(lengths))
    if typical > 1 and np.mean(np.abs(lengths - typical) <= 1) > THRESHOLDS.repeats_regular:
        held = float(np.mean(lengths)) * period
        why = f"air data are renewed every {held:.3g} s and held between"
        return Check("repeated samples", "failed", why), (
            _counted("sample_and_hold", Estimate("period_s", held, period)),
        )
    lost = repeated & ~out
    if not lost.any():
        return Check("repeated samples", "failed", f"air data{where[1:]}"), ()
    lengths = np.diff(np.flatnonzero(~repeated))
    share = float(np.mean(lost))
    spread = 2.0 * float(
        np.sqrt(share * max(1.0, float(lengths[lengths > 1].mean()) - 1.0) / len(log))
    )
    why = (
        f"{100.0 * share:.1f} % of the rows repeat the air data of the row before: lost "
        f"samples, filled in{where}"
    )
    return Check("repeated samples", "failed", why), (
        _counted("dropped_samples", Estimate("fraction", share, spread)),
    )


def _slow_bus(log: FlightLog) -> Check:
    """Whether the pressures alone are held between samples: a slower bus, on which the comparison
    does not rest.
    """
    new = np.flatnonzero(np.any([np.diff(getattr(log, name)) != 0.0 for name in PRESSURES], axis=0))
    held = float(np.median(np.diff(new))) * interval(log.time) if len(new) > 1 else 0.0
    if held < SLOW_BUS * interval(log.time):
        return Check("repeated samples", "passed", "air data are new on every row")
    why = f"the pressures are renewed every {held:.3g} s and held between; no row is lost"
    return Check("repeated samples", "remark", why)


def _steps(log: FlightLog, repeated: Booleans) -> tuple[Check, tuple[Candidate, ...]]:
    """The smallest step of the pressures against their noise, which second differences show."""
    steps = [_step(getattr(log, name)[~repeated]) for name in PRESSURES]
    noise = [_noise(getattr(log, name)[~repeated]) for name in PRESSURES]
    coarse = [
        step > max(THRESHOLDS.quantization_smallest, THRESHOLDS.quantization_noise * level)
        for step, level in zip(steps, noise, strict=True)
    ]
    listed = " and ".join(f"{step:.3g}" for step in steps)
    if not any(coarse):
        return Check(
            "quantization", "passed", f"pressures come in steps of {listed} Pa, below their noise"
        ), ()
    worst = max(steps)
    why = (
        f"pressures come in steps of {listed} Pa, above their noise of {noise[0]:.2g} and "
        f"{noise[1]:.2g} Pa"
    )
    return Check("quantization", "failed", why), (
        _counted("quantization", Estimate("step_pa", worst, 0.02 * worst)),
    )


def _step(values: Array) -> float:
    levels = np.unique(values)
    return float(np.median(np.diff(levels))) if len(levels) > 2 else 0.0


def _noise(values: Array) -> float:
    """Standard deviation of the noise without the rounding, from second differences."""
    second = values[2:] - 2.0 * values[1:-1] + values[:-2]
    return float(np.sqrt(max(0.0, float(np.mean(second**2)) / 6.0 - _step(values) ** 2 / 12.0)))


def _ceiling(log: FlightLog) -> tuple[Check, tuple[Candidate, ...]]:
    capped = at_ceiling(log.impact_pressure)
    if not capped.any():
        return Check("saturation", "passed", "impact pressure does not stand at a ceiling"), ()
    top = float(log.impact_pressure.max())
    why = f"impact pressure stands at {top:.1f} Pa on {int(capped.sum())} rows"
    return Check("saturation", "failed", why), (
        _counted("saturation", Estimate("ceiling_pa", top, 1.0)),
    )


def _clock(log: FlightLog) -> Check:
    step = np.diff(log.time)
    typical = float(np.median(step))
    odd = float(np.mean(np.abs(step - typical) > THRESHOLDS.clock_odd_step * typical))
    if odd > THRESHOLDS.clock_odd_share:
        return Check(
            "clock",
            "failed",
            f"{100.0 * odd:.1f} % of the time steps differ from the median of {typical:.4g} s",
        )
    return Check("clock", "passed", f"rows every {typical:.4g} s")


def _gaps(log: FlightLog) -> Check:
    after = gaps(log.time)
    if len(after):
        lasted = float(np.sum(log.time[after] - log.time[after - 1]))
        return Check("gaps", "passed", f"{len(after)} gaps in the recording, {lasted:.1f} s in all")
    return Check("gaps", "passed", "no gap in the recording")


def _gps(log: FlightLog) -> Check:
    fresh = log.fresh_fixes()
    if fresh.all():
        return Check("GPS", "passed", "velocity is new on every row")
    held = in_outage(log.time, log.renewed_fixes())
    if held.any():
        return Check("GPS", "failed", f"fixes {_outages(log, held)}")
    period = interval(log.time[fresh])
    return Check(
        "GPS", "passed", f"velocity is renewed every {period:.3g} s and interpolated between"
    )


def _outages(log: FlightLog, held: Booleans) -> str:
    """How long a sensor was silent in all, and when the first times began, in words."""
    begins = np.flatnonzero(np.diff(held.astype(np.int8), prepend=0) == 1)
    lasted = float(np.sum(held)) * interval(log.time)
    places = ", ".join(f"{log.time[row] - log.time[0]:.0f}" for row in begins[:LISTED])
    more = ", …" if len(begins) > LISTED else ""
    return f"stand still for {lasted:.1f} s in all, from {places}{more} s after the start: not used"


# Lay out a log for judgment: residuals, free parameters, signatures, and the cells in which a gap
# is located.

# Locate the gap: cells, which are columns without physics, one a channel and phase of flight or
# variable. They are fitted as the effects are, so that both have significances in the same units: a
# gap that cells show and no effect explains is real, with an unknown cause. Phases and variables
# come from the clean track, because a variable that contains the gusts, such as the angle of
# attack, is correlated with the residuals by its noise.

TURN = 12.0 * DEGREE  # bank from which the airplane turns; gusts bank it by less
VERTICAL = 2.0  # m/s of climb or descent
CHANGE = 0.25  # m/s² of airspeed
IDLE = 12.0 * INCH_OF_MERCURY
FEWEST = 12  # instants of a phase that is examined, so 6 s
SPAN = 4.0  # s over which rates are taken, so that gusts do not make a phase
MEAN_HALF_ROWS = 10  # rows on either side over which a value is averaged before its rate is taken
WITH_HEADING = ("airspeed_along", "airspeed_across", "airspeed_down")
LEAST_SPREAD = {"bank": 3.0 * DEGREE, "altitude": 30.0 * FOOT}  # less is the wander of a held state
LEAST_OTHER_SPREAD = 1e-9  # of any other variable: it has to vary at all


@dataclass(frozen=True, slots=True)
class Cell:
    """A place of the gap: a channel, and a phase of flight or a variable."""

    channel: str
    phase: str
    variable: str

    @property
    def where(self) -> str:
        """The phase of flight, or the variable."""
        return where(self.phase, self.variable)


def is_examined(cell: Cell) -> bool:
    """Whether a cell is examined: the heading matters to compass and GPS, not to forces and
    engines.
    """
    return not cell.variable.startswith("heading") or cell.channel in WITH_HEADING


def phases(track: Track, grid: Grid) -> NDArray[np.str_]:
    """Return the phase of flight at every instant, (n,)."""
    speed, half = true_airspeed_along(track), max(1, round(0.5 * SPAN / track.row_period))
    names = np.full(len(grid), "level", dtype="<U12")
    acceleration = _slope(speed, grid, half, track)
    names[acceleration > CHANGE] = "acceleration"
    names[acceleration < -CHANGE] = "deceleration"
    if "altitude" in track:
        climb = _slope(track["altitude"], grid, half, track)
        names[climb > VERTICAL] = "climb"
        names[climb < -VERTICAL] = "descent"
    if "manifold_pressure_left" in track:
        names[grid.smooth(track["manifold_pressure_left"]) < IDLE] = "idle"
    if "roll" in track:
        names[np.abs(grid.smooth(track["roll"])) > TURN] = "turn"
    return names


def _slope(values: Array, grid: Grid, half: int, track: Track) -> Array:
    ahead = np.minimum(grid.rows + half, len(values) - 1)
    behind = np.maximum(grid.rows - half, 0)
    change = _mean_around(values, ahead) - _mean_around(values, behind)
    seconds = np.maximum(ahead - behind, 1) * track.row_period
    return np.asarray(change / seconds)


def _mean_around(values: Array, rows: NDArray[np.intp], half: int = MEAN_HALF_ROWS) -> Array:
    """Mean over the rows around each row."""
    around = np.clip(rows[:, None] + np.arange(-half, half + 1), 0, len(values) - 1)
    return np.asarray(values[around].mean(axis=1))


def flight_variables(track: Track, grid: Grid) -> dict[str, Array]:
    """Return the variables that a gap may follow, at the instants in SI units and radians, (n,)
    each.
    """
    values = {"airspeed": grid.smooth(true_airspeed_along(track)), "time": track.time[grid.rows]}
    sources = {"bank": "roll", "altitude": "altitude", "power": "manifold_pressure_left"}
    for name, source in sources.items():
        if source in track:
            values[name] = grid.smooth(track[source])
    if "heading" in track:
        for name, way in (("heading_north", np.cos), ("heading_east", np.sin)):
            values[name] = grid.smooth(way(track["heading"]))
            values[f"{name}_twice"] = grid.smooth(way(2.0 * track["heading"]))
    if "bank" in values:
        values["bank"] = np.abs(values["bank"])
    return values


def variables(track: Track, grid: Grid) -> dict[str, Array]:
    """Return the variables of a flight that vary, each scaled to mean 0 and deviation 1, (n,)."""
    values = flight_variables(track, grid)
    spread = {name: float(np.std(each)) for name, each in values.items()}
    varying = [name for name in values if spread[name] > LEAST_SPREAD.get(name, LEAST_OTHER_SPREAD)]
    return {name: (values[name] - values[name].mean()) / spread[name] for name in varying}


def cells(track: Track, grid: Grid, base: ChannelResiduals) -> tuple[tuple[Cell, ...], Array]:
    """Return the cells of all channels, and their shapes, (n, k): one column a variable and a
    phase.

    Every channel has the same shapes.
    """
    phase = phases(track, grid)
    shapes = {("", name): values for name, values in variables(track, grid).items()}
    for name in np.unique(phase):
        if np.sum(phase == name) >= FEWEST:
            shapes[str(name), ""] = (phase == name).astype(np.float64)
    places = tuple(Cell(channel, *key) for channel in base.names for key in shapes)
    return places, np.stack(list(shapes.values()), axis=1)


# Lay out a log for judgment: its residuals, its free parameters, and the signatures of the effects.

PASCAL_A_METER = 10.0  # of height near the ground, rounded
VANE_ROUNDS = 3  # Gauss-Newton steps
# rad (rms) of a vane, from which the force meter follows it: 2 % of its scale. Of flights without
# an error the fit moves no vane by half of that.
VANE_MOVED = 0.001
MOST_OFF = {"bias": 10.0 * DEGREE, "scale": 0.5}  # of a vane: the ranges of its effects
CURVE_ROUNDS = 2  # the error curve is linearized, so that a large one needs a second round
DAY = (
    "nonstandard_temperature"  # a gap where the day is told; a free parameter where nobody told it
)
USUAL_DAYS = {"warmer_k": 10.0}  # prior deviation of its sizes: days of the temperate zone
Curves = tuple[Mapping[str, float], ...]
FEWEST_INSTANTS = 40  # of a log: three times the memory of its noise


@dataclass(frozen=True, slots=True)
class Layout:
    """A log laid out, before its noise is known.

    `residuals` are measured less predicted, `free` the free parameters, `signatures` the
    hypotheses; `cells` are the places to examine, and `shapes` (n, k) the values that each cell has
    at the instants. `measured` marks the rows of the track whose air data lie below the end of
    their sensor's range. `curves` are the sizes of the error curves that were taken out of the
    track, one after the other. `angles`
    are the sizes of the free parameters of the vanes that were taken out of the track and stay in
    the residuals, to first order.
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

    @property
    def grid(self) -> Grid:
        """The instants."""
        return self.reference.grid

    @property
    def used(self) -> Booleans:
        """Whether the comparison uses each channel at each instant, (n, c): not at the end of a
        sensor's range.
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
        """Return the layout with errors of the vanes, which its track lacks, in its residuals, to
        first order.
        """
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
    """Lay out a log. Without an aircraft its sensors are judged alone; `effects` are the
    hypotheses, by default those of the table and, as the setting says, the terms of the file.

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
        sizes = fit_free_parameters(laid.residuals.values, laid.free, laid.used).sizes
        again = without_vane_errors(laid, dict(zip(laid.free.names, sizes.tolist(), strict=True)))
        if again is laid:
            break
        laid = again
    return laid


def without_vane_errors(layout: Layout, sizes: Mapping[str, float]) -> Layout:
    """Return a layout along the track without errors of the vanes of these sizes, by the name of
    the free parameter, where others are ignored; the same object where that moves no vane, or one
    is beyond what a vane can have.

    Forces are not linear in the angles: two degrees of a vane's zero would otherwise look like
    drag. Without a force meter nothing is done.

    The force meter and the signatures follow the corrected track; the errors stay in the residuals,
    so that the sizes to be fitted stay whole sizes.
    """
    model = layout.reference.force_model
    if model is None:
        return layout
    angles = {name: sizes[name] for name in VANE_PARAMETERS if name in sizes}
    bare = without_vane_angles(with_vane_angles(layout.track, layout.angles), angles)
    moved = [np.sqrt(np.mean((bare[n] - layout.track[n]) ** 2)) for n in ANGLE_SCALE if n in bare]
    possible = all(abs(v) < MOST_OFF[VANE_PARAMETERS[name][1]] for name, v in angles.items())
    if not possible or all(each <= VANE_MOVED for each in moved):
        return layout
    effects = hypotheses(model.aircraft, layout.setting)
    laid = _laid_out(layout.checked, bare, layout.measured, model.aircraft, layout.setting, effects)
    shown = {each.effect for each in layout.signatures}
    signatures = tuple(each for each in laid.signatures if each.effect in shown)
    return replace(laid.with_angles(angles), curves=layout.curves, signatures=signatures)


def hypotheses(aircraft: AircraftModel | None, setting: AnalysisSetting) -> Catalog[Effect]:
    """Return the effects of the table and, as a setting says, the terms of an aircraft's file."""
    own = terms_beside(aircraft.baseline) if aircraft is not None and setting.terms else ()
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
        replay = replay_motion(track, lambda motion: aircraft.react(motion, Overlay(), True))
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
    """Return what the patches of an aircraft may be off by as free parameters, by name the change
    of the residuals, (n, c), and the deviation: the sizes with their covariance, and each form,
    which may follow any of the cells' shapes, (n, k).

    Each size stays a hypothesis: what is beyond its error is a gap of its own.
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
    """The residuals of a track with their slack: how far each is beyond noise, and whether it is
    used.
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
    """Return the track without the error curve that its wind triangle shows on the rows `measured`,
    (m,).

    The second is what was taken out. All later steps are linear in the remaining curve. Forces
    follow the product of pressure and angles, so that a large curve would otherwise look like drag.
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
    """Return the rows of a log's track whose impact pressure lies below the end of its sensor's
    range, (m,).
    """
    ceiling = at_ceiling(log.impact_pressure).astype(np.float64)
    rows: Booleans = np.interp(track.time, log.time, ceiling) == 0.0
    return rows


def mean_wind_of(track: Track, measured: Booleans) -> Array:
    """Return the mean wind over the rows `measured`, (m,), toward north, east, down [m/s], (3,).

    It is the ground velocity less the velocity through the air.
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
    """Instants that are not near a row at the ceiling, and not above the greatest Mach number,
    (n,).
    """
    at_ceiling = grid.smooth((~measured).astype(np.float64)) > 0.0
    usable: Booleans = ~at_ceiling & (grid.smooth(mach_number(track)) <= setting.mach_max)
    return usable
