"""Channels computed from what a display shows.

Pressures come from airspeed and altitude, velocity from speed and track.

A display shows steps. Within a step nobody knows the value, so that half a step and less stays as a
constant error of each reading. The header's table `display` holds the steps, from which the
calibration widens its bound, and `accuracy` what they leave of the velocity, where the header does
not state another one.
"""

from collections.abc import Mapping
from dataclasses import replace
from datetime import datetime, timedelta
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pitotbench import air
from pitotbench.airdata import NEEDED, mean_wind
from pitotbench.logbook.columns import (
    AIR_DATA,
    DAY,
    HEIGHT,
    PLACE,
    START,
    Table,
    clock_seconds,
    joined_clock,
    numbers,
    parse_column,
    zone_seconds,
)
from pitotbench.logbook.draft import Draft
from pitotbench.records import USUAL_ACCURACIES, BadInputError
from pitotbench.records.log import (
    GUESSED,
    NAMED,
    OF_FIXES,
    PRESSURE,
    UNITS_BY,
    UNITS_OF_A_LOG,
    Caution,
)
from pitotbench.units import DEGREE, Array, Booleans, Radians, Seconds, from_si, to_si

# 2σ of a value known to one step, in steps.
_TWO_SIGMA = float(2.0 / np.sqrt(12.0))
_SINCE_1970 = (3e8, 1e10)  # s: a clock between them counts from 1970
_EQUATOR = 6378137.0  # m, WGS 84 (NIMA TR 8350.2)
_ECCENTRICITY_SQUARED = 0.00669437999  # likewise
_FEWEST_FIXES = 16  # of which a velocity or a temperature is formed
MEDIAN_OF_NORMAL = 0.6745  # of |x| where x is normal with unit variance
_FINE = 1e-3  # of the median size of the values: a finer step does not matter
_SLOWEST_MACH = 0.1  # below it the steps of a Mach number are too coarse
_FAR = 5.0  # median departures from the usual one
_CLIMBED = 6.5  # K of the standard day, a kilometer
_ON_GRID = 1e-6  # of a step: what the rounding of a decimal leaves


def derive(draft: Draft, header: dict[str, Any]) -> None:
    """Form the channels of a log that the file holds in another form.

    `header` gets the accuracies of the display.

    A channel that the file holds itself is used as it is.
    """
    _time(draft, header)
    _altitude(draft, header)
    if DAY in header:
        from pitotbench.logbook.temperature import take_day  # most logs hold a temperature

        take_day(draft, str(header[DAY]), header)
    _units_by(draft, header)
    _temperature(draft, header)
    _airspeed(draft, header)
    _velocity(draft, header)
    _attitude(draft)
    _heading(draft)


def _units_by(draft: Draft, header: dict[str, Any]) -> None:
    """Note what fixes the units of air data and velocity in the header.

    The usual of a log, a pressure and a named velocity, is not noted. The reader's word is there
    before, none for `named`.
    """
    by = header.pop(UNITS_BY, NAMED)
    if isinstance(by, str):  # else the file is a log that was read before, which states it
        pressure = {"impact_pressure", "total_pressure"} & set(draft.channels)
        by = {"air_data": PRESSURE if pressure and by != GUESSED else by, "velocity": by}
    draft.units_by = dict(by)
    if draft.units_by != UNITS_OF_A_LOG:
        header[UNITS_BY] = draft.units_by


def _time(draft: Draft, header: dict[str, Any]) -> None:
    """Form the seconds of the log from its clock, local or not.

    A zone that is left in flight sets no clock back.

    A clock of the day, or one that counts from 1970, counts from the first row; `header` gets the
    moment of that.
    """
    clock, date, offset = (
        draft.channels.pop(name, None) for name in ("clock_time", "date", "utc_offset")
    )
    if "time" in draft.channels:
        seconds = draft.channels["time"]
        if draft.clock or _counts_from_1970(seconds):
            draft.channels["time"] = _from_start(seconds, header)
        return
    if clock is None:
        return
    if clock.dtype.kind in "fiu":
        seconds = np.asarray(clock, dtype=np.float64)
    else:
        clock = clock if date is None else joined_clock(date, clock)
        seconds = clock_seconds(draft.columns["clock_time"], clock)
    if offset is not None:
        seconds = seconds - zone_seconds(draft.columns["utc_offset"], offset)
    draft.put("time", _from_start(seconds, header), draft.columns["clock_time"], "s")


