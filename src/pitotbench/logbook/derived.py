"""Channels computed from what a display shows: pressures from airspeed and altitude, velocity from speed and track.

A display shows steps. Within a step nobody knows the value, so that half a step and less stays as a constant error
of each reading. The header's table `display` holds the steps, from which the calibration widens its bound, and
`accuracy` what they leave of the velocity, where the header does not state another one.
"""

from collections.abc import Mapping
from dataclasses import replace
from datetime import UTC, datetime
from typing import Any

import numpy as np

from pitotbench import air
from pitotbench.logbook.columns import (
    START,
    Table,
    clock_seconds,
    joined_clock,
    numbers,
    parse_column,
    zone_seconds,
)
from pitotbench.logbook.draft import Draft
from pitotbench.records.accuracy import USUAL_ACCURACIES
from pitotbench.units import Array, Booleans, Seconds, from_si, to_si

# 2σ of a value known to one step, in steps.
_TWO_SIGMA = float(2.0 / np.sqrt(12.0))
_SINCE_1970 = (3e8, 1e10)  # s: a clock between them counts from 1970
_FINE = 1e-3  # of the median size of the values: a finer step does not matter
_ON_GRID = 1e-6  # of a step: what the rounding of a decimal leaves


def derive(draft: Draft, header: dict[str, Any]) -> None:
    """Form the channels of a log that the file holds in another form; `header` gets the accuracies of the display.

    A channel that the file holds itself is used as it is.
    """
    _time(draft, header)
    _airspeed(draft, header)
    _altitude(draft)
    _velocity(draft, header)
    _heading(draft)


def _take(draft: Draft, name: str) -> Array | None:
    values: Array | None = draft.channels.pop(name, None)
    return values


def _put(draft: Draft, name: str, values: Array, source: str, unit: str = "pa") -> None:
    """Store a channel under the column it came from, which messages name."""
    draft.channels[name], draft.columns[name], draft.suffixes[name] = values, draft.columns[source], unit


def _time(draft: Draft, header: dict[str, Any]) -> None:
    """Form the seconds of the log from its clock, local or not; a zone that is left in flight sets no clock back.

    A clock of the day, or one that counts from 1970, counts from the first row; `header` gets the moment of that.
    """
    clock, date, offset = (draft.channels.pop(name, None) for name in ("clock_time", "date", "utc_offset"))
    if "time" in draft.channels:
        seconds = draft.channels["time"]
        if draft.clock or _counts_from_1970(seconds):
            draft.channels["time"] = _from_start(seconds, header)
        return
    if clock is None:
        return
    seconds = clock_seconds(draft.columns["clock_time"], clock if date is None else joined_clock(date, clock))
    if offset is not None:
        seconds = seconds - zone_seconds(draft.columns["utc_offset"], offset)
    _put(draft, "time", _from_start(seconds, header), "clock_time", "s")


def _from_start(seconds: Seconds, header: dict[str, Any]) -> Seconds:
    known = seconds[np.isfinite(seconds)]
    if len(known) and START not in header:
        moment = datetime.fromtimestamp(float(known[0]), UTC).replace(tzinfo=None)
        header[START] = moment.isoformat(" ", "seconds") if _counts_from_1970(known) else f"{moment:%H:%M:%S}"
    return seconds - known[:1] if len(known) else seconds


def _counts_from_1970(seconds: Seconds) -> bool:
    known = seconds[np.isfinite(seconds)]
    return len(known) > 0 and _SINCE_1970[0] < float(known[0]) < _SINCE_1970[1]


def _airspeed(draft: Draft, header: dict[str, Any]) -> None:
    source = next((n for n in ("indicated_airspeed", "calibrated_airspeed") if n in draft.channels), None)
    speed = None if source is None else _take(draft, source)
    _take(draft, "calibrated_airspeed")
    if source is None or speed is None or {"impact_pressure", "total_pressure"} & set(draft.channels):
        return
    if source == "calibrated_airspeed":
        draft.warnings.append(
            f"column {draft.columns[source]!r} is taken as the airspeed indicated: the correction is what the air "
            "data computer has left"
        )
    _put(draft, "impact_pressure", np.asarray(air.impact_pressure(np.maximum(speed, 0.0))), source)
    step = display_step(speed, draft.suffixes[source])
    if step > 0.0:
        draft.displayed.add("impact_pressure")
        header["display"] = {**_table(header, "display"), "airspeed_mps": step}


