"""What is typed at a prompt, word for word, and what one expects of it: a number, a file, or the
word that was meant.
"""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure
from tests.shared_data import real_log

from pitotbench import (
    BadInputError,
    Case,
    UnknownNameError,
    calibrate,
    fixed_speed,
    fly,
    inspect,
    read_case,
    read_log,
    sense,
    write_log,
)
from pitotbench.cli.app import DONE, main
from pitotbench.records.case import _NAMES
from pitotbench.simulation.maneuvers import MANEUVERS
from pitotbench.units import FOOT, KNOT

pytestmark = pytest.mark.usefixtures("one_fit_of_each_log")

C172S = ("garmin", "c172s-g1000-2011.csv.gz")


@pytest.fixture(scope="module")
def path():
    return real_log(*C172S)


@pytest.fixture(scope="module")
def c(path):
    return calibrate(str(path))


def test_a_record_begins_with_its_answer_as_the_command_does(c, capsys, path):
    assert main(["calibrate", str(path)]) == DONE
    answer = capsys.readouterr().out.splitlines()[1]
    assert answer.startswith("Add ")
    assert repr(c).startswith(f"<Calibration: {answer}")
    assert c.doubts[0] in repr(c)
    assert "<svg" in c._repr_html_()
    assert isinstance(c.plot(), Figure)
    assert "two_sigma_kt" in c.to_frame()


def test_a_number_at_an_airspeed_is_that_of_the_curve_and_of_the_sentence(c):
    value, two_sigma = c.at(100)
    assert (value, two_sigma) == c.curve.at(100) == c.curve(100)
    known = c.curve
    between = np.searchsorted(known.indicated_airspeed_kt, 100.0)
    assert min(known.correction_kt[between - 1 : between + 1]) <= value
    assert value <= max(known.correction_kt[between - 1 : between + 1])
    low = float(known.indicated_airspeed_kt[0])
    assert f"{c.at(low)[0]:+.2f} ± {c.at(low).two_sigma_kt:.2f} kt at {low:.0f} KIAS" in repr(c)
    assert c.at([70, 100]).correction_kt == pytest.approx([c.at(70)[0], value])
    with pytest.raises(BadInputError, match=r"known from \d+ to \d+ KIAS, and 200"):
        c.at(200)


@pytest.mark.parametrize(
    ("name", "hint"),
    [("correction", r"use at\(100\)"), ("report", "use save"), ("plott", "has no")],
)
def test_a_name_that_is_none_is_told_what_it_means(c, name, hint):
    with pytest.raises(AttributeError, match=hint):
        getattr(c, name)


def test_an_answer_is_saved_as_the_command_writes_it(c, path, tmp_path, capsys):
    page, card, data = (tmp_path / f"c.{suffix}" for suffix in ("html", "csv", "json"))
    for each in (page, card, data):
        c.save(each)
    own = tmp_path / "own.csv"
    assert main(["calibrate", str(path), "--json", "--card", str(own)]) == DONE
    told = json.loads(capsys.readouterr().out)
    assert json.loads(data.read_text(encoding="utf-8"))["curve"] == told["curve"]
    assert card.read_text(encoding="utf-8") == own.read_text(encoding="utf-8")
    assert c.doubts[0] in page.read_text(encoding="utf-8")
    with pytest.raises(BadInputError, match=r"\.json"):
        c.save(tmp_path / "c.pdf")


def test_minutes_are_those_of_the_command(path, tmp_path, capsys):
    part = calibrate(path, start="12:30", end="25:00")
    assert main(["calibrate", str(path), "--from", "12:30", "--to", "25:00", "--json"]) == DONE
    curve = json.loads(capsys.readouterr().out)["curve"]
    assert part.curve.correction_kt == pytest.approx([p["correction_kt"] for p in curve])
    choices = {each.name: each.value for each in part.provenance.choices}
    assert (choices["from"], choices["to"]) == ("12:30", "25:00")
    with pytest.raises(BadInputError, match=r"start 15: give minutes and seconds .* as text"):
        calibrate(path, start=15, end=40)
    log = read_log(path)
    with pytest.raises(BadInputError, match="no rows between start and end"):
        calibrate(log, start="900:00")


