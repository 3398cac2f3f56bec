"""Logs of the kinds that the cases of the field are of, read without a flag or by their draft."""

import errno
import json
import zipfile
from collections.abc import Mapping
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pytest
from scipy.io import savemat
from tests.logbook.field_recorders import KINDS, READS, ROWS, WIND, clock, dynon, flown, g5, table

from pitotbench import BadInputError, air, calibrate, read_log
from pitotbench.bench.contents import flights_of
from pitotbench.cli.app import main
from pitotbench.logbook.drafting import draft_mapping, mapping_text
from pitotbench.logbook.reading import read_table
from pitotbench.logbook.temperature import stated_day
from pitotbench.units import FOOT, KNOT

# Several voices of one answer are looked at: each log is fitted once.
pytestmark = pytest.mark.usefixtures("one_fit_of_each_log")

# What is tested is the reading; a law costs half of what the smooth curve does.
LAW = "linear"


def assert_found(curve) -> None:
    """The curve is that with which the log was made, inside its bound, and within 5 % of the speed."""
    off = np.abs(curve.correction - curve.indicated_airspeed * (1.0 / READS - 1.0))
    assert np.all(off <= curve.two_sigma)
    assert np.all(off < 0.05 * curve.indicated_airspeed)


@pytest.mark.parametrize("kind", list(KINDS))
def test_a_log_of_the_kind_is_read_without_a_flag(kind, tmp_path):
    write, mapping = KINDS[kind]
    log = read_log(write(tmp_path))
    assert log.header["mapping"] == mapping
    # Track and speed of the airliner lie on lines between seconds, which cut its turns short: a law
    # has no room for that.
    found = calibrate(log, model="smooth" if kind == "airliner" else LAW)
    assert_found(found.curve)
    assert found.wind.speed_kt == pytest.approx(np.hypot(*WIND) / KNOT, abs=1.0)
    assert found.wind.from_deg == pytest.approx(230.2, abs=4.0)


def test_two_recordings_of_one_download_are_two_flights(tmp_path):
    log = read_log(dynon(tmp_path))
    assert np.all(np.diff(log.time) > 0.0)
    assert np.diff(log.time)[239] > 300.0
    assert any("2 recordings" in words for words in log.header["warnings"])


def test_a_clock_that_was_set_in_flight_is_refused(tmp_path):
    f = flown()
    path = dynon(tmp_path)
    lines = path.read_text().splitlines()
    lines[301] = lines[301].replace(f"{f['time'][60] + 2.0:.2f}", "1.00", 1)
    path.write_text("\n".join(lines) + "\n")
    with pytest.raises(BadInputError, match="time runs back"):
        read_log(path)


def foreign(f: Mapping) -> dict:
    """A recorder that nobody knows."""
    return {
        "Milliseconds": np.round(1e3 * f["time"]),
        "Course": np.round(f["track"], 1),
        "SpeedOverGround": np.round(f["gs"] * KNOT, 2),
        "Lat": f["latitude"],
        "Lon": f["longitude"],
        "Airspeed": np.round(f["ias"] * KNOT, 2),
        "PressAlt (m)": np.round(f["height"], 1),
        "OAT": np.round(f["celsius"], 2),
    }


def drafted(path: Path, columns: Mapping):
    return draft_mapping(read_table(table(path, columns)))


def test_a_draft_tells_units_and_meaning_by_the_values(tmp_path):
    """The position gives the unit of the ground speed, and this, by the whole log, the airspeed's."""
    path = tmp_path / "log.csv"
    found = drafted(path, foreign(flown()))
    lines = {line.guess.theirs: line for line in found.lines}
    assert lines["SpeedOverGround"].guess.target() == "ground_speed_mps"
    assert not lines["SpeedOverGround"].question
    assert lines["Milliseconds"].guess.target() == "time_ms"
    assert lines["Airspeed"].guess.target() == "indicated_airspeed_mps"
    mapping = tmp_path / "m.toml"
    mapping.write_text(mapping_text(found, path.name), encoding="utf-8")
    assert_found(calibrate(path, mapping=mapping, model=LAW).curve)


