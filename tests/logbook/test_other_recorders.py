"""Files of universities and of old autopilots: arrays of two rates, kilopascals, quaternions, and what
no flight log holds under a name that sounds like it.
"""

import shutil

import numpy as np
import pytest
from scipy.io import savemat
from scipy.spatial.transform import Rotation
from tests.logbook import sample_log as sample
from tests.shared_data import shared_case

from pitotbench import BadInputError, air, calibrate, read_log
from pitotbench.logbook.columns import Table
from pitotbench.logbook.drafting import draft_mapping
from pitotbench.logbook.matlab import read_mat
from pitotbench.units import KNOT


def holds(found, factor, speed, direction):
    """Whether a curve holds a factor of the airspeed, and the answer a wind."""
    curve = found.curve
    off = curve.correction - (factor - 1.0) * curve.indicated_airspeed
    return (
        np.all(np.abs(off) <= curve.two_sigma)
        and abs(found.wind.speed_kt - speed) < 1.0
        and abs(found.wind.from_deg - direction) < 5.0
    )


def test_arrays_of_another_rate_are_left_out_and_named():
    found = calibrate(shared_case("23-uav-struct-two-rates-kpa.mat"))
    assert holds(found, 1.06, 9.0, 276.0)
    (note,) = (words for words in found.warnings if "another length" in words)
    assert "motor_time, motor_RPM" in note
    (note,) = (words for words in found.warnings if "as their names, units" in words)
    assert "Ps → static_pressure_kpa" in note
    assert "Pd → impact_pressure_kpa" in note


def test_arrays_without_a_time_among_the_most_are_refused(tmp_path):
    arrays = {name: np.arange(50.0) for name in ("ias", "vn", "ve")} | {"time": np.arange(5.0)}
    savemat(tmp_path / "log.mat", {"log": arrays})
    with pytest.raises(BadInputError, match=r"ias 50, time 5\), and none of the 3 of 50 is a time"):
        read_mat(tmp_path / "log.mat")


def test_a_folder_of_a_px4_of_2017_is_one_log():
    """Its height by pressure stands with the position, and its topics need no flag."""
    folder = shared_case("24-px4-topics-of-2017")
    assert read_log(folder).header["mapping"] == "px4"
    assert holds(calibrate(folder), 1.03, 5.0, 292.0)


def test_a_topic_that_is_missing_is_named_with_its_others(tmp_path):
    folder = shutil.copytree(shared_case("24-px4-topics-of-2017"), tmp_path / "log")
    (folder / "log_vehicle_global_position_0.csv").unlink()
    with pytest.raises(
        BadInputError, match=r"air_data_0.*or .*global_position_0.*own file \(\.ulg"
    ):
        read_log(folder)


def test_a_quaternion_is_roll_pitch_and_heading(tmp_path):
    rng = np.random.default_rng(3)
    count = len(sample.columns()["time_s"])
    angles = np.column_stack(
        [rng.uniform(0.0, 6.2, count), rng.uniform(-1.0, 1.0, count), rng.uniform(-3.0, 3.0, count)]
    )
    x, y, z, w = Rotation.from_euler("ZYX", angles).as_quat().T
    table = sample.columns() | {f"attitude_q{n}": part for n, part in enumerate((w, x, y, z))}
    log = read_log(sample.write(tmp_path / "log.csv", table))
    for found, true in zip((log.heading, log.pitch, log.roll), angles.T, strict=True):
        np.testing.assert_allclose(np.angle(np.exp(1j * (found - true))), 0.0, atol=1e-6)


def test_what_only_sounds_like_a_quantity_is_not_sure():
    time = np.arange(300.0)
    turn = 0.02 * time
    quaternion = [np.cos(turn), 0.0 * time, 0.0 * time, np.sin(turn)]
    table = Table(
        ("timestamp", "satVisible", "q[0]", "q[1]", "q[2]", "q[3]", "HeadingX(µT)", "p", "beta_innov",
         "differential_pressure_filtered_pa"),
        (1e6 * time, 7.0 + time % 2, *quaternion, 40.0 * np.cos(turn), 30.0 + time % 7,
         0.1 * np.sin(turn), 150.0 + time % 9),
    )  # fmt: skip
    sure = {
        line.guess.theirs: line.guess.target()
        for line in draft_mapping(table).lines
        if not line.question
    }
    assert sure == {
        "timestamp": "time_s",
        "q[0]": "attitude_q0",
        "q[1]": "attitude_q1",
        "q[2]": "attitude_q2",
        "q[3]": "attitude_q3",
    }


def test_a_ground_speed_is_in_the_unit_of_the_airspeed_beside_it():
    time = np.arange(300.0)
    table = Table(
        ("time_s", "airspeed_mps", "groundspeed"),
        (time, 23.1 + np.sin(time), 22.8 + np.cos(time)),
    )
    lines = {line.guess.theirs: line for line in draft_mapping(table).lines}
    assert lines["groundspeed"].guess.target() == "ground_speed_mps"
    assert lines["groundspeed"].question  # the file does not say so


def test_mode_s_holds_its_temperature_and_a_row_counts_where_its_value_is_new():
    """TAS and Mach make the air 8 K warmer than the standard day; the airspeed is 3 kt low."""
    path = shared_case("30-mode-s-held-values.csv.gz")
    log = read_log(path)
    assert np.all(np.diff(log.impact_pressure) != 0.0)
    height = air.pressure_altitude(log.static_pressure)
    departure = log.air_temperature - air.standard_temperature(height)
    assert np.median(departure) == pytest.approx(8.0, abs=0.5)
    curve = calibrate(log).curve
    assert np.all(np.abs(curve.correction - 3.0 * KNOT) <= curve.two_sigma)
    assert np.all(curve.two_sigma < 3.0 * KNOT)


def test_an_airspeed_that_is_stuck_in_most_rows_is_still_refused(tmp_path):
    table = sample.columns()
    table["impact_pressure_pa"][100:] = table["impact_pressure_pa"][100]
    with pytest.raises(BadInputError, match=r"stands still|stuck|died|dead|stops"):
        read_log(sample.write(tmp_path / "log.csv", table))
