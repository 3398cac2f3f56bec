"""A log with several airspeed sensors: each has its own answer, and the others are named."""

from struct import pack, unpack_from

import numpy as np
import pytest
from tests.logbook import foreign_files as foreign

from pitotbench import BadInputError, air, read_log
from pitotbench.calibration import calibrate
from pitotbench.cli import main
from pitotbench.logbook.drafting import draft_mapping, mapping_text
from pitotbench.logbook.reading import read_table
from pitotbench.pressure_error.autopilot_settings import autopilot_settings

FLOWN = foreign.flight()
SECOND = 1.1  # of the impact pressure: what the second sensor reads
OLD = {"ARSPD_RATIO": 2.0, "ARSPD_OFFSET": 0.0, "ARSPD2_RATIO": 1.9, "ARSPD2_OFFSET": 0.0}


def told(log):
    return [w for w in log.header.get("warnings", []) if "airspeed sensors" in w]


def own_csv(folder, *, more=()):
    """Our own columns, with a second impact pressure."""
    table = foreign.canonical(FLOWN)
    table["impact_pressure_2_pa"] = SECOND * FLOWN["impact_pressure"]
    return foreign.exact(folder / "two.csv", table | dict(more))


def test_the_second_sensor_of_a_table_is_read_where_it_is_asked_for(tmp_path):
    path = own_csv(tmp_path)
    first, second = read_log(path), read_log(path, airspeed_sensor=2)
    np.testing.assert_allclose(first.impact_pressure, FLOWN["impact_pressure"])
    np.testing.assert_allclose(second.impact_pressure, SECOND * FLOWN["impact_pressure"])
    np.testing.assert_allclose(second.static_pressure, first.static_pressure)
    names = "1 impact_pressure_pa, 2 impact_pressure_2_pa"
    assert told(first) == [
        f"the log holds 2 airspeed sensors ({names}): this is impact_pressure_pa; "
        "--airspeed-sensor 2 takes impact_pressure_2_pa"
    ]
    assert f"({names}): this is impact_pressure_2_pa; --airspeed-sensor 1" in told(second)[0]
    with pytest.raises(BadInputError, match="--airspeed-sensor 3: the log holds the airspeed sens"):
        read_log(path, airspeed_sensor=3)


def test_a_static_pressure_of_its_own_goes_with_the_second_sensor(tmp_path):
    static = FLOWN["static_pressure"] + 55.0
    path = own_csv(tmp_path, more={"static_pressure_2_pa": static})
    np.testing.assert_allclose(read_log(path, airspeed_sensor=2).static_pressure, static)
    np.testing.assert_allclose(read_log(path).static_pressure, FLOWN["static_pressure"])


def test_a_log_with_one_sensor_says_so(tmp_path):
    path = foreign.plain(tmp_path / "one.csv", FLOWN)
    assert not told(read_log(path, airspeed_sensor=1))
    with pytest.raises(BadInputError, match="the log holds one airspeed sensor, 1 impact_press"):
        read_log(path, airspeed_sensor=2)


@pytest.mark.parametrize("kind", ["bin", "bin up to 4.0", "tables"])
def test_each_sensor_of_an_ardupilot_has_its_own_parameters(kind, tmp_path):
    """The writers give the second sensor half of the first one's pressure."""
    names = ("ARSP", "ASP2") if kind == "bin up to 4.0" else ("ARSP[0]", "ARSP[1]")
    if kind == "bin up to 4.0":
        path = foreign.dataflash(tmp_path / "log.bin", FLOWN, OLD, foreign.UP_TO_4_0)
    elif kind == "bin":
        path = foreign.dataflash(tmp_path / "log.bin", FLOWN, OLD)
    else:
        foreign.message_tables(tmp_path, FLOWN, OLD["ARSPD_RATIO"], OLD)
        path = tmp_path / "x_ARSP.csv"
    first, second = read_log(path), read_log(path, airspeed_sensor=2)
    assert f"(1 {names[0]}, 2 {names[1]}): this is {names[0]}" in told(first)[0]
    assert f"this is {names[1]}; --airspeed-sensor 1 takes {names[0]}" in told(second)[0]
    found = calibrate(second)
    settings = {each.name: each for each in autopilot_settings(found, "ardupilot").settings}
    assert {"ARSPD2_RATIO", "ARSPD2_OFFSET"} <= settings.keys()
    assert not any(name.startswith("ARSPD_") for name in settings)
    # Half of the pressure asks for twice the ratio of the first sensor.
    of_first = autopilot_settings(calibrate(first), "ardupilot").settings[0]
    new, bound = settings["ARSPD2_RATIO"].value, settings["ARSPD2_RATIO"].two_sigma
    assert abs(new - 2.0 * of_first.value) < bound + 2.0 * of_first.two_sigma
    assert settings["ARSPD2_RATIO"].old == OLD["ARSPD2_RATIO"]