def afs(f: Mapping) -> dict:
    return {
        "Time": clock(f["time"]),
        "IAS (Knots)": np.round(f["ias"], 1),
        "TAS (Knots)": f["tas"],
        "Press Alt (Feet)": np.round(f["palt_ft"]),
        "OAT (F)": 1.8 * f["celsius"] + 32.0,
        "Ground Speed (Knots)": np.round(f["gs"], 1),
        "Ground Track (Deg)": np.round(f["track"]),
        "EGT1": np.full(ROWS, 1300.0),
    }


def ultralight(f: Mapping) -> dict:
    return {
        "Date": ["2022-01-02"] * ROWS,
        "Time": clock(f["time"]),
        "ASI km/h": np.round(1.852 * f["ias"]),
        "Altitude ft": np.round(f["palt_ft"]),
        "OAT C": np.round(f["celsius"]),
        "GPS speed km/h": np.round(1.852 * f["gs"]),
        "GPS track": np.round(f["track"]),
        "CHT1": np.full(ROWS, 150.0),
    }


def properties(f: Mapping) -> dict:
    """A simulator whose columns are places in a tree."""
    return {
        "Time": f["time"],
        "/velocities/airspeed-kt": f["ias"],
        "/instrumentation/altimeter/pressure-alt-ft": f["palt_ft"],
        "/velocities/speed-north-fps": f["north"] / FOOT,
        "/velocities/speed-east-fps": f["east"] / FOOT,
        "/environment/temperature-degc": f["celsius"],
        "/orientation/heading-deg": f["heading"],
    }


def messages(f: Mapping) -> dict:
    """Whole numbers, as a radio link sends them."""
    return {
        "time_boot_ms": 1e3 * f["time"],
        "airspeed": f["ias"] * KNOT,
        "groundspeed": f["gs"] * KNOT,
        "alt": f["height"],
        "heading": np.round(f["heading"]),
        "lat": np.round(1e7 * f["latitude"]),
        "lon": np.round(1e7 * f["longitude"]),
        "press_abs": f["pressure"] / 100.0,
        "temperature": np.full(ROWS, 4100.0),
    }


def research(f: Mapping) -> dict:
    """A box's name stands before what it measures, and the pressure says no unit."""
    return {
        "SystemMillis": 1e3 * f["time"],
        "NumSat": np.full(ROWS, 11.0),
        "VelN_mps": f["north"],
        "VelE_mps": f["east"],
        "AbsPressure": f["pressure"] / 47.880259,
        "HSDB_diff_press_pa": np.asarray(air.impact_pressure(f["ias"] * KNOT)),
        "HSDB_mhdg_deg": f["heading"] - 4.0,
    }


def planner(f: Mapping) -> dict:
    """Groups of columns in a line above the names; the airspeed is a true one."""
    return {
        "Time": [f"2014-07-08T{each}Z" for each in clock(f["time"])],
        "Lat": f["latitude"],
        "Lon": f["longitude"],
        "PressAlt": np.round(f["palt_ft"]),
        "DensityAlt": np.round(f["palt_ft"] + 300.0),
        "OAT": np.round(f["celsius"], 1),
        "TAS": np.round(READS * f["tas"], 1),
        "HDGT": f["heading"],
        "Rate": np.full(ROWS, 4.0),
    }


def game(f: Mapping) -> dict:
    """The axes of a game engine: x points east, y up and z north."""
    return {
        "time_s": f["time"],
        "tas_mps": f["tas"] * KNOT,
        "ias_kts": f["ias"],
        "qbar_Pa": np.full(ROWS, 1500.0),
        "altitude_m": f["height"],
        "vel_world_x": f["east"],
        "vel_world_y": f["up"],
        "vel_world_z": f["north"],
    }


def laboratory(f: Mapping) -> dict:
    """Bare names; the position gives the unit of the velocity, and this the airspeed's."""
    return {
        "time": f["time"],
        "ias": f["ias"] * KNOT,
        "vn": f["north"],
        "ve": f["east"],
        "lat": f["latitude"],
        "lon": f["longitude"],
        "alt": f["height"],
    }


