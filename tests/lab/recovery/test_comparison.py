"""Two versions of an airplane's file: equal ones, one known change, several at once, and bad input."""

import json
import shutil
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from pitotbench import BadInputError
from pitotbench.cli.app import main
from pitotbench.models.comparison import compare_models
from pitotbench.records.comparison import ChannelChange, ModelComparison, TermChange
from pitotbench.show.comparison import comparison_sentences
from pitotbench.simulation.aircraft import find_aircraft

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
        patch.setattr("pitotbench.models.comparison.compare_models", cache(compare_models))
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


def test_a_wing_that_is_larger_says_by_how_much_and_how_the_airplane_flies(steeper, capsys):
    assert main(["compare", str(OLD), str(steeper), "--json"]) == 0
    flown = json.loads(capsys.readouterr().out)["flown"]
    flown = {each["name"]: each["new"] / each["old"] for each in flown}
    # A fifth more lift of wing and body carries the weight at down to 1/√1.2 of the speed; the
    # elevator's part is as it was.
    assert 1.2**-0.5 < flown["stall speed"] < 0.96
    assert main(["compare", str(OLD), str(steeper)]) == 0
    assert "It flies: stall speed" in capsys.readouterr().out


def test_channels_that_grow_by_one_factor_are_told_together():
    def change(name, share, growth):
        return ChannelChange(name, "", "lb", 8.0, 10.0, share, 0.002, growth)

    channels = (change("pitch moment", 0.07, None), change("drag", 0.034, 0.034))
    channels += (change("lift", 0.034, 0.034),)
    term = TermChange("wing area", "wing area", "ft²", 174.0, 180.0, channels)
    found = ModelComparison("a", "b", "diagnostic", np.empty(0), {}, channels, (), (term,))
    assert comparison_sentences(found) == [
        "Wing area 174 → 180 ft² (+3.4 %): drag and lift +3.4 %; pitch moment up to 7 % of the "
        "largest in the flight."
    ]


def test_a_change_beyond_the_tolerance_is_exit_code_1(steeper, capsys, tmp_path):
    page = tmp_path / "page.html"
    assert (
        main(["compare", str(OLD), str(steeper), "--tolerance", "10", "--report", str(page)]) == 1
    )
    assert "lift slope 4.999 → 5.999 per rad (+20 %)" in capsys.readouterr().out
    assert "<svg" in page.read_text(encoding="utf-8")


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
