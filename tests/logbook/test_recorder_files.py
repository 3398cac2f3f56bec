"""IGC files of flight recorders, written here byte by byte."""

import gzip

import numpy as np
import pytest
from tests.logbook import foreign_files as foreign

from pitotbench import BadInputError, air, read_log

FLOWN = foreign.flight()
ABOVE = [
    "AXXX001",
    "HFDTEDATE:020918,01",
    "HFPLTPILOTINCHARGE:A Name",
    "HFCM2CREW2:Another",
    "HFGTYGLIDERTYPE:Trainer 13",
    "HFFTYFRTYPE:Maker,Type 9",
]
EXTENSIONS = [("TAS", 5), ("GSP", 5), ("TRT", 3), ("OAT", 4)]


def igc(path, *, fix="A", start=86_380, extensions=EXTENSIONS):
    """The flight as a recorder writes it, one fix a second, over midnight."""
    tas = air.true_airspeed(FLOWN["impact_pressure"], FLOWN["static_pressure"], FLOWN["air_temperature"])
    speed = np.hypot(FLOWN["velocity_north"], FLOWN["velocity_east"])
    track = np.degrees(np.arctan2(FLOWN["velocity_east"], FLOWN["velocity_north"])) % 360.0
    values = {
        "TAS": 360.0 * tas,
        "GSP": 360.0 * speed,
        "TRT": np.round(track) % 360.0,
        "OAT": 10.0 * (FLOWN["air_temperature"] - 273.15),
    }
    height = air.pressure_altitude(FLOWN["static_pressure"])
    ends = 35 + np.cumsum([width for _, width in extensions])
    parts = [f"{end - width + 1:02d}{end:02d}{code}" for end, (code, width) in zip(ends, extensions, strict=True)]
    lines = [*ABOVE, f"I{len(parts):02d}{''.join(parts)}", "LXXXWORDS"]
    for row, second in enumerate(FLOWN["time"] + start):
        clock = round(second) % 86_400
        stamp = f"{clock // 3600:02d}{clock // 60 % 60:02d}{clock % 60:02d}"
        place = f"50{16_000 + 20 * row:05d}S07202189W"
        line = f"B{stamp}{place}{fix}{round(height[row]):05d}{round(FLOWN['altitude'][row]):05d}"
        lines.append(line + "".join(f"{round(values[code][row]):0{width}d}" for code, width in extensions))
    data = ("\r\n".join([*lines, "GSIGNATURE"]) + "\r\n").encode()
    path.write_bytes(gzip.compress(data) if path.suffix == ".gz" else data)
    return path


@pytest.mark.parametrize("name", ["log.igc", "LOG.IGC", "log.igc.gz"])
def test_a_recorder_file_is_read(name, tmp_path):
    log = read_log(igc(tmp_path / name))
    np.testing.assert_allclose(log.time, FLOWN["time"] - FLOWN["time"][0], atol=0.51)
    assert np.abs(log.static_pressure - FLOWN["static_pressure"]).max() < 10.0
    np.testing.assert_allclose(log.impact_pressure, FLOWN["impact_pressure"], rtol=2e-3)
    np.testing.assert_allclose(log.air_temperature, FLOWN["air_temperature"], atol=0.051)
    np.testing.assert_allclose(log.altitude, FLOWN["altitude"], atol=0.51)
    north, east = (getattr(log, name) - FLOWN[name] for name in ("velocity_north", "velocity_east"))
    assert np.hypot(north, east).max() < 1.0


def test_no_name_of_a_person_leaves_the_file_and_one_without_an_airspeed_says_so(tmp_path):
    header = read_log(igc(tmp_path / "log.igc")).header
    assert (header["glider"], header["recorder"]) == ("Trainer 13", "Maker,Type 9")
    assert header["start"] == "2018-09-02 23:59:40"
    assert "Name" not in str(header)
    assert "Another" not in str(header)
    with pytest.raises(BadInputError, match="missing column impact_pressure_pa"):
        read_log(igc(tmp_path / "log.igc", extensions=[]))


def test_fixes_without_height_are_left_out(tmp_path):
    path = igc(tmp_path / "log.igc")
    lines = path.read_text().splitlines()
    lines[20:30] = [line.replace("WA", "WV") for line in lines[20:30]]
    lines[-2] = lines[-2][:30]
    path.write_text("\n".join(lines))
    log = read_log(path)
    assert len(log) == foreign.ROWS - 11
    assert any(f"11 of {foreign.ROWS} fixes are left out" in warning for warning in log.header["warnings"])


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"", "is empty"),
        (b"AXXX\r\nHFDTE020918\r\n", "holds no fix"),
        (b"\x00\x01" * 90, "holds no fix"),
        (b"B1441245016753S07202189WV0026500198\n" * 3, "no fix of three dimensions"),
        (b"B1441245016753S0720x189WA0026500198\n" * 3, "no number at bytes 19 to 23"),
    ],
)
def test_what_is_no_recorder_file_is_refused(content, says, tmp_path):
    path = tmp_path / "log.igc"
    path.write_bytes(content)
    with pytest.raises(BadInputError, match=says):
        read_log(path)