@pytest.mark.parametrize(
    "headers", [afs, ultralight, properties, messages, research, planner, game, laboratory]
)
def test_the_draft_of_another_recorder_needs_no_edit(headers, tmp_path):
    path, mapping = tmp_path / "log.csv", tmp_path / "m.toml"
    found = drafted(path, headers(flown()))
    assert not found.unusable
    mapping.write_text(mapping_text(found, path.name), encoding="utf-8")
    assert_found(calibrate(path, mapping=mapping, model=LAW).curve)


DISGUISES = {
    # What another column is called, its values of the flight, and what must not be said of it.
    "satellites": ("GPS_numSat", lambda f: np.round(12.0 + 2.0 * np.sin(f["time"])), "temperature"),
    "the box": ("Internal Temperature", lambda f: 35.0 + 0.01 * f["time"], "temperature"),
    "the board": ("IMU temp", lambda f: 41.0 - 0.001 * f["time"], "temperature"),
    "an engine": ("Oil temp", lambda f: 80.0 + 0.0 * f["time"], "temperature"),
}


@pytest.mark.parametrize("name", list(DISGUISES))
def test_a_temperature_of_something_else_is_left_out(name, tmp_path):
    column, values, kind = DISGUISES[name]
    columns = foreign(flown())
    del columns["OAT"]
    found = drafted(tmp_path / "log.csv", {column: values(flown()), **columns})
    assert not any(kind in line.guess.quantity for line in found.lines)
    assert f"# Not used: {column}: " in mapping_text(found, "log.csv")


def test_a_temperature_that_does_not_fall_with_height_is_asked_for(tmp_path):
    f = flown()
    columns = foreign(f) | {"OAT": 20.0 + 0.01 * (f["height"] - 1500.0)}
    found = drafted(tmp_path / "log.csv", columns)
    (line,) = [line for line in found.lines if line.guess.theirs == "OAT"]
    assert "is it the air's?" in line.question
    assert not found.sure


@pytest.mark.parametrize(
    ("name", "angle", "quantity"),
    [
        ("Heading", lambda f: f["track"], "track"),
        ("Heading", lambda f: f["heading"], "heading"),
        ("Course", lambda f: (f["track"] - 11.0) % 360.0, "magnetic_track"),
    ],
)
def test_a_direction_is_what_it_does(name, angle, quantity, tmp_path):
    f = flown()
    columns = {key: values for key, values in foreign(f).items() if key != "Course"}
    found = drafted(tmp_path / "log.csv", {**columns, name: np.round(angle(f), 1)})
    lines = {line.guess.theirs: line.guess.quantity for line in found.lines}
    assert lines[name] == quantity


@pytest.mark.parametrize("right", [1.0, -1.0])
def test_a_roll_gets_its_sign_from_the_turn(right, tmp_path):
    """Simulators count the bank to the left."""
    f = flown()
    banked = foreign(f) | {"bank_deg": right * (20.0 + np.sin(f["time"]))}
    found = drafted(tmp_path / "log.csv", banked)
    (guess,) = [line.guess for line in found.lines if line.guess.theirs == "bank_deg"]
    assert (guess.target(), guess.factor) == ("roll_deg", right)


def test_a_heading_beside_a_magnetic_track_is_asked_for(tmp_path):
    f = flown()
    columns = foreign(f) | {"HDG": f["heading"] - 11.0, "Course": f["track"] - 11.0}
    found = drafted(tmp_path / "log.csv", columns)
    questions = {line.guess.theirs: line.question for line in found.lines}
    assert "is it true, or magnetic as 'Course' beside it suggests" in questions["HDG"]


def test_a_unit_behind_a_semicolon_is_no_name(tmp_path):
    f = flown()
    columns = foreign(f) | {"OIL P;PSI": np.full(ROWS, 60.0), "HP;%": np.full(ROWS, 70.0)}
    found = drafted(tmp_path / "log.csv", columns)
    assert {"OIL P;PSI", "HP;%"} <= set(found.unused)


def test_a_name_in_capitals_before_another_is_a_word(tmp_path):
    columns = foreign(flown()) | {"AHRSMagHeading": flown()["heading"] - 11.0}
    found = drafted(tmp_path / "log.csv", columns)
    lines = {line.guess.theirs: line.guess.quantity for line in found.lines}
    assert lines["AHRSMagHeading"] == "magnetic_heading"


