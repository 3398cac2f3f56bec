"""A flight at another rate of integration is the same to far less than its bound; wrong rates are refused.

`python -m tests.simulation.rates` measures it for every maneuver, in gusts too.
"""

from dataclasses import replace

import numpy as np
import pytest
from tests.simulation.rates import corrections, differences, exact

from pitotbench import BadInputError, Case, fly
from pitotbench.sensing.recorder import record
from pitotbench.sensing.sampling import data_system
from pitotbench.timeline import interval

SMOOTH = Case(maneuver="rapid_decel", turbulence="none")


@pytest.mark.parametrize(("rate", "name"), [(50.0, "50/50"), (40.0, "20/1")])
def test_the_slower_flight_answers_the_same(rate, name, smooth_flights):
    usual, slow = smooth_flights["rapid_decel"], fly(replace(SMOOTH, integration_rate=rate))
    assert interval(slow["time"]) == pytest.approx(1.0 / rate)
    assert list(dict.fromkeys(slow.segment)) == list(dict.fromkeys(usual.segment))
    airspeed, altitude, bank = differences(usual, slow)
    assert airspeed < 0.2  # kt, ft and degrees: a tenth of the card's tolerances at most
    assert altitude < 0.2
    assert bank < 0.1
    system = data_system(name)
    change = corrections(slow, exact(system))[0] - corrections(usual, exact(system))[0]
    assert np.abs(change / corrections(usual, system)[1]).max() < 0.1


def test_a_rate_that_cannot_be_is_refused():
    with pytest.raises(BadInputError, match=r"a flight is integrated at 40, .* 100 Hz, not at 30 Hz"):
        fly(replace(SMOOTH, integration_rate=30.0))
    short = {"maneuver": "race_track", "card": {"dwell_s": 2.0, "speeds_kt": [140.0]}}
    flight = fly(replace(SMOOTH, integration_rate=50.0, **short))
    assert len(record(flight, data_system("25/5"), 1)) > 100
    with pytest.raises(BadInputError, match=r"data system 20/1: 50 Hz is not a whole multiple of the 20 Hz"):
        record(flight, data_system("20/1"), 1)
