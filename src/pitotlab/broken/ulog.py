"""Write a flight as the log of a PX4, after the public description of ULog, version 1."""

import struct
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from pitotlab.outside.physics import Array, calibrated_airspeed

DENSITY = 1.225  # kg/m³, with which the airspeed is shown
_PARAMETERS = {"ASPD_SCALE_1": 1.0, "SENS_DPRES_OFF": 0.0}
_HEAD = b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 0)


def _message(kind: str, body: bytes) -> bytes:
    return struct.pack("<HB", len(body), ord(kind)) + body


def write_ulog(columns: Mapping[str, Array], path: Path) -> None:
    """Write the columns of a log as a .ulg: every row, and each GPS fix once.

    The pressure of the sensor is that which shows the airspeed of the log, √(2d/1.225).
    """
    shown = calibrated_airspeed(np.maximum(columns["impact_pressure_pa"], 0.0))
    fresh = columns["gps_fresh"] > 0.5
    velocity = [columns[f"velocity_{axis}_mps"][fresh] for axis in ("north", "east", "down")]
    clock = np.round(5e6 + 1e6 * (columns["time_s"] - columns["time_s"][0])).astype(np.int64)
    topics = {
        "differential_pressure": ("differential_pressure_pa", clock, [0.5 * DENSITY * shown**2]),
        "vehicle_air_data": ("baro_pressure_pa", clock, [columns["static_pressure_pa"]]),
        "sensor_gps": (
            "vel_n_m_s vel_e_m_s vel_d_m_s altitude_msl_m",
            clock[fresh],
            [*velocity, columns["altitude_m"][fresh]],
        ),
        "vehicle_local_position": ("heading", clock, [columns["heading_rad"]]),
    }
    parts = [_HEAD, _message("B", bytes(40))]
    for key, value in _PARAMETERS.items():
        typed = f"float {key}".encode()
        parts.append(_message("P", bytes([len(typed)]) + typed + struct.pack("<f", value)))
    for name, (fields, _, _) in topics.items():
        listing = "".join(f"float {field};" for field in fields.split())
        parts.append(_message("F", f"{name}:uint64_t timestamp;{listing}".encode()))
    for number, name in enumerate(topics):
        parts.append(_message("A", struct.pack("<BH", 0, number) + name.encode()))
    for number, (_, stamps, values) in enumerate(topics.values()):
        for stamp, *row in zip(stamps, *values, strict=True):
            body = struct.pack(f"<HQ{len(row)}f", number, int(stamp), *row)
            parts.append(_message("D", body))
    path.write_bytes(b"".join(parts))