def _altitude(draft: Draft) -> None:
    """Form the static pressure from the pressure altitude, or from an altitude and the setting of the altimeter."""
    pressure_altitude, indicated = _take(draft, "pressure_altitude"), _take(draft, "indicated_altitude")
    setting = _take(draft, "altimeter_setting")
    source = "pressure_altitude"
    if pressure_altitude is None and indicated is not None and setting is not None:
        # The altimeter's scale is turned by the pressure altitude of its setting (ICAO Doc 7488).
        pressure_altitude, source = indicated + air.pressure_altitude(setting), "indicated_altitude"
    if pressure_altitude is None or "static_pressure" in draft.channels:
        return
    _put(draft, "static_pressure", np.asarray(air.standard_pressure(pressure_altitude)), source)
    if display_step(pressure_altitude, draft.suffixes[source]) > 0.0 or source == "indicated_altitude":
        draft.displayed.add("static_pressure")


def _velocity(draft: Draft, header: dict[str, Any]) -> None:
    speed, track, magnetic = (_take(draft, name) for name in ("ground_speed", "track", "magnetic_track"))
    if speed is None or {"velocity_north", "velocity_east"} & set(draft.channels):
        return
    if track is None and magnetic is not None:
        track = magnetic + _variation(draft, "magnetic_track", "the wind's direction is magnetic")
    if track is None:
        return
    _put(draft, "velocity_north", speed * np.cos(track), "ground_speed", draft.suffixes["ground_speed"])
    _put(draft, "velocity_east", speed * np.sin(track), "ground_speed", draft.suffixes["ground_speed"])
    step = display_step(speed, draft.suffixes["ground_speed"])
    if step > 0.0:
        draft.displayed.add("velocity_north")
        if "gps_fresh" not in draft.channels:
            draft.channels["gps_fresh"] = _renewed(speed, track)
            draft.columns["gps_fresh"] = draft.columns["ground_speed"]
        header["display"] = {**_table(header, "display"), "ground_speed_mps": step}
        if "velocity_mps" not in _table(header, "accuracy"):
            bound = float(np.hypot(USUAL_ACCURACIES["velocity_mps"], _TWO_SIGMA * step))  # receiver and display
            header["accuracy"] = {**_table(header, "accuracy"), "velocity_mps": bound}


def _renewed(speed: Array, track: Array) -> Booleans:
    """Return the rows in which a display was renewed, (n,): on steady legs it shows the same numbers again.

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
    pairs = [changed.get(name, (name, column)) for name, column in zip(table.names, table.columns, strict=True)]
    names, columns = zip(*pairs, strict=True)
    return replace(table, names=names, columns=columns, units=())


def _heading(draft: Draft) -> None:
    magnetic = _take(draft, "magnetic_heading")
    if magnetic is not None and "heading" not in draft.channels:
        heading = magnetic + _variation(draft, "magnetic_heading", "so is the heading")
        _put(draft, "heading", heading % (2.0 * np.pi), "magnetic_heading", draft.suffixes["magnetic_heading"])
    _take(draft, "magnetic_variation")


def _variation(draft: Draft, name: str, consequence: str) -> Array:
    variation = draft.channels.get("magnetic_variation")
    if variation is not None:
        known = np.degrees(variation[np.isfinite(variation)])
        if len(known):
            draft.warnings.append(
                f"column {draft.columns[name]!r} is magnetic: made true by "
                f"{draft.columns['magnetic_variation']!r} ({known.min():.1f} to {known.max():.1f}°, east positive)"
            )
        return np.asarray(np.nan_to_num(variation), dtype=np.float64)
    draft.warnings.append(
        f"column {draft.columns[name]!r} is magnetic and the log holds no magnetic variation: {consequence}"
    )
    return np.zeros(len(draft.rows))


def display_step(values: Array, suffix: str) -> float:
    """Return the step of a display [SI] whose numbers (n,), in the unit of `suffix`, are whole multiples of it.

    0 where no step is seen, or where it is finer than a thousandth of the values.
    """
    written = np.unique(np.round(from_si(values[np.isfinite(values)], suffix), 9)) if suffix else np.zeros(0)
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