def _from_start(seconds: Seconds, header: dict[str, Any]) -> Seconds:
    known = seconds[np.isfinite(seconds)]
    if len(known) and START not in header:
        moment = datetime(1970, 1, 1) + timedelta(seconds=float(known[0]))
        header[START] = (
            # To the millisecond where it is no whole second: two logs of a flight have one clock.
            moment.isoformat(" ", "milliseconds").removesuffix(".000")
            if _counts_from_1970(known)
            else f"{moment:%H:%M:%S}"
        )
    return seconds - known[:1] if len(known) else seconds


def _counts_from_1970(seconds: Seconds) -> bool:
    known = seconds[np.isfinite(seconds)]
    return len(known) > 0 and _SINCE_1970[0] < float(known[0]) < _SINCE_1970[1]


def _temperature(draft: Draft, header: dict[str, Any]) -> None:
    """Form the air's temperature from true airspeed and Mach number where the log holds none.

    Both are of one computer, and their ratio is the speed of sound.

    Both come in steps, and at moments of their own. Their temperature is that of the standard day
    and a departure, which is linear in height where the log climbs. Without a Mach number a
    calibrated airspeed gives it.
    """
    c = draft.channels
    static, fast = c.get("static_pressure"), c.get("true_airspeed")
    if static is None or fast is None or {"air_temperature", "total_temperature"} & set(c):
        return
    mach = c.get("mach")
    if mach is None and (shown := c.get("calibrated_airspeed")) is not None:
        impact = air.impact_pressure(np.maximum(shown, 0.0))
        mach = np.asarray(air.mach_from_impact_pressure(impact, static))
    if mach is None:
        return
    standard = air.standard_temperature(air.pressure_altitude(static))
    with np.errstate(all="ignore"):
        excess = np.square(fast / mach / air.sound_speed(1.0)) - standard
    new = np.isfinite(excess) & (np.diff(excess, prepend=np.nan) != 0.0) & (mach > _SLOWEST_MACH)
    if int(new.sum()) < _FEWEST_FIXES:
        return
    departure = float(np.median(excess[new]))
    near = new & (np.abs(excess - departure) < _FAR * np.median(np.abs(excess[new] - departure)))
    height = np.nan_to_num(standard - np.nanmedian(standard))
    slope, level = (
        np.polyfit(height[near], excess[near], 1) if np.ptp(height) > _CLIMBED else (0.0, departure)
    )
    spread = 2.0 * float(np.std(excess[near]) / np.sqrt(near.sum()))
    source = "mach" if "mach" in c else "calibrated_airspeed"
    draft.put(
        "air_temperature",
        np.asarray(standard + level + slope * height),
        draft.columns["true_airspeed"],
        "k",
    )
    draft.warnings.append(
        f"the air's temperature is that of {draft.columns['true_airspeed']!r} and "
        f"{draft.columns[source]!r}: {level:+.1f} K from a standard day, ±{spread:.1f} K (2σ)"
    )
    if spread > USUAL_ACCURACIES["temperature_k"]:
        _state_accuracy(header, "temperature_k", spread)


# What stands for the impact pressure where the log does not hold it, the nearest to the sensor
# first.
_AIRSPEEDS = ("indicated_airspeed", "calibrated_airspeed", "mach", "true_airspeed")


def _airspeed(draft: Draft, header: dict[str, Any]) -> None:
    """Form the impact pressure from an airspeed.

    A Mach number and a true airspeed need the static pressure.
    """
    given = {
        name: values
        for name in _AIRSPEEDS
        if (values := draft.channels.pop(name, None)) is not None
    }
    if {"impact_pressure", "total_pressure"} & set(draft.channels):
        return
    for source, shown in given.items():
        if (impact := _impact_pressure(draft, source, np.maximum(shown, 0.0))) is None:
            continue
        draft.put("impact_pressure", impact, draft.columns[source], "pa")
        if source != "indicated_airspeed":
            draft.warnings.append(
                f"column {draft.columns[source]!r} stands for the impact pressure: what is "
                "calibrated is the output of the air data computer, and the correction is what it "
                "has left"
            )
            header[AIR_DATA] = f"computer: {source.replace('_', ' ')}"
        step = display_step(shown, draft.suffixes[source])
        if step > 0.0:
            draft.displayed.add("impact_pressure")
            header["display"] = {**_table(header, "display"), "airspeed_mps": step}
        return


