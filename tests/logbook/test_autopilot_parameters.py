"""The parameters of an autopilot: read with the log, and made anew from the calibration of its
airspeed.
"""

import json
from dataclasses import replace

import numpy as np
import pytest
from pymavlink import mavparm
from tests.calibration import trajectories
from tests.logbook import foreign_files as foreign
from tests.shared_data import shared_case

from pitotbench import (
    BadInputError,
    Calibration,
    CalibrationOptions,
    FlightLog,
    air,
    read_log,
    write_log,
)
from pitotbench.calibration import calibrate
from pitotbench.calibration.fit_checks import propwash_effect
from pitotbench.cli import main
from pitotbench.logbook.autopilot import AUTOPILOTS, stated_parameters
from pitotbench.logbook.columns import PARAMETERS
from pitotbench.pressure_error import MODELS
from pitotbench.pressure_error.autopilot_settings import autopilot_settings
from pitotbench.pressure_error.models import PressureErrorCurve
from pitotbench.records.calibration import (
    AutopilotSettings,
    ErrorCurve,
    RecordedAutopilot,
    Residuals,
    Setting,
)
from pitotbench.show.deliverables import parameter_file
from pitotbench.units import KNOT, Array

# Several voices of one answer are looked at: each log is fitted once.
pytestmark = pytest.mark.usefixtures("one_fit_of_each_log")

FLOWN = foreign.flight()
EXACT = PressureErrorCurve(MODELS["bias"], (0.0,), 1630.28)
# What the sensor makes of the true impact pressure: a loss of the tube, and a zero of its own [Pa].
LOSS, ZERO = 0.93, 21.0
OLD = {
    "ardupilot": {"ARSPD_RATIO": 1.6, "ARSPD_OFFSET": 12.0, "ARSPD_TYPE": 1.0},
    "px4": {"ASPD_SCALE_1": 0.98, "SENS_DPRES_OFF": 12.0},
}
CHOICE = CalibrationOptions(
    model="bias", error_location="total", accuracies={"impact_pressure_zero_pa": 100.0}
)


def shown(name: str, values: dict[str, float], sensor: Array) -> Array:
    """The airspeed [m/s] that an autopilot shows of its sensor's pressure [Pa], as its documents
    say.
    """
    if name == "ardupilot":
        return np.sqrt(values["ARSPD_RATIO"] * np.maximum(sensor - values["ARSPD_OFFSET"], 0.0))
    return values["ASPD_SCALE_1"] * np.sqrt(
        np.maximum(sensor - values["SENS_DPRES_OFF"], 0.0) * 2.0 / 1.225
    )


def flown_with(name: str, values: dict[str, float], seed: int) -> FlightLog:
    """A flight in light air at 40 to 80 kt whose airspeed is that shown by the autopilot."""
    path = trajectories.circles(10, (80, 65, 50, 40))
    log = trajectories.fly(path, 10, 5, trajectories.Air(pressure=3.0), seed, EXACT)
    speed = shown(name, values, LOSS * log.impact_pressure + ZERO)
    header = {**log.header, PARAMETERS: values}
    return replace(log, impact_pressure=np.asarray(air.impact_pressure(speed)), header=header)


def settings_of(name: str, seed: int = 1) -> AutopilotSettings:
    return autopilot_settings(calibrate(flown_with(name, OLD[name], seed), CHOICE), name)


def new_values(found: AutopilotSettings) -> dict[str, float]:
    return {each.name: each.value for each in found.settings}


@pytest.mark.parametrize("name", list(AUTOPILOTS))
def test_the_formula_with_the_new_parameters_gives_the_true_airspeed(name):
    """Evidence: each is within twice its bound, of the formula written anew here; the bound is no
    empty one.
    """
    found = settings_of(name)
    true = found.calibrated_airspeed
    left = (
        shown(name, new_values(found), LOSS * np.asarray(air.impact_pressure(true)) + ZERO) - true
    )
    assert np.all(np.abs(left) < 2.0 * found.bound)
    assert np.all(found.bound < 1.0)
    offset = found.settings[1]
    assert offset.value == pytest.approx(ZERO, abs=2.0 * offset.two_sigma)
    before = shown(name, OLD[name], LOSS * np.asarray(air.impact_pressure(true)) + ZERO) - true
    assert np.max(np.abs(before)) > 2.0 * np.max(found.bound)


