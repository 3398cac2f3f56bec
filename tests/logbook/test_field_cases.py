"""Logs as other recorders, autopilots and simulators write them, read in place: what each holds is
found without a flag, and its answer is the one with which it was made.
"""

import json
import shutil
from functools import cache

import numpy as np
import pytest
from tests.shared_data import shared_case

from pitotbench import BadInputError, calibrate, read_log
from pitotbench.cli.app import main
from pitotbench.logbook.drafting import draft_mapping, mapping_text
from pitotbench.logbook.reading import read_table
from pitotbench.units import FOOT, KNOT

# Case: the correction with which it was made [kt], and its wind [kt, from °].
ANSWERS = {
    "02-g3x-touch-whole-mps.csv": (2.0, 15.0, 250.0),
    "03-garmin-g5.csv": (2.0, 15.0, 250.0),
    "05-one-glitch-at-a-quarter-hertz.csv": (2.0, 15.0, 250.0),
    "08-x-plane-data.txt": (0.0, 15.0, 250.0),
    "14a-igc-tas-without-temperature.igc": (0.0, 12.0, 250.0),
    "15-dashlink-rates.mat": (2.0, 35.0, 250.0),
    "20-msfs-simvars.csv": (0.0, 15.0, 250.0),
}
AUTOPILOT = ("10-ardupilot-same-flight.bin", "16-dataflash-text.log")


@cache
def answer_of(name):
    """The answer of a case, without a flag."""
    return calibrate(shared_case(name))


@pytest.mark.parametrize("name", list(ANSWERS))
def test_the_answer_of_a_recorders_file_is_that_with_which_it_was_made(name):
    correction, wind, wind_from = ANSWERS[name]
    found = answer_of(name)
    off = np.abs(found.curve.correction / KNOT - correction)
    assert np.all(off <= found.curve.simultaneous_two_sigma / KNOT)  # all points at once
    assert np.max(found.curve.two_sigma) < 3.5 * KNOT  # 15 K are 2.6 % of the airspeed
    assert abs(found.wind.speed_kt - wind) < 1.0
    assert abs(found.wind.from_deg - wind_from) < 3.0


def test_the_finer_of_two_velocities_is_taken_and_a_steady_leg_is_no_stuck_sensor():
    """The components come in whole m/s, ground speed and track in tenths."""
    found = answer_of("02-g3x-touch-whole-mps.csv")
    assert np.max(found.curve.two_sigma) < 0.5 * KNOT
    assert not any("stuck" in words for words in found.warnings)
    for speed in (85.0, 105.0, 125.0):
        assert found.curve.indicated_airspeed[0] < (speed + 1.0) * KNOT
    assert np.all(np.abs(found.curve.correction / KNOT - 2.0) < 0.2)


def test_a_temperature_of_the_box_is_none_of_the_air_and_upward_counts_the_other_way():
    log = read_log(shared_case("03-garmin-g5.csv"))
    assert log.air_temperature is None
    climb = np.gradient(log.altitude, log.time)
    assert np.corrcoef(climb, -log.velocity_down)[0, 1] > 0.7
    assert log.header["start"].startswith("2018-09-01 14:35")


def test_one_bad_row_is_left_out():
    found = answer_of("05-one-glitch-at-a-quarter-hertz.csv")
    (warning,) = (words for words in found.warnings if "disagree with all others" in words)
    assert "1 rows" in warning
    assert "at 20:00" in warning
    assert np.all(np.abs(found.curve.correction / KNOT - 2.0) < found.curve.two_sigma / KNOT)


def test_an_inav_log_is_read_in_its_units():
    log = read_log(shared_case("06-inav-blackbox.csv"))
    assert log.air_temperature is None  # neither satellites nor the barometer's
    speed = np.hypot(log.velocity_north, log.velocity_east)
    assert 8.0 < np.min(speed) < np.max(speed) < 30.0
    assert log.time[1] - log.time[0] == pytest.approx(0.5)
    assert np.degrees(np.median(log.roll)) == pytest.approx(15.0, abs=4.0)
    height = 44330.0 * (1.0 - (log.static_pressure / 101325.0) ** 0.1903)
    assert abs(np.median(height - log.altitude)) < 2.0  # m: counted from the place of take-off


@pytest.mark.parametrize("name", ["07a-qgroundcontrol.csv", "09-edgetx.csv"])
def test_a_drones_ground_station_is_read_and_its_airspeed_is_low(name):
    """12 % low. The height is of a day and a place that nobody states, which widens the bound."""
    found = answer_of(name)
    curve = found.curve
    shown = curve.indicated_airspeed
    off = shown + curve.correction - shown / 0.88
    assert np.all(np.abs(off) <= curve.two_sigma)
    assert abs(found.wind.speed_kt - 8.0) < 0.5


