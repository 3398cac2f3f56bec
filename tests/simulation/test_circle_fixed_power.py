"""Circle as the paper's pilot flew it: the power fixed, pitch on airspeed and altitude together."""

import numpy as np
import pytest

from pitotbench import bench
from pitotbench.records import BadInputError
from pitotbench.records.case import Case
from pitotbench.units import FOOT, INCH_OF_MERCURY, KNOT

SPEED = 140.0


@pytest.fixture(scope="module")
def circles():
    """One circle in smooth air by the autopilot, with the airspeed held by throttle and by pitch."""
    cards = {power: {"speeds_kt": [SPEED], "fixed_power": power} for power in (0, 1)}
    flights = {p: bench.fly(Case(maneuver="circle", turbulence="none", card=card)) for p, card in cards.items()}
    return {p: (flight, np.char.startswith(flight.segment, "circle")) for p, flight in flights.items()}


def test_power_stays_and_pitch_holds_the_airspeed(circles):
    flight, on = circles[1]
    power = flight["manifold_pressure_left"][on] / INCH_OF_MERCURY
    assert np.ptp(power[len(power) // 10 :]) < 0.3
    assert np.max(np.abs(flight["calibrated_airspeed"][on] / KNOT - SPEED)) < 2.0
    assert np.max(np.abs(flight["altitude"][on] - flight.case.altitude)) < 50.0 * FOOT


def test_altitude_wanders_more_than_with_the_throttle_on_airspeed(circles):
    wander = {power: np.ptp(flight["altitude"][on]) for power, (flight, on) in circles.items()}
    assert wander[1] > 3.0 * wander[0]


def test_fixed_power_is_yes_or_no():
    with pytest.raises(BadInputError, match="0 or 1"):
        bench.fly(Case(maneuver="circle", card={"fixed_power": 2}))
