"""Residual channels: every measured quantity minus what the others, and the aircraft model, say it should be.

Families: air data (wind triangle, height, temperature), kinematic (acceleration against ground velocity), force
and moment, engine. Each channel is zero but for noise where sensors and model are true; wind and sensor biases are
taken out later as columns of a regression.
"""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import maximum_filter1d

from pitotbench import air
from pitotbench.axes import body_to_earth, flow_direction
from pitotbench.reconcile.residuals.grid import Grid
from pitotbench.reconcile.residuals.replay import REACTION_NAMES, Replay, motion_of, outside_temperature
from pitotbench.reconcile.residuals.track import Track, mach_number
from pitotbench.units import Array, MetersPerSecond

FORCES, MOMENTS, ENGINES = REACTION_NAMES[:3], REACTION_NAMES[3:6], REACTION_NAMES[6:]
RATES = ("roll_rate", "pitch_rate", "yaw_rate")
TIMING = 0.1  # s, one step of the replay
NEAR = 4  # instants on either side
QUICK = 6.0  # times the usual rate: gusts and sensor noise stay below
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


@dataclass(frozen=True, slots=True)
class Frame:
    """Directions at the instants that belong to the log, not to a hypothesis: along the flight through the air and
    across it, in the horizontal (n, 3) each, toward north, east, down."""

    along: Array
    across: Array

    @classmethod
    def of(cls, track: Track, grid: Grid) -> "Frame":
        """From the air velocity of the log itself."""
        level = np.stack([grid.smooth(v) for v in air_velocity(track)], axis=1)[:, :2]
        level = level / np.linalg.norm(level, axis=1)[:, None]
        zero = np.zeros(len(level))
        return cls(
            np.stack([level[:, 0], level[:, 1], zero], axis=1), np.stack([-level[:, 1], level[:, 0], zero], axis=1)
        )

    def turned(self, vectors: Array, down: bool) -> Array:
        """Components along, across and, where asked for, down of vectors toward north, east, down."""
        parts = [np.sum(self.along * vectors, axis=1), np.sum(self.across * vectors, axis=1)]
        return np.stack([*parts, vectors[:, 2]] if down else parts, axis=1)


def true_airspeed_along(track: Track) -> MetersPerSecond:
    """True airspeed [m/s] of a track's pressures and temperature."""
    mach = mach_number(track)
    return mach * air.sound_speed(outside_temperature(track, mach))


def air_velocity(track: Track) -> tuple[Array, Array, Array]:
    """Velocity through the air toward north, east, down [m/s]; without vanes the flow is taken to be level and
    along the nose."""
    speed = true_airspeed_along(track)
    alpha = track["angle_of_attack"] if "angle_of_attack" in track else track["pitch"]
    beta = track["sideslip"] if "sideslip" in track else np.zeros_like(speed)
    flow = flow_direction(alpha, beta)
    north, east, down = speed * body_to_earth(flow, track["roll"], track["pitch"], track["heading"])
    return north, east, down


@dataclass(frozen=True, slots=True)
class ChannelResiduals:
    """Residual channels by name, (n, c); `slack` is the deviation that adds to the noise where the model changes
    quickly or an instant says little."""

    names: tuple[str, ...]
    values: Array
    slack: Array


def channel_residuals(track: Track, grid: Grid, frame: Frame, model: Replay | None) -> ChannelResiduals:
    """All residual channels that a track allows; with a model also forces, moments and engines.

    With a replay of another track the model's answer is moved to this one's state, to first order.
    """
    parts = _triangle(track, grid, frame) | _height(track, grid) | _temperature(track, grid)
    late: dict[str, Array] = _kinematic(track, grid, frame)
    if model is not None:
        answer = model.shifted(motion_of(track, model.rows))
        seen = grid.smooth_answer(answer, model.rows)
        parts |= _forces(track, grid, seen) | _engines(track, grid, seen)
        late |= _moments(track, grid, model, answer)
    values = np.stack([*parts.values(), *late.values()], axis=1)
    return ChannelResiduals((*parts, *late), values, np.zeros_like(values))


def slack(grid: Grid, model: Replay | None, names: tuple[str, ...]) -> Array:
    """What a model that is early or late by `TIMING` errs where it changes quickly: an engine's answer to a lever,
    a propeller that meets its stop; seen by the instants near it as well, (n, c)."""
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
    seen = grid.smooth(air.pressure_altitude(track["static_pressure"]))
    return {"pressure_height": seen - grid.smooth(track["altitude"], gps=True)}


def _temperature(track: Track, grid: Grid) -> dict[str, Array]:
    if "total_temperature" not in track:
        return {}
    pressure = track["static_pressure"]
    standard = air.standard_temperature(air.pressure_altitude(pressure))
    expected = air.total_temperature(standard, mach_number(track))
    return {"temperature": grid.smooth(track["total_temperature"]) - grid.smooth(expected)}


def _kinematic(track: Track, grid: Grid, frame: Frame) -> dict[str, Array]:
    force = ("specific_force_x", "specific_force_y", "specific_force_z")
    if not all(name in track for name in force):
        return {}
    felt = np.stack([track[name] for name in force])
    earth = body_to_earth(felt, track["roll"], track["pitch"], track["heading"])
    earth[2] += air.GRAVITY
    names = ["velocity_north", "velocity_east"] + (["velocity_down"] if "velocity_down" in track else [])
    gap = np.zeros((len(grid), 3))
    for i, name in enumerate(names):
        gap[:, i] = grid.rate(grid.smooth(track[name], gps=True), track) - grid.mean_between(earth[i], gps=True)
    parts = frame.turned(np.where(grid.first[:, None], 0.0, gap), len(names) == 3)
    return {
        f"acceleration_{name}": parts[:, i] for i, name in enumerate(("forward", "right", "down")[: parts.shape[1]])
    }


def _forces(track: Track, grid: Grid, seen: Array) -> dict[str, Array]:
    return {name: grid.smooth(track[name]) - seen[:, i] for i, name in enumerate(FORCES)}


def _engines(track: Track, grid: Grid, seen: Array) -> dict[str, Array]:
    column = {name: i for i, name in enumerate(REACTION_NAMES)}
    present = [name for name in ENGINES if name in track]
    split = grid.smooth(track["throttle_left"] - track["throttle_right"])
    return {name: grid.smooth(track[name]) - seen[:, column[name]] for name in present} | {"throttle_split": split}


def _moments(track: Track, grid: Grid, model: Replay, answer: Array) -> dict[str, Array]:
    """Change of a body rate over a step against the mean angular acceleration."""
    found = {}
    for i, (rate, name) in enumerate(zip(RATES, MOMENTS, strict=True), start=len(FORCES)):
        moved = grid.rate(grid.smooth(track[rate]), track)
        felt = np.interp(np.arange(len(track.time)), model.rows, answer[:, i])
        found[name] = np.where(grid.first, 0.0, moved - grid.mean_between(felt))
    return found