def test_a_course_is_no_heading():
    """A transmitter calls the course of its GPS Hdg."""
    drafted = draft_mapping(read_table(shared_case("09-edgetx.csv")))
    lines = {line.guess.theirs: line for line in drafted.lines}
    assert lines["Hdg(@)"].guess.quantity == "track"
    assert lines["ASpd(kmh)"].guess.target() == "indicated_airspeed_kmh"
    assert not drafted.unusable
    assert read_log(shared_case("09-edgetx.csv")).heading is None


@pytest.mark.parametrize("name", AUTOPILOT)
def test_a_dataflash_log_as_text_reads_as_the_binary_one(name):
    found = answer_of(name)
    assert np.all(np.abs(found.curve.correction) <= found.curve.two_sigma)
    assert found.autopilot.parameters["ARSPD_RATIO"] == 2.0


def test_one_table_a_message_reads_as_the_binary_log():
    tables = read_log(shared_case("10-ardupilot-csv-with-old-ratio", "x_ARSP.csv"))
    binary = read_log(shared_case("10-ardupilot-same-flight.bin"))
    assert tables.header["mapping"] == "ardupilot"
    np.testing.assert_allclose(tables.impact_pressure, binary.impact_pressure, rtol=1e-3)


def test_a_folder_with_one_table_a_message_is_one_log():
    folder = shared_case("10-ardupilot-csv-with-old-ratio")
    first = shared_case("10-ardupilot-csv-with-old-ratio", "x_ARSP.csv")
    np.testing.assert_array_equal(read_log(folder).impact_pressure, read_log(first).impact_pressure)


def test_each_variable_of_an_airliner_has_its_rate():
    log = read_log(shared_case("15-dashlink-rates.mat"))
    assert np.median(np.diff(log.time)) == 0.5
    assert log.time[-1] == pytest.approx(529.5)
    assert log.header["air_data"] == "computer: calibrated airspeed"


def test_a_recording_without_gps_is_refused_with_its_reason(capsys):
    path = shared_case("21-dynon-d180-no-gps.csv")
    with pytest.raises(BadInputError, match=r"Dynon.*no GPS.*fixed-speed"):
        read_log(path)
    assert main(["calibrate", str(path)]) == 2
    assert "no ground speed and no position" in capsys.readouterr().err


def test_the_temperature_of_the_day_narrows_the_bound():
    """The air of this flight is 10.1 °C at 5,000 ft: 4 K above the standard day's 5.1 °C."""
    path = shared_case("03-garmin-g5.csv")
    without = answer_of("03-garmin-g5.csv")
    log = read_log(path, temperature_c="10.1±1@5000ft")
    found = calibrate(log)
    assert np.all(found.curve.two_sigma < 0.5 * without.curve.two_sigma)
    assert np.all(np.abs(found.curve.correction / KNOT - 2.0) <= found.curve.two_sigma / KNOT)
    for temperature in ("15.9±1@ground", "6+-1@5000ft"):
        wrong = calibrate(read_log(path, temperature_c=temperature))
        assert abs(np.median(wrong.curve.correction - found.curve.correction)) < 2.5 * KNOT


@cache
def drafted_of(pattern):
    """The file of a case and its draft, as for a recorder that nobody knows."""
    (path, *_) = sorted(shared_case(".").glob(pattern))
    return path, draft_mapping(read_table(path))


MAPPED = ("02*", "03*", "06*", "07a*", "08*", "09*", "15*", "19*", "20*", "21*", "18*", "17*")


@pytest.mark.parametrize("pattern", MAPPED)
def test_map_never_stops(pattern, tmp_path, capsys):
    """Under other names than those by which its recorder is known, each gets a draft; a handbook and
    a card are no logs, and what reads them is named.
    """
    path, drafted = drafted_of(pattern)
    listed = mapping_text(drafted, path.name)
    for name in filter(None, drafted.unused):
        assert f"# Not used: {' '.join(name.split())}: " in listed
    out = tmp_path / "m.toml"
    code = main(["map", str(path), "-o", str(out)])
    assert code == (2 if pattern in ("17*", "18*", "21*") else 0), capsys.readouterr().err


DRAFTED = {
    "03*": 2.0,
    "08*": 0.0,
    "20*": 0.0,
    "15*": 2.0,
}


