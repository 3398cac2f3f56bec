"""Residual channels: measured quantities less predictions along a clean track by the model."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cache

import numpy as np
from scipy.ndimage import maximum_filter1d

from pitotbench import air
from pitotbench.axes import body_rates, euler_rates
from pitotbench.channels import CHANNELS
from pitotbench.effects.overlay import Baseline, Overlay
from pitotbench.reconciliation.clean_track import clean_track
from pitotbench.reconciliation.flight_path import (
    ATTITUDE,
    PATH_SCALES,
    VANES,
    VELOCITY,
    WIND,
    air_velocity,
    earth_acceleration,
    is_without_vanes,
)
from pitotbench.reconciliation.replay import (
    RATES,
    REACTION_NAMES,
    Replay,
    answer,
    coarse_rows,
    motion_of,
    properties_of_forces,
)
from pitotbench.reconciliation.track import FORCES, Grid, Track, grid_of, mach_number
from pitotbench.records.motion import CONTROLS, Motion, PatchErrors, Reaction, UnitForces
from pitotbench.timeline import Indices
from pitotbench.units import SYMBOLS, Array

MOMENTS, ENGINES = REACTION_NAMES[3:6], REACTION_NAMES[6:]
ATTITUDE_RATES = ("attitude_roll_rate", "attitude_pitch_rate", "attitude_yaw_rate")
TIMING = 0.1  # s, one step of the replay: by so much the model may be early or late
NEAR = 4  # instants on either side over which an error of timing shows
QUICK = 6.0  # times the median rate: gusts and sensor noise stay below
UNITS = {
    **dict.fromkeys(("airspeed_along", "airspeed_across", "airspeed_down"), SYMBOLS["mps"]),
    "pressure_height": SYMBOLS["m"],
    "temperature": SYMBOLS["k"],
    **dict.fromkeys(
        ("acceleration_forward", "acceleration_right", "acceleration_down", *FORCES),
        SYMBOLS["mps2"],
    ),
    **dict.fromkeys(ATTITUDE_RATES, "rad/s"),
    "climb_rate": SYMBOLS["mps"],
    **dict.fromkeys(MOMENTS, "rad/s²"),
    **{name: SYMBOLS[CHANNELS[name].unit] for name in ENGINES},
    "throttle_split": "",
}
FAMILIES = {
    "air data": (
        "airspeed_along",
        "airspeed_across",
        "airspeed_down",
        "pressure_height",
        "temperature",
    ),
    "kinematic": (
        *ATTITUDE_RATES,
        "acceleration_forward",
        "acceleration_right",
        "acceleration_down",
        "climb_rate",
    ),
    "force and moment": (*FORCES, *MOMENTS),
    "engine": (*ENGINES, "throttle_split"),
}
# The channels of a track that each part of the residuals reads.
_AIR = ("impact_pressure", "static_pressure", "total_temperature", "air_temperature")
_TRIANGLE_READS = (*_AIR, *VANES, *ATTITUDE, *VELOCITY)
_ACCELERATION_READS = (*FORCES, *ATTITUDE, *VELOCITY)
# The states in `VARIED`; without vanes those of the path through the air are among them.
_ANSWER_READS = (*_AIR, *VANES, *RATES)
_PATH_READS = (*ATTITUDE, *VELOCITY, *FORCES, *WIND, *PATH_SCALES)
_ENGINES_READ = (*_ANSWER_READS, *ENGINES, "throttle_left", "throttle_right")


@dataclass(frozen=True, slots=True)
class Frame:
    """Horizontal directions at the instants: along the flight through the air and across it.

    Each is a unit vector toward north, east, down, (n, 3), of the log, and stays the same for every
    hypothesis.
    """

    along: Array
    across: Array

    @classmethod
    def of(cls, track: Track, grid: Grid) -> "Frame":
        """Return the frame of the measured air velocity."""
        level = np.stack([grid.smooth(v) for v in air_velocity(track)], axis=1)[:, :2]
        level = level / np.linalg.norm(level, axis=1)[:, None]
        zero = np.zeros(len(level))
        return cls(
            np.stack([level[:, 0], level[:, 1], zero], axis=1),
            np.stack([-level[:, 1], level[:, 0], zero], axis=1),
        )

    def turned(self, vectors: Array, down: bool) -> Array:
        """Return vectors toward north, east, down along and across the track, and down if asked."""
        parts = [np.sum(self.along * vectors, axis=1), np.sum(self.across * vectors, axis=1)]
        return np.stack([*parts, vectors[:, 2]] if down else parts, axis=1)


@dataclass(frozen=True, slots=True)
class ChannelResiduals:
    """Residual channels by name, (n, c).

    `slack` is a standard deviation that adds to the noise, (n, c), where the model changes quickly
    or an instant holds little information.
    """

    names: tuple[str, ...]
    values: Array
    slack: Array

    @property
    def places(self) -> dict[str, int]:
        """The column of each channel."""
        return {name: i for i, name in enumerate(self.names)}


def channel_residuals(
    track: Track,
    grid: Grid,
    frame: Frame,
    model: Replay | None,
    known: "tuple[Track, ChannelResiduals] | None" = None,
) -> ChannelResiduals:
    """Return all residual channels that a track allows, with a model forces and moments too.

    Families: air data (wind triangle, height, temperature), kinematic (gyros against attitude,
    acceleration against ground velocity, altitude against vertical speed), force and moment,
    engine. Each channel is noise alone where sensors and model are true. Wind and sensor biases are
    free parameters of the regression.

    The answer of a model that was moved along another track is shifted to this state, to first
    order. `known` is another track with its residuals on the same grid, frame and model: what reads
    none of the channels in which the two tracks differ is taken from there.
    """

    def part(
        reads: tuple[str, ...], names: tuple[str, ...], computed: Callable[[], dict[str, Array]]
    ) -> None:
        if known is None or any(
            track.channels.get(n) is not known[0].channels.get(n) for n in reads
        ):
            columns.update(computed())
        else:
            places = known[1].places
            columns.update({n: known[1].values[:, places[n]] for n in names if n in places})

    @cache
    def answer() -> Array:
        return model.shifted(track) if model is not None else np.empty(0)

    @cache
    def predicted() -> Array:
        return grid.smooth_answer(answer(), model.rows) if model is not None else np.empty(0)

    path = _PATH_READS if is_without_vanes(track) else ()
    columns: dict[str, Array] = {}
    part((*_TRIANGLE_READS, *path), FAMILIES["air data"][:3], lambda: _triangle(track, grid, frame))
    part(("static_pressure", "altitude"), ("pressure_height",), lambda: _height(track, grid))
    part(_AIR, ("temperature",), lambda: _temperature(track, grid))
    if model is not None:
        part((*_ANSWER_READS, *FORCES, *path), FORCES, lambda: _forces(track, grid, predicted()))
        part(
            (*_ENGINES_READ, *path),
            FAMILIES["engine"],
            lambda: _engines(track, grid, predicted(), model.split),
        )
    part((*ATTITUDE, *RATES), ATTITUDE_RATES, lambda: _attitude_rates(track, grid))
    part(_ACCELERATION_READS, FAMILIES["kinematic"][3:6], lambda: _acceleration(track, grid, frame))
    part(("altitude", "velocity_down"), ("climb_rate",), lambda: _climb_rate(track, grid))
    if model is not None:
        part((*_ANSWER_READS, *path), MOMENTS, lambda: _moments(track, grid, model, answer()))
    values = np.stack(list(columns.values()), axis=1)
    return ChannelResiduals(tuple(columns), values, np.zeros_like(values))


def change_by_answer(
    names: tuple[str, ...], track: Track, grid: Grid, rows: Indices, added: Array
) -> Array:
    """Return the residuals' change, (n, c), by a growth of a model's answer at `rows`, (m, 12)."""
    change = np.zeros((len(grid), len(names)))
    lower = grid.smooth_answer(added, rows)
    for i, name in enumerate(REACTION_NAMES):
        if name in names:
            between = name in MOMENTS and name not in track
            felt = _mean_answer(track, grid, rows, added[:, i]) if between else lower[:, i]
            change[:, names.index(name)] = -felt
    return change


def slack(grid: Grid, model: Replay | None, names: tuple[str, ...]) -> Array:
    """Return the error of a model that is off by `TIMING` where it changes quickly, (n, c).

    Examples: an engine that answers to a lever, a propeller that meets its stop. The instants near
    it get the same slack.
    """
    loose = np.zeros((len(grid), len(names)))
    if model is None:
        return loose
    rate = np.abs(np.gradient(grid.smooth_answer(model.values, model.rows), axis=0)) / grid.step
    quick = np.maximum(0.0, rate - QUICK * np.median(rate, axis=0)) * TIMING
    near = maximum_filter1d(quick, 2 * NEAR + 1, axis=0)
    for i, name in enumerate(REACTION_NAMES):
        if name in (FORCES[0], *ENGINES) and name in names:
            loose[:, names.index(name)] = near[:, i]
    return loose


def _triangle(track: Track, grid: Grid, frame: Frame) -> dict[str, Array]:
    if "velocity_north" not in track:
        return {}
    through = np.stack([grid.smooth(v) for v in air_velocity(track)], axis=1)
    down = "velocity_down" in track
    ground = ["velocity_north", "velocity_east", *(["velocity_down"] if down else [])]
    over = np.stack([grid.smooth(track[name], gps=True) for name in ground], axis=1)
    gap = np.zeros((len(grid), 3))
    gap[:, : len(ground)] = over - through[:, : len(ground)]
    if is_without_vanes(track):
        gap -= np.stack([grid.smooth(track[name]) for name in WIND], axis=1)
    parts = frame.turned(gap, down)
    shown = 1 if is_without_vanes(track) else parts.shape[1]  # the path itself gives the direction
    return {
        f"airspeed_{name}": parts[:, i]
        for i, name in enumerate(("along", "across", "down")[:shown])
    }


def _height(track: Track, grid: Grid) -> dict[str, Array]:
    if "altitude" not in track:
        return {}
    height = grid.smooth(air.pressure_altitude(track["static_pressure"]))
    return {"pressure_height": height - grid.smooth(track["altitude"], gps=True)}


def _temperature(track: Track, grid: Grid) -> dict[str, Array]:
    if "total_temperature" not in track:
        return {}
    pressure = track["static_pressure"]
    standard = air.standard_temperature(air.pressure_altitude(pressure))
    expected = air.total_temperature(standard, mach_number(track))
    return {"temperature": grid.smooth(track["total_temperature"]) - grid.smooth(expected)}


def _attitude_rates(track: Track, grid: Grid) -> dict[str, Array]:
    """Return gyros less the change of the attitude, about the body axes, over each step.

    Empty where the track holds angular accelerations, whose rates were derived from the same
    records.
    """
    if MOMENTS[0] in track or not all(name in track for name in (*ATTITUDE, *RATES)):
        return {}
    told = euler_rates(*(track[name] for name in (*RATES, "roll", "pitch")))
    gap = [
        grid.mean_between(rate) - grid.rate(grid.smooth(track[name]), track)
        for name, rate in zip(ATTITUDE, told, strict=True)
    ]
    about = body_rates(*gap, *(grid.smooth(track[name]) for name in ("roll", "pitch")))
    return dict(zip(ATTITUDE_RATES, about, strict=True))


def _climb_rate(track: Track, grid: Grid) -> dict[str, Array]:
    """The change of the altitude less the vertical speed, over each step."""
    if not ("altitude" in track and "velocity_down" in track):
        return {}
    climbed = grid.rate(grid.smooth(track["altitude"], gps=True), track)
    return {"climb_rate": climbed + grid.mean_between(track["velocity_down"], gps=True)}


def _acceleration(track: Track, grid: Grid, frame: Frame) -> dict[str, Array]:
    earth = earth_acceleration(track)
    if earth is None or "velocity_north" not in track:
        return {}
    names = ["velocity_north", "velocity_east"] + (
        ["velocity_down"] if "velocity_down" in track else []
    )
    gap = np.zeros((len(grid), 3))
    for i, name in enumerate(names):
        gap[:, i] = grid.rate(grid.smooth(track[name], gps=True), track) - grid.mean_between(
            earth[i], gps=True
        )
    parts = frame.turned(np.where(grid.first[:, None], 0.0, gap), len(names) == 3)
    return {
        f"acceleration_{name}": parts[:, i]
        for i, name in enumerate(("forward", "right", "down")[: parts.shape[1]])
    }


def _forces(track: Track, grid: Grid, predicted: Array) -> dict[str, Array]:
    return {name: grid.smooth(track[name]) - predicted[:, i] for i, name in enumerate(FORCES)}


def _engines(track: Track, grid: Grid, predicted: Array, split: float) -> dict[str, Array]:
    column = {name: i for i, name in enumerate(REACTION_NAMES)}
    present = [name for name in ENGINES if name in track]
    residuals = {name: grid.smooth(track[name]) - predicted[:, column[name]] for name in present}
    if (
        present and "throttle_right" in track
    ):  # levers alone, without any gauge, say nothing of the engines
        apart = track["throttle_left"] - track["throttle_right"]
        residuals["throttle_split"] = grid.smooth(apart - split)
    return residuals


def _moments(track: Track, grid: Grid, model: Replay, answer: Array) -> dict[str, Array]:
    """Return the measured less the model's mean angular acceleration over each step.

    The measured one is the track's own, or else the change of the body rate.
    """
    residuals = {}
    for i, (rate, name) in enumerate(zip(RATES, MOMENTS, strict=True), start=len(FORCES)):
        if name in track:
            predicted = grid.smooth_answer(answer, model.rows)[:, i]
            residuals[name] = grid.smooth(track[name]) - predicted
            continue
        moved = grid.rate(grid.smooth(track[rate]), track)
        residuals[name] = np.where(
            grid.first, 0.0, moved - _mean_answer(track, grid, model.rows, answer[:, i])
        )
    return residuals


def _mean_answer(track: Track, grid: Grid, rows: Indices, values: Array) -> Array:
    """Mean of an answer at some rows, (m,), since the previous instant, (n,)."""
    return grid.mean_between(np.interp(np.arange(len(track.time)), rows, values))


# The force meter: a motion, the overlay to put on the aircraft, and whether the engines run along.
ReactWith = Callable[[Motion, Overlay, bool], Reaction]
# The changes by unit forces: a motion, and the paths of properties to record.
UnitForcesWith = Callable[[Motion, frozenset[str]], UnitForces]


@dataclass(frozen=True, slots=True)
class AircraftModel:
    """The analyst's model of an aircraft: a force meter with overlays, and data for effects.

    `mass` [kg] is that with the load and the fuel of its file, for logs that hold none. `controls`
    are the surfaces and throttles that a log must hold so that the force meter can be moved along
    it. `errors` are the standard deviations of the sizes that were patched into it, by effect and
    parameter. `split` is the left less the right throttle with the levers together, as it was
    patched.
    """

    name: str
    react: ReactWith
    unit_forces: UnitForcesWith
    baseline: Baseline
    mass: float
    controls: tuple[str, ...] = CONTROLS
    errors: PatchErrors = field(default_factory=PatchErrors)
    split: float = 0.0


@dataclass(frozen=True, slots=True)
class ForceModel:
    """An aircraft model on the force meter along one log.

    `replay` is its answer along the measured track. `units` are the changes by unit forces along
    the clean track at the rows of `replay`, with the properties that the functions of all effects
    read. `coarse` is the motion of the clean track in steps of 1 s. What was measured in that
    motion is kept: `unchanged` by whether the engines run, `kept` by overlay.
    """

    replay: Replay
    aircraft: AircraftModel
    coarse: Motion
    units: UnitForces
    kept: dict[Overlay, Array] = field(default_factory=dict)
    unchanged: dict[bool, Array] = field(default_factory=dict)

    def along(self, motion: Motion, aircraft: AircraftModel | None = None) -> "ForceModel":
        """Return the model with its answer, or another aircraft's, along a motion measured anew.

        Its slopes stay, and what was measured in coarse steps stays for the same aircraft.
        """
        flown = aircraft or self.aircraft
        values = answer(lambda states: flown.react(states, Overlay(), True), motion)
        replay = replace(self.replay, motion=motion, values=values, split=flown.split)
        if aircraft is None:
            return replace(self, replay=replay)
        return ForceModel(replay, aircraft, self.coarse, self.units)

    def missing(self, overlay: Overlay, engines_run: bool) -> Array:
        """Return the reaction without an overlay less that with it, on the force meter, (m, 12)."""
        if overlay not in self.kept:
            self.kept[overlay] = self._without(engines_run) - self._measured(
                self.coarse, overlay, engines_run
            )
        return self.kept[overlay]

    def moved_by(self, motion: Motion) -> Array:
        """Return the reaction to another motion less that to `coarse`, at its instants, (m, 12)."""
        return self._measured(motion, Overlay(), True) - self._without(True)

    def _without(self, engines_run: bool) -> Array:
        if engines_run not in self.unchanged:
            self.unchanged[engines_run] = self._measured(self.coarse, Overlay(), engines_run)
        return self.unchanged[engines_run]

    def _measured(self, motion: Motion, overlay: Overlay, engines_run: bool) -> Array:
        return answer(lambda motion: self.aircraft.react(motion, overlay, engines_run), motion)


@dataclass(frozen=True, slots=True)
class ReferenceState:
    """The state from which signatures and free parameters are computed, as changes of residuals.

    All that depends on a hypothesis starts here. `base` are the residuals of the clean track.
    `force_model` is None where sensors alone are judged.
    """

    clean: Track
    grid: Grid
    frame: Frame
    base: ChannelResiduals
    force_model: ForceModel | None

    @property
    def replay(self) -> Replay | None:
        """The model's answer along the measured track; None without a model."""
        return None if self.force_model is None else self.force_model.replay

    def moved(self, clean: Track, model: ForceModel | None) -> "ReferenceState":
        """Return the reference state of another clean track or model, with new residuals."""
        base = channel_residuals(
            clean, self.grid, self.frame, None if model is None else model.replay
        )
        return replace(self, clean=clean, base=base, force_model=model)

    def residuals_of(self, track: Track) -> ChannelResiduals:
        """Return the residual channels of a track, with the grid, frame and model of this one."""
        return channel_residuals(track, self.grid, self.frame, self.replay, (self.clean, self.base))

    def change_by(self, track: Track) -> Array:
        """Return the residuals of a track less those of the clean track, (n, c)."""
        return self.residuals_of(track).values - self.base.values

    def blank(self) -> Array:
        """Return zeros of the shape of the residuals, (n, c), to be filled for single channels."""
        return np.zeros_like(self.base.values)

    def channel(self, name: str) -> int | None:
        """Return the column of a residual channel; None where the log does not have it."""
        return self.base.places.get(name)


def reference_state(
    track: Track,
    wind: Array,
    replay: Replay | None,
    aircraft: AircraftModel | None,
) -> ReferenceState:
    """Return the reference state of a track.

    `wind` toward north, east, down [m/s], (3,), is the wind of the clean track. `replay` and
    `aircraft` are both None where sensors alone are judged.
    """
    grid = grid_of(track)
    frame = Frame.of(track, grid)
    clean = clean_track(track, wind)
    base = channel_residuals(clean, grid, frame, replay)
    if replay is None or aircraft is None:
        return ReferenceState(clean, grid, frame, base, None)
    coarse = motion_of(clean, coarse_rows(clean))
    fine, read = motion_of(clean, replay.rows), properties_of_forces(aircraft.baseline)
    units = aircraft.unit_forces(fine, read)
    return ReferenceState(clean, grid, frame, base, ForceModel(replay, aircraft, coarse, units))
