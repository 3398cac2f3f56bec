"""Write a flight as the binary log of an ArduPilot, after the public description of DataFlash."""

import struct
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from pitotlab.outside.physics import Array, calibrated_airspeed

RATIO = 2.0  # ARSPD_RATIO with which the airspeed was shown
_HEAD = b"\xa3\x95"
_CODES = {"Q": "Q", "B": "B", "f": "f", "N": "16s", "n": "4s", "Z": "64s", "I": "I"}
# Message: its number, the letters of its fields, and their names.
_FORMATS = {
    "FMT": (128, "BBnNZ", "Type,Length,Name,Format,Columns"),
    "PARM": (129, "QNf", "TimeUS,Name,Value"),
    "ARSP": (130, "QBfff", "TimeUS,I,Airspeed,DiffPress,Temp"),
    "BARO": (131, "QBff", "TimeUS,I,Alt,Press"),
    "GPS": (132, "QBBffff", "TimeUS,I,Status,Alt,Spd,GCrs,VZ"),
    "ATT": (133, "Qfff", "TimeUS,Roll,Pitch,Yaw"),
}


def _packed(name: str, *values: object) -> bytes:
    number, letters, _ = _FORMATS[name]
    codes = "<" + "".join(_CODES[letter] for letter in letters)
    return _HEAD + bytes([number]) + struct.pack(codes, *values)


def _format_of(name: str) -> bytes:
    number, letters, fields = _FORMATS[name]
    length = 3 + struct.calcsize("<" + "".join(_CODES[letter] for letter in letters))
    return _packed("FMT", number, length, name.encode(), letters.encode(), fields.encode())


def write_dataflash(
    columns: Mapping[str, Array], path: Path, every: int = 2, ratio: float = RATIO
) -> None:
    """Write the columns of a log as a .bin: every second row, and each GPS fix once.

    The pressure of the sensor is that which shows the airspeed of the log, √(ratio·d); a negative
    impact pressure is a negative pressure.
    """
    impact = columns["impact_pressure_pa"]
    shown = calibrated_airspeed(np.maximum(impact, 0.0))
    pressure = np.where(impact > 0.0, shown**2, impact * 2.0 / 1.225) / ratio
    north, east = columns["velocity_north_mps"], columns["velocity_east_mps"]
    speed, course = np.hypot(north, east), np.degrees(np.arctan2(east, north)) % 360.0
    fresh = columns["gps_fresh"] > 0.5
    angles = np.degrees([columns[f"{name}_rad"] for name in ("roll", "pitch", "heading")]).T
    parts = [_format_of(name) for name in _FORMATS]
    parts.append(_packed("PARM", 0, b"ARSPD_RATIO", ratio))
    parts.append(_packed("PARM", 0, b"ARSPD_OFFSET", 0.0))
    for row, seconds in enumerate(columns["time_s"]):
        clock = round(5e6 + 1e6 * float(seconds - columns["time_s"][0]))
        if row % every == 0:
            parts.append(
                _packed("ARSP", clock, 0, float(shown[row]), float(pressure[row]), 30.0)
                + _packed("BARO", clock, 0, 0.0, float(columns["static_pressure_pa"][row]))
                + _packed("ATT", clock, *map(float, angles[row]))
            )
        if fresh[row]:
            fix = (columns["altitude_m"][row], speed[row], course[row])
            down = float(columns["velocity_down_mps"][row])
            parts.append(_packed("GPS", clock, 0, 3, *map(float, fix), down))
    path.write_bytes(b"".join(parts))
