"""What is changed about a flight after it was flown changes that, and nothing else."""

import numpy as np
import pytest

from pitotbench.campaigns.flights import wind_toward
from pitotbench.catalog import UnknownNameError
from pitotbench.units import FOOT, KNOT
from pitotlab.study.measures import fit
from pitotlab.study.reductions import CHANGES, COVERING, SIDESLIP_ERROR, Reduction, sense_for


@pytest.fixture(scope="module")
def flight(light_flights):
    return light_flights["rapid_decel"]


def _air_speed(flight):
    wind = wind_toward(flight.case.wind)
    north, east = flight["velocity_north"] - wind[0], flight["velocity_east"] - wind[1]
    return np.sqrt(north**2 + east**2 + flight["velocity_down"] ** 2)


@pytest.mark.parametrize("name", ["wind change", "shear", "steady sideslip", "sideslip in turns"])
def test_a_change_of_no_size_is_none(flight, name):
    same = CHANGES[name](flight, 0.0)
    for channel in ("velocity_north", "velocity_east", "total_pressure"):
        np.testing.assert_allclose(same[channel], flight[channel], rtol=1e-12)


def test_wind_grows_with_the_clock(flight):
    blown = CHANGES["wind change"](flight, 2.0)
    gained = [blown[c] - flight[c] for c in ("velocity_north", "velocity_east")]
    rate = np.hypot(*[np.polyfit(flight["time"], g, 1)[0] for g in gained])
    assert rate * 60.0 / KNOT == pytest.approx(2.0, rel=1e-6)
    assert abs(np.mean(gained)) < 1e-6


def test_shear_grows_with_altitude(flight):
    blown = CHANGES["shear"](flight, 3.0)
    gained = np.hypot(*(blown[c] - flight[c] for c in ("velocity_north", "velocity_east")))
    above = np.abs(flight["altitude"] - flight["altitude"].mean()) / (100.0 * FOOT)
    np.testing.assert_allclose(gained / KNOT, 3.0 * above, atol=1e-9)


def test_steeper_path_keeps_the_airspeed(flight):
    steep = CHANGES["vertical speed"](flight, 5.0)
    np.testing.assert_allclose(steep["velocity_down"], 5.0 * flight["velocity_down"])
    np.testing.assert_allclose(_air_speed(steep), _air_speed(flight), rtol=1e-9)


def test_sideslip_takes_its_share_of_impact_pressure(flight):
    slipping = CHANGES["steady sideslip"](flight, 4.0)
    impact = flight["total_pressure"] - flight["static_pressure"]
    kept = (slipping["total_pressure"] - slipping["static_pressure"]) / impact
    np.testing.assert_allclose(kept, 1.0 - 16.0 * SIDESLIP_ERROR)


def test_sideslip_in_turns_spares_the_straight_legs(flight):
    slipping = CHANGES["sideslip in turns"](flight, 4.0)
    moved = slipping["total_pressure"] != flight["total_pressure"]
    assert moved.any()
    assert not moved[flight.on_condition].any()


def test_twice_the_rate_keeps_every_sample(flight):
    double = CHANGES["twice the rate"](flight, 0.0)
    assert np.median(np.diff(double["time"])) == pytest.approx(0.005)
    kept = np.isin(np.round(double["time"], 6), np.round(flight["time"], 6))
    np.testing.assert_array_equal(double["velocity_north"][kept], flight["velocity_north"])


def test_200_hz_and_another_truth_are_held_against_it(flight):
    for how in (("200/200", COVERING), ("50/50", COVERING, "quadratic truth")):
        reduction = Reduction(*how)
        row, result = fit(*sense_for(flight, reduction), reduction)
        assert result is not None
        assert row["rms_error_kt"] < 3.0 * row["two_sigma_kt"]


def test_an_unknown_change_names_the_known_ones(flight):
    with pytest.raises(UnknownNameError, match="vertical speed"):
        sense_for(flight, Reduction(change="vertical sped", level=1.0))


def test_velocity_down_is_recorded_where_asked_for(flight):
    _, usual = sense_for(flight, Reduction("20/1"))
    _, given = sense_for(flight, Reduction("20/1", given_down=True))
    assert usual.velocity_down is None
    true = np.interp(given.time, flight["time"], flight["velocity_down"])
    assert np.std(given.velocity_down - true) < 2.0
