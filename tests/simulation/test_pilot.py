"""The pilot: late, coarse and drifting, by the seed; the autopilot is none of it."""

from dataclasses import replace

import numpy as np
import pytest

from pitotbench import Case, fly
from pitotbench.records.case import PILOTS as CASE_PILOTS
from pitotbench.simulation.pilot import PILOTS
from pitotbench.units import FOOT, KNOT

SHORT = Case(maneuver="race_track", card={"dwell_s": 60.0, "speeds_kt": [140.0]}, turbulence="none")


def wander(flight, name):
    """Standard deviation of a channel on the legs."""
    legs = np.char.startswith(flight.segment, "leg")
    return float(np.std(flight[name][legs]))


def test_height_and_speed_wander_more_the_busier_the_pilot():
    assert tuple(PILOTS) == CASE_PILOTS
    flights = {pilot: fly(replace(SHORT, pilot=pilot)) for pilot in PILOTS}
    height = {pilot: wander(flight, "altitude") / FOOT for pilot, flight in flights.items()}
    speed = {pilot: wander(flight, "calibrated_airspeed") / KNOT for pilot, flight in flights.items()}
    assert height["none"] < height["good"] < height["busy"] < 40.0
    assert speed["none"] < speed["good"] < speed["busy"] < 2.0


@pytest.mark.parametrize("maneuver", ["step_decrease", "circle"])
def test_a_good_pilot_keeps_the_tolerances_most_of_the_time(maneuver):
    flight = fly(Case(maneuver=maneuver, pilot="good", turbulence="none"))
    judged = np.char.startswith(flight.segment, maneuver.split("_")[0] + " ")
    assert flight.on_condition[judged].mean() > 0.85


def test_a_pilot_is_drawn_from_the_truth_seed():
    busy = replace(SHORT, pilot="busy", card={"dwell_s": 10.0, "speeds_kt": [140.0]})
    one, again, other = fly(busy), fly(busy), fly(replace(busy, truth_seed=2))
    assert (one["altitude"] == again["altitude"]).all()
    assert len(other) != len(one) or (one["altitude"] != other["altitude"]).any()
