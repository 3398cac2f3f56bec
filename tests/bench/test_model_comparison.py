"""Two versions of an airplane's file: equal ones, one known change, several at once, and bad input."""

import json
import shutil
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from pitotbench import BadInputError, Case, fly
from pitotbench.bench.model_comparison import compare_models
from pitotbench.cli.app import main
from pitotbench.show.comparison import comparison_sentences, comparison_tree
from pitotbench.show.markup import page_of
from pitotbench.simulation.aircraft import find_aircraft
from pitotbench.units import POUND, STANDARD_GRAVITY

OLD = find_aircraft("navajo") / "navajo.xml"


def edited(folder: Path, *changes: tuple[str, str], engine: tuple[str, str] = ("", "")) -> Path:
    """Write a copy of the navajo in which texts of its file, and of its engine's, are replaced;
    return the file.
    """
    copy = folder / "navajo"
    shutil.copytree(OLD.parent, copy)
    for file, pairs in (
        ("navajo.xml", changes),
        ("Engines/tio540a.xml", [engine] if engine[0] else []),
    ):
        text = (copy / file).read_text(encoding="utf-8")
        for before, after in pairs:
            assert before in text
            text = text.replace(before, after)
        (copy / file).write_text(text, encoding="utf-8")
    return copy / "navajo.xml"


def _scaled_lift(share: float) -> list[tuple[str, str]]:
    """Put the table of the navajo's lift into a product."""
    text = OLD.read_text(encoding="utf-8")
    begin = text.index("<table>", text.index('<function name="aero/lift-clean">'))
    table = text[begin : text.index("</table>", begin) + len("</table>")]
    return [(table, f"<product> <value> {share} </value> {table} </product>")]


def test_a_file_is_equal_to_itself_and_to_one_with_other_comments_spaces_and_zeros(tmp_path):
    same = edited(
        tmp_path,
        ("<value> -18 </value>", "<value>-18.000</value>"),
        ("<!-- Gear: estimates", "<!-- Gear"),
    )
    assert main(["compare", str(OLD), str(same), "--tolerance", "0"]) == 0
    found = compare_models(str(OLD), str(same))
    assert found.terms == found.channels == found.located == ()
    assert "says the same" in comparison_sentences(found)[0]


@pytest.fixture(scope="module")
def steeper(tmp_path_factory):
    """A file with more lift; its commands share one comparison with the old file."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("pitotbench.bench.model_comparison.compare_models", cache(compare_models))
        yield edited(tmp_path_factory.mktemp("steeper"), *_scaled_lift(1.2))


def test_a_lift_slope_20_percent_larger_is_told_as_that_and_nothing_else(steeper, capsys):
    assert main(["compare", str(OLD), str(steeper), "--json", "--tolerance", "25"]) == 0
    found = json.loads(capsys.readouterr().out)
    (term,) = found["terms"]
    assert term["name"] == "lift slope"
    assert term["unit"] == "per rad"
    assert term["new"] / term["old"] == pytest.approx(1.2, rel=1e-6)
    assert term["old"] == pytest.approx(5.0, rel=0.01)  # the slope that the file's comment states
    assert found["remarks"] == []
    lift = next(each for each in found["channels"] if each["channel"] == "lift")
    assert lift["unit"] == "lb"
    # All of the lift but that of the elevator and of rates is a fifth larger.
    assert lift["share_percent"] == pytest.approx(20.0, abs=1.0)
    # Drag reads the lift; power and mass stay as they are.
    assert {each["channel"] for each in found["channels"]} <= {
        *("lift", "drag", "side force", "pitch moment", "roll moment", "yaw moment")
    }
    assert {each["phase"] for each in found["located"]} >= {"leg", "climb", "turn", "sideslip left"}


def test_a_change_beyond_the_tolerance_is_exit_code_1(steeper, capsys, tmp_path):
    page = tmp_path / "page.html"
    assert (
        main(["compare", str(OLD), str(steeper), "--tolerance", "10", "--report", str(page)]) == 1
    )
    assert "lift slope 4.999 → 5.999 per rad (+20 %)" in capsys.readouterr().out
    assert "<svg" in page.read_text(encoding="utf-8")


def test_several_differences_are_told_apart_and_those_without_effect_as_such(tmp_path):
    new = edited(
        tmp_path,
        ('<emptywt unit="LBS"> 4060', '<emptywt unit="LBS"> 4160'),
        ("<value> 0.0262 </value>", "<value> 0.0288 </value>"),
        ("<max_steer", "<relaxation> <value> 1 </value> </relaxation> <max_steer"),
        engine=('<displacement unit="IN3"> 541.5', '<displacement unit="IN3"> 514.4'),
    )
    found = compare_models(str(OLD), str(new))
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


def test_what_cannot_be_compared_is_refused(tmp_path, capsys):
    text = tmp_path / "old.txt"
    text.write_text("x", encoding="utf-8")
    broken = tmp_path / "broken.xml"
    broken.write_text("<fdm_config>", encoding="utf-8")
    for arguments, problem in (
        ([str(OLD), str(text)], "give two alike"),
        ([str(OLD), str(tmp_path / "none.xml")], "no such aircraft file"),
        ([str(OLD), str(broken)], "not valid XML"),
        ([str(OLD), str(OLD), "--card", "spiral"], "spiral"),
        ([str(OLD), str(OLD), "--tolerance=-1"], "give a share in percent"),
    ):
        assert main(["compare", *arguments]) == 2, arguments
        assert problem in capsys.readouterr().err
    with pytest.raises(BadInputError, match="no such aircraft file"):
        compare_models(str(tmp_path / "none.xml"), str(OLD))
