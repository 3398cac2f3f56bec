"""A file that is no log is named for what it is, with a way that its owner can take."""

from dataclasses import replace

import numpy as np
import openpyxl
import pytest
from scipy.io import savemat
from tests.logbook import sample_log as sample

from pitotbench import BadInputError, calibrate, fixed_speed, read_log, write_log
from pitotbench.cli.app import main
from pitotbench.logbook.reading import read_table


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("card.ods", "a spreadsheet: save its sheet as CSV"),
        ("card.xlsx", r"not a complete spreadsheet \(\.xlsx\)"),
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


def test_the_stream_of_a_display_is_no_table(tmp_path):
    path = tmp_path / "display.txt"
    path.write_text("".join(f"=1115{t:06d}+112-00071230050+00984+026-02+1A8\n" for t in range(60)))
    with pytest.raises(BadInputError, match=r"serial port.*log that the display itself records"):
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


def test_a_sheet_is_read_as_its_csv(tmp_path):
    book = openpyxl.Workbook()
    book.active.title = "notes"
    sheet = book.create_sheet("points")
    sheet.append(["Tunnel speed [m/s]", "IAS [m/s]", "remark"])
    for shown in (10.0, 14.5, 19.0, 24.0):
        sheet.append([1.05 * shown, shown, "a, b"])
    book.save(path := tmp_path / "points.xlsx")
    found = fixed_speed(path)
    assert [point.factor for point in found.points] == pytest.approx([1.05] * 4, abs=1e-3)
    with pytest.raises(BadInputError, match=r"known speed, no log: `pitotbench fixed-speed "):
        read_log(path)


def test_a_sheet_of_more_cells_than_a_log_is_not_read(tmp_path, monkeypatch):
    book = openpyxl.Workbook()
    for _ in range(30):
        book.active.append([1.0] * 4)
    book.save(path := tmp_path / "log.xlsx")
    monkeypatch.setattr("pitotbench.logbook.spreadsheet._MOST_CELLS", 100)
    with pytest.raises(BadInputError, match=r"more than 100 cells.*save its sheet as CSV"):
        read_log(path)


def test_points_without_a_time_are_told_their_columns(tmp_path):
    path = tmp_path / "day.csv"
    path.write_text("v,p\n" + "".join(f"{v},{0.19 + 1e-3 * v * v}\n" for v in range(2, 15)))
    with pytest.raises(BadInputError, match=r"points of a tunnel or a car.*known_airspeed_mps"):
        read_log(path)


def test_fly_bys_under_other_names_are_told_theirs(tmp_path):
    path = tmp_path / "card.csv"
    path.write_text("Vic,Hic,grid_reading,tower_temp\n" + "300,2390,7.1,13.2\n" * 5)
    with pytest.raises(BadInputError, match=r"tower fly-bys under other names.*grid_height_ft"):
        calibrate(path)


def test_python_and_map_name_a_card_as_the_command_does(tmp_path, capsys):
    path = tmp_path / "book.csv"
    path.write_text("KIAS,KCAS\n50,56\n70,72\n90,90\n")
    with pytest.raises(BadInputError, match="a handbook's table of airspeeds, no log") as found:
        calibrate(path)
    for command in ("calibrate", "map"):
        assert main([command, str(path)]) == 2
        assert f"aircraft indicator {path}" in capsys.readouterr().err
    assert str(path) in str(found.value)


def test_what_a_log_of_another_recorder_lacks_is_named_with_the_way_to_it(tmp_path):
    time = np.arange(300.0)
    table = {"t": time, "airspeed": 15.0 + time % 3, "groundspeed": 14.0 + time % 4}
    path = sample.write(tmp_path / "log.csv", table)
    with pytest.raises(BadInputError, match=r"no height is logged: state the one.*no track is"):
        read_log(path)


def test_a_line_of_blanks_above_the_numbers_is_no_line_of_names(tmp_path):
    path = tmp_path / "probe.csv"
    path.write_text(" \n" + "".join(f"{t / 10},{20 + t % 3},1013.2,12.5,3\n" for t in range(50)))
    with pytest.raises(BadInputError, match="no line of names"):
        read_log(path)


def test_a_log_of_a_tunnel_is_led_to_the_table_of_its_runs(tmp_path):
    log = sample.log()
    still = replace(log, velocity_north=0.0 * log.time, velocity_east=0.0 * log.time)
    path = write_log(still, tmp_path / "tunnel.csv")
    with pytest.raises(BadInputError, match=r"of a tunnel .* here \d+\.\d m/s.*fixed-speed"):
        read_log(path)


def test_numbers_about_the_flight_beside_a_struct_of_vectors_are_none_of_its_channels(tmp_path):
    time = np.arange(0.0, 200.0, 0.5)
    channels = {"time": time, "ias": 30.0 + time % 7, "short": np.arange(9.0)}
    path = tmp_path / "flight.mat"
    savemat(path, {"flight_data": channels, "flight_info": {"flight": 75, "note": "calm"}})
    assert set(read_table(path).names) == {"time", "ias"}


def test_a_null_byte_before_rows_without_names_is_no_name(tmp_path):
    path = tmp_path / "data.csv"
    path.write_bytes(b"\0\n" + b"0.00,290.84,4.16,0.00,0.00\r\n" * 50)
    with pytest.raises(BadInputError, match="no line of names"):
        read_log(path)


@pytest.mark.parametrize("name", ["flight.json", "flight.json.gz"])
def test_a_list_of_rows_in_json_is_told_how_to_become_a_table(name, tmp_path):
    path = tmp_path / name
    path.write_text('[{"altitude": 1300.0}]')
    with pytest.raises(BadInputError, match=r"read_json\(FILE\).to_csv"):
        read_log(path)


def test_a_table_of_no_flight_is_told_what_it_holds(tmp_path):
    table = {"Cp_flight": np.linspace(0.01, 0.09, 2000), "J_flight": np.linspace(-0.3, 0.8, 2000)}
    path = sample.write(tmp_path / "propeller.csv", table)
    with pytest.raises(BadInputError, match="holds Cp_flight, J_flight") as told:
        read_log(path)
    assert "missing column" not in str(told.value)


def test_names_that_begin_as_ours_are_not_ours(tmp_path):
    """An autopilot's `roll_commanded` is no unit of ours that is not known."""
    time = np.arange(200.0)
    names = [f"{axis}_{kind}" for axis in ("roll", "pitch") for kind in ("commanded", "measured")]
    table = {name: np.sin(time / 9.0) for name in names}
    table |= {"time": time, "airspeed": 20.0 + np.sin(time), "groundspeed": 21.0 + np.cos(time)}
    table |= {"altitude": 80.0 + time % 7.0}
    path = sample.write(tmp_path / "autopilot.csv", table)
    with pytest.raises(BadInputError, match="no track is logged") as told:
        read_log(path)
    assert "missing column" not in str(told.value)
