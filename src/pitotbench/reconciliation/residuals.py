"""Residual channels: every measured quantity minus its prediction, along a clean track with the
model's forces.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache

import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.ndimage import maximum_filter1d
from scipy.signal import savgol_filter

from pitotbench import air
from pitotbench.axes import body_to_earth, flow_direction
from pitotbench.channels import CHANNELS
from pitotbench.effects.overlay import Baseline, Overlay
from pitotbench.reconciliation.track import (
    CONTROLS,
    GPS_CHANNELS,
    REACTION_NAMES,
    Grid,
    Replay,
    Track,
    answer,
    coarse_rows,
    grid_of,
    mach_number,
    motion_of,
    outside_temperature,
    properties_of_forces,
)
from pitotbench.records.aircraft import Motion, PatchErrors, Reaction, UnitForces
from pitotbench.timeline import Indices
from pitotbench.units import SYMBOLS, Array, MetersPerSecond

# Families: air data (wind triangle, height, temperature), kinematic (acceleration against ground
# velocity), force and moment, engine. Each channel is noise alone where sensors and model are true.
# Wind and sensor biases are free parameters of the regression.

FORCES, MOMENTS, ENGINES = REACTION_NAMES[:3], REACTION_NAMES[3:6], REACTION_NAMES[6:]
RATES = ("roll_rate", "pitch_rate", "yaw_rate")
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
    "kinematic": ("acceleration_forward", "acceleration_right", "acceleration_down"),
    "force and moment": (*FORCES, *MOMENTS),
    "engine": (*ENGINES, "throttle_split"),
}
# The channels of a track that each part of the residuals reads.
_AIR = ("impact_pressure", "static_pressure", "total_temperature", "air_temperature")
_FLOW = ("angle_of_attack", "sideslip")
_ATTITUDE = ("roll", "pitch", "heading")
_GROUND = ("velocity_north", "velocity_east", "velocity_down")
_TRIANGLE_READS = (*_AIR, *_FLOW, *_ATTITUDE, *_GROUND)
_KINEMATIC_READS = (*FORCES, *_ATTITUDE, *_GROUND)
_ANSWER_READS = (*_AIR, *_FLOW)  # the states in `VARIED`
_ENGINES_READ = (*_ANSWER_READS, *ENGINES, "throttle_left", "throttle_right")


@dataclass(frozen=True, slots=True)
class Frame:
    """Horizontal directions at the instants: along the flight through the air and across it.

    Each is a unit vector toward north, east, down, (n, 3). They come from the log and stay the same
    for every hypothesis.
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
        """Return the components along, across and (with `down`) down of vectors toward north, east,
        down.
        """
        parts = [np.sum(self.along * vectors, axis=1), np.sum(self.across * vectors, axis=1)]
        return np.stack([*parts, vectors[:, 2]] if down else parts, axis=1)


def true_airspeed_along(track: Track) -> MetersPerSecond:
    """Return the true airspeed [m/s] of the pressures and temperature of a track."""
    mach = mach_number(track)
    return mach * air.sound_speed(outside_temperature(track, mach))


