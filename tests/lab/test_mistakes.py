"""The mistakes of `mistakes`, read only; `python -m tests.lab.mistakes` calibrates what is read as
well.
"""

import re

import pytest
from tests.lab import mistakes
from tests.lab.mistakes import FAULTS, MISTAKES, Mistake, check, good_columns, judge, read

KNOWABLE = [m for m in MISTAKES.values() if not m.passes]
PASSING = [m for m in MISTAKES.values() if m.passes]

NAMED = {  # the mistake and the words that say what to write
    "velocity kt as mps": "these look like knots: name the columns velocity_north_kt and "
    "velocity_east_kt",
    "velocity mph as mps": "name the columns velocity_north_mph and velocity_east_mph",
    "velocity kmh as mps": "name the columns velocity_north_kmh and velocity_east_kmh",
    "velocity fps as mps": "name the columns velocity_north_fps and velocity_east_fps",
    "velocity mps as kt": "name the columns velocity_north_mps and velocity_east_mps",
    "velocity mph as kt": "name the columns velocity_north_mph and velocity_east_mph",
    "north alone in kt": "name the column velocity_north_kt",
    "east alone in kt": "name the column velocity_east_kt",
    "impact_pressure: hpa written as psf": "name the column impact_pressure_hpa",
    "impact_pressure: mmhg written as hpa": "name the column impact_pressure_mmhg",
    "impact_pressure: inh2o written as pa": "name the column impact_pressure_inh2o",
    "impact x 2": "looks like twice the impact pressure",
    "impact x 0.5": "looks like half the impact pressure",
    "static_pressure: mmhg written as hpa": "the pressure would fit static_pressure_mmhg",
    "static reduced to sea level": "reduced to sea level (QNH)",
    "static as total": "name the column total_pressure_pa",
    "temperature °F as °C": "it would fit total_temperature_degf",
    "temperature °F as K": "they would fit total_temperature_degf: correct",
    "temperature of the air as total": "it looks like air_temperature",
    "temperature total as of the air": "name the column total_temperature_k",
    "altitude ft as m": "the height would fit altitude_ft",
    "north with the wrong sign": "the north velocity has the wrong sign",
    "east with the wrong sign": "the east velocity has the wrong sign",
    "north and east with the wrong sign": "both velocities have the wrong sign",
    "north and east exchanged": "the north and east velocities are exchanged",
    "axes turned by 12°": "the axes are turned by",
    "heading magnetic, 12° off": "the axes are turned by",
    "heading is the track": "the heading is the track over ground",
    "roll: rad written as °": "it would fit roll_rad",
    "pitch: rad written as °": "it would fit pitch_rad",
}


def test_there_are_149_mistakes():
    assert len(MISTAKES) == 149
    assert {*NAMED} <= {mistake.name for mistake in KNOWABLE}


def test_the_good_log_has_no_warning():
    assert "warnings" not in read(good_columns(mistakes.log())).header


@pytest.mark.parametrize("mistake", KNOWABLE, ids=lambda m: m.name)
def test_a_mistake_that_a_log_can_show_is_refused_or_named_in_a_warning(mistake):
    """The message says what to write; a factor of the speed is an answer of the calibration."""
    log, says = check(mistake)
    assert log is None or any(name in says for name in mistake.names), says
    assert NAMED.get(mistake.name, "") in says


@pytest.mark.parametrize("mistake", PASSING, ids=lambda m: m.name)
def test_what_no_log_can_show_is_read_without_a_word(mistake):
    """A mistake that comes to be found must leave the list."""
    log, says = check(mistake)
    assert log is not None
    assert not any(name in says for name in mistake.names)


def test_the_good_log_is_judged_unharmed_and_a_gain_as_not_to_be_shown():
    assert judge(Mistake("none", lambda t: t, ())).kind == "unharmed"
    assert judge(MISTAKES["velocity x 1.02"]).kind == "no log can show it"


TOLD = {  # a fault, the maneuver, and words of what is said, as a log is read or calibrated
    ("velocity of airspeed and heading", "circle"): "made of the air data",
    ("velocity of airspeed, heading and a typed wind", "diagnostic"): "made of the air data",
    ("q_c in steps of 150 Pa", "circle"): "comes in steps of 150 Pa",
    ("GPS 1.5 s late", "circle"): "one of them late in the turns",
    ("static frozen for 60 s", "diagnostic"): "seems stuck",
    ("T with the wrong sign of °C", "circle"): "rises with the airspeed",
    ("q_c of the flight backwards", "circle"): "did a unit, a gain or a source change",
}
STEPS = {"pitot x 0.95 in the first third": 0.05, "q_c zero steps by -120 Pa": -0.05}


def test_there_are_60_faults():
    assert len(FAULTS) == 60
    assert {name for name, _ in TOLD} | STEPS.keys() <= FAULTS.keys()
    assert not FAULTS.keys() & MISTAKES.keys()


@pytest.mark.parametrize(("name", "maneuver"), TOLD)
def test_a_fault_is_told(name, maneuver):
    assert TOLD[name, maneuver] in check(FAULTS[name], maneuver)[1]
    assert check(Mistake("none", lambda t: t, ()), maneuver)[1] == ""


@pytest.mark.parametrize("name", [None, *STEPS])
def test_a_step_of_the_impact_pressure_within_a_speed_is_told_with_its_time(name):
    """It was silent and 5 to 7 times beyond the bound. Of the good log nothing is said."""
    says = judge(FAULTS[name] if name else Mistake("none", lambda t: t, ()), wind="checked").says
    told = re.search(
        r"impact pressure seems to change by ([+-]\d+) % from (\d):(\d\d) of the rows used on", says
    )
    if name is None:
        assert says == ""
        return
    assert told
    assert float(told[1]) / 100.0 == pytest.approx(STEPS[name], abs=0.025)
    whole = (mistakes.log().time[-1] - mistakes.log().time[0]) * (0.33 if "third" in name else 0.45)
    assert 60.0 * float(told[2]) + float(told[3]) == pytest.approx(whole, abs=60.0)