LACKS = {
    # What a recorder without a pitot tube writes, and what the refusal names.
    "Stratux": (
        ("GPSGroundSpeed", "GPSTrueCourse", "BaroPressureAltitude", "AHRSRoll"),
        "airspeed",
    ),
    "MVP-50": (("MSTR_WRN", "GPS-SPEED;KTS", "GPS-TRACK;DEG"), "airspeed and no pressure altitude"),
}


@pytest.mark.parametrize("name", list(LACKS))
def test_a_recorder_without_a_pitot_tube_is_told_as_such(name, tmp_path, capsys):
    names, lacks = LACKS[name]
    path = table(tmp_path / "log.csv", dict.fromkeys(names, flown()["gs"]))
    for command in ("calibrate", "map"):
        assert main([command, str(path)]) == 2
        assert f"it holds no {lacks}" in capsys.readouterr().err


def test_a_recognized_log_that_lacks_a_column_is_drafted_all_the_same(tmp_path):
    """`map` does not say that no mapping is needed where the reader refuses the log."""
    f = flown(230.0, 4000.0)
    columns = {
        "icao24": ["4b1800"] * ROWS,
        "utc": clock(f["time"]),
        "IAS": f["ias"],
        "gs": f["gs"],
        "track": f["track"],
        "altitude": f["palt_ft"],
    }
    path, mapping = table(tmp_path / "log.csv", columns), tmp_path / "m.toml"
    with pytest.raises(BadInputError, match=r"another recorder's.* utc \(time\)"):
        read_log(path)
    assert main(["map", str(path), "-o", str(mapping)]) == 0
    assert '"utc" = "time_s"  # sure' in mapping.read_text()


def test_a_struct_of_texts_beside_that_of_the_channels_is_passed_over(tmp_path):
    f = flown()
    channels = laboratory(f)
    savemat(tmp_path / "log.mat", {"data": channels, "info": {"date": "1-Jun-2012", "by": "us"}})
    assert len(read_table(tmp_path / "log.mat")) == ROWS


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_vertical_velocity_gets_its_sign_from_the_height(sign, tmp_path):
    f = flown()
    columns = foreign(f) | {
        "Velocity North (m/s)": f["north"],
        "Velocity East (m/s)": f["east"],
        "Velocity Down (m/s)": np.round(sign * f["up"], 3),
    }
    found = drafted(tmp_path / "log.csv", columns)
    (guess,) = [line.guess for line in found.lines if line.guess.theirs.startswith("Velocity Down")]
    assert (guess.target(), guess.factor) == ("velocity_down_mps", -sign)


def test_a_name_of_ours_without_a_unit_gets_it_from_its_values(tmp_path):
    """As a program writes it that knows the quantities and not the suffixes."""
    f = flown()
    columns = {
        "time_s": f["time"],
        "indicated_airspeed_kt": f["ias"],
        "static_pressure": f["pressure"],
        "air_temperature_degc": f["celsius"],
        "velocity_north_mps": f["north"],
        "velocity_east_mps": f["east"],
        "heading": f["heading"],
        "pitch": np.full(ROWS, 0.02),
    }
    log = read_log(table(tmp_path / "log.csv", columns))
    np.testing.assert_allclose(log.static_pressure, f["pressure"], rtol=1e-6)
    np.testing.assert_allclose(np.degrees(log.heading), f["heading"], atol=1e-4)
    assert log.pitch is None  # 0.02 may be radians or degrees
    told = " ".join(log.header["warnings"])
    assert "'static_pressure' states no unit: by its values pa" in told
    assert "not used: column 'pitch' does not say its unit" in told


def test_a_word_a_blank_and_a_duplicate_are_remarks(tmp_path):
    columns = {name: list(map(str, values)) for name, values in foreign(flown()).items()}
    columns["Airspeed"][17] = "---"
    columns["Lat"][40] = ""
    path = table(tmp_path / "log.csv", columns)
    lines = path.read_text().splitlines()
    again = [f"{line},{line.split(',')[-1]}" for line in lines]
    path.write_text("\n".join(again) + "\n")
    mapping = tmp_path / "m.toml"
    assert main(["map", str(path), "-o", str(mapping)]) == 0
    log = read_log(path, mapping)
    assert len(log) >= ROWS - 2
    told = " ".join(log.header["warnings"])
    assert "'Airspeed' holds words among its numbers" in told
    assert "given more than once: OAT" in told


