"""Differences between two files of an airplane that take many flights to tell apart."""

import numpy as np
import pytest
from tests.lab.recovery.test_comparison import OLD, edited

from pitotbench import Case, fly
from pitotbench.models.comparison import compare_models
from pitotbench.show.comparison import comparison_sentences, comparison_tree
from pitotbench.show.markup import page_of
from pitotbench.units import POUND, STANDARD_GRAVITY


def test_several_differences_are_told_apart_and_those_without_effect_as_such(tmp_path):
    new = edited(
        tmp_path,
        ('<emptywt unit="LBS"> 4060', '<emptywt unit="LBS"> 4160'),
        ("<value> 0.0262 </value>", "<value> 0.0288 </value>"),
        ("<max_steer", "<relaxation> <value> 1 </value> </relaxation> <max_steer"),
        engine=('<displacement unit="IN3"> 541.5', '<displacement unit="IN3"> 514.4'),
    )
    found = compare_models(str(OLD), str(new), "rapid_decel")
    by_name = {term.name: term for term in found.terms}
    drag, weight = by_name["parasite drag"], by_name["mass_balance: emptywt"]
    assert (drag.old, drag.new) == (
        pytest.approx(0.0262, rel=1e-3),
        pytest.approx(0.0288, rel=1e-3),
    )
    assert drag.effects[0].channel == "drag"
    assert (weight.old, weight.new, weight.unit) == (4060.0, 4160.0, "LBS")
    assert next(e for e in weight.effects if e.channel == "weight").largest == pytest.approx(
        100.0, abs=0.01
    )
    engine = by_name["file: Engines/tio540a.xml displacement"]
    assert {effect.channel for effect in engine.effects} >= {"power", "thrust"}
    assert all(not term.effects for term in found.terms if term.part.startswith("ground_reactions"))
    # Air, power and weight do not act on one another in a state that is given: the drag is that of
    # one term.
    whole = next(each for each in found.channels if each.channel == "drag")
    assert whole.largest == pytest.approx(drag.effects[0].largest, rel=1e-3)
    assert np.max(np.abs(found.traces["weight"])) == pytest.approx(100.0, abs=0.01)
    assert "nothing in flight" in page_of("it", comparison_tree(found))


def test_an_engine_further_out_yaws_the_airplane_by_its_thrust(tmp_path):
    place = '<location unit="IN"> <x> 72.0 </x> <y> {} </y>'
    new = edited(tmp_path, (place.format("-74.0"), place.format("-84.0")))
    found = compare_models(str(OLD), str(new), "rapid_decel")
    (term,) = found.terms
    assert (term.old, term.new, term.unit) == (-74.0, -84.0, "IN")
    yaw = next(each for each in found.channels if each.channel == "yaw moment")
    flight = fly(Case(aircraft=str(OLD), maneuver="rapid_decel"), channels=("thrust_left",))
    thrust = float(np.max(flight["thrust_left"])) / (POUND * STANDARD_GRAVITY)
    assert yaw.largest == pytest.approx(10.0 / 12.0 * thrust, rel=0.03)


def test_parts_that_do_not_load_one_by_one_are_judged_together(tmp_path):
    renamed = edited(tmp_path, ("aero/lift-clean", "aero/lift-wing"))
    found = compare_models(str(OLD), str(renamed), "rapid_decel")
    assert found.channels == ()
    assert any("do not load one by one" in term.name for term in found.terms)
    assert "Nothing changed in flight" in comparison_sentences(found)[0]
