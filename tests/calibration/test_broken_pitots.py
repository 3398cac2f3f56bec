"""A broken pitot is told by its kind, a good one is not; and a factor on the airspeed is an answer."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.calibration import trajectories as fixture
from tests.shared_data import shared_case

from pitotbench import BadInputError, CalibrationOptions, FlightLog, air, read_log
from pitotbench.airdata import follow, parts_of
from pitotbench.broken import find_broken
from pitotbench.calibration import calibrate, reduction
from pitotbench.cli import main
from pitotbench.logbook.plausibility import SPEED_FACTOR
from pitotbench.records.log import UNITS_BY
from pitotbench.units import KNOT
from pitotlab.broken.breaks import BASE, CLIMBING, KINDS, broken_columns, ports_of
from pitotlab.broken.measure import answer_of, outcome_of
from pitotlab.outside.generator import generate, write_csv
from pitotlab.outside.kinds import KINDS as GOOD

SEED = 301  # of development


def channels_of(columns):
    """The channels of a log in our own columns."""
    names = {
        "time_s": "time",
        "impact_pressure_pa": "impact_pressure",
        "static_pressure_pa": "static_pressure",
        "velocity_north_mps": "velocity_north",
        "velocity_east_mps": "velocity_east",
        "altitude_m": "altitude",
        "heading_rad": "heading",
    }
    found = {ours: columns[name] for name, ours in names.items()}
    return found | {"gps_fresh": columns["gps_fresh"] > 0.5}


@pytest.mark.parametrize("name", list(KINDS))
def test_each_kind_of_broken_pitot_is_named_in_a_table(name, tmp_path):
    kind = KINDS[name]
    path = tmp_path / "log.csv"
    write_csv(broken_columns(kind, SEED, 0), path)
    found, says = answer_of(path)
    assert outcome_of(kind, found, says) == "named", says
    assert "reciprocal" not in says


@pytest.mark.parametrize("name", ["base", "front", "wave", "bursts", "pilot", "cockpit", "jet"])
def test_a_good_log_is_called_broken_by_nothing(name, tmp_path):
    cell = GOOD[name]
    flight = generate(cell, cell.maneuvers[0], SEED)
    path = tmp_path / "log.csv"
    write_csv(flight.columns, path)
    assert find_broken(read_log(path).channels()) is None


def test_no_zero_drifts_where_the_height_is_stated_and_the_flight_may_climb():
    channels = channels_of(generate(BASE, "race_track", SEED).columns)
    since = channels["time"] - channels["time"][0]
    channels["impact_pressure"] = channels["impact_pressure"] + 1000.0 * since / since[-1]
    assert "the zero drifts" in repr(find_broken(channels))
    del channels["altitude"]
    channels["static_pressure"] = np.full_like(since, np.mean(channels["static_pressure"]))
    assert find_broken(channels) is None


def test_the_regression_gives_what_the_reading_follows():
    """A closed total line reads an altimeter, a closed static port adds one."""
    flight = generate(CLIMBING, "race_track", SEED)
    ports, columns = ports_of(flight), flight.columns
    closed = {
        "sound": (ports.impact, 1.0, 0.0),
        "total closed": (ports.total[0] - ports.static, 0.0, -1.0),
        "static closed": (ports.total - ports.static[0], 1.0, 1.0),
    }
    for name, (impact, speed, ambient) in closed.items():
        channels = channels_of(columns) | {"impact_pressure": impact}
        (part,) = parts_of(channels)
        around = part.ambient - np.mean(part.ambient)
        fit = follow(part, part.impact, around)
        assert fit.values[:2] == pytest.approx([speed, ambient], abs=0.2), name


def test_the_part_before_the_ice_is_read_and_answered(tmp_path, capsys):
    columns = broken_columns(KINDS["iced"], SEED, 0)
    path = tmp_path / "log.csv"
    write_csv(columns, path)
    with pytest.raises(BadInputError, match="--to ") as refusal:
        read_log(path)
    moment = str(refusal.value).rpartition("--to ")[2]
    minutes, seconds = moment.split(":")
    end = 60.0 * float(minutes) + float(seconds)
    part = read_log(path, part=(None, end))
    assert part.time[-1] - part.time[0] <= end
    assert part.start == columns["time_s"][0]
    assert main(["inspect", str(path)]) == 2
    assert "--to " in capsys.readouterr().err


def test_a_case_of_the_field_that_ices_is_told_with_its_moment():
    path = shared_case("13a-pitot-ices-halfway.bin")
    with pytest.raises(BadInputError, match=r"airspeed dies.*--to 2:3\d"):
        read_log(path)


def flown() -> FlightLog:
    return fixture.fly(fixture.circles(10), 10, 10, fixture.Air(gust=0.1))


def shown(log: FlightLog, factor: float) -> FlightLog:
    """The log whose airspeed is to be multiplied by a factor."""
    speed = air.calibrated_airspeed(log.impact_pressure) / factor
    return replace(log, impact_pressure=np.asarray(air.impact_pressure(speed)))


@pytest.mark.parametrize(
    ("factor", "meaning", "usable"),
    [
        (0.869, "miles per hour that is read as knots", True),
        (1.852, "read as kilometers per hour", False),
    ],
)
def test_a_factor_that_a_unit_makes_as_well_names_both(factor, meaning, usable):
    """Only one that no sensor has is not to be used."""
    log = replace(shown(flown(), factor), header={UNITS_BY: {"air_data": "named"}})
    found = calibrate(log, CalibrationOptions())
    assert found.usable == usable
    assert found.scale.factor == pytest.approx(factor, abs=found.scale.two_sigma)
    assert any(meaning in each for each in found.scale.units)


def test_only_a_format_tells_a_sensor_that_reads_half_from_knots():
    """The two factors are 3 % apart, as far as an airplane's own error may be."""
    log = shown(flown(), 2.0)
    found = calibrate(log, CalibrationOptions())
    assert not found.usable
    (told,) = found.disagreements
    causes = ("half of the airspeed (", "a GPS velocity in knots that is read as m/s (")
    places = [told.words.index(each) for each in causes]
    assert places == sorted(places)
    assert "range setting" in told.words
    fixed = calibrate(replace(log, header={UNITS_BY: {"velocity": "speed"}}), CalibrationOptions())
    assert fixed.usable
    assert any("half of the airspeed does so" in each for each in fixed.warnings)