def _impact_pressure(draft: Draft, source: str, shown: Array) -> Array | None:
    """Return the impact pressure of an airspeed or a Mach number, (n,).

    None where the log lacks what it needs. A true airspeed without a temperature is that of a
    standard day, which the calibration assumes as well.
    """
    static, cold, total = (
        draft.channels.get(n) for n in ("static_pressure", "air_temperature", "total_temperature")
    )
    if source in ("indicated_airspeed", "calibrated_airspeed"):
        return np.asarray(air.impact_pressure(shown))
    if static is None:
        return None
    if source == "mach":
        return np.asarray(air.impact_pressure_from_mach(shown, static))
    if cold is None and total is not None:
        mach = air.mach_from_true_airspeed(shown, total)
        return np.asarray(air.impact_pressure_from_mach(mach, static))
    if cold is None:
        cold = air.standard_temperature(air.pressure_altitude(static))
    return np.asarray(air.impact_pressure_from_true_airspeed(shown, static, cold))


_SEA_LEVEL = 350.0  # m, 2σ: height of 1013.25 hPa above the sea, from 970 to 1050 hPa
_FIELD = 300.0  # m: usual height of a place of take-off
_FIELD_SPREAD = 600.0  # m: its 2σ


def _altitude(draft: Draft, header: dict[str, Any]) -> None:
    """Form the static pressure from a height.

    That is the pressure altitude, or an altitude with the setting of the altimeter. Without the
    setting, and from a height above the place of take-off, the pressure is a standard day's, and
    `header` gets what is unknown of it.
    """
    pressure_altitude, indicated, above = (
        draft.channels.pop(name, None)
        for name in ("pressure_altitude", "indicated_altitude", "height_above_takeoff")
    )
    setting, altitude = (
        draft.channels.pop("altimeter_setting", None),
        draft.channels.get("altitude"),
    )
    if "static_pressure" in draft.channels:
        return
    source, unknown, words = "pressure_altitude", 0.0, ""
    if pressure_altitude is None and indicated is not None:
        source, pressure_altitude = "indicated_altitude", indicated
        if setting is not None:
            # The altimeter's scale is turned by the pressure altitude of its setting (ICAO Doc
            # 7488).
            pressure_altitude = indicated + air.pressure_altitude(setting)
        else:
            unknown, words = _SEA_LEVEL, "without the setting of the altimeter"
    elif pressure_altitude is None and above is not None:
        source = "height_above_takeoff"
        if altitude is None:
            field, unknown = _FIELD, _FIELD_SPREAD
            words = f"above a place of take-off that is taken to lie at {field:.0f} m"
        else:
            field, unknown = float(np.nanmedian(altitude - above)), _SEA_LEVEL
            words = f"above a place of take-off that lies at {field:.0f} m by GPS"
        pressure_altitude = above + field
    if pressure_altitude is None:
        if HEIGHT in header:
            from pitotbench.logbook.stated_height import take_height  # most logs hold a height

            accuracy = take_height(draft, str(header[HEIGHT]), _SEA_LEVEL)
            _state_accuracy(header, "static_pressure_pa", accuracy)
            draft.displayed.add("static_pressure")
        return
    pressure = np.asarray(air.standard_pressure(pressure_altitude))
    draft.put("static_pressure", pressure, draft.columns[source], "pa")
    if unknown:
        draft.warnings.append(
            f"column {draft.columns[source]!r} is a height {words}: the static pressure is that of "
            f"a standard day there, ±{unknown:.0f} m (2σ)"
        )
        a_meter = air.standard_pressure(_FIELD) - air.standard_pressure(_FIELD + 1.0)
        _state_accuracy(header, "static_pressure_pa", float(unknown * a_meter))
    if (
        display_step(pressure_altitude, draft.suffixes[source]) > 0.0
        or source != "pressure_altitude"
    ):
        draft.displayed.add("static_pressure")


def _state_accuracy(header: dict[str, Any], name: str, two_sigma: float) -> None:
    """Put the accuracy of a channel into the header, unless the header states one."""
    header["accuracy"] = {name: two_sigma, **_table(header, "accuracy")}


_COMPONENTS = ("velocity_north", "velocity_east")


def _place(latitude: Radians, longitude: Radians) -> str:
    """The middle of the positions of a log, to a mile."""
    north, east = (float(np.nanmedian(each)) / DEGREE for each in (latitude, longitude))
    return f"{abs(north):.2f}° {'NS'[north < 0.0]} {abs(east):.2f}° {'EW'[east < 0.0]}"