def air_velocity(track: Track) -> tuple[Array, Array, Array]:
    """Return the velocity through the air toward north, east, down [m/s].

    Without vanes the flow is assumed to be level and along the nose.
    """
    speed = true_airspeed_along(track)
    alpha = track["angle_of_attack"] if "angle_of_attack" in track else track["pitch"]
    beta = track["sideslip"] if "sideslip" in track else np.zeros_like(speed)
    flow = flow_direction(alpha, beta)
    north, east, down = speed * body_to_earth(flow, track["roll"], track["pitch"], track["heading"])
    return north, east, down


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
    """Return all residual channels that a track allows; with a model also forces, moments and
    engines.

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

    columns: dict[str, Array] = {}
    part(_TRIANGLE_READS, FAMILIES["air data"][:3], lambda: _triangle(track, grid, frame))
    part(("static_pressure", "altitude"), ("pressure_height",), lambda: _height(track, grid))
    part(_AIR, ("temperature",), lambda: _temperature(track, grid))
    if model is not None:
        part((*_ANSWER_READS, *FORCES), FORCES, lambda: _forces(track, grid, predicted()))
        part(_ENGINES_READ, FAMILIES["engine"], lambda: _engines(track, grid, predicted()))
    part(_KINEMATIC_READS, FAMILIES["kinematic"], lambda: _kinematic(track, grid, frame))
    if model is not None:
        part((*_ANSWER_READS, *RATES), MOMENTS, lambda: _moments(track, grid, model, answer()))
    values = np.stack(list(columns.values()), axis=1)
    return ChannelResiduals(tuple(columns), values, np.zeros_like(values))


def change_by_answer(
    names: tuple[str, ...], track: Track, grid: Grid, rows: Indices, added: Array
) -> Array:
    """Return the change of the residuals, (n, c), by a growth of the answer of a model at `rows`,
    (m, 12).
    """
    change = np.zeros((len(grid), len(names)))
    lower = grid.smooth_answer(added, rows)
    for i, name in enumerate(REACTION_NAMES):
        if name in names:
            between = name in MOMENTS and name not in track
            felt = _mean_answer(track, grid, rows, added[:, i]) if between else lower[:, i]
            change[:, names.index(name)] = -felt
    return change


def slack(grid: Grid, model: Replay | None, names: tuple[str, ...]) -> Array:
    """Return the error of a model that is early or late by `TIMING` where it changes quickly, (n,
    c).

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
    parts = frame.turned(gap, down)
    return {
        f"airspeed_{name}": parts[:, i]
        for i, name in enumerate(("along", "across", "down")[: parts.shape[1]])
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


def earth_acceleration(track: Track) -> Array | None:
    """Return the acceleration toward north, east, down [m/s²], (3, n); None without accelerometers."""
    if not all(name in track for name in FORCES):
        return None
    felt = np.stack([track[name] for name in FORCES])
    earth = body_to_earth(felt, track["roll"], track["pitch"], track["heading"])
    earth[2] += air.GRAVITY
    return earth


def _kinematic(track: Track, grid: Grid, frame: Frame) -> dict[str, Array]:
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


def _engines(track: Track, grid: Grid, predicted: Array) -> dict[str, Array]:
    column = {name: i for i, name in enumerate(REACTION_NAMES)}
    present = [name for name in ENGINES if name in track]
    residuals = {name: grid.smooth(track[name]) - predicted[:, column[name]] for name in present}
    if (
        present and "throttle_right" in track
    ):  # levers alone, without any gauge, say nothing of the engines
        residuals["throttle_split"] = grid.smooth(track["throttle_left"] - track["throttle_right"])
    return residuals


def _moments(track: Track, grid: Grid, model: Replay, answer: Array) -> dict[str, Array]:
    """Change of each body rate over a step less the mean angular acceleration of the model; the
    angular acceleration itself where the track has it.
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


# The clean track: a track without noise and without gusts, on which signatures are computed. A
# signature made of noisy signals would carry their noise. The residuals carry the same noise, so
# that the two would correlate: a lag of this noise looks like a lag of the airplane. Noise in a
# signature also counts as knowledge: on a circle at a constant airspeed, which cannot show a lag,
# one of 0.25 s seemed to be worth 6σ. Therefore only the slow changes of a channel come from its
# own sensor, and the quick ones from the sensors that feel them best (complementary filters:
# Higgins 1975). Those of the ground velocity come from the accelerometers, those of the two heights
# from the vertical speed, those of the temperature from height and airspeed. Impact pressure is
# that of ground velocity and wind. All else is smoothed by local parabolas (Savitzky and Golay
# 1964).

WINDOW = 3.0  # s, of the local parabolas
# s, for a GPS without accelerometers: with 3 s its noise made a latency of 0.30 s come out as 0.24
# s.
GPS_WINDOW = 4.5
# s, of what a slow sensor reads less what quick ones predict: long, for the prediction holds the
# quick changes.
SLOW_WINDOW = 20.0
WANDER = 0.2  # deviation of a random walk from its local parabolas, over √window: 0.20 to 0.21 by simulation
VELOCITY = ("velocity_north", "velocity_east", "velocity_down")
UNSMOOTHED = ("throttle_left", "throttle_right", "mass")  # steps of these channels are real


def clean_track(track: Track, wind: Array) -> Track:
    """Return the smoothed track; `wind` is toward north, east, down [m/s], (3,)."""
    changing = {name: values for name, values in track.channels.items() if name not in UNSMOOTHED}
    smooth = track.replaced(
        {name: _smoothed(track, values, WINDOW) for name, values in changing.items()}
    )
    smooth = smooth.replaced({"static_pressure": _static_pressure(track, smooth)})
    velocity = _velocity(track)
    smooth = smooth.replaced(velocity)
    smooth = smooth.replaced(_impact_pressure(smooth, wind))
    smooth = smooth.replaced(_total_temperature(track, smooth))
    slow = [name for name in GPS_CHANNELS if name in track and name not in velocity]
    smooth = smooth.replaced({name: _smoothed(track, track[name], GPS_WINDOW) for name in slow})
    return smooth.replaced(_altitude(track, smooth))


def _complementary_filter(track: Track, measured: Array, predicted: Array) -> Array:
    """The quick changes of a prediction, with the slow ones of what a channel measures."""
    return predicted + _smoothed(track, measured - predicted, SLOW_WINDOW)


def _integrated(track: Track, rate: Array) -> Array:
    """The integral of a rate over the rows, from zero; by trapezoids, for rectangles are half a row
    late.
    """
    return np.asarray(cumulative_trapezoid(rate, dx=track.row_period, initial=0))


def _velocity(track: Track) -> Mapping[str, Array]:
    """Ground velocity with the quick changes of the accelerometers; empty without these, or where
    they shake.
    """
    acceleration = earth_acceleration(track)
    if acceleration is None or _is_noisy(track, acceleration):
        return {}
    gained = _integrated(track, acceleration)
    return {
        name: _complementary_filter(track, track[name], gained[i])
        for i, name in enumerate(VELOCITY)
        if name in track
    }


def _is_noisy(track: Track, acceleration: Array) -> bool:
    """Whether the noise of accelerometers, integrated over the window, is above that of a single
    GPS fix.

    Differences of neighbors show the noise: twice its variance, and 20 times that of a fix in third
    differences.
    """
    names = [name for name in VELOCITY if name in track]
    a_second = np.diff(acceleration[: len(names)], axis=1).std() * np.sqrt(0.5 * track.row_period)
    fixes = np.stack([track[name][track.fix] for name in names])
    return bool(
        WANDER * a_second * np.sqrt(SLOW_WINDOW) > np.diff(fixes, 3, axis=1).std() / np.sqrt(20.0)
    )


def _static_pressure(track: Track, smooth: Track) -> Array:
    """Static pressure whose quick changes come from the vertical speed and not from sensor noise."""
    down = smooth["velocity_down"] if "velocity_down" in smooth else air_velocity(smooth)[2]
    height = air.pressure_altitude(track["static_pressure"])
    return air.standard_pressure(_complementary_filter(track, height, -_integrated(track, down)))


def _altitude(track: Track, smooth: Track) -> Mapping[str, Array]:
    """GPS altitude whose quick changes come from the vertical velocity; empty without one of the
    two.
    """
    if "altitude" not in track or "velocity_down" not in track:
        return {}
    return {
        "altitude": _complementary_filter(
            track, track["altitude"], -_integrated(track, smooth["velocity_down"])
        )
    }


def _total_temperature(track: Track, smooth: Track) -> Mapping[str, Array]:
    """Total temperature whose quick changes come from height and airspeed and not from sensor
    noise.
    """
    if "total_temperature" not in track:
        return {}
    standard = air.standard_temperature(air.pressure_altitude(smooth["static_pressure"]))
    expected = air.total_temperature(standard, mach_number(smooth))
    return {"total_temperature": _complementary_filter(track, track["total_temperature"], expected)}


def _smoothed(track: Track, values: Array, window: float) -> Array:
    length = 2 * round(0.5 * window / track.row_period) + 1
    out = values.copy()
    for begin, end in zip(track.start[:-1], track.start[1:], strict=True):
        if end - begin > length:
            out[begin:end] = savgol_filter(values[begin:end], length, 2)
    return out


def _impact_pressure(track: Track, wind: Array) -> Mapping[str, Array]:
    """Impact pressure of the airspeed that ground velocity and wind give."""
    through = np.stack(air_velocity(track), axis=1)
    along = through / true_airspeed_along(track)[:, None]
    over = np.stack(
        [track[n] if n in track else through[:, i] + wind[i] for i, n in enumerate(VELOCITY)],
        axis=1,
    )
    speed = np.sum(along * (over - wind), axis=1)
    pressure = track["static_pressure"]
    temperature = outside_temperature(track, mach_number(track))
    return {
        "impact_pressure": air.impact_pressure_from_true_airspeed(
            np.maximum(speed, 1.0), pressure, temperature
        )
    }


# The reference state of a log: the clean track, its residuals, and the force meter where there is
# an aircraft model. All that depends on a hypothesis starts here: signatures of effects and columns
# of free parameters are changes of its residuals.

# The force meter: a motion, the overlay to put on the aircraft, and whether the engines run along.
ReactWith = Callable[[Motion, Overlay, bool], Reaction]
# The changes by unit forces: a motion, and the paths of properties to record.
UnitForcesWith = Callable[[Motion, frozenset[str]], UnitForces]


@dataclass(frozen=True, slots=True)
class AircraftModel:
    """The analyst's model of an aircraft: a force meter that takes overlays, and the data that
    effects need.

    `controls` are the surfaces and throttles that a log must hold so that the force meter can be
    moved along it. `errors` are the standard deviations of the sizes that were patched into it, by
    effect and parameter.
    """

    name: str
    react: ReactWith
    unit_forces: UnitForcesWith
    baseline: Baseline
    controls: tuple[str, ...] = CONTROLS
    errors: PatchErrors = field(default_factory=PatchErrors)


@dataclass(frozen=True, slots=True)
class ForceModel:
    """An aircraft model on the force meter along one log.

    `replay` is its answer along the measured track. `coarse` is the motion of the clean track in
    steps of 1 s. `units` are the changes by unit forces in that motion, with the properties that
    the functions of all effects read. What was measured in that motion is kept: `unchanged` by
    whether the engines run, `kept` by overlay.
    """

    replay: Replay
    aircraft: AircraftModel
    coarse: Motion
    units: UnitForces
    kept: dict[Overlay, Array] = field(default_factory=dict)
    unchanged: dict[bool, Array] = field(default_factory=dict)

    def along(self, motion: Motion, aircraft: AircraftModel | None = None) -> "ForceModel":
        """Return the model with its answer along a motion measured anew, or with that of another
        aircraft.

        Its slopes stay, and what was measured in coarse steps stays for the same aircraft.
        """
        flown = aircraft or self.aircraft
        values = answer(lambda states: flown.react(states, Overlay(), True), motion)
        replay = replace(self.replay, motion=motion, values=values)
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
        """Return the reaction to another motion at the instants of `coarse` less that to `coarse`,
        (m, 12).
        """
        return self._measured(motion, Overlay(), True) - self._without(True)

    def _without(self, engines_run: bool) -> Array:
        if engines_run not in self.unchanged:
            self.unchanged[engines_run] = self._measured(self.coarse, Overlay(), engines_run)
        return self.unchanged[engines_run]

    def _measured(self, motion: Motion, overlay: Overlay, engines_run: bool) -> Array:
        return answer(lambda motion: self.aircraft.react(motion, overlay, engines_run), motion)


@dataclass(frozen=True, slots=True)
class ReferenceState:
    """The data from which signatures and free parameters are computed.

    `base` are the residuals of the clean track. `force_model` is None where sensors alone are
    judged.
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
        """Return the reference state of another clean track or with another model: its residuals
        are computed anew.
        """
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
    units = aircraft.unit_forces(coarse, properties_of_forces(aircraft.baseline))
    return ReferenceState(clean, grid, frame, base, ForceModel(replay, aircraft, coarse, units))
