"""Stall, climb, cruise, glide and ceiling from forces in balance: against the model's own polar,
and flown.
"""

import json
from pathlib import Path

import numpy as np
import pytest

from pitotbench.cli.app import main
from pitotbench.models.handbook import read_handbook
from pitotbench.models.performance import find_performance
from pitotbench.records import BadInputError
from pitotbench.simulation.plant import Plant
from pitotbench.units import DEGREE, FOOT, KNOT, STANDARD_GRAVITY
from pitotlab.reference_figures import SPEED_BY_PITCH

DIRECT = 0  # throttle mode: the lever is where it is put
MINUTE = 60.0


@pytest.fixture(scope="module")
def navajo():
    return find_performance("navajo")


def _figure(found, name, condition):
    (figure,) = [f for f in found.figures if f.name == name and f.condition.startswith(condition)]
    return figure.model


# The polar of the navajo's file, in trim: its center of gravity is at the aerodynamic reference
# point.


def _trimmed_polar():
    alpha = np.linspace(0.0, 18.0, 1801)
    table = [
        (0, 0.25),
        (2, 0.4245),
        (4, 0.599),
        (6, 0.7736),
        (8, 0.948),
        (10, 1.118),
        (11, 1.195),
        (12, 1.268),
    ]
    table += [(13, 1.334), (14, 1.390), (15, 1.434), (16, 1.462), (17, 1.465), (18, 1.440)]
    wing = np.interp(alpha, *np.array(table).T)
    elevator = (0.045 - 0.90 * alpha * DEGREE) / 1.20
    separation = np.interp(alpha, [12.0, 14.0, 16.0, 18.0], [0.0, 0.006, 0.022, 0.060])
    return wing + 0.42 * elevator, 0.0262 + 0.0614 * wing**2 + separation


def test_the_stall_speed_is_that_of_the_greatest_trimmed_lift(navajo):
    lift, _ = _trimmed_polar()
    weight, area = navajo.mass * STANDARD_GRAVITY, 229.0 * FOOT**2
    speed = np.sqrt(2.0 * weight / (1.225 * area * lift.max())) / KNOT
    # Idle engines carry or push some pounds.
    assert _figure(navajo, "stall speed", "flaps up") == pytest.approx(speed, rel=0.01)


def test_the_best_lift_to_drag_ratio_is_that_of_the_polar_and_idle_propellers_make_the_glide_steeper(
    navajo,
):
    lift, drag = _trimmed_polar()
    best = _figure(navajo, "best lift-to-drag ratio", "5,000 ft")
    assert best == pytest.approx((lift / drag).max(), rel=0.015)
    assert 0.5 < _figure(navajo, "glide ratio", "5,000 ft") / best < 1.0


def _airborne(height, speed):
    plant = Plant.load("navajo")
    plant.set("position/terrain-elevation-asl-ft", -5000.0)
    plant.start(height, speed)
    plant.set("throttle_mode", DIRECT)
    return plant


def test_the_climb_is_the_one_that_is_flown(navajo):
    height, speed = 5000.0 * FOOT, _figure(navajo, "speed of the best rate", "5,000 ft") * KNOT
    plant = _airborne(height - 2600.0 * FOOT, speed)
    plant.set("pitch_mode", SPEED_BY_PITCH)
    plant.set("throttle_command", 1.0)
    plant.run(80.0)
    low = plant.get("altitude")
    plant.run(20.0)
    rate = (plant.get("altitude") - low) / FOOT / 20.0 * MINUTE
    middle = 0.5 * (low + plant.get("altitude"))
    assert middle == pytest.approx(height, abs=600.0 * FOOT)
    assert rate == pytest.approx(_figure(navajo, "best rate of climb", "5,000 ft"), rel=0.02)


def test_the_cruise_is_the_one_that_is_flown(navajo):
    plant = _airborne(8000.0 * FOOT, 150.0 * KNOT)
    plant.set("throttle_command", 0.6)
    plant.run(150.0)
    cruise = _figure(navajo, "cruise speed", "8,000 ft, 60 %")
    assert plant.get("true_airspeed") / KNOT == pytest.approx(cruise, rel=0.01)


def test_the_service_ceiling_lies_where_the_climb_is_100_feet_a_minute(navajo):
    service, absolute = (_figure(navajo, f"{kind} ceiling", "") for kind in ("service", "absolute"))
    rates = [
        (_figure(navajo, "best rate of climb", f"{height:,} ft"), float(height))
        for height in (20_000, 25_000)
    ]
    assert 25_000.0 < service < absolute
    slope = (rates[0][0] - rates[1][0]) / 5000.0
    assert 25_000.0 + rates[1][0] / slope == pytest.approx(absolute, rel=0.03)


def test_what_a_model_lacks_is_told(capsys, tmp_path):
    page = tmp_path / "page.html"
    assert main(["aircraft", "performance", "J3Cub", "--json", "--report", str(page)]) == 0
    shown = page.read_text(encoding="utf-8")
    assert "it stalls at" in shown
    assert "calibrated airspeed [kt]" in shown
    told = json.loads(capsys.readouterr().out)
    assert {"name": "stall speed", "reason": "the flaps of the model change no lift"} in told[
        "skipped"
    ]
    climb = next(f for f in told["figures"] if f["name"] == "best rate of climb")
    assert climb["unit"] == "ft/min"
    assert climb["published"] is None
    assert climb["difference"] is None


def test_a_glider_has_a_stall_and_a_glide_but_no_climb():
    found = find_performance("SGS")
    # Without engines, the glide is that of the lift over the drag.
    glide, best = (
        _figure(found, name, "5,000 ft") for name in ("glide ratio", "best lift-to-drag ratio")
    )
    assert glide == pytest.approx(best, rel=0.02)
    reasons = dict(found.skipped)
    assert "no engine" in reasons["climb and ceiling"]
    assert "no engine" in reasons["cruise"]


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("figure,climb_rate_fpm\nclimb,\n", "which is blank"),
        ("figure,climb_rate_fpm\nclimb,fast\n", "give a number"),
        ("figure,climb_rate_fpm\nhover,100\n", "'hover' is not known"),
        ("figure,climb_rate\nclimb,100\n", "unknown column 'climb_rate'"),
        ("climb_rate_fpm\n100\n", "no column `figure`"),
        ("figure,climb_rate_fpm\n", "no row"),
        ("figure,climb_rate_fpm,flaps_percent\nclimb,100,50\n", "is no condition of climb"),
    ],
)
def test_a_wrong_handbook_is_refused_with_its_line_and_a_way_out(
    tmp_path: Path, text: str, problem: str
):
    table = tmp_path / "handbook.csv"
    table.write_text(text, encoding="utf-8")
    with pytest.raises(BadInputError, match=problem):
        read_handbook(table)


def test_a_flag_of_the_other_action_is_refused(capsys):
    assert main(["aircraft", "performance", "navajo", "--seed", "2"]) == 2
    assert "--seed is no flag of `aircraft performance`" in capsys.readouterr().err
    assert main(["aircraft", "performance", "nosuch"]) == 2
    assert "nosuch" in capsys.readouterr().err
