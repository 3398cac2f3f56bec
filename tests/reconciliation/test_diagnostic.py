"""The diagnostic maneuver separates effects that look alike in a calibration maneuver."""

import numpy as np
import pytest

from pitotbench import Case, fly, sense
from pitotbench.catalog import Catalog
from pitotbench.effects import EFFECTS
from pitotbench.reconciliation.equations import noise_of_log, whitened_equations
from pitotbench.reconciliation.free_parameters import AnalysisSetting
from pitotbench.reconciliation.layout import lay_out
from pitotbench.reconciliation.patches import flights_to_fly
from pitotbench.reconciliation.signatures import FITTED, columns_of
from pitotbench.records.case import EffectSpec
from pitotbench.units import INCH_OF_MERCURY

LAG = (EffectSpec("pitot_lag", {"lag_s": 0.3}),)


def separation(maneuver: str) -> float:
    """σ by which a log with a pitot lag prefers the lag to a GPS latency, sensors alone."""
    few = Catalog("effect", {name: FITTED[name] for name in ("pitot_lag", "gps_latency")})
    log = sense(fly(Case(maneuver=maneuver, truth_seed=52, sensor_seed=52, effects=LAG)), "20/20")
    layout = lay_out(log, None, AnalysisSetting(day_known=True), few)
    equations, columns = whitened_equations(layout, noise_of_log(layout)), columns_of(layout.signatures)
    gains = {name: equations.fit(of_effect).gain for name, of_effect in columns.items()}
    return float(np.sqrt(max(0.0, gains["pitot_lag"] - gains["gps_latency"])))


def test_it_separates_lag_from_latency_far_better_than_step_decrease():
    before, after = separation("step_decrease"), separation("diagnostic")
    assert after > 2.0 * before
    assert after > 8.0


def test_it_is_advised_where_causes_of_two_kinds_cannot_be_separated_but_not_again():
    assert "diagnostic" in flights_to_fly("one_of", [("pitot_lag", "static_lag")])[0]
    assert "look at the airplane" in flights_to_fly("one_of", [("gear_not_up", "belly_pod")])[0]
    group = [("belly_pod", "turn_drag")]
    assert "circle" in flights_to_fly("one_of", group)[0]
    assert "circle" not in flights_to_fly("one_of", group, ["circle"])[0]
    assert "four_leg" in flights_to_fly("one_of", group, ["diagnostic", "circle"])[0]
    assert "look at the airplane" in flights_to_fly("one_of", group, ["diagnostic", "circle", "four_leg"])[0]


@pytest.mark.parametrize("name", EFFECTS)
def test_every_effect_is_sharpened_by_a_maneuver_that_shows_it(name):
    (sentence,) = flights_to_fly("named", [(name,)])
    assert any(maneuver in sentence for maneuver in EFFECTS[name].shows_in.maneuvers)


def test_it_climbs_slips_to_both_sides_and_idles(smooth_flights):
    flight = smooth_flights["diagnostic"]
    assert np.ptp(flight["altitude"]) > 230.0
    assert np.degrees(flight["sideslip"].max()) > 2.0
    assert np.degrees(flight["sideslip"].min()) < -1.5
    assert flight["manifold_pressure_left"].min() < 12.0 * INCH_OF_MERCURY
