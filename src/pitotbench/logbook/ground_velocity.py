"""The ground velocity of a log that holds it as speed and track, or as positions."""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pitotbench.airdata import NEEDED, mean_wind
from pitotbench.logbook.columns import PLACE, Table, numbers, parse_column
from pitotbench.logbook.directions import variation
from pitotbench.logbook.displays import TWO_SIGMA, display_step, state_accuracy, table_in
from pitotbench.logbook.draft import Draft
from pitotbench.records import USUAL_ACCURACIES, BadInputError
from pitotbench.records.log import OF_FIXES
from pitotbench.scatter import NORMAL, white_differences
from pitotbench.units import DEGREE, Array, Booleans, Radians, Seconds, to_si

_EQUATOR = 6378137.0  # m, WGS 84 (NIMA TR 8350.2)
_ECCENTRICITY_SQUARED = 0.00669437999  # likewise
FEWEST_FIXES = 16  # of which a velocity or a temperature is formed
_COMPONENTS = ("velocity_north", "velocity_east")


def _place(latitude: Radians, longitude: Radians) -> str:
    """The middle of the positions of a log, to a mile."""
    north, east = (float(np.nanmedian(each)) / DEGREE for each in (latitude, longitude))
    return f"{abs(north):.2f}° {'NS'[north < 0.0]} {abs(east):.2f}° {'EW'[east < 0.0]}"


def form_velocity(draft: Draft, header: dict[str, Any]) -> None:
    """Form the velocity from ground speed and track, else from positions, where it is needed.

    A velocity that the log holds in coarse steps gives way only to a finer ground speed and track.
    """
    speed, track, magnetic = (
        draft.channels.pop(name, None) for name in ("ground_speed", "track", "magnetic_track")
    )
    latitude, longitude = (
        draft.channels.pop("latitude", None),
        draft.channels.pop("longitude", None),
    )
    if latitude is not None and longitude is not None and np.isfinite(latitude + longitude).any():
        header[PLACE] = _place(latitude, longitude)
    given = [name for name in _COMPONENTS if name in draft.channels]
    steps = [display_step(draft.channels[name], draft.suffixes[name]) for name in given]
    coarse = len(given) == 2 and TWO_SIGMA * min(steps) > USUAL_ACCURACIES["velocity_mps"]
    if given and not coarse:
        return
    if (
        speed is not None
        and track is None
        and magnetic is not None
        and (not coarse or "magnetic_variation" in draft.channels)
    ):
        track = magnetic + variation(draft, "magnetic_track", "the wind's direction is magnetic")
    if coarse:
        if speed is None or track is None or _area(draft, speed, track) >= np.prod(steps):
            north, east = (draft.channels[name] for name in given)
            _show_velocity(draft, header, max(steps), north, east)
            return
        draft.warnings.append(
            f"{' and '.join(repr(draft.columns[name]) for name in given)} come in steps of "
            f"{max(steps):.2g} m/s: the finer {draft.columns['ground_speed']!r} is used, with the "
            "track"
        )
    if speed is None or track is None:
        if latitude is not None and longitude is not None and "time" in draft.channels:
            _velocity_from_position(draft, header, latitude, longitude)
        return
    column, suffix = draft.columns["ground_speed"], draft.suffixes["ground_speed"]
    draft.put("velocity_north", speed * np.cos(track), column, suffix)
    draft.put("velocity_east", speed * np.sin(track), column, suffix)
    step = display_step(speed, suffix)
    if step > 0.0:
        _show_velocity(draft, header, step, speed, track)


def _area(draft: Draft, speed: Array, track: Array) -> float:
    """Return the area of the velocity [m²/s²] that the steps of speed and track leave open."""
    suffix = draft.suffixes.get("track", draft.suffixes.get("magnetic_track", ""))
    along = display_step(speed, draft.suffixes["ground_speed"])
    across = float(np.nanmedian(speed)) * display_step(track, suffix)
    return along * across


def _show_velocity(
    draft: Draft, header: dict[str, Any], step: float, first: Array, second: Array
) -> None:
    """Note that the velocity comes from a display in steps [m/s].

    Two numbers of it tell when the display was renewed.
    """
    draft.displayed.add("velocity_north")
    if "gps_fresh" not in draft.channels:
        draft.put("gps_fresh", _renewed(first, second), draft.columns["velocity_north"])
    header["display"] = {**table_in(header, "display"), "ground_speed_mps": step}
    _widen_accuracy(header, TWO_SIGMA * step)


def _widen_accuracy(header: dict[str, Any], added: float) -> None:
    """State the accuracy of a velocity [m/s, 2σ] that has an error beside the receiver's own."""
    receiver = USUAL_ACCURACIES["velocity_mps"]
    state_accuracy(header, "velocity_mps", float(np.hypot(receiver, added)))


