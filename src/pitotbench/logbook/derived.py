"""Channels computed from a display: pressures from airspeed and height, velocity from track.

The velocity takes the ground speed too.
"""

from datetime import datetime, timedelta
from typing import Any

import numpy as np

from pitotbench import air
from pitotbench.logbook.columns import (
    AIR_DATA,
    DAY,
    HEIGHT,
    START,
    clock_seconds,
    joined_clock,
    zone_seconds,
)
from pitotbench.logbook.directions import form_attitude, form_heading
from pitotbench.logbook.displays import display_step, state_accuracy, table_in
from pitotbench.logbook.draft import Draft
from pitotbench.logbook.ground_velocity import FEWEST_FIXES, form_velocity
from pitotbench.records import USUAL_ACCURACIES
from pitotbench.records.log import GUESSED, NAMED, PRESSURE, UNITS_BY, UNITS_OF_A_LOG
from pitotbench.units import Array, Seconds

_SINCE_1970 = (3e8, 1e10)  # s: a clock between them counts from 1970
_SLOWEST_MACH = 0.1  # below it the steps of a Mach number are too coarse
_FAR = 5.0  # median departures from the usual one
_CLIMBED = 6.5  # K of the standard day, a kilometer


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
    form_velocity(draft, header)
    form_attitude(draft)
    form_heading(draft)


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

    Where both are of one computer, their ratio is the speed of sound. They come in steps, and at
    moments of their own. Their temperature is that of the standard day and a departure, which is
    linear in height where the log climbs. Without a Mach number a calibrated airspeed gives it.
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
    if int(new.sum()) < FEWEST_FIXES:
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
        state_accuracy(header, "temperature_k", spread)


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
            header["display"] = {**table_in(header, "display"), "airspeed_mps": step}
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
    """Form the static pressure from a pressure altitude, or an altitude and the altimeter setting.

    Without the setting, and from a height above the place of take-off, the pressure is a standard
    day's, and `header` gets what is unknown of it.
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
            state_accuracy(header, "static_pressure_pa", accuracy)
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
        state_accuracy(header, "static_pressure_pa", float(unknown * a_meter))
    if (
        display_step(pressure_altitude, draft.suffixes[source]) > 0.0
        or source != "pressure_altitude"
    ):
        draft.displayed.add("static_pressure")