def _velocity(draft: Draft, header: dict[str, Any]) -> None:
    """Form the velocity from ground speed and track, else from positions.

    Where the log holds it in coarse steps, it is formed only from a finer ground speed and track.
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
    coarse = len(given) == 2 and _TWO_SIGMA * min(steps) > USUAL_ACCURACIES["velocity_mps"]
    if given and not coarse:
        return
    if (
        speed is not None
        and track is None
        and magnetic is not None
        and (not coarse or "magnetic_variation" in draft.channels)
    ):
        track = magnetic + _variation(draft, "magnetic_track", "the wind's direction is magnetic")
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
    across = float(np.nanmedian(speed)) * display_step(track, suffix)
    return display_step(speed, draft.suffixes["ground_speed"]) * across


def _show_velocity(
    draft: Draft, header: dict[str, Any], step: float, first: Array, second: Array
) -> None:
    """Note that the velocity comes from a display in steps [m/s].

    Two numbers of it tell when it was renewed.
    """
    draft.displayed.add("velocity_north")
    if "gps_fresh" not in draft.channels:
        draft.put("gps_fresh", _renewed(first, second), draft.columns["velocity_north"])
    header["display"] = {**_table(header, "display"), "ground_speed_mps": step}
    receiver = USUAL_ACCURACIES["velocity_mps"]
    _state_accuracy(header, "velocity_mps", float(np.hypot(receiver, _TWO_SIGMA * step)))


_HALF_BASE = 0.5  # s to either side between which positions are differenced, or to the next fix
_EVEN = 0.05  # of the usual step: an even clock keeps to it so nearly
_FEW_ODD = 0.01  # of the steps, that may be farther off
_ARC_PASSES = 3  # the wind comes from the arcs, and the arcs from the wind
_PAUSE = 4.0  # usual steps of a clock that is not even: a longer one is a pause


def _velocity_from_position(
    draft: Draft, header: dict[str, Any], latitude: Array, longitude: Array
) -> None:
    """Form the ground velocity from fixes of the position, by differences centered on each.

    On the ellipsoid of WGS 84. Between fixes the velocity is held. The noise of the fixes is what
    the velocity differs by from the mean of its neighbors; `header` gets it as the accuracy of the
    velocity.
    """
    time = draft.channels["time"]
    known = np.isfinite(latitude) & np.isfinite(longitude) & np.isfinite(time)
    rows = np.flatnonzero(known)
    moved = (np.diff(latitude[rows], prepend=np.nan) != 0.0) | (
        np.diff(longitude[rows], prepend=np.nan) != 0.0
    )
    rows = rows[moved]
    runs_on = time[rows] > np.r_[-np.inf, np.maximum.accumulate(time[rows])[:-1]]
    rows = rows[runs_on]
    if len(rows) < _FEWEST_FIXES:
        raise BadInputError(
            f"column {draft.columns['latitude']!r}: {len(rows)} different positions give no "
            "velocity: give a log of a flight, or one with ground speed and track"
        )
    steps = np.diff(moments := time[rows])
    usual = float(np.median(steps))
    # A clock that is even but for a few steps was set there, or stood still: no speed comes from
    # such a step.
    odd = np.abs(steps / usual - 1.0) > _EVEN
    odd = (np.diff(np.flatnonzero(runs_on)) > 1) | (
        odd if np.mean(odd) < _FEW_ODD else steps > _PAUSE * usual
    )
    reach = max(1, round(_HALF_BASE / usual))
    counted = np.r_[0, np.cumsum(odd)]
    apart = np.where(counted[reach:] > counted[:-reach], np.nan, moments[reach:] - moments[:-reach])
    phi = latitude[rows]
    bent = 1.0 - _ECCENTRICITY_SQUARED * np.sin(phi) ** 2
    meridian, parallel = (
        _EQUATOR * (1.0 - _ECCENTRICITY_SQUARED) / bent**1.5,
        _EQUATOR * np.cos(phi) / np.sqrt(bent),
    )
    turn = np.unwrap(longitude[rows])
    chords = [
        0.5 * (scale[reach:] + scale[:-reach]) * (at[reach:] - at[:-reach])
        for scale, at in ((meridian, phi), (parallel, turn))
    ]
    (north, east), (speed, heading) = _along_arcs(draft, rows, np.stack(chords) / apart, apart)
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
    receiver = USUAL_ACCURACIES["velocity_mps"]
    _state_accuracy(header, "velocity_mps", float(np.hypot(receiver, 2.0 * noise)))


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
    """Return the mean of what is between fixes (m, k − r), before and after each fix, (m, k).

    At either end it is that of the one side.
    """
    after = np.pad(between, ((0, 0), (0, reach)), "edge")
    before = np.pad(between, ((0, 0), (reach, 0)), "edge")
    return np.asarray(0.5 * (before + after))


def _noise(velocity: Array, spacing: int) -> float:
    """Return the 1σ of a velocity's noise, by third differences.

    They are of values `spacing` rows from one another, which share no fix.
    """
    third = (
        velocity[3 * spacing :]
        - 3.0 * velocity[2 * spacing : -spacing]
        + 3.0 * velocity[spacing : -2 * spacing]
    )
    third = np.abs(third - velocity[: -3 * spacing])
    third = third[np.isfinite(third)]
    return float(np.median(third) / MEDIAN_OF_NORMAL / np.sqrt(20.0)) if len(third) else 0.0


def _renewed(speed: Array, track: Array) -> Booleans:
    """Return the rows in which a display was renewed, (n,).

    On steady legs it shows the same numbers again.

    The shortest time between two changes is that between two fixes.
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


