"""The patch as a case file takes it, and as JSBSim loads it."""

import tomllib
import xml.etree.ElementTree as ET

import pytest

from pitotbench.reconciliation.patches import patch_of_effects
from pitotbench.records.calibration import Estimate
from pitotbench.records.case import EffectSpec
from pitotbench.records.case_file import read_case
from pitotbench.records.verdict import Candidate
from pitotbench.simulation.modified import overlay_xml


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
        # A case with water in the line must state its column, so that the patch could not be flown without it.
        ("water_in_line", ("lag_s", 0.5, 0.2), {}, {"column_m": 0.0, "lag_s": 0.5}),
        # The time of an event is kept.
        ("sea_breeze_front", ("north_mps", 3.0, 0.4), {"at_s": 123.0}, {"at_s": 123.0, "north_mps": 3.0}),
    ],
)
def test_the_patch_holds_sizes_that_can_be_flown(name, size, shapes, entry):
    made = patch_of_effects([candidate(name, size)], "flight.csv", "2026-01-01", {name: shapes})
    (effect,) = read_case(made.text).effects
    assert effect.name == name
    assert entry.items() <= effect.parameters.items()
    assert entry.items() <= dict(made.entries)[name].items()


def test_the_overlay_holds_what_is_added_and_nothing_else():
    text = overlay_xml("navajo", [EffectSpec("belly_pod", {"drag_area_m2": 0.12}), EffectSpec("pitot_lag")])
    root = ET.fromstring(text)
    assert [p.text for p in root.findall("system/property")] == ["effects/belly-pod/drag-area-m2"]
    functions = root.findall("aerodynamics/axis/function")
    assert [f.get("name") for f in functions] == ["effects/drag-0"]
    assert root.find("propulsion") is None
    assert root.find("metrics") is None
    assert overlay_xml("navajo", [EffectSpec("pitot_lag", {"lag_s": 0.4})]) == ""  # on the sensors alone
