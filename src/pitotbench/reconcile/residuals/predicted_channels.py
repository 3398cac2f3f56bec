"""Residual channels: every measured quantity minus its prediction from the others and the aircraft model.

Families: air data (wind triangle, height, temperature), kinematic (acceleration against ground velocity), force and
moment, engine. Each channel is noise alone where sensors and model are true. Wind and sensor biases are free
parameters of the regression.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.ndimage import maximum_filter1d

from pitotbench import air
from pitotbench.axes import body_to_earth, flow_direction
from pitotbench.reconcile.residuals.grid import Grid, Indices
from pitotbench.reconcile.residuals.replay import REACTION_NAMES, Replay, outside_temperature
from pitotbench.reconcile.residuals.track import Track, mach_number
from pitotbench.units import Array, MetersPerSecond

FORCES, MOMENTS, ENGINES = REACTION_NAMES[:3], REACTION_NAMES[3:6], REACTION_NAMES[6:]
RATES = ("roll_rate", "pitch_rate", "yaw_rate")
TIMING = 0.1  # s, one step of the replay: by so much the model may be early or late
NEAR = 4  # instants on either side over which an error of timing shows
QUICK = 6.0  # times the median rate: gusts and sensor noise stay below
UNITS = {
    **dict.fromkeys(("airspeed_along", "airspeed_across", "airspeed_down"), "m/s"),
    "pressure_height": "m",
    "temperature": "K",
    **dict.fromkeys(("acceleration_forward", "acceleration_right", "acceleration_down", *FORCES), "m/s²"),
    **dict.fromkeys(MOMENTS, "rad/s²"),
    **dict(zip(ENGINES, ("Pa", "Pa", "rad/s", "rad/s", "kg/s", "kg/s"), strict=True)),
    "throttle_split": "",
}
FAMILIES = {
    "air data": ("airspeed_along", "airspeed_across", "airspeed_down", "pressure_height", "temperature"),
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

    Each is a unit vector toward north, east, down, (n, 3). They come from the log and stay the same for every
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
            np.stack([level[:, 0], level[:, 1], zero], axis=1), np.stack([-level[:, 1], level[:, 0], zero], axis=1)
        )

    def turned(self, vectors: Array, down: bool) -> Array:
        """Return the components along, across and (with `down`) down of vectors toward north, east, down."""
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

    `slack` is a standard deviation that adds to the noise, (n, c), where the model changes quickly or an instant
    holds little information.
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
    """Return all residual channels that a track allows; with a model also forces, moments and engines.

    The answer of a model that was moved along another track is shifted to this state, to first order. `known` is
    another track with its residuals on the same grid, frame and model: what reads none of the channels in which the
    two tracks differ is taken from there.
    """

    def part(reads: tuple[str, ...], names: tuple[str, ...], computed: Callable[[], dict[str, Array]]) -> None:
        if known is None or any(track.channels.get(n) is not known[0].channels.get(n) for n in reads):
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


def change_by_answer(names: tuple[str, ...], track: Track, grid: Grid, rows: Indices, added: Array) -> Array:
    """Return the change of the residuals, (n, c), by a growth of the answer of a model at `rows`, (m, 12)."""
    change = np.zeros((len(grid), len(names)))
    lower = grid.smooth_answer(added, rows)
    for i, name in enumerate(REACTION_NAMES):
        if name in names:
            felt = _mean_answer(track, grid, rows, added[:, i]) if name in MOMENTS else lower[:, i]
            change[:, names.index(name)] = -felt
    return change


def slack(grid: Grid, model: Replay | None, names: tuple[str, ...]) -> Array:
    """Return the error of a model that is early or late by `TIMING` where it changes quickly, (n, c).

    Examples: an engine that answers to a lever, a propeller that meets its stop. The instants near it get the same
    slack.
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
    through = np.stack([grid.smooth(v) for v in air_velocity(track)], axis=1)
    down = "velocity_down" in track
    ground = ["velocity_north", "velocity_east", *(["velocity_down"] if down else [])]
    over = np.stack([grid.smooth(track[name], gps=True) for name in ground], axis=1)
    gap = np.zeros((len(grid), 3))
    gap[:, : len(ground)] = over - through[:, : len(ground)]
    parts = frame.turned(gap, down)
    return {f"airspeed_{name}": parts[:, i] for i, name in enumerate(("along", "across", "down")[: parts.shape[1]])}


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
    if earth is None:
        return {}
    names = ["velocity_north", "velocity_east"] + (["velocity_down"] if "velocity_down" in track else [])
    gap = np.zeros((len(grid), 3))
    for i, name in enumerate(names):
        gap[:, i] = grid.rate(grid.smooth(track[name], gps=True), track) - grid.mean_between(earth[i], gps=True)
    parts = frame.turned(np.where(grid.first[:, None], 0.0, gap), len(names) == 3)
    return {
        f"acceleration_{name}": parts[:, i] for i, name in enumerate(("forward", "right", "down")[: parts.shape[1]])
    }


def _forces(track: Track, grid: Grid, predicted: Array) -> dict[str, Array]:
    return {name: grid.smooth(track[name]) - predicted[:, i] for i, name in enumerate(FORCES)}


def _engines(track: Track, grid: Grid, predicted: Array) -> dict[str, Array]:
    column = {name: i for i, name in enumerate(REACTION_NAMES)}
    present = [name for name in ENGINES if name in track]
    split = grid.smooth(track["throttle_left"] - track["throttle_right"])
    return {name: grid.smooth(track[name]) - predicted[:, column[name]] for name in present} | {
        "throttle_split": split
    }


def _moments(track: Track, grid: Grid, model: Replay, answer: Array) -> dict[str, Array]:
    """Change of each body rate over a step less the mean angular acceleration of the model."""
    residuals = {}
    for i, (rate, name) in enumerate(zip(RATES, MOMENTS, strict=True), start=len(FORCES)):
        moved = grid.rate(grid.smooth(track[rate]), track)
        residuals[name] = np.where(grid.first, 0.0, moved - _mean_answer(track, grid, model.rows, answer[:, i]))
    return residuals


def _mean_answer(track: Track, grid: Grid, rows: Indices, values: Array) -> Array:
    """Mean of an answer at some rows, (m,), since the previous instant, (n,)."""
    return grid.mean_between(np.interp(np.arange(len(track.time)), rows, values))