def test_an_old_ratio_that_is_far_off_is_named_and_replaced():
    """Its error is beyond that of any airplane, and what the builder came to mend."""
    old = {**OLD["ardupilot"], "ARSPD_RATIO": 2.6}
    found = calibrate(flown_with("ardupilot", old, seed=1), CHOICE)
    assert any("ARSPD_RATIO 2.6" in text and "--params" in text for text in found.warnings)
    new = autopilot_settings(found, "ardupilot").settings[0]
    assert new.value == pytest.approx(
        new_values(settings_of("ardupilot"))["ARSPD_RATIO"], abs=new.two_sigma
    )


@pytest.mark.parametrize("name", list(AUTOPILOTS))
def test_a_log_flown_with_the_new_parameters_has_a_curve_of_zero(name):
    found = settings_of(name)
    again = calibrate(flown_with(name, new_values(found), seed=2), CHOICE)
    assert np.all(
        np.abs(again.curve.correction) < 2.0 * (again.curve.two_sigma + np.max(found.bound))
    )
    once_more = autopilot_settings(again, name)
    for old, new in zip(found.settings[:2], once_more.settings[:2], strict=True):
        assert new.value == pytest.approx(old.value, abs=2.0 * (old.two_sigma + new.two_sigma))


def calibration_of(curve: ErrorCurve, held: dict[str, float]) -> Calibration:
    real = calibrate(flown_with("px4", OLD["px4"], 1), CHOICE)
    return replace(real, curve=curve, autopilot=RecordedAutopilot(held))


def exact_curve(correction: Array, speed: Array, two_sigma: float) -> ErrorCurve:
    bound = np.full(len(speed), two_sigma)
    zero = np.zeros(len(speed))
    return ErrorCurve(
        speed, correction, bound, bound, bound, zero, zero, correlation=np.eye(len(speed))
    )


def test_a_curve_of_scale_and_offset_gives_them_back():
    speed = np.linspace(15.0, 45.0, 7)
    right = np.sqrt(1.2 * speed**2 - 1.85 * 1.2 * 10.0)  # R = 1.2 · 1.85 and δ = 10 Pa
    held = {"ARSPD_RATIO": 1.85, "ARSPD_OFFSET": 3.0}
    curve = exact_curve(right - speed, speed, 1e-3)
    ratio, offset, *_ = autopilot_settings(calibration_of(curve, held), "ardupilot").settings
    assert ratio.value == pytest.approx(1.2 * 1.85, rel=1e-9)
    assert offset.value == pytest.approx(13.0, abs=1e-6)
    assert (ratio.old, offset.old) == (1.85, 3.0)
    swapped = calibration_of(curve, {**held, "ARSPD_TUBE_ORDR": 1.0})
    _, offset, *_ = autopilot_settings(swapped, "ardupilot").settings
    assert offset.value == pytest.approx(-7.0, abs=1e-6)


def test_the_two_sigma_of_a_scale_alone_is_that_of_the_airspeed():
    """One point's 2σ would be 2R·2σ/V; of n independent points alike in weight it is that over √n."""
    speed = np.linspace(20.0, 40.0, 9)
    held = {"ARSPD_RATIO": 1.9, "ARSPD_TYPE": 6.0}
    found = autopilot_settings(
        calibration_of(exact_curve(0.02 * speed, speed, 0.1), held), "ardupilot"
    )
    weight = np.sum((1.02 * speed) ** 2)
    assert found.settings[0].value == pytest.approx(1.9 * 1.02**2)
    assert found.settings[0].two_sigma == pytest.approx(
        2.0 * 1.9 * 1.02**2 * 0.1 / np.sqrt(weight), rel=1e-6
    )
    assert "ARSPD_OFFSET" not in new_values(found)
    assert "ARSPD_SKIP_CAL" not in new_values(found)


def test_the_bound_says_what_the_formula_cannot_follow():
    speed = np.linspace(20.0, 40.0, 9)
    bump = 1.0 * np.sin(np.linspace(0.0, 3.0 * np.pi, 9))
    found = autopilot_settings(calibration_of(exact_curve(bump, speed, 1e-6), OLD["px4"]), "px4")
    held = new_values(found)
    sensor = (speed / OLD["px4"]["ASPD_SCALE_1"]) ** 2 * 1.225 / 2.0 + OLD["px4"]["SENS_DPRES_OFF"]
    np.testing.assert_allclose(
        np.abs(shown("px4", held, sensor) - speed - bump), found.bound, atol=1e-5
    )
    assert found.settings[0].two_sigma > 0.5 * np.max(found.bound / speed)