def test_the_command_writes_the_parameters_of_the_second_sensor(tmp_path, capsys):
    path, out = foreign.dataflash(tmp_path / "log.bin", FLOWN, OLD), tmp_path / "new.param"
    words = ["-v", "--airspeed-sensor", "2", "--params", "ardupilot", "-o", str(out)]
    assert main(["calibrate", str(path), *words]) == 0
    assert "--airspeed-sensor 1 takes ARSP[0]" in " ".join(capsys.readouterr().out.split())
    assert "ARSPD2_RATIO" in out.read_text()
    assert "ARSPD_RATIO" not in out.read_text()
    assert main(["inspect", str(path)]) == 0
    assert "2 airspeed sensors" in " ".join(capsys.readouterr().out.split())


def test_each_sensor_of_a_px4_is_a_topic(tmp_path):
    ULog = pytest.importorskip("pyulog", reason="needs the extra pitotbench[logs]").ULog
    held = {"ASPD_SCALE_1": 1.0, "ASPD_SCALE_2": 0.9, "SENS_DPRES_OFF": 0.0}
    path = foreign.ulog(tmp_path / "log.ulg", FLOWN, True, held)
    # The first topic again, as the second of its kind: the same subscription with another number.
    data = path.read_bytes()
    name, place, extra = b"differential_pressure", 16, []
    while place < len(data):
        size, kind = unpack_from("<HB", data, place)
        body = data[place + 3 : place + 3 + size]
        if kind == ord("A") and body[3:] == name:
            number = unpack_from("<H", body, 1)[0]
            extra.append(pack("<HB", size, kind) + pack("<BH", 1, 50) + name)
        if kind == ord("D") and unpack_from("<H", body)[0] == number:
            extra.append(pack("<HB", size, kind) + pack("<H", 50) + body[2:])
        place += 3 + size
    path.write_bytes(data + b"".join(extra))
    assert {each.multi_id for each in ULog(str(path)).data_list} == {0, 1}
    first, second = read_log(path), read_log(path, airspeed_sensor=2)
    assert "(1 differential_pressure_0, 2 differential_pressure_1)" in told(first)[0]
    ratio = np.median(second.impact_pressure / first.impact_pressure)
    assert ratio == pytest.approx(0.9**2, rel=0.02)
    assert calibrate(second).autopilot.sensor == 2
    names = [each.name for each in autopilot_settings(calibrate(second), "px4").settings]
    assert names[:2] == ["ASPD_SCALE_2", "SENS_DPRES_OFF"]


@pytest.mark.parametrize("name", ["IAS2", "IAS_standby"])
def test_a_second_airspeed_under_another_name_is_drafted_as_such(name, tmp_path):
    shown = foreign.displayed(FLOWN)
    table = {
        "Time [s]": FLOWN["time"],
        "IAS [kt]": shown["ias"],
        f"{name} [kt]": 1.05 * shown["ias"],
        "Pressure altitude [ft]": shown["pressure_altitude"],
        "OAT [degc]": shown["oat"],
        "Ground speed [kt]": shown["ground_speed"],
        "Track [deg]": shown["track"],
    }
    path = foreign.exact(tmp_path / "foreign.csv", table)
    drafted = draft_mapping(read_table(path))
    (line,) = (each for each in drafted.lines if each.guess.theirs == f"{name} [kt]")
    assert line.guess.target() == "indicated_airspeed_2_kt"
    assert line.question == "is this a sensor beside 'IAS [kt]'?"
    mapping = tmp_path / "m.toml"
    mapping.write_text(mapping_text(drafted, path.name))
    first, second = (read_log(path, mapping, airspeed_sensor=each) for each in (1, 2))
    ratio = air.calibrated_airspeed(second.impact_pressure) / air.calibrated_airspeed(
        first.impact_pressure
    )
    np.testing.assert_allclose(ratio, 1.05, rtol=1e-6)
    assert "1 indicated_airspeed_kt, 2 indicated_airspeed_2_kt" in told(first)[0]
