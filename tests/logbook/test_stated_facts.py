"""What a user states of a flight reaches every way to ask, and a file whose columns are sure is
calibrated as it is.
"""

import json

import numpy as np
import pytest
from tests.calibration import trajectories as fixture
from tests.logbook import sample_log as sample
from tests.shared_data import shared_case

from pitotbench import BadInputError, air, calibrate, inspect, read_log
from pitotbench.cli.app import main
from pitotbench.logbook.draft import MissingColumnsError
from pitotbench.logbook.drafting import draft_mapping
from pitotbench.logbook.reading import read_table
from pitotbench.logbook.stated_height import stated_height
from pitotbench.units import FOOT, KNOT


@pytest.mark.parametrize(
    ("text", "height", "two_sigma"),
    [("2000", 2000 * FOOT, 150.0), ("600m", 600.0, 150.0), ("2000±300ft", 2000 * FOOT, 300 * FOOT)],
)
def test_a_height_is_read_in_feet_unless_it_says_otherwise(text, height, two_sigma):
    assert stated_height(text) == pytest.approx((height, two_sigma))


@pytest.mark.parametrize("text", ["high", "2000 km", "", "99999"])
def test_another_text_is_no_height(text):
    with pytest.raises(BadInputError, match=r"such as 2000|no airplane flies there"):
        stated_height(text)


def without_height(folder):
    """A log of circles that holds an airspeed and a velocity alone."""
    log = fixture.fly(fixture.circles(2), 2, 2, fixture.Air(gust=0.3))
    table = {
        "time_s": log.time,
        "impact_pressure_pa": log.impact_pressure,
        "air_temperature_k": np.full(len(log), 278.0),
        "velocity_north_mps": log.velocity_north,
        "velocity_east_mps": log.velocity_east,
    }
    return sample.write(folder / "flight.csv", table), log


def test_a_log_without_a_height_says_that_a_stated_one_is_enough(tmp_path, capsys):
    path, _ = without_height(tmp_path)
    assert main(["calibrate", str(path)]) == 2
    assert "--height 2000 (ft) or 600m states it" in capsys.readouterr().err


def test_a_stated_height_reaches_command_python_inspection_and_page(tmp_path, capsys):
    from pitotbench.browser.work import SETTINGS, Request

    path, log = without_height(tmp_path)
    high = str(round(float(np.median(air.pressure_altitude(log.static_pressure))) / FOOT))
    assert main(["calibrate", str(path), "--height", high, "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["stated"]["height"] == high
    static = next(a for a in document["assumptions"] if a["name"] == "static_pressure_pa")
    assert static["two_sigma"] > 3000.0  # 350 m by the weather
    found = calibrate(path, height=high)
    shown = [point["correction_kt"] for point in document["curve"]]
    np.testing.assert_allclose(found.curve.correction_kt, shown)
    assert inspect(path, height=high).rate == pytest.approx(2.0)
    assert "height" in SETTINGS
    assert Request(height=high).reading.facts() == {"height": high}
    for word in ("inspect", "fixed-speed"):
        assert main([word, str(path), "--height", high]) in (0, 3), word
    with pytest.raises(BadInputError, match="give it to read_log"):
        calibrate(read_log(path, height=high), height=high)
    with pytest.raises(BadInputError, match="Known: temperature_c, height"):
        read_log(path, heigth=high)


def test_a_stated_height_changes_the_answer_by_what_the_density_does(tmp_path):
    """4,000 ft are 12 % of the density, 6 % of the airspeed."""
    path, _ = without_height(tmp_path)
    low, high = (calibrate(path, height=text).curve for text in ("2000", "6000"))
    change = float(np.median((low.correction - high.correction) / low.indicated_airspeed))
    assert change == pytest.approx(0.06, abs=0.015)


def test_a_file_whose_columns_are_sure_is_calibrated_as_it_is():
    path = shared_case("29-no-altitude.mat")
    with pytest.raises(MissingColumnsError):
        read_log(path)
    found = calibrate(path, height="1000±300ft")
    curve = found.curve
    off = curve.correction - 0.033 * curve.indicated_airspeed
    assert np.all(np.abs(off) <= curve.two_sigma)
    assert np.all(curve.two_sigma < 2.0 * KNOT)
    assert any("airspeed → indicated_airspeed_mps" in words for words in found.warnings)


def test_a_name_of_ours_is_never_read_as_another_quantity(tmp_path):
    """A height beyond the usual flights is no pressure in meters of something."""
    time = np.arange(200.0)
    table = {"time_s": time, "pressure_altitude_m": 20e3 + 10.0 * time}
    drafted = draft_mapping(read_table(sample.write(tmp_path / "high.csv", table)))
    assert all(line.guess.quantity != "static_pressure" for line in drafted.lines)


def test_a_log_without_a_temperature_names_the_weather_report(tmp_path, capsys):
    """The report is that of the middle of the flight at its place; it is typed, never fetched."""
    log = fixture.fly(fixture.circles(2), 2, 2, fixture.Air(gust=0.3))
    table = {
        "time_s": log.time,
        "impact_pressure_pa": log.impact_pressure,
        "static_pressure_pa": log.static_pressure,
        "velocity_north_mps": log.velocity_north,
        "velocity_east_mps": log.velocity_east,
        "latitude_deg": np.full(len(log), -33.958),
        "longitude_deg": np.full(len(log), 151.236),
    }
    header = '# start = "2026-05-03 23:58:00"\n'
    path = sample.write(tmp_path / "flight.csv", table, header)
    middle = 0.5 * (log.time[0] + log.time[-1]) / 60.0
    assert 2.0 < middle < 62.0
    assert main(["calibrate", str(path)]) == 0
    said = " ".join(capsys.readouterr().out.split())
    report = f"the METAR of 2026-05-04 00:{int(middle - 2.0):02d} by the log's clock"
    assert f"--temperature-c 18±2@ground ({report}, nearest to 33.96° S 151.24° E)" in said
    assert main(["calibrate", str(path), "--temperature-c", "18±2@ground"]) == 0
    assert "METAR" not in capsys.readouterr().out
    del table["latitude_deg"], table["longitude_deg"]
    path = sample.write(tmp_path / "nowhere.csv", table, header)
    assert main(["calibrate", str(path)]) == 0
    assert "METAR" not in capsys.readouterr().out
