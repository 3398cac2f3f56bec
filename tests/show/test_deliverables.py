"""Tables for the handbook, and the airspeed indicator of a simulator."""

import csv
import io
import shutil
from dataclasses import replace

import jsbsim
import numpy as np
import pytest
from tests.calibration import static_flights

from pitotbench import BadInputError, CalibrationOptions, air, write_log
from pitotbench.calibration import calibrate
from pitotbench.cli.app import main
from pitotbench.records.calibration import ErrorCurve
from pitotbench.show.deliverables import (
    altitude_correction,
    handbook_csv,
    handbook_page,
    jsbsim_system,
    table_text,
)
from pitotbench.simulation.aircraft import find_aircraft
from pitotbench.units import FOOT, KNOT

# Several voices of one answer are looked at: each log is fitted once.
pytestmark = pytest.mark.usefixtures("one_fit_of_each_log")


@pytest.fixture(scope="module")
def static():
    """The curve of a flight whose static source errs, and the median pressure altitude of the
    flight [m].
    """
    log = static_flights.fly("circle")
    found = calibrate(log, CalibrationOptions(error_location="static"))
    return found.curve, float(air.pressure_altitude(np.median(log.static_pressure)))


def test_the_altitude_correction_at_the_height_flown_is_that_of_the_calibration(static):
    curve, height = static
    found, bound = altitude_correction(curve, height)
    np.testing.assert_allclose(
        found, curve.altitude_correction, atol=0.02 * np.max(np.abs(found)) + 0.1
    )
    np.testing.assert_allclose(bound, curve.altitude_two_sigma, rtol=0.1, atol=0.1)
    # It grows with height as the air thins.
    low, high = (altitude_correction(curve, h * FOOT)[0] for h in (0.0, 20000.0))
    ratio = [air.standard_pressure(h) / air.standard_temperature(h) for h in (0.0, 20000.0 * FOOT)]
    np.testing.assert_allclose(high / low, ratio[0] / ratio[1], rtol=0.02)
    # An assumed place leaves zero inside the bound.
    assumed = replace(curve, altitude_assumed=True)
    found, bound = altitude_correction(assumed, 3000.0)
    assert np.all(bound >= np.abs(found))
    # It is not for the cockpit then, nor is one of heights far above the flight.
    heights = [f"at_{h}_ft" in handbook_csv({"": curve}) for h in (0, 5000, 10000, 15000, 20000)]
    assert heights == [True, True, True, False, False]
    assert "altitude" not in handbook_csv({"": assumed})


def test_the_csv_holds_each_configuration_with_a_unit_in_every_name(static):
    curve, _ = static
    text = handbook_csv(
        {"clean": curve, "flaps": replace(curve, correction=curve.correction + 1.0)}
    )
    rows = list(csv.DictReader(io.StringIO(text)))
    assert len(rows) == 2 * len(curve.indicated_airspeed)
    assert [row["configuration"] for row in rows[:: len(curve.indicated_airspeed)]] == [
        "clean",
        "flaps",
    ]
    assert all(name == "configuration" or name.endswith(("_kt", "_ft")) for name in rows[0])
    assert float(rows[0]["calibrated_airspeed_kt"]) == pytest.approx(
        curve.calibrated_airspeed_kt[0], abs=1e-3
    )
    found, _ = altitude_correction(curve, 10000.0 * FOOT)
    assert float(rows[0]["altitude_correction_at_10000_ft"]) == pytest.approx(
        found[0] / FOOT, abs=1e-3
    )


def test_a_curve_without_a_static_error_has_no_altitude_columns():
    speed = np.linspace(60.0, 160.0, 11) * KNOT
    assert "altitude" not in handbook_csv({"": curve_of(speed, 0.01 * speed)})
    page = handbook_page({"clean": curve_of(speed, 0.01 * speed)}, "my <airplane>")
    assert "my &lt;airplane&gt;" in page
    assert "altimeter at" not in page


def curve_of(speed, correction):
    bound, zero = np.full(len(speed), 0.2), np.zeros(len(speed))
    return ErrorCurve(speed, correction, bound, bound, bound, zero, zero)