def test_the_airspeed_of_a_dataflash_log_is_that_which_was_shown(tmp_path):
    pytest.importorskip("pymavlink", reason="needs the extra pitotbench[logs]")
    held = {"ARSPD_RATIO": 1.9, "ARSPD_OFFSET": 4.0, "ARSPD_TYPE": 1.0, "RLL2SRV_P": 0.5}
    log = read_log(foreign.dataflash(tmp_path / "log.bin", FLOWN, held))
    want = np.sqrt(1.9 * FLOWN["impact_pressure"])
    np.testing.assert_allclose(air.calibrated_airspeed(log.impact_pressure), want, rtol=1e-5)
    assert dict(log.header[PARAMETERS]) == pytest.approx(
        {n: v for n, v in held.items() if n != "RLL2SRV_P"}
    )
    assert any("ARSPD_RATIO 1.9, ARSPD_OFFSET 4" in text for text in log.header["warnings"])


def test_the_airspeed_of_a_ulog_is_that_which_was_shown(tmp_path):
    pytest.importorskip("pyulog", reason="needs the extra pitotbench[logs]")
    held = {"ASPD_SCALE_1": 1.06, "SENS_DPRES_OFF": 7.0}
    log = read_log(foreign.ulog(tmp_path / "log.ulg", FLOWN, True, held))
    want = shown("px4", held, FLOWN["impact_pressure"])
    np.testing.assert_allclose(air.calibrated_airspeed(log.impact_pressure), want, rtol=1e-4)
    assert dict(log.header[PARAMETERS]) == pytest.approx(held)


@pytest.mark.parametrize("known", ["table beside", "stated", "by the airspeed"])
def test_tables_of_messages_are_read_as_the_log_that_they_come_from(tmp_path, known):
    """On the pressure of the messages no ratio has acted, in whatever file they are."""
    pytest.importorskip("pymavlink", reason="needs the extra pitotbench[logs]")
    held = {"ARSPD_RATIO": 1.7, "ARSPD_OFFSET": 4.0}
    whole = read_log(foreign.dataflash(tmp_path / "log.bin", FLOWN, held))
    beside, stated = (held if known == each else None for each in ("table beside", "stated"))
    folder = foreign.message_tables(tmp_path, FLOWN, 1.7, beside)
    log = read_log(folder, "ardupilot", stated)
    rtol = 2e-4 if known == "by the airspeed" else 1e-5  # a ratio of four digits
    np.testing.assert_allclose(log.impact_pressure, whole.impact_pressure, rtol=rtol)
    assert log.header[PARAMETERS]["ARSPD_RATIO"] == pytest.approx(1.7, rel=rtol)


def test_stated_parameters_replace_those_of_the_log(tmp_path):
    pytest.importorskip("pymavlink", reason="needs the extra pitotbench[logs]")
    held = {"ARSPD_RATIO": 1.9, "ARSPD_OFFSET": 4.0}
    path = foreign.dataflash(tmp_path / "log.bin", FLOWN, held)
    log = read_log(path, parameters={"ARSPD_RATIO": 1.7, "ARSPD_OFFSET": 900.0})
    want = np.sqrt(1.7 * FLOWN["impact_pressure"])
    np.testing.assert_allclose(air.calibrated_airspeed(log.impact_pressure), want, rtol=1e-5)
    assert log.header[PARAMETERS]["ARSPD_OFFSET"] == 4.0
    assert any("ARSPD_OFFSET 900 is not used" in text for text in log.header["warnings"])


def test_a_table_of_a_px4_topic_is_read_with_the_stated_scale(tmp_path):
    (tmp_path / "m.toml").write_text(
        '[columns]\ntimestamp = { name = "time_s", factor = 1e-6 }\n'
        'differential_pressure_pa = "impact_pressure_pa"\nbaro = "static_pressure_pa"\n'
        'vel_n = "velocity_north_mps"\nvel_e = "velocity_east_mps"\n'
    )
    columns = {
        "timestamp": 1e6 * FLOWN["time"],
        "differential_pressure_pa": FLOWN["impact_pressure"],
        "baro": FLOWN["static_pressure"],
        "vel_n": FLOWN["velocity_north"],
        "vel_e": FLOWN["velocity_east"],
    }
    rows = foreign.rows_of(*((values, ".10g") for values in columns.values()))
    path = foreign.write_rows(tmp_path / "log.csv", [], list(columns), rows)
    held = {"ASPD_SCALE_1": 1.06, "SENS_DPRES_OFF": 7.0}
    log = read_log(path, tmp_path / "m.toml", held)
    want = shown("px4", held, FLOWN["impact_pressure"])
    np.testing.assert_allclose(air.calibrated_airspeed(log.impact_pressure), want, rtol=1e-5)


