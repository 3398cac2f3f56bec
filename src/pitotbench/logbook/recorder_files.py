"""Read the files of flight recorders of gliders (IGC).

Source: the FAI's Technical Specification for GNSS Flight Recorders.
"""

import re
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pitotbench.logbook.columns import KIND, SECONDS_A_DAY, START, Table
from pitotbench.logbook.csv import unpacked
from pitotbench.records import BadInputError
from pitotbench.units import Array

# Where the numbers of a B record stand: first byte, and the byte after the last.
_CLOCK = ((1, 3), (3, 5), (5, 7))  # hours, minutes, seconds
_LATITUDE = ((7, 9), (9, 14))  # degrees, and thousandths of a minute
_SOUTH = 14  # the letter N or S
_LONGITUDE = ((15, 18), (18, 23))  # degrees, and thousandths of a minute
_WEST = 23  # the letter E or W
_FIX = 24  # the letter A of a fix in three dimensions
_PRESSURE_ALTITUDE = (25, 30)  # m
_GPS_ALTITUDE = (30, 35)  # m
_SHORTEST = 35  # bytes of a record
_DATE = re.compile(rb"^HFDTE(?:DATE:)?\s*(\d\d)(\d\d)(\d\d)", re.MULTILINE)
_NUMBER = re.compile(rb"-?\d+")
_EXTENSION = re.compile(rb"(\d\d)(\d\d)([A-Z]{3})")
_KEPT = {"glider": rb"^H.GTY[^:\r\n]*:([^\r\n]*)", "recorder": rb"^H.FTY[^:\r\n]*:([^\r\n]*)"}

# The extensions that are channels: our column, and the digits before the decimal point. The records
# state no unit and no point; recorders write km/h, degrees and °C, and more digits where they know
# them better.
_CHANNELS: dict[str, tuple[str, int]] = {
    "IAS": ("indicated_airspeed_kmh", 3),
    "TAS": ("true_airspeed_kmh", 3),
    "GSP": ("ground_speed_kmh", 3),
    "TRT": ("track_deg", 3),
    "TRM": ("magnetic_track_deg", 3),
    "HDT": ("heading_deg", 3),
    "HDM": ("magnetic_heading_deg", 3),
    "OAT": ("air_temperature_degc", 3),
}


_AIRSPEEDS = ("indicated_airspeed", "true_airspeed")


def read_igc(path: Path) -> Table:
    """Return the fixes of a recorder, packed or not, as columns of ours.

    Rows without a fix of three dimensions are left out, with a warning. Of the header only the
    types of glider and recorder are kept: it names people. Raises BadInputError for a file without
    fixes.
    """
    data = unpacked(path)
    lines = data.split(b"\n")
    written = [line.rstrip() for line in lines if line.startswith(b"B")]
    usual = int(np.median([len(line) for line in written])) if written else 0
    # The bytes of each extension of the B records, from the I record: `3638FXA`, counted from 1.
    listed = _EXTENSION.findall(next((line for line in lines if line.startswith(b"I")), b"")[3:])
    spans = {code.decode(): (int(first) - 1, int(end)) for first, end, code in listed}
    extensions = {n: (a, b) for n, (a, b) in spans.items() if _SHORTEST <= a < b <= usual}
    length = max([_SHORTEST, *(end for _, end in extensions.values())])
    whole = [line[:length] for line in written if len(line) >= length]
    if not whole:
        raise BadInputError(
            "not an IGC file: it holds no fix (no line begins with B); load it from the recorder "
            "again"
        )
    fixes = np.frombuffer(b"".join(whole), dtype="S1").reshape(len(whole), length)
    fixed = (*_CLOCK, *_LATITUDE, *_LONGITUDE, _PRESSURE_ALTITUDE, _GPS_ALTITUDE)
    legible = np.array([np.isfinite(_numbers(fixes, span)) for span in fixed])
    for (first, end), rows in zip(fixed, legible, strict=True):
        if not rows.any():
            raise BadInputError(
                f"the fixes hold no number at bytes {first + 1} to {end}; load the file from the "
                "recorder again"
            )
    valid = legible.all(axis=0) & (fixes[:, _FIX] == b"A")
    if not valid.any():
        raise BadInputError(
            "the recorder had no fix of three dimensions in the whole flight; use another log"
        )
    warnings = ["read as the IGC file of a flight recorder"]
    if len(whole) < len(written) or not valid.all():
        warnings.append(
            f"{len(written) - int(valid.sum())} of {len(written)} fixes are left out: broken off, "
            "illegible, or without height"
        )
    if lost := spans.keys() - extensions.keys():
        warnings.append(
            f"the extensions {', '.join(sorted(lost))} are left out: their bytes are not those of "
            "an extension of the fixes"
        )
    columns = _columns(fixes[valid], extensions)
    if not any(name.startswith(_AIRSPEEDS) for name in columns):
        named = ", ".join(sorted(spans)) or "no extension"
        raise BadInputError(
            f"this recorder logged no airspeed: its I record names {named}, and an airspeed stands "
            "in IAS or TAS. Give the log of a recorder that is connected to the air data, such as "
            "a flight computer"
        )
    kept = ((name, re.search(pattern, data, re.MULTILINE)) for name, pattern in _KEPT.items())
    header = {name: found[1].decode("utf-8", "replace").strip() for name, found in kept if found}
    header[KIND] = "glider"
    begin = float(columns["time_s"][0])
    if date := _DATE.search(data):
        day, month, year = (int(part) for part in date.groups())
        try:
            moment = datetime(2000 + year, month, day) + timedelta(seconds=begin)
            header[START] = moment.isoformat(" ", "seconds")
        except ValueError:  # a recorder without a fix writes such dates
            warnings.append(f"the date {day:02d}.{month:02d}.{year:02d} is none: left out")
    columns["time_s"] = columns["time_s"] - begin
    return Table(tuple(columns), tuple(columns.values()), header, tuple(warnings))