_HALF_BASE = 0.5  # s to either side between which positions are differenced, or to the next fix
_EVEN = 0.05  # of the usual step: an even clock keeps to it so nearly
_FEW_ODD = 0.01  # of the steps, that may be farther off
_ARC_PASSES = 3  # the wind comes from the arcs, and the arcs from the wind
_COARSE = 2.0  # steps of a position: a shorter way between fixes is no velocity
_PAUSE = 4.0  # usual steps of a clock that is not even: a longer one is a pause


def _velocity_from_position(
    draft: Draft, header: dict[str, Any], latitude: Array, longitude: Array
) -> None:
    """Form the ground velocity from fixes of the position, by differences centered on each.

    Distances are those on the ellipsoid of WGS 84. Between fixes the velocity is held. The noise of
    the fixes is what the velocity differs by from the mean of its neighbors; `header` gets it as
    the accuracy of the velocity.
    """
    time = draft.channels["time"]
    rows, skips = _fixes(time, latitude, longitude)
    if len(rows) < FEWEST_FIXES:
        raise BadInputError(
            f"column {draft.columns['latitude']!r}: {len(rows)} different positions give no "
            "velocity: give a log of a flight, or one with ground speed and track"
        )
    moments = time[rows]
    odd = skips | _odd_steps(np.diff(moments))
    reach = max(1, round(_HALF_BASE / float(np.median(np.diff(moments)))))
    counted = np.r_[0, np.cumsum(odd)]
    apart = np.where(counted[reach:] > counted[:-reach], np.nan, moments[reach:] - moments[:-reach])
    chords, grid = _chords(latitude[rows], np.unwrap(longitude[rows]), reach)
    if np.nanmedian(np.hypot(*chords)) < _COARSE * grid:
        raise BadInputError(
            f"column {draft.columns['latitude']!r}: the positions come in steps of {grid:.0f} m, "
            "too coarse for a velocity: record more digits, or ground speed and track"
        )
    (north, east), (speed, heading) = _along_arcs(draft, rows, chords / apart, apart)
    last = np.searchsorted(rows, np.arange(len(time)), side="right") - 1
    for name, values in (("velocity_north", north), ("velocity_east", east)):
        held = np.where(last >= 0, values[np.maximum(last, 0)], np.nan)
        draft.put(name, held, draft.columns["latitude"], "mps")
    if "gps_fresh" not in draft.channels:
        draft.put("gps_fresh", np.isin(np.arange(len(time)), rows), draft.columns["latitude"])
    # Through the air, where a circle is a steady speed and a steady turn.
    across = float(np.nanmedian(speed)) * heading
    noise = max(_noise(speed, 2 * reach), _noise(across, 2 * reach))
    draft.warnings.append(
        f"the ground velocity is formed from {draft.columns['latitude']!r} and "
        f"{draft.columns['longitude']!r} over {2.0 * float(np.nanmedian(apart)):.2g} s, along arcs "
        f"in turns: ±{2.0 * noise:.2g} m/s of noise (2σ)"
    )
    header[OF_FIXES] = 2.0 * float(np.nanmedian(apart))
    _widen_accuracy(header, 2.0 * noise)


def _fixes(
    time: Seconds, latitude: Radians, longitude: Radians
) -> tuple[NDArray[np.intp], Booleans]:
    """Return the rows with a new position at a later time, (k,), and which steps skip one, (k − 1,)."""
    rows = np.flatnonzero(np.isfinite(latitude) & np.isfinite(longitude) & np.isfinite(time))
    moved = (np.diff(latitude[rows], prepend=np.nan) != 0.0) | (
        np.diff(longitude[rows], prepend=np.nan) != 0.0
    )
    rows = rows[moved]
    runs_on = time[rows] > np.r_[-np.inf, np.maximum.accumulate(time[rows])[:-1]]
    return rows[runs_on], np.diff(np.flatnonzero(runs_on)) > 1


def _odd_steps(steps: Seconds) -> Booleans:
    """Return which time steps give no speed, (n,).

    A clock that is even but for a few steps was set there, or stood still. One that is uneven
    everywhere has a pause where a step is far longer than usual.
    """
    usual = float(np.median(steps))
    odd = np.abs(steps / usual - 1.0) > _EVEN
    return odd if np.mean(odd) < _FEW_ODD else steps > _PAUSE * usual


def _chords(latitude: Radians, longitude: Radians, reach: int) -> tuple[Array, float]:
    """Return the ways north and east [m] from each fix to the one `reach` later, and the grid [m].

    The ways are (2, k − reach); the grid is the least change of a position.
    """
    bent = 1.0 - _ECCENTRICITY_SQUARED * np.sin(latitude) ** 2
    meridian = _EQUATOR * (1.0 - _ECCENTRICITY_SQUARED) / bent**1.5
    parallel = _EQUATOR * np.cos(latitude) / np.sqrt(bent)
    chords = [
        0.5 * (scale[reach:] + scale[:-reach]) * (at[reach:] - at[:-reach])
        for scale, at in ((meridian, latitude), (parallel, longitude))
    ]
    steps = _EQUATOR * np.diff(latitude), parallel[1:] * np.diff(longitude)
    return np.stack(chords), max(map(_shortest, steps))