CSV_TABLES, SAME_FLIGHT = "10-ardupilot-csv-with-old-ratio", "10-ardupilot-same-flight.bin"


@pytest.mark.parametrize(
    ("case", "stated"),
    [
        (SAME_FLIGHT, ""),
        (SAME_FLIGHT, ",ARSPD_RATIO=4"),
        (CSV_TABLES, ",ARSPD_RATIO=2,ARSPD_OFFSET=2000"),
        (CSV_TABLES, ",ARSPD_RATIO=4,ARSPD_OFFSET=2000"),
        (CSV_TABLES, ""),
        ("16-dataflash-text.log", ""),
    ],
)
def test_a_flight_has_one_ratio_from_every_container(case, stated, capsys):
    """The sensor's true ratio is 2.0."""
    pytest.importorskip("pymavlink", reason="needs the extra pitotbench[logs]")
    flags = ["--mapping", "ardupilot", "--params", f"ardupilot{stated}", "--json"]
    assert main(["calibrate", str(shared_case(case)), *flags]) == 0
    ratio = json.loads(capsys.readouterr().out)["params"][0]
    assert abs(ratio["value"] - 2.0) < ratio["two_sigma"] < 0.1


@pytest.mark.parametrize("kind", ["dataflash", "ulog", "renewed ulog"])
def test_the_throttle_is_read_and_a_wash_looked_for(tmp_path, kind):
    pytest.importorskip(
        "pymavlink" if kind == "dataflash" else "pyulog", reason="needs pitotbench[logs]"
    )
    throttle = 0.5 + 0.3 * np.sign(np.sin(FLOWN["time"] / 25.0))
    if kind == "dataflash":
        held = {"ARSPD_RATIO": 1.7, "ARSPD_OFFSET": 4.0, "ARSPD_TYPE": 1.0}
        log = read_log(
            foreign.dataflash(tmp_path / "log.bin", {**FLOWN, "throttle": throttle}, held)
        )
    else:
        throttle[:3] = np.nan  # motors that are stopped
        held = {"ASPD_SCALE_1": 1.06, "SENS_DPRES_OFF": 7.0}
        flown = {**FLOWN, "throttle": throttle}
        log = read_log(foreign.ulog(tmp_path / "log.ulg", flown, kind == "renewed ulog", held))
    np.testing.assert_allclose(log.throttle_left, throttle[np.isfinite(throttle)], atol=1e-3)
    found = calibrate(log, replace(CHOICE, use_altitude=False))
    wash = found.params("ardupilot" if kind == "dataflash" else "px4").wash
    assert abs(wash.value) < 2.0 * wash.two_sigma < 2.0


@pytest.mark.parametrize(
    ("name", "held", "says"),
    [
        (
            "px4",
            None,
            r"holds none of an autopilot\). Calibrate the file .* or state the old values",
        ),
        ("px4", OLD["ardupilot"], "does not hold ASPD_SCALE_1 and SENS_DPRES_OFF"),
        ("ardupilot", {"ARSPD_RATIO": 1.9}, "does not hold ARSPD_OFFSET"),
        ("ardupilot", {**OLD["ardupilot"], "ARSPD_TYPE": 16.0}, "an airspeed from outside"),
        ("ardupilot", {**OLD["ardupilot"], "ARSPD_RATIO": 0.0}, "must be above zero"),
        ("px4", {**OLD["px4"], "SENS_EN_SDP3X": 1.0}, "model of its tube"),
        ("inav", OLD["px4"], "inav"),
    ],
)
def test_what_a_log_cannot_give_is_refused_with_the_reason(name, held, says):
    speed = np.linspace(20.0, 40.0, 9)
    real = calibration_of(exact_curve(0.02 * speed, speed, 0.1), {})
    with pytest.raises(BadInputError, match=says):
        autopilot_settings(
            replace(real, autopilot=None if held is None else RecordedAutopilot(held)), name
        )
    for text in ("inav", "px4,ASPD_SCALE_1", "px4,ASPD_SCALE_1=one"):
        with pytest.raises(BadInputError):
            stated_parameters(text)