def _attitude(draft: Draft) -> None:
    """Form roll, pitch and heading from the quaternion that turns body axes to north, east, down.

    Source: Diebel (2006), Representing Attitude, equation 290.
    """
    parts = [draft.channels.pop(f"attitude_q{place}", None) for place in range(4)]
    w, x, y, z = (np.zeros(0) if part is None else part for part in parts)
    if any(part is None for part in parts):
        return
    angles = {
        "roll": np.arctan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x**2 + y**2)),
        "pitch": np.arcsin(np.clip(2.0 * (w * y - z * x), -1.0, 1.0)),
        "heading": np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y**2 + z**2)) % (2.0 * np.pi),
    }
    for name, angle in angles.items():
        if name not in draft.channels:
            draft.put(name, angle, draft.columns["attitude_q0"], "rad")


def _heading(draft: Draft) -> None:
    magnetic = draft.channels.pop("magnetic_heading", None)
    if magnetic is not None and "heading" not in draft.channels:
        heading = magnetic + _variation(draft, "magnetic_heading", "so is the heading")
        column, suffix = draft.columns["magnetic_heading"], draft.suffixes["magnetic_heading"]
        draft.put("heading", heading % (2.0 * np.pi), column, suffix)
    draft.channels.pop("magnetic_variation", None)


def _variation(draft: Draft, name: str, consequence: str) -> Array:
    variation = draft.channels.get("magnetic_variation")
    if variation is not None:
        known = np.degrees(variation[np.isfinite(variation)])
        words = f"made true by {draft.columns['magnetic_variation']!r}"
        if len(known) and not any(words in warning for warning in draft.warnings):
            draft.warnings.append(
                f"what is magnetic is {words} ({known.min():.1f} to {known.max():.1f}°, east "
                "positive)"
            )
        return np.asarray(np.nan_to_num(variation), dtype=np.float64)
    draft.warnings.append(
        Caution(
            f"column {draft.columns[name]!r} is magnetic and the log holds no magnetic variation: "
            f"{consequence}",
            "suspect",
        )
    )
    return np.zeros(len(draft.rows))


def display_step(values: Array, suffix: str) -> float:
    """Return the step of a display [SI], of which its numbers (n,) are whole multiples.

    The numbers are those in the unit of `suffix`.

    0 where no step is seen, or where it is finer than a thousandth of the values.
    """
    written = (
        np.unique(np.round(from_si(values[np.isfinite(values)], suffix), 9))
        if suffix
        else np.zeros(0)
    )
    if len(written) < 2:
        return 0.0
    step = float(np.min(np.diff(written)))
    typical = float(np.median(np.abs(written)))
    steps = written / step
    if step <= _FINE * typical or np.max(np.abs(steps - np.round(steps))) > max(
        _ON_GRID * np.max(np.abs(steps)), 1e-6
    ):
        return 0.0
    return float(to_si(step, suffix) - to_si(0.0, suffix))


def _table(header: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    found = header.get(name, {})
    return found if isinstance(found, Mapping) else {}