def _shortest(ways: Array) -> float:
    """Return the shortest way between fixes [m] that is not zero: the step of a position."""
    return float(np.min(np.abs(ways), where=ways != 0.0, initial=np.inf))


def _along_arcs(
    draft: Draft, rows: NDArray[np.intp], chords: Array, apart: Seconds
) -> tuple[Array, Array]:
    """Return the velocities along arcs, and speed and heading through the air, (2, k) each.

    The velocities [m/s] are at the fixes in `rows` (k,); `chords` (2, k − r) [m/s] lead from each
    fix over the time `apart` [s] to the r-th after it. Speed and heading are in m/s and rad.

    A chord is shorter than its arc by sin(θ/2)/(θ/2), with θ the turn *through the air* in the
    time between: over the ground a wind makes the same circle tight here and wide there. A fix has
    the mean speed and the mean heading of the arcs before and after it.
    """
    time, reach = draft.channels["time"][rows], len(rows) - chords.shape[1]
    middle = time[: len(time) - reach] + 0.5 * apart
    known, heading = np.isfinite(chords[0]), np.full(len(middle), np.nan)
    at_fixes = _at_fixes(chords, reach)
    for _ in range(_ARC_PASSES):
        wind = _wind_at(draft, rows, at_fixes)[:, None]
        north, east = chords - wind
        heading[known] = np.unwrap(np.arctan2(east, north)[known])
        ahead, behind = (
            np.interp(middle + at * apart, middle[known], heading[known]) for at in (0.5, -0.5)
        )
        speed = np.hypot(north, east) / np.sinc(0.5 * (ahead - behind) / np.pi)
        polar = _at_fixes(np.stack([speed, heading]), reach)
        at_fixes = wind + polar[0] * np.stack([np.cos(polar[1]), np.sin(polar[1])])
    return at_fixes, polar


def _wind_at(draft: Draft, rows: NDArray[np.intp], velocity: Array) -> Array:
    """The mean wind, (2,) [m/s], by velocities (2, k) at `rows`, (k,)."""
    if "impact_pressure" not in draft.channels or "static_pressure" not in draft.channels:
        return np.zeros(2)
    moving = dict(zip(("velocity_north", "velocity_east"), velocity, strict=True))
    return mean_wind({n: moving[n] if n in moving else draft.channels[n][rows] for n in NEEDED})


def _at_fixes(between: Array, reach: int) -> Array:
    """Return the mean of what is between fixes (m, k − r) before and after each fix, (m, k).

    At either end the mean is that of the one side.
    """
    before = np.pad(between, ((0, 0), (reach, 0)), "edge")
    after = np.pad(between, ((0, 0), (0, reach)), "edge")
    return np.asarray(0.5 * (before + after))


def _noise(velocity: Array, spacing: int) -> float:
    """Return the 1σ of a velocity's noise, by third differences `spacing` rows apart.

    Rows so far apart share no fix.
    """
    third = np.concatenate(
        [white_differences(velocity[first::spacing], 3) for first in range(spacing)]
    )
    sizes = np.abs(third[np.isfinite(third)])
    return NORMAL * float(np.median(sizes)) if len(sizes) else 0.0


def _renewed(speed: Array, track: Array) -> Booleans:
    """Return the rows in which a display was renewed, also with the same numbers, (n,).

    A steady leg shows the same numbers again. The shortest time between two changes is that between
    two fixes.
    """
    changed = np.flatnonzero((np.diff(speed) != 0.0) | (np.diff(track) != 0.0)) + 1
    fresh = np.zeros(len(speed), dtype=np.bool_)
    if len(changed) < 2:
        return ~fresh
    fresh[changed[0] % int(np.min(np.diff(changed))) :: int(np.min(np.diff(changed)))] = True
    fresh[changed] = True
    return fresh


def components(table: Table) -> Table:
    """Return a table whose ground speed and true track are components toward north and east [m/s].

    Tables are joined by interpolation, and a track jumps by a full turn at north.
    """
    found = {}
    for name in table.names:
        parsed = parse_column(name)
        if parsed is not None and parsed[0].name in ("ground_speed", "track"):
            found[parsed[0].name] = (name, to_si(numbers(name, table.column(name)), parsed[1]))
    if len(found) < 2:
        return table
    (speed_name, speed), (track_name, track) = found["ground_speed"], found["track"]
    changed = {speed_name: ("velocity_north_mps", speed * np.cos(track)),
               track_name: ("velocity_east_mps", speed * np.sin(track))}  # fmt: skip
    pairs = [
        changed.get(name, (name, column))
        for name, column in zip(table.names, table.columns, strict=True)
    ]
    names, columns = zip(*pairs, strict=True)
    return replace(table, names=names, columns=columns, units=())