def test_the_command_prints_the_parameters_and_refuses_a_log_without_them(tmp_path, capsys):
    log = flown_with("px4", OLD["px4"], 1)
    path = write_log(
        replace(log, header={k: v for k, v in log.header.items() if k != PARAMETERS}),
        tmp_path / "a.csv",
    )
    flags = ["calibrate", str(path), "--model", "bias", "--accuracy", "impact_pressure_zero_pa=100"]
    assert main([*flags, "--params", "px4"]) == 2
    assert "state the old values" in capsys.readouterr().err
    stated = "px4,ASPD_SCALE_1=0.98,SENS_DPRES_OFF=12"
    assert main([*flags, "--params", stated, "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert [row["name"] for row in answer["params"]] == [
        "ASPD_SCALE_1",
        "SENS_DPRES_OFF",
        "ASPD_SCALE_APPLY",
    ]
    assert set(answer["params"][0]) == {"name", "value", "two_sigma", "old", "from"}
    assert answer["wash"] is None
    page, loaded = tmp_path / "page.html", tmp_path / "airspeed.params"
    assert main([*flags, "--params", stated, "--report", str(page), "-o", str(loaded)]) == 0
    rows = [line.split("\t") for line in loaded.read_text("utf-8").splitlines() if line[0] != "#"]
    assert [(row[2], row[4]) for row in rows] == [
        ("ASPD_SCALE_1", "9"),
        ("SENS_DPRES_OFF", "9"),
        ("ASPD_SCALE_APPLY", "6"),
    ]
    assert float(rows[0][3]) == pytest.approx(answer["params"][0]["value"], rel=1e-6)
    assert "ASPD_SCALE_1" in page.read_text("utf-8")
    assert "Parameters of px4" in capsys.readouterr().out


def test_a_file_of_parameters_is_one_that_pymavlink_loads(tmp_path):
    settings = AutopilotSettings(
        "ardupilot",
        (
            Setting("ARSPD_RATIO", 2.0241, 0.06, 4.0, "old value and the slope of the curve"),
            Setting("ARSPD_AUTOCAL", 0.0, None, 1.0, "else the flight replaces the ratio"),
        ),
        np.array([15.0]),
        np.array([0.2]),
    )
    path = tmp_path / "airspeed.param"
    path.write_text(parameter_file(settings), encoding="utf-8")
    loaded = mavparm.MAVParmDict()
    loaded.load(str(path))
    assert dict(loaded) == {"ARSPD_RATIO": pytest.approx(2.0241), "ARSPD_AUTOCAL": 0.0}


@pytest.mark.parametrize(
    ("flags", "says"),
    [
        (["-o", "a.param"], "add --params ardupilot or px4"),
        (["--params", "px4", "-o", "a.param"], "must end in .params"),
        (["--params", "ardupilot", "-o", "a.txt"], "must end in .param"),
    ],
)
def test_a_file_of_parameters_that_cannot_be_is_refused_at_once(flags, says, tmp_path, capsys):
    assert main(["calibrate", str(tmp_path / "none.csv"), *flags]) == 2
    assert says in capsys.readouterr().err


def with_power(effect: float, seed: int) -> tuple[Residuals, FlightLog]:
    """Residuals that rise by `effect` [m/s] from idle to full power, beside slow noise; power
    beside airspeed.
    """
    rng, n = np.random.default_rng(seed), 6000
    log = trajectories.fly(
        trajectories.circles(10, (60, 60, 50, 50, 40, 40)), 10, 5, trajectories.CALM, 1, EXACT
    )
    indicated = np.asarray(air.calibrated_airspeed(log.impact_pressure))[:n]
    power = 0.5 + 0.3 * np.sign(np.sin(log.time[:n] / 70.0)) + 0.005 * (indicated / KNOT - 50.0)
    noise = np.convolve(rng.standard_normal(n + 200), np.ones(200) / np.sqrt(200.0), "valid")[:n]
    airspeed = effect * power + 0.3 * noise
    used = np.ones(len(log), dtype=bool)
    return Residuals(log.time[:n], indicated + airspeed, airspeed, used), replace(
        log, throttle_left=power
    )


@pytest.mark.parametrize("effect", [0.0, 1.5])
def test_a_wash_is_found_within_its_bound_and_not_told_where_power_follows_airspeed_or_was_not_recorded(
    effect,
):
    found = [propwash_effect(*with_power(effect, seed)) for seed in range(40)]
    inside = [each is not None and abs(each.value - effect) <= each.two_sigma for each in found]
    assert np.mean(inside) >= 0.8  # 95 % is meant; 32 of 40 or fewer happen once in a million
    assert all(each is not None and each.two_sigma < 1.0 for each in found)
    residuals, log = with_power(effect, 1)
    assert propwash_effect(residuals, replace(log, throttle_left=None)) is None
    follows = (residuals.indicated_airspeed - residuals.airspeed) / 60.0
    assert np.isinf(
        propwash_effect(residuals, replace(log, throttle_left=np.clip(follows, 0.0, 1.0))).two_sigma
    )