def test_lines_of_prose_above_the_names_are_skipped(tmp_path):
    """As an engine monitor writes them, in a file that ends in .log."""
    columns = foreign(flown())
    above = "Acme monitor, serial 12\nAircraft: N123\nSoftware 2.1, rate 1 Hz, all metric\n"
    path = table(tmp_path / "0012.log", columns, above=above)
    found = draft_mapping(read_table(path))
    assert not found.unusable
    assert {line.guess.theirs for line in found.lines} >= {
        "Milliseconds",
        "Airspeed",
        "PressAlt (m)",
    }


def test_a_folder_and_a_zip_list_their_flights(tmp_path, capsys):
    folder = tmp_path / "card"
    (folder / "old").mkdir(parents=True)
    first = g5(folder)
    dynon(folder / "old")
    (folder / "old" / "notes.txt").write_text("bring the car keys\n")
    packed = tmp_path / "card.zip"
    with zipfile.ZipFile(packed, "w") as file:
        for path in sorted(folder.rglob("*.*")):
            file.write(path, path.relative_to(folder))
    for place in (folder, packed):
        held = flights_of(place)
        assert [each.file for each in held] == [
            "log.csv",
            "old/USER_LOG.csv",
            "old/USER_LOG.csv",
            "old/notes.txt",
        ]
        assert held[0].start == "2021-06-05 14:00:00"
        assert held[0].seconds == pytest.approx(ROWS - 1.0)
        assert held[0].airspeeds[0] == pytest.approx(85.0 * READS * KNOT, abs=0.5)
        assert held[-1].refusal
        assert main(["inspect", str(place)]) == 0
        assert "2021-06-05 14:00:00" in capsys.readouterr().out
        # Its second flight has one airspeed in turns, which a smoothing receiver would leave open.
        known = ["--set", "receiver_smoothing_s2=0"]
        assert main(["calibrate", str(place), "--json", *known]) == 0
        out, told = capsys.readouterr()
        assert "3 logs, 2 with an answer" in told
        assert "notes.txt: left out" in told
        # Two recorders have a curve each; the Dynon's file holds two flights.
        flights = [each.get("flight", {}) for each in json.loads(out)]
        assert [each.get("flights_of_the_curve", 1) for each in flights] == [1, 2, 2]
        with pytest.raises(BadInputError, match="name one, such as"):
            read_log(place)
    member = read_log(packed / "log.csv")
    np.testing.assert_array_equal(member.impact_pressure, read_log(first).impact_pressure)
    assert main(["calibrate", str(packed / "log.csv"), "--json"]) == 0


def test_a_broken_zip_is_refused(tmp_path):
    path = tmp_path / "card.zip"
    path.write_bytes(b"PK\x03\x04" + bytes(40))
    with pytest.raises(BadInputError, match=r"not a complete \.zip"):
        read_log(path)


@pytest.mark.parametrize("method", [zipfile.ZIP_LZMA, zipfile.ZIP_BZIP2])
def test_a_zip_of_another_method_with_damage_within_is_refused(tmp_path, method):
    path = tmp_path / "card.zip"
    with zipfile.ZipFile(path, "w", method) as file:
        file.writestr("log.csv", ",".join(map(str, range(5000))))
    whole = path.read_bytes()
    path.write_bytes(whole[:80] + bytes(80) + whole[160:])
    with pytest.raises(BadInputError, match=r"\.zip"):
        read_log(path)


@pytest.mark.parametrize("name", [b"\xff\xfe\xfd", b""])
def test_a_zip_whose_member_has_no_name_is_refused(tmp_path, name):
    path = tmp_path / "card.zip"
    with zipfile.ZipFile(path, "w") as file:
        file.writestr("\u20ac", "1,2")  # three bytes
    whole = bytearray(path.read_bytes().replace("\u20ac".encode(), name.ljust(3, b"\0")))
    path.write_bytes(whole)
    with pytest.raises(BadInputError, match="card"):
        read_log(path)


