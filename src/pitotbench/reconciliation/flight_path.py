"""The path of a log: its accelerations, velocities, and flow angles where it has no vanes."""

from collections.abc import Mapping
from itertools import pairwise

import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.signal import savgol_filter

from pitotbench import air
from pitotbench.axes import body_to_earth, earth_to_body, flow_direction
from pitotbench.reconciliation.track import (
    FORCES,
    Track,
    mach_number,
    outside_temperature,
)
from pitotbench.units import Array, MetersPerSecond

WINDOW = 3.0  # s, of the local parabolas
# s, of what a slow sensor reads less what quick ones predict: long, for the prediction holds the
# quick changes.
SLOW_WINDOW = 20.0
WANDER = 0.2  # deviation of a random walk from its local parabolas, over √window: 0.20 to 0.21 by simulation
ATTITUDE = ("roll", "pitch", "heading")
VANES = ("angle_of_attack", "sideslip")
VELOCITY = ("velocity_north", "velocity_east", "velocity_down")
# Channels of a track without vanes: the wind, and the scales of the angles of the path.
WIND = ("wind_north", "wind_east", "wind_down")
PATH_SCALES = ("path_alpha_scale", "path_sideslip_scale")


def true_airspeed_along(track: Track) -> MetersPerSecond:
    """Return the true airspeed [m/s] of the pressures and temperature of a track."""
    mach = mach_number(track)
    return mach * air.sound_speed(outside_temperature(track, mach))


def is_without_vanes(track: Track) -> bool:
    """Return whether the flow angles of a track are those of its path, for want of vanes."""
    return WIND[0] in track


def air_velocity(track: Track) -> tuple[Array, Array, Array]:
    """Return the velocity through the air toward north, east, down [m/s].

    Without vanes its direction is that of the path through the air, or else level and along the
    nose.
    """
    speed = true_airspeed_along(track)
    if is_without_vanes(track):
        alpha, beta = flow_angles(track)
    else:
        alpha = track["angle_of_attack"] if "angle_of_attack" in track else track["pitch"]
        beta = track["sideslip"] if "sideslip" in track else np.zeros_like(speed)
    flow = flow_direction(alpha, beta)
    north, east, down = speed * body_to_earth(flow, track["roll"], track["pitch"], track["heading"])
    return north, east, down


def with_path_flow(track: Track, wind: Array, mass: float) -> Track:
    """Return a track that `flow_angles` can be taken of, with a mass; what it has stays.

    `wind` is toward north, east, down [m/s], (3,), of which the last, that of vanes, is not used;
    `mass` [kg] is that of the loaded model.
    """
    ones, level = np.ones(len(track.time)), (wind[0], wind[1], 0.0)
    vanes = all(name in track for name in VANES)
    added = {} if vanes else dict(zip(WIND, level, strict=True)) | dict.fromkeys(PATH_SCALES, 0.0)
    added |= {} if "mass" in track else {"mass": mass}
    return track.replaced({name: value * ones for name, value in added.items()})


def flow_angles(track: Track) -> tuple[Array, Array]:
    """Return the angles of attack and sideslip [rad], (n,) each, of the vanes, else of the path.

    The path through the air is ground velocity less wind, in body axes (Klein and Morelli 2006, ch.
    10). It does not show the gusts, which the airplane answers within seconds, so that the quick
    changes of its angles have a scale of their own. The slow ones follow airspeed and load, and are
    whole.
    """
    if all(name in track for name in VANES):
        return track["angle_of_attack"], track["sideslip"]
    over = {**track.channels, **quick_velocity(track)}
    if "velocity_down" not in track:
        over["velocity_down"] = _sink(track)
    through = np.stack([over[n] - track[w] for n, w in zip(VELOCITY, WIND, strict=True)])
    forward, right, down = earth_to_body(through, *(track[name] for name in ATTITUDE))
    speed = np.sqrt(forward**2 + right**2 + down**2)
    angles = np.arctan2(down, forward), np.arcsin(right / np.maximum(speed, 1.0))
    alpha, beta = (
        a + track[scale] * (a - smoothed(track, a, SLOW_WINDOW))
        for scale, a in zip(PATH_SCALES, angles, strict=True)
    )
    return alpha, beta


def earth_acceleration(track: Track) -> Array | None:
    """Return the acceleration north, east, down [m/s²], (3, n); None without accelerometers."""
    if not all(name in track for name in FORCES):
        return None
    felt = np.stack([track[name] for name in FORCES])
    earth = body_to_earth(felt, track["roll"], track["pitch"], track["heading"])
    earth[2] += air.GRAVITY
    return earth


def quick_velocity(track: Track) -> Mapping[str, Array]:
    """Return the ground velocity with the quick changes of the accelerometers.

    {} without these, or where they shake.
    """
    acceleration = earth_acceleration(track)
    if acceleration is None or _is_noisy(track, acceleration):
        return {}
    gained = integrated(track, acceleration)
    return {
        name: complementary_filter(track, track[name], gained[i])
        for i, name in enumerate(VELOCITY)
        if name in track
    }


def _sink(track: Track) -> Array:
    """Return the velocity down [m/s] by static pressure, quick changes by accelerometers.

    Where the accelerometers shake, the quick changes are left out.
    """
    acceleration = earth_acceleration(track)
    sink = -_rate(track, air.pressure_altitude(track["static_pressure"]))
    if acceleration is None or _is_noisy(track, acceleration):
        return smoothed(track, sink, WINDOW)
    return complementary_filter(track, sink, integrated(track, acceleration[2]))


def _rate(track: Track, values: Array) -> Array:
    """The change of a channel a second, stretch by stretch."""
    parts = (values[begin:end] for begin, end in pairwise(track.start))
    return np.concatenate([np.gradient(part, track.row_period) for part in parts])


def _is_noisy(track: Track, acceleration: Array) -> bool:
    """Whether accelerometers, integrated over the window, are noisier than a single GPS fix.

    Differences of neighbors show the noise: twice its variance, and 20 times that of a fix in third
    differences.
    """
    names = [name for name in VELOCITY if name in track]
    a_second = np.diff(acceleration[: len(names)], axis=1).std() * np.sqrt(0.5 * track.row_period)
    fixes = np.stack([track[name][track.fix] for name in names])
    return bool(
        WANDER * a_second * np.sqrt(SLOW_WINDOW) > np.diff(fixes, 3, axis=1).std() / np.sqrt(20.0)
    )


def complementary_filter(track: Track, measured: Array, predicted: Array) -> Array:
    """The quick changes of a prediction, with the slow ones of what a channel measures."""
    return predicted + smoothed(track, measured - predicted, SLOW_WINDOW)


def integrated(track: Track, rate: Array) -> Array:
    """Return the trapezoidal integral of a rate over the rows, from zero.

    Rectangles are half a row late.
    """
    return np.asarray(cumulative_trapezoid(rate, dx=track.row_period, initial=0))


def smoothed(track: Track, values: Array, window: float) -> Array:
    length = 2 * round(0.5 * window / track.row_period) + 1
    out = values.copy()
    for begin, end in zip(track.start[:-1], track.start[1:], strict=True):
        if end - begin > length:
            out[begin:end] = savgol_filter(values[begin:end], length, 2)
    return out