def test_a_part_of_a_log_in_memory_keeps_the_clock_of_the_whole():
    log = sense(fly(Case(card={"dwell_s": 10.0, "settle_s": 2.0}, maneuver="rapid_decel")), "5/1")
    part = calibrate(log, start="0:30")
    assert part.log_start == log.start
    assert part.samples < calibrate(log).samples


def test_columns_in_memory_without_a_unit_are_told_the_name_to_give():
    rows = np.arange(200.0)
    table = pd.DataFrame(
        {"ias": 100.0 + 10.0 * np.sin(rows), "gs": 110.0 + 10.0 * np.sin(rows), "track": rows}
    )
    with pytest.raises(BadInputError, match="ias: kt\\? name it indicated_airspeed_kt") as refusal:
        calibrate(table)
    assert "gs: kt? name it ground_speed_kt" in str(refusal.value)
    assert "track: °? name it track_deg" in str(refusal.value)
    assert "no column was found for time" in str(refusal.value)


def test_fixed_speed_takes_what_the_command_takes(path, tmp_path, capsys):
    points = fixed_speed(path)
    assert main(["fixed-speed", str(path), "--json"]) == DONE
    told = json.loads(capsys.readouterr().out)["fixed_speed"]
    assert [p.correction / KNOT for p in points] == pytest.approx(
        [p["correction_kt"] for p in told]
    )
    legs = fixed_speed(np.array([52.5, 61.7, 68.4]), np.radians([0.0, 120.0, 240.0]))
    assert legs.true_airspeed > 0.0
    card = tmp_path / "card.csv"
    card.write_text(
        "point,indicated_airspeed_kt,pressure_altitude_ft,air_temperature_degc,ground_speed_kt,track_deg\n"
        + "".join(f"1,100,5000,5,{g},{t}\n" for g, t in ((118, 0), (108, 120), (99, 240)))
    )
    assert main(["fixed-speed", str(card), "--json"]) == DONE
    told = json.loads(capsys.readouterr().out)["points"]
    assert [p.correction / KNOT for p in fixed_speed(card).points] == pytest.approx(
        [p["correction_kt"] for p in told]
    )


def test_a_case_is_stated_in_the_units_of_a_case_file():
    case = Case.of(altitude_ft=8000, wind_kt=20)
    assert case == read_case("altitude_ft = 8000\nwind = { speed_kt = 20 }\n")
    assert case.altitude == pytest.approx(8000.0 * FOOT)
    turned = Case.of(wind={"speed_kt": 20}, wind_from_deg=90, maneuver="circle")
    assert turned.wind.from_direction == pytest.approx(np.pi / 2.0)
    with pytest.raises(BadInputError, match="the unit is missing: write altitude_ft"):
        Case.of(altitude=8000)
    for name in ("altitude_ft", "wind_kt"):
        with pytest.raises(TypeError, match=rf"Case\.of\({name}=…\)"):
            Case(**{name: 20})
    assert "altitude 26200 ft" in repr(Case(altitude=8000))
    assert replace(case, altitude=1000.0).wind == case.wind


@pytest.mark.parametrize(
    ("field", "typed", "meant"),
    [
        ("maneuver", "cirlce", "circle"),
        ("turbulence", "lihgt", "light"),
        ("pilot", "bussy", "busy"),
    ],
)
def test_a_word_of_a_case_that_is_misspelled_is_refused_with_the_nearest(field, typed, meant):
    with pytest.raises(UnknownNameError, match=f"Did you mean '{meant}'"):
        Case(**{field: typed})
    with pytest.raises(BadInputError, match=f"Did you mean '{meant}'"):
        read_case(f"{field} = '{typed}'\n")


def test_every_maneuver_has_a_name_that_a_case_knows():
    assert list(MANEUVERS) == _NAMES["maneuver"]


def test_what_was_right_before(path, tmp_path):
    flight = fly("rapid_decel")
    assert flight.case.maneuver == "rapid_decel"
    log = write_log(sense(flight, "5/1"), tmp_path / "flight.csv")
    assert inspect(log).rows > 1000
    table = tmp_path / "poh.csv"
    table.write_text("KIAS,KCAS\n60,62\n80,78\n110,107\n")
    assert calibrate(path, handbook=table).curve.published[0].source == Path(table).name