def test_a_zip_with_damage_within_is_refused_and_a_full_disk_is_named(tmp_path, monkeypatch):
    path = tmp_path / "card.zip"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        file.writestr("log.csv", ",".join(map(str, range(5000))))
    whole = path.read_bytes()
    for place in range(60, 1000, 47):  # of some the packed bits are no code at all
        path.write_bytes(whole[:place] + bytes(8) + whole[place + 8 :])
        with pytest.raises(BadInputError, match=r"not a complete \.zip"):
            read_log(path)
    path.write_bytes(whole)
    full = OSError(errno.ENOSPC, "No space left on device")
    monkeypatch.setattr(zipfile.ZipFile, "extractall", Mock(side_effect=full))
    with pytest.raises(BadInputError, match="cannot be unpacked: No space left on device"):
        read_log(path)


DAYS = {
    "18": (18.0, 2.0, None),
    "18±1.5": (18.0, 1.5, None),
    "18+-2@ground": (18.0, 2.0, None),
    "18/3": (18.0, 3.0, None),
    "-5.5±1@1500ft": (-5.5, 1.0, 1500.0 * FOOT),
    "−12 ± 2 @ 400 m": (-12.0, 2.0, 400.0),
}


@pytest.mark.parametrize("text", list(DAYS))
def test_a_temperature_of_the_day_is_read(text):
    day = stated_day(text)
    celsius, two_sigma, height = DAYS[text]
    assert day.temperature == pytest.approx(celsius + 273.15)
    assert (day.two_sigma, day.height) == (two_sigma, height)


@pytest.mark.parametrize("text", ["warm", "18@", "18±", "290", "18@1500", "18±-2", "1e3", ""])
def test_a_temperature_that_is_none_is_refused_with_the_form(text):
    with pytest.raises(BadInputError, match=r"degrees Celsius"):
        stated_day(text)


@pytest.mark.parametrize("warmer", [-15.0, 12.0])
def test_the_temperature_of_the_day_takes_the_place_of_a_standard_day(warmer, tmp_path):
    """On a day far from standard the answer needs it; it narrows the bound to that of a probe."""
    f = flown(warmer=warmer)
    columns = {
        "time_s": f["time"],
        "indicated_airspeed_kt": f["ias"],
        "pressure_altitude_ft": f["palt_ft"],
        "velocity_north_mps": f["north"],
        "velocity_east_mps": f["east"],
    }
    path = table(tmp_path / "log.csv", columns)
    text = f"{f['celsius'].max():.1f}±1@ground"
    found = calibrate(read_log(path, temperature_c=text))
    assert_found(found.curve)
    assert np.max(found.curve.two_sigma) < 0.6 * KNOT
    assert {each.name: each.two_sigma for each in found.assumptions}["temperature_k"] < 1.5
    without = calibrate(path)
    assert np.all(without.curve.two_sigma > 2.0 * found.curve.two_sigma)
    (told,) = (words for words in without.warnings if "--temperature-c" in words)
    assert "contributes ±" in told


def test_a_temperature_below_zero_is_taken_after_its_flag(tmp_path, capsys):
    assert main(["calibrate", str(g5(tmp_path)), "--temperature-c", "-5±2@ground", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)["warnings"]
    assert any("temperature of the day, -5±2@ground" in words for words in told)


def test_a_slow_airplane_at_one_speed_is_not_said_to_disagree_with_its_velocity(tmp_path):
    """Rows at one speed on neighboring tracks do not tell the share of the speed in the reading,
    and a solar airplane's sensor has steps of a tenth of what it reads.
    """
    time = np.arange(90.0)
    track, speed = np.radians(150.0 + 20.0 * np.sin(time / 14.0)), 7.0 + 0.4 * np.sin(time / 5.0)
    noise = np.random.default_rng(3).normal(0.0, 4.0, len(time))
    columns = {
        "time_s": time,
        "impact_pressure_pa": 6.0 * np.round((56.0 + noise) / 6.0),
        "static_pressure_pa": np.full(len(time), 89000.0) - 0.1 * time,
        "velocity_north_mps": speed * np.cos(track),
        "velocity_east_mps": speed * np.sin(track),
    }
    told = read_log(table(tmp_path / "log.csv", columns)).header.get("warnings", [])
    assert not any("no steady wind" in words for words in told)
