"""A factor is an answer, a unit that the file cannot hold is never said, and what moves the answer
is a doubt in every voice.
"""

from dataclasses import replace

import numpy as np
import pytest
from tests.calibration import trajectories as fixture

from pitotbench import CalibrationOptions, air, read_log
from pitotbench.calibration import calibrate
from pitotbench.cli import main
from pitotbench.logbook.plausible_air import HEIGHT
from pitotbench.logbook.reading import table_of
from pitotbench.pressure_error.autopilot_settings import autopilot_settings
from pitotbench.records import NoAnswerError
from pitotbench.records.log import UNITS_BY, Caution
from pitotbench.show.calibration import doubts_of
from pitotbench.show.calibration_json import calibration_json
from pitotbench.show.record import checks_of
from pitotbench.units import KNOT
from pitotlab.broken.breaks import BASE
from pitotlab.broken.scales import answer
from pitotlab.outside.generator import generate, write_csv

SEED = 4100  # of development
MPH = 0.44704  # m/s


@pytest.mark.parametrize(
    ("container", "factor"), [(".ulg", 0.92), (".bin", 0.88), (".csv", 0.92), (".csv", 1.14)]
)
def test_a_factor_that_a_unit_makes_as_well_is_to_be_used(container, factor, tmp_path):
    pytest.importorskip("pymavlink", reason="needs the extra pitotbench[logs]")
    pytest.importorskip("pyulog", reason="needs the extra pitotbench[logs]")
    found, true, says = answer(container, 6000.0, factor, SEED, tmp_path, temperature=True)
    assert found.usable
    assert abs(found.scale.factor - true) <= found.scale.two_sigma
    assert "multiply the airspeed by" in says
    named = [word for word in ("read as", "true airspeed", " %)") if word in says]
    assert not named or container == ".csv"


HELD = {
    "impact_pressure_pa": {"air_data": "pressure", "velocity": "named"},
    "indicated_airspeed_kt": {"air_data": "named", "velocity": "named"},
    "indicated_airspeed": {"air_data": "guessed", "velocity": "guessed"},
}


@pytest.mark.parametrize("name", list(HELD))
def test_a_log_says_what_fixes_its_units(name, tmp_path):
    columns = dict(generate(BASE, "circle", SEED).columns)
    impact = columns.pop("impact_pressure_pa")
    if "speed" in name:
        impact = air.calibrated_airspeed(np.maximum(impact, 0.0)) / KNOT
    write_csv(columns | {name: impact}, tmp_path / "log.csv")
    assert read_log(tmp_path / "log.csv").units_by == HELD[name]


def edgetx(path, speed_kmh, velocity, seconds):
    """A transmitter's log: the unit of each column in its heading."""
    course = np.degrees(np.arctan2(*velocity[::-1])) % 360.0
    ground = np.hypot(*velocity) * 3.6
    lines = ["Date,Time,GSpd(kmh),Hdg(@),ASpd(kmh),Alt(m)"]
    for row in zip(seconds, ground, course, speed_kmh, strict=True):
        minute, second = divmod(row[0], 60.0)
        lines.append(
            f"2025-09-17,14:{int(minute):02d}:{second:06.3f},{row[1]:.2f},{row[2]:.2f},{row[3]:.2f},120"
        )
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def test_the_format_of_a_transmitter_fixes_its_units(tmp_path):
    seconds = np.arange(60.0)
    velocity = 15.0 * np.cos(seconds / 9.0), 15.0 * np.sin(seconds / 9.0) + 2.0
    edgetx(tmp_path / "log.csv", np.full(60, 54.0) + seconds % 7, velocity, seconds)
    table = table_of(tmp_path / "log.csv")
    assert table.header[UNITS_BY] == "speed"
    log = read_log(tmp_path / "log.csv")
    assert log.units_by == {"air_data": "speed", "velocity": "speed"}