@pytest.mark.parametrize("pattern", list(DRAFTED))
def test_a_draft_needs_no_edit(pattern, tmp_path):
    """The draft alone gives the answer."""
    path, drafted = drafted_of(pattern)
    mapping = tmp_path / "m.toml"
    mapping.write_text(mapping_text(drafted, path.name), encoding="utf-8")
    found = calibrate(path, mapping=mapping)
    bound = found.curve.two_sigma / KNOT
    assert np.all(np.abs(found.curve.correction / KNOT - DRAFTED[pattern]) <= bound)


def test_a_file_with_another_suffix_and_more_than_one_name_line_is_read(tmp_path):
    """A download of a display, renamed by a mail program."""
    copy = tmp_path / "flight.txt"
    shutil.copy(shared_case("03-garmin-g5.csv"), copy)
    log = read_log(copy)
    assert log.header["mapping"] == "garmin_g3x"
    assert np.median(log.altitude) == pytest.approx(5130.0 * FOOT, abs=20.0)


def points_of(name, capsys):
    """The points of a card, and the warnings."""
    assert main(["fixed-speed", str(shared_case(name)), "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert not answer["slips"]
    return answer["points"], answer["warnings"]


def test_legs_in_another_order_are_no_slips(capsys):
    points, warnings = points_of("01b-hand-card-other-order.csv", capsys)
    assert not warnings
    for point in points:
        assert point["legs"] == 4
        assert point["correction_kt"] == pytest.approx(1.5, abs=0.1)
        assert point["wind_speed_kt"] == pytest.approx(10.0, abs=0.2)
        assert point["wind_from_deg"] == pytest.approx(200.0, abs=1.0)


@pytest.mark.parametrize("name", ["18-headings-written-as-tracks.csv", "18b-headings-card.csv"])
def test_headings_have_the_airspeed_of_headings_whatever_the_column_is_called(name, capsys):
    (point,), warnings = points_of(name, capsys)
    assert point["true_airspeed_kt"] == pytest.approx(100.0, abs=0.1)
    assert point["wind_speed_kt"] == pytest.approx(20.0, abs=0.1)
    assert [w for w in warnings if "name the column heading_deg" in w] == warnings
    assert bool(warnings) == name.startswith("18-")


# Case: the factor with which it was made, on the airspeed.
FACTORS = {"06-inav-blackbox.csv": 1.25, "12-airspeed-reads-half.bin": 2.0}


@pytest.mark.parametrize("name", list(FACTORS))
def test_a_factor_is_an_answer(name):
    found = answer_of(name)
    assert found.usable
    assert abs(found.scale.factor - FACTORS[name]) <= found.scale.two_sigma < 0.05
    assert any(f"multiply the airspeed by {found.scale.factor:.3f}" in w for w in found.warnings)


def test_a_sensor_that_reads_half_gives_the_ratio_to_set_and_a_hint_at_its_tube():
    found = answer_of("12-airspeed-reads-half.bin")
    (told,) = [words for words in found.warnings if "multiply the airspeed" in words]
    assert "ARSPD_RATIO 8." in told
    assert "half of the airspeed" in told
    assert "tube" in told


def test_what_is_before_the_ice_is_answered():
    path = shared_case("13a-pitot-ices-halfway.bin")
    with pytest.raises(BadInputError, match=r"airspeed dies.*--to 2:3\d") as refusal:
        read_log(path)
    assert "reciprocal" not in str(refusal.value)
    minutes, seconds = str(refusal.value).rpartition("--to ")[2].split(":")
    found = calibrate(read_log(path, part=(None, 60.0 * float(minutes) + float(seconds))))
    assert np.all(np.abs(found.curve.correction) <= found.curve.two_sigma)


def test_a_true_airspeed_that_is_too_high_by_as_much_at_all_speeds_is_answered():
    """26 km/h of true airspeed at 6,000 ft, by the density of the standard day there."""
    found = answer_of("14b-igc-tas-26-kmh-high.igc")
    off = -26.0 / 1.852 * np.sqrt(0.8359)
    assert found.usable
    assert np.all(np.abs(found.curve.correction / KNOT - off) <= found.curve.two_sigma / KNOT)


def test_a_true_airspeed_in_the_column_of_the_indicated_one_is_named():
    found = answer_of("19-tas-in-the-ias-column.csv")
    assert found.usable
    assert "true airspeed in the column of the indicated one" in found.scale.units[0]
    assert any("true airspeed in the column" in each for each in found.warnings)
