"""The patch as a case file takes it and as JSBSim loads it, and the maneuver that tells causes
apart.
"""

import tomllib
import xml.etree.ElementTree as ET

import numpy as np
import pytest

from pitotbench import Case, fly, read_case, sense
from pitotbench.catalog import Catalog
from pitotbench.effects import EFFECTS
from pitotbench.reconciliation.equations import noise_of_log, whitened_equations
from pitotbench.reconciliation.free_parameters import AnalysisSetting
from pitotbench.reconciliation.layout import lay_out
from pitotbench.reconciliation.patches import (
    flights_to_fly,
    maneuver_to_fly,
    patch_of_effects,
)
from pitotbench.reconciliation.signatures import FITTED, columns_of
from pitotbench.records.calibration import Estimate
from pitotbench.records.case import EffectSpec
from pitotbench.records.verdict import Candidate
from pitotbench.simulation.maneuvers import MANEUVERS
from pitotbench.simulation.modified import overlay_xml
from pitotbench.units import INCH_OF_MERCURY


def candidate(name: str, *sizes: tuple[str, float, float]) -> Candidate:
    return Candidate(name, tuple(Estimate(*size) for size in sizes), 10.0)


POD = candidate("belly_pod", ("drag_area_m2", 0.1234567, 0.01))
GEAR = candidate("gear_not_up", ("extension", 0.26, 0.02))


def test_it_reads_back_with_bounds_and_provenance_in_comments():
    made = patch_of_effects([POD], "flight.csv", "2026-01-01")
    assert read_case(made.text).effects == (EffectSpec("belly_pod", {"drag_area_m2": 0.12346}),)
    assert "± 0.01 (2σ)" in made.text
    assert "flight.csv" in made.text


def test_an_inseparable_effect_stands_in_comments_ready_to_replace_the_named_one():
    made = patch_of_effects([POD], "flight.csv", "2026-01-01", others=[[GEAR]])
    assert [e.name for e in read_case(made.text).effects] == ["belly_pod"]
    swapped = made.text[made.text.index("# the log does not") :].splitlines()[1:]
    table = tomllib.loads("\n".join(line.removeprefix("#").strip() for line in swapped))
    assert table["effects"] == [{"name": "gear_not_up", "parameters": {"extension": 0.26}}]


@pytest.mark.parametrize(
    ("name", "size", "shapes", "entry"),
    [
        # A size out of range is brought to its edge.
        ("belly_pod", ("drag_area_m2", 3.0, 0.1), {}, {"drag_area_m2": 0.8}),
        # A case with water in the line must state its column, so that the patch could not be flown
        # without it.
        ("water_in_line", ("lag_s", 0.5, 0.2), {}, {"column_m": 0.0, "lag_s": 0.5}),
        # The time of an event is kept.
        (
            "sea_breeze_front",
            ("north_mps", 3.0, 0.4),
            {"at_s": 123.0},
            {"at_s": 123.0, "north_mps": 3.0},
        ),
    ],
)
def test_the_patch_holds_sizes_that_can_be_flown(name, size, shapes, entry):
    made = patch_of_effects([candidate(name, size)], "flight.csv", "2026-01-01", {name: shapes})
    (effect,) = read_case(made.text).effects
    assert effect.name == name
    assert entry.items() <= effect.parameters.items()
    assert entry.items() <= dict(made.entries)[name].items()


def test_a_size_that_is_cut_to_its_range_says_so():
    far = candidate("belly_pod", ("drag_area_m2", 0.83, 0.1))
    made = patch_of_effects([far], "flight.csv", "2026-01-01", others=[[far]])
    assert made.text.count("drag_area_m2 = 0.8  # the end of its range, for 0.83 ± 0.1 (2σ)") == 2
    assert "its range" not in patch_of_effects([POD], "flight.csv", "2026-01-01").text


def test_the_overlay_holds_what_is_added_and_nothing_else():
    text = overlay_xml(
        "navajo", [EffectSpec("belly_pod", {"drag_area_m2": 0.12}), EffectSpec("pitot_lag")]
    )
    root = ET.fromstring(text)
    assert [p.text for p in root.findall("system/property")] == ["effects/belly-pod/drag-area-m2"]
    functions = root.findall("aerodynamics/axis/function")
    assert [f.get("name") for f in functions] == ["effects/drag-0"]
    assert root.find("propulsion") is None
    assert root.find("metrics") is None
    assert (
        overlay_xml("navajo", [EffectSpec("pitot_lag", {"lag_s": 0.4})]) == ""
    )  # on the sensors alone


LAG = (EffectSpec("pitot_lag", {"lag_s": 0.3}),)


def separation(maneuver: str) -> float:
    """σ by which a log with a pitot lag prefers the lag to a GPS latency, sensors alone."""
    few = Catalog("effect", {name: FITTED[name] for name in ("pitot_lag", "gps_latency")})
    log = sense(fly(Case(maneuver=maneuver, truth_seed=52, sensor_seed=52, effects=LAG)), "20/20")
    layout = lay_out(log, None, AnalysisSetting(day_known=True), few)
    equations, columns = (
        whitened_equations(layout, noise_of_log(layout)),
        columns_of(layout.signatures),
    )
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
    assert (
        "look at the airplane"
        in flights_to_fly("one_of", group, ["diagnostic", "circle", "four_leg"])[0]
    )


def test_the_card_for_the_pilot_is_of_the_maneuver_that_the_advice_begins_with():
    group = [("belly_pod", "turn_drag")]
    assert maneuver_to_fly([("pitot_lag", "static_lag")]) == "diagnostic"
    assert maneuver_to_fly(group, ["diagnostic"]) in flights_to_fly("one_of", group)[0]
    alike = [("gear_not_up", "belly_pod")]  # no maneuver tells these apart: the card sharpens both
    assert maneuver_to_fly(alike) in flights_to_fly("one_of", alike)[0]
    assert maneuver_to_fly([("gps_latency",)]) in EFFECTS["gps_latency"].shows_in.maneuvers
    assert maneuver_to_fly(group, [*MANEUVERS]) == maneuver_to_fly([]) == ""


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