def road(tmp_path):
    """A car out and back on one road at three speeds, on a calm day; it reads 16 % low."""
    rng = np.random.default_rng(SEED)
    time = np.arange(0.0, 480.0, 0.2)
    leg = (time // 80.0).astype(int)
    true = np.array([16.0, 16.0, 20.0, 20.0, 25.0, 25.0])[leg] + 0.4 * np.sin(time / 11.0)
    back = np.where(leg % 2 == 0, 1.0, -1.0)
    heading = np.deg2rad(331.0 + 0.5 * np.sin(time / 25.0))  # the road bends
    gust = 0.15 * rng.standard_normal((2, 120)).repeat(len(time) // 120, axis=1)
    north, east = back * true * np.cos(heading), back * true * np.sin(heading)
    through = np.hypot(north - gust[0], east - gust[1])
    shown = 0.84 * through * np.sqrt(0.972) + 0.2 * rng.standard_normal(len(time))
    columns = {
        "time_s": time,
        "indicated_airspeed_mph": shown / MPH,
        "pressure_altitude_ft": np.full(len(time), 820.0) + 2.0 * rng.standard_normal(len(time)),
        "air_temperature_degc": 15.0 + 0.1 * rng.standard_normal(len(time)),
        "velocity_north_mps": north + 0.05 * rng.standard_normal(len(time)),
        "velocity_east_mps": east + 0.05 * rng.standard_normal(len(time)),
    }
    write_csv(columns, tmp_path / "road.csv")
    return tmp_path / "road.csv"


def test_a_clean_factor_on_one_road_is_a_factor_and_no_zero(tmp_path):
    """The wind across the road is unknown, so the bound is wide."""
    log = read_log(road(tmp_path))
    assert not any("zero offset" in each for each in log.cautions)
    found = calibrate(log, CalibrationOptions(model="smooth"))
    assert found.usable
    assert abs(found.scale.factor - 1.0 / 0.84) <= found.scale.two_sigma < 0.15


def slow_log(cell=BASE):
    """The columns of a flight, each tenth row."""
    return {name: column[::10] for name, column in generate(cell, "circle", SEED).columns.items()}


@pytest.fixture
def knots(tmp_path):
    """A log with knots in columns of meters a second."""
    columns = slow_log()
    for axis in ("north", "east"):
        columns[f"velocity_{axis}_mps"] = columns[f"velocity_{axis}_mps"] / KNOT
    write_csv(columns, tmp_path / "log.csv")
    return tmp_path / "log.csv"


def test_what_cannot_be_used_says_in_no_voice_what_to_add_or_to_set(knots, tmp_path, capsys):
    path, record, card = knots, tmp_path / "record.html", tmp_path / "card.csv"
    state = ["--params", "px4,ASPD_SCALE_1=1,SENS_DPRES_OFF=0"]
    assert main(["calibrate", str(path), "--record", str(record), "--card", str(card), *state]) == 0
    says = capsys.readouterr().out
    assert says.splitlines()[1].startswith("Do not use this answer: ")
    assert "a GPS velocity in knots that is read as m/s" in says.splitlines()[1]
    for voice in (says, record.read_text(encoding="utf-8")):
        assert "Do not use this answer" in voice
        assert "Add " not in voice.replace("Add the correction", "")
        assert "Parameters of" not in voice
        assert "ultiply the airspeed" not in voice
    assert "Do not use this answer" in card.read_text(encoding="utf-8")


def test_what_cannot_be_used_says_so_in_python(knots):
    answer = calibrate(read_log(knots), CalibrationOptions())
    assert calibration_json(answer)["usable"] is False
    assert str(answer).index("Do not use") < 200
    with pytest.raises(NoAnswerError, match="not to be used"):
        autopilot_settings(answer, "px4")


def test_a_column_that_moves_the_answer_is_a_doubt_in_every_voice(tmp_path):
    """A total temperature under the name of an outside air temperature."""
    right = slow_log(replace(BASE, temperature="total"))
    wrong = dict(right)
    wrong["air_temperature_k"] = wrong.pop("total_temperature_k")
    found = []
    for columns in (wrong, right):
        write_csv(columns, tmp_path / "log.csv")
        found.append(calibrate(read_log(tmp_path / "log.csv"), CalibrationOptions()))
    answer, curves = found[0], [each.curve for each in found]
    moved = np.interp(
        curves[0].indicated_airspeed, curves[1].indicated_airspeed, curves[1].correction
    )
    moved -= curves[0].correction
    assert np.max(np.abs(moved) / curves[0].two_sigma) > 0.25
    assert found[1].disagreements == ()
    (told,) = calibration_json(answer)["disagreements"]
    assert told["kind"] == "reading"
    assert told["size_kt"] == pytest.approx(float(np.max(np.abs(moved))) / KNOT, rel=0.1)
    first, *_ = calibration_json(answer)["findings"]
    assert first == {
        "kind": "reading",
        "words": told["words"],
        "moves_kt": told["size_kt"],
        "first": True,
        "usable": True,
    }
    record, card = tmp_path / "record.html", tmp_path / "card.csv"
    answer.write_record(record)
    answer.write_card(card)
    files = [each.read_text(encoding="utf-8") for each in (record, card)]
    for voice in (doubts_of(answer)[0], str(answer), *files):
        assert "name the column total_temperature_k" in voice
    assert "columns hold what their names say" in [
        each.name for each in checks_of(answer) if each.status == "failed"
    ]


def test_a_finding_that_moves_nothing_is_a_note_with_its_size():
    log = fixture.fly(fixture.circles(10), 10, 10, fixture.Air(gust=0.1))
    assert log.altitude is None
    finding = Caution("the height does not fit", HEIGHT)
    found = calibrate(replace(log, header={**log.header, "warnings": [finding]}))
    assert found.disagreements == ()
    (note,) = [each for each in found.warnings if "the height does not fit" in each]
    assert note.endswith("KIAS")
    assert "+0.00 kt" in note
    assert not any("height does not fit" in each for each in doubts_of(found))