def _columns(fixes: NDArray[np.bytes_], extensions: dict[str, tuple[int, int]]) -> dict[str, Array]:
    hours, minutes, seconds = (_numbers(fixes, span) for span in _CLOCK)
    latitude, longitude = (
        _numbers(fixes, degrees)
        + (_numbers(fixes, span) + _tail(fixes, extensions.get(more))) / 60e3
        for (degrees, span), more in ((_LATITUDE, "LAD"), (_LONGITUDE, "LOD"))
    )
    time = 3600.0 * hours + 60.0 * minutes + seconds + _tail(fixes, extensions.get("TDS"))
    columns = {
        # A clock that falls by half a day has passed midnight.
        "time_s": time
        + SECONDS_A_DAY * np.cumsum(np.diff(time, prepend=time[:1]) < -0.5 * SECONDS_A_DAY),
        "pressure_altitude_m": _numbers(fixes, _PRESSURE_ALTITUDE),
        "altitude_m": _numbers(fixes, _GPS_ALTITUDE),
        "latitude_deg": np.where(fixes[:, _SOUTH] == b"S", -latitude, latitude),
        "longitude_deg": np.where(fixes[:, _WEST] == b"W", -longitude, longitude),
    }
    for code, (name, digits) in _CHANNELS.items():
        if code in extensions:
            first, end = extensions[code]
            values = _numbers(fixes, (first, end)) * 10.0 ** (digits - (end - first))
            known = values[np.isfinite(values)]
            # A field that a recorder reserves and never fills is blank, or stands at zero.
            if 2 * len(known) > len(values) and np.ptp(known) > 0.0:
                columns[name] = values
    return columns


def _tail(fixes: NDArray[np.bytes_], span: tuple[int, int] | None) -> Array:
    """Return further decimals of a number as a fraction of its last digit, 0 for none."""
    return (
        np.zeros(len(fixes))
        if span is None
        else _numbers(fixes, span) * 10.0 ** (span[0] - span[1])
    )


def _numbers(fixes: NDArray[np.bytes_], span: tuple[int, int]) -> Array:
    """Return the numbers between two bytes of each fix, (n,); NaN for anything else."""
    cells = np.ascontiguousarray(fixes[:, span[0] : span[1]]).view(f"S{span[1] - span[0]}").ravel()
    try:
        return cells.astype(np.float64)
    except ValueError:
        return np.array([float(c) if _NUMBER.fullmatch(c) else np.nan for c in cells.tolist()])