def test_a_simulators_airspeed_indicator_reads_as_the_curve(tmp_path, result):
    """Flown in JSBSim from 60 to 160 kt: its indicated airspeed is within 0.05 kt of the curve."""
    curve = result.curve
    source = find_aircraft("navajo")
    folder = tmp_path / "aircraft" / "navajo"
    shutil.copytree(source, folder)
    (folder / "Systems").mkdir(exist_ok=True)
    (folder / "Systems" / "asi.xml").write_text(jsbsim_system(curve, "Navajo"), encoding="utf-8")
    file = folder / "navajo.xml"
    text = file.read_text(encoding="utf-8")
    file.write_text(
        text.replace("</fdm_config>", '<system file="asi"/>\n</fdm_config>'), encoding="utf-8"
    )
    simulator = jsbsim.FGFDMExec(str(tmp_path), None)
    simulator.set_debug_level(0)
    simulator.set_aircraft_path("aircraft")
    simulator.set_engine_path("aircraft/navajo/Engines")
    assert simulator.load_model("navajo")
    simulator["ic/h-sl-ft"] = 6000.0
    shown, true = [], []
    for speed in np.arange(60.0, 165.0, 2.5):
        simulator["ic/vc-kts"] = float(speed)
        assert simulator.run_ic()
        for _ in range(3):
            simulator.run()
            shown.append(simulator["instrumentation/airspeed-indicator/indicated-speed-kt"])
            true.append(simulator["velocities/vc-kts"])
    calibrated = curve.calibrated_airspeed_kt
    want = np.interp(true, calibrated, curve.indicated_airspeed_kt)
    inside = (np.array(true) >= calibrated[0]) & (np.array(true) <= calibrated[-1])
    assert inside.sum() > 50
    assert np.max(np.abs(np.array(shown) - want)[inside]) < 0.05
    # Beyond the curve the outer correction stays.
    below = np.array(true) < calibrated[0] - 1.0
    outer = curve.correction_kt[0]
    np.testing.assert_allclose((np.array(true) - np.array(shown))[below], outer, atol=0.05)


def test_a_curve_that_no_instrument_has_and_two_curves_in_one_system_are_refused():
    speed = np.linspace(60.0, 160.0, 11) * KNOT
    with pytest.raises(BadInputError, match="does not grow"):
        jsbsim_system(curve_of(speed, -1.1 * speed), "it")
    good = curve_of(speed, 0.01 * speed)
    with pytest.raises(BadInputError, match="there are 2"):
        table_text(".xml", {"clean": good, "flaps": good}, "it")


@pytest.mark.parametrize("suffix", [".csv", ".html", ".xml"])
def test_the_command_writes_each_kind_of_table(tmp_path, capsys, log, suffix):
    path = write_log(log, tmp_path / "flight.csv")
    table = tmp_path / f"table{suffix}"
    assert main(["calibrate", str(path), "--table", str(table)]) == 0
    assert table.stat().st_size > 500
    assert main(["calibrate", str(path), "--table", str(path.with_suffix(".txt"))]) == 2
    assert "must end in .csv or .html or .xml" in capsys.readouterr().err


CARD = """\
point,configuration,indicated_airspeed_kt,pressure_altitude_ft,air_temperature_degc,ground_speed_kt,track_deg
1,clean,100,5000,5,118,358
1,clean,101,5010,5,104,92
1,clean,99,4990,5,96,181
1,clean,100,5000,5,111,268
2,flaps 20,80,5000,5,97,358
2,flaps 20,80,5010,5,83,92
2,flaps 20,80,4990,5,76,181
2,flaps 20,80,5000,5,90,268
"""


def test_the_table_of_a_card_has_its_configurations(tmp_path, capsys, log):
    card, table = tmp_path / "card.csv", tmp_path / "table.csv"
    card.write_text(CARD, encoding="utf-8")
    assert main(["fixed-speed", str(card), "--table", str(table)]) == 0
    assert {row["configuration"] for row in csv.DictReader(table.open())} == {"clean", "flaps 20"}
    path = write_log(log, tmp_path / "flight.csv")
    assert main(["fixed-speed", str(path), "--table", str(table)]) == 2
    assert "use calibrate LOG --table" in capsys.readouterr().err
