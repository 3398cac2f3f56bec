"""A PX4 ULog through a mapping of its topics. The file is built here, byte by byte, after the published format."""

import struct
from pathlib import Path

import numpy as np
import pytest

from pitotbench.logbook.reading import read_log
from pitotbench.records import BadInputError

pytest.importorskip("pyulog", reason="reading a ULog needs the extra pitotbench[logs]")

TOPICS = {
    "differential_pressure": ("differential_pressure_pa",),
    "vehicle_air_data": ("baro_pressure_pa",),
    "sensor_gps": ("vel_n_m_s", "vel_e_m_s", "vel_d_m_s", "alt"),
}


def message(kind: str, body: bytes) -> bytes:
    return struct.pack("<HB", len(body), ord(kind)) + body


def build(path: Path, topics: dict[str, np.ndarray]) -> Path:
    """Write a ULog (PX4 file format, version 1): header, flags, formats, subscriptions, data."""
    parts = [b"ULog\x01\x12\x35\x01", struct.pack("<Q", 0), message("B", bytes(40))]
    for name, fields in TOPICS.items():
        listing = "".join(f"float {field};" for field in fields)
        parts.append(message("F", f"{name}:uint64_t timestamp;{listing}".encode()))
    for number, name in enumerate(topics):
        parts.append(message("A", struct.pack("<BH", 0, number) + name.encode()))
    for number, rows in enumerate(topics.values()):
        for clock, *values in rows:
            body = struct.pack(f"<HQ{len(values)}f", number, int(clock * 1e6), *values)
            parts.append(message("D", body))
    path.write_bytes(b"".join(parts))
    return path


def flight() -> dict[str, np.ndarray]:
    rng = np.random.default_rng(2)
    clock = 100.0 + np.arange(90.0)
    q, p = 120.0 + rng.standard_normal(90), 99000.0 + rng.standard_normal(90)
    velocity = np.column_stack([10.0 * np.cos(clock / 20), 10.0 * np.sin(clock / 20), np.zeros(90), 90e3 + clock])
    return {
        "differential_pressure": np.column_stack([clock, q]),
        "vehicle_air_data": np.column_stack([clock - 0.5, p]),
        "sensor_gps": np.column_stack([clock + 0.25, velocity]),
    }


def test_topics_are_joined(tmp_path):
    topics = flight()
    log = read_log(build(tmp_path / "log.ulg", topics), mapping="seaway")
    assert (log.time[0], log.time[-1]) == pytest.approx((101.0, 188.0))
    np.testing.assert_allclose(log.impact_pressure, topics["differential_pressure"][1:89, 1], rtol=1e-6)
    gps = topics["sensor_gps"]
    np.testing.assert_allclose(log.velocity_north, np.interp(log.time, gps[:, 0], gps[:, 1]), atol=1e-5)
    np.testing.assert_allclose(log.altitude, np.interp(log.time, gps[:, 0], gps[:, 4]) * 1e-3, rtol=1e-6)


def test_a_missing_topic_is_named(tmp_path):
    topics = {name: rows for name, rows in flight().items() if name != "sensor_gps"}
    with pytest.raises(
        BadInputError, match=r"no topic sensor_gps_0; it holds differential_pressure_0, vehicle_air"
    ):
        read_log(build(tmp_path / "log.ulg", topics), mapping="seaway")


@pytest.mark.parametrize("content", [b"", b"ULog", b"not a ulog at all, but long enough to have a header"])
def test_no_ulog_at_all(tmp_path, content):
    (tmp_path / "log.ulg").write_bytes(content)
    with pytest.raises(BadInputError, match=r"log\.ulg: "):
        read_log(tmp_path / "log.ulg", mapping="seaway")


def test_a_missing_file(tmp_path):
    with pytest.raises(BadInputError, match=r"none\.ulg: "):
        read_log(tmp_path / "none.ulg", mapping="seaway")
