"""A file that is no log is named for what it is, with a way that its owner can take."""

import numpy as np
import pytest
from tests.logbook import sample_log as sample

from pitotbench import BadInputError, read_log
from pitotbench.cli.app import main


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("card.xlsx", "a spreadsheet: save its sheet as CSV"),
        ("flight.tlog", "telemetry of MAVLink: give the log that the autopilot wrote"),
        ("little.bbl", "`blackbox_decode FILE`"),
        ("track.gpx", "without an airspeed"),
        ("log.dat", "write it as one of these with the program that made it"),
    ],
)
def test_a_file_of_another_kind_is_named_and_nobody_is_told_to_rename_it(name, words, tmp_path):
    (tmp_path / name).write_bytes(b"PK\x03\x04 any bytes")
    with pytest.raises(BadInputError, match=words) as found:
        read_log(tmp_path / name)
    assert "rename" not in str(found.value)


def test_a_table_without_names_is_asked_for_them(tmp_path):
    path = tmp_path / "probe.csv"
    path.write_text("".join(f"{t / 10},{20 + t % 3},1013.2,12.5,3\n" for t in range(50)))
    with pytest.raises(BadInputError, match=r"no line of names.*such as time_s,") as found:
        read_log(path)
    assert "joined" not in str(found.value)
    path.write_text("".join(f"{20 + t % 3}\n" for t in range(50)))
    with pytest.raises(BadInputError, match=r"no line of names.*one channel is to be joined"):
        read_log(path)


IGC = "AXXX000\nHFDTE010124\nI023638FXA3940SIU\n"


def test_a_recorder_without_an_airspeed_says_so(tmp_path):
    fixes = "".join(
        f"B12{t // 60:02d}{t % 60:02d}4700{t:03d}N00800{t:03d}EA0100001050{12:03d}08\n"
        for t in range(100)
    )
    path = tmp_path / "flight.igc"
    path.write_text(IGC + fixes)
    with pytest.raises(BadInputError, match="logged no airspeed: its I record names FXA, SIU"):
        read_log(path)


def test_a_phone_in_the_cockpit_is_told_what_it_lacks(tmp_path, capsys):
    time = np.arange(300.0)
    table = {
        "time": time,
        "lat": 47.0 + 4e-4 * time,
        "lng": 8.0 + 1e-4 * np.sin(time / 50.0),
        "alt": 500.0 + time,
        "HeadingX(µT)": 30.0 + time % 5,
    }
    path = sample.write(tmp_path / "phone.csv", table)
    assert main(["calibrate", str(path)]) == 2
    said = capsys.readouterr().err
    assert "no airspeed is logged" in said
    assert "lat (latitude)" in said
    assert "missing column" not in said