def test_a_factor_of_the_calibration_replaces_the_guess_of_the_reader(tmp_path):
    """One cause, one story: the reader's warning had lost the name of its check on the way."""
    columns = dict(generate(BASE, "circle", SEED).columns)
    columns["impact_pressure_pa"] = 1.4 * columns["impact_pressure_pa"]
    write_csv(columns, tmp_path / "log.csv")
    log = read_log(tmp_path / "log.csv")
    assert [each.code for each in log.cautions].count(SPEED_FACTOR) == 1
    codes = [each.code for each in calibrate(log, CalibrationOptions()).warnings]
    assert "scale" in codes
    assert SPEED_FACTOR not in codes


def test_the_factor_is_that_of_the_curve_and_costs_no_second_reduction(monkeypatch):
    """One answer: what is told of the airspeed as a whole is read off the curve that is told."""
    chosen, original = [], reduction.observe

    def counted(*given, **named):
        chosen.append(given)
        return original(*given, **named)

    monkeypatch.setattr(reduction, "observe", counted)
    calibrate(flown(), CalibrationOptions())
    of_sound = len(chosen)
    found = calibrate(shown(flown(), 1.4), CalibrationOptions())
    assert len(chosen) == 2 * of_sound
    ratio = 1.0 + found.curve.correction / found.curve.indicated_airspeed
    assert np.min(ratio) < found.scale.factor < np.max(ratio)
    assert np.all(np.abs(ratio - found.scale.factor) < 0.05)


def test_the_json_holds_the_factor(tmp_path, capsys):
    flight = generate(BASE, "circle", SEED)
    write_csv(flight.columns, tmp_path / "log.csv")
    assert main(["calibrate", str(tmp_path / "log.csv"), "--json"]) == 0
    scale = json.loads(capsys.readouterr().out)["scale"]
    assert scale["factor"] == pytest.approx(1.0, abs=0.05)
    assert scale["two_sigma"] > 0.0
    assert scale["units"] is None


def test_the_old_ratio_of_a_log_is_turned_into_the_new_one():
    path: Path = shared_case("12-airspeed-reads-half.bin")
    pytest.importorskip("pymavlink", reason="needs the extra pitotbench[logs]")
    answer, says = answer_of(path)
    assert abs(answer.scale.factor - 2.0) < answer.scale.two_sigma
    assert "as ARSPD_RATIO 8" in says
    assert "half of the airspeed" in says


def test_a_true_airspeed_in_the_indicated_column_is_named():
    answer, says = answer_of(shared_case("19-tas-in-the-ias-column.csv"))
    assert "true airspeed in the column of the indicated one" in says
    assert answer.usable


def test_a_copy_of_the_ground_speed_is_told_by_the_noise_of_the_receiver():
    log = flown()
    ground = np.hypot(log.velocity_north, log.velocity_east)
    copy = log.channels() | {"impact_pressure": np.asarray(air.impact_pressure(ground))}
    assert "copy of the GPS speed" in find_broken(copy).words
    assert find_broken(log.channels()) is None
    assert np.median(ground) > 60.0 * KNOT


@pytest.mark.parametrize("walk", [0.0, 20.0])
def test_a_wind_that_turns_is_none_of_a_broken_pitot(walk):
    """Half a turn of a wind in half an hour, as along a mountain wave: the reading stays sound."""
    time = np.arange(0.0, 1800.0, 1.0)
    phase, heading = 2.0 * np.pi * time / 3600.0, 2.0 * np.pi * time / 240.0
    speed = 60.0 + 12.0 * np.sin(time / 300.0)
    channels = {
        "time": time,
        "impact_pressure": np.asarray(air.impact_pressure_from_mach(speed / 334.0, 84556.0)),
        "static_pressure": np.full_like(time, 84556.0),
        "velocity_north": speed * np.cos(heading) + walk * np.cos(phase),
        "velocity_east": speed * np.sin(heading) + walk * np.sin(phase),
    }
    (part,) = parts_of(channels)
    fit = follow(part, part.impact)
    assert fit.values[0] == pytest.approx(1.0, abs=0.05)
    assert fit.rms < 0.02 * np.median(part.impact)
    assert find_broken(channels) is None
    stuck = {**channels, "impact_pressure": np.full_like(time, 2000.0)}
    assert "stuck" in find_broken(stuck).words
