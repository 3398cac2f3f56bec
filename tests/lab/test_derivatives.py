"""Edited airplanes: the table fits the files, an edit changes what it says, nothing leaks, and the
score counts.
"""

import json
import xml.etree.ElementTree as ET
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from pitotbench.logbook.reading import read_log
from pitotbench.simulation.aircraft import find_aircraft
from pitotlab.__main__ import main
from pitotlab.blind.analyze import analyze
from pitotlab.derivatives.files import AIRPLANES, Change, Place, write_edited
from pitotlab.derivatives.generate import (
    LEAST,
    MOST,
    EditedCase,
    draw_cases,
    flown_log,
    generate,
)
from pitotlab.derivatives.score import NAMES, rows_of, score, score_case
from pitotlab.sealing import opened, seal

SHARE = 0.25
EVERY = [
    (plane, name, pivot)
    for plane, table in AIRPLANES.items()
    for name in table
    for pivot in table[name]
]
# Angle of level flight, and what its unit is in the table of lift.
TRIM = {"navajo": 1.07, "c310": np.radians(1.16), "DHC6": 0.0, "c172x": np.radians(1.35)}


def numbers(folder, function):
    """The numbers of a function's tables, or of its value, by line."""
    root = ET.parse(folder / f"{folder.name}.xml").getroot()
    (found,) = [each for each in root.iter("function") if each.get("name") == function]
    held = list(found.iter("tableData")) or list(found.iter("value"))
    lines = [line for each in held for line in each.text.splitlines() if line.strip()]
    return [[float(word) for word in line.split()] for line in lines]


def edited(tmp_path, plane, *changes):
    write_edited(find_aircraft(plane), tmp_path / "edited", AIRPLANES[plane], changes)
    return tmp_path / "edited"


@pytest.mark.parametrize(("plane", "name", "pivot"), EVERY)
def test_a_change_scales_its_own_functions_alone(tmp_path, plane, name, pivot):
    base, copy = find_aircraft(plane), edited(tmp_path, plane, Change(name, SHARE, pivot))
    for place in AIRPLANES[plane][name][pivot]:
        before, after = numbers(base, place.function), numbers(copy, place.function)
        value = len(before[0]) == 1
        for old, new in zip(before, after, strict=True):
            wanted = [v + SHARE * (place.scale * v + place.shift) for v in old]
            heads = len(old) < len(before[-1])  # the line of columns
            kept = old if heads else [] if value else old[:1]
            assert new == pytest.approx([*kept, *wanted[len(kept) :]])
    functions = {place.function for place in AIRPLANES[plane][name][pivot]}
    for each in ET.parse(base / f"{plane}.xml").getroot().find("aerodynamics").iter("function"):
        name, held = each.get("name"), [*each.iter("value"), *each.iter("tableData")]
        if held and name not in functions:
            assert numbers(copy, name) == numbers(base, name)


@pytest.mark.parametrize("plane", AIRPLANES)
def test_every_airplane_has_every_derivative_and_every_derivative_a_name(plane):
    assert set(AIRPLANES[plane]) == set(NAMES)


@pytest.mark.parametrize(
    ("plane", "name", "pivot"), [each for each in EVERY if each[2] in ("zero", "trim")]
)
def test_a_slope_is_scaled_about_its_pivot(tmp_path, plane, name, pivot):
    """The sum of the functions of lift, or of moment, is the same at the pivot."""
    base, copy = find_aircraft(plane), edited(tmp_path, plane, Change(name, SHARE, pivot))
    angle = TRIM[plane] if pivot == "trim" else 0.0

    def value(folder):
        total = 0.0
        for number, place in enumerate(AIRPLANES[plane][name][pivot]):
            rows = numbers(folder, place.function)
            if number:  # a slope by angle in degrees; flaps up is the second table, no sideslip the middle column
                table = np.array([row for row in rows if len(row) == len(rows[1])][21:42])
                total += angle * np.interp(np.degrees(angle), table[:, 0], table[:, 7])
            else:
                table = np.array([row for row in rows if len(row) == len(rows[-1])])
                total += np.interp(angle, table[:, 0], table[:, 1])
        return total

    assert value(copy) == pytest.approx(value(base), abs=2e-4)


def test_a_function_that_is_not_there_is_refused(tmp_path):
    places = {"CL_0": {"whole": (Place("aero/nothing"),)}}
    with pytest.raises(ValueError, match="0 functions are named aero/nothing"):
        write_edited(find_aircraft("navajo"), tmp_path / "edited", places, [Change("CL_0", SHARE)])
    places = {"CL_0": {"whole": (Place("aero/moment/roll-yaw-rate"),)}}
    with pytest.raises(ValueError, match="2 values"):
        write_edited(find_aircraft("navajo"), tmp_path / "again", places, [Change("CL_0", SHARE)])


def test_cases_hold_every_derivative_as_often_with_both_pivots():
    cases = draw_cases(1, ["navajo", "c172x"], 2, 5)
    assert cases == draw_cases(1, ["navajo", "c172x"], 2, 5)
    single = [case for case in cases if len(case.changes) == 1]
    assert len(single) == 2 * 2 * len(NAMES)
    slopes = [c.changes[0] for c in single if c.changes[0].derivative == "CL_alpha"]
    assert {change.pivot for change in slopes} == {"zero", "trim"}
    several = [case for case in cases if len(case.changes) > 1]
    assert len(several) == 10
    for case in several:
        assert 3 <= len({change.derivative for change in case.changes}) == len(case.changes) <= 6
    assert all(LEAST <= abs(change.share) <= MOST for case in cases for change in case.changes)


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    """A folder with one flight that an edit changes much, and one that cannot be flown."""
    cases = [
        EditedCase("case-0000", 5, "navajo", (Change("CD_0", 0.4),)),
        EditedCase("case-0001", 5, "navajo", (Change("Cm_alpha", -3.0),)),
    ]
    out = tmp_path_factory.mktemp("derivatives")
    return out, cases, generate(7, cases, out)


def test_a_log_names_the_unchanged_airplane_and_the_truth_stands_apart(flown):
    out, _, _ = flown
    log = read_log(out / "logs" / "case-0000.parquet")
    assert log.header["case"]["aircraft"] == "navajo"
    assert log.header["case"]["maneuver"] == "diagnostic"
    assert log.header["case"]["turbulence"] == "light"
    assert not {"seeds", "case_sha256"} & set(log.header)
    assert "CD_0" not in json.dumps(log.header)
    assert "edited" not in json.dumps(log.header)
    truth = opened(out / "seal")["cases"]
    assert truth[0]["changes"] == [{"derivative": "CD_0", "share": 0.4, "pivot": "whole"}]


def test_the_edit_is_flown(flown):
    """With 40 % more parasite drag the airplane burns 21 % more at the same speed."""
    log = read_log(flown[0] / "logs" / "case-0000.parquet")
    plain = flown_log(EditedCase("case-0000", 5, "navajo", ()))
    level = log.segment == log.segment[0]
    before = plain.segment == plain.segment[0]
    assert log.fuel_flow_left[level].mean() > 1.1 * plain.fuel_flow_left[before].mean()


def test_a_flight_that_fails_is_told_and_in_the_score(flown, monkeypatch):
    """The judge reads the airplane from the log, and skips what it has."""
    out, cases, failed = flown
    assert set(failed) == {"case-0001"}
    assert failed["case-0001"].startswith("navajo: ")
    with pytest.raises(ValueError, match="another truth"):
        generate(7, cases[:1], out)
    asked = []

    def refuse(paths, aircraft):
        asked.append((paths[0].name, aircraft))
        raise RuntimeError("no time")

    monkeypatch.setattr("pitotlab.blind.analyze._reconciled", refuse)
    monkeypatch.setattr("pitotlab.blind.analyze.is_warm", lambda *given: True)
    monkeypatch.setattr("pitotlab.blind.analyze.ProcessPoolExecutor", HereExecutor)
    for _ in range(2):
        analyze(out / "logs", out / "results.jsonl")
    assert asked == [("case-0000.parquet", "navajo")]
    assert [case.terms[0].outcome for case in score(out)] == ["no answer", "not flown"]


class HereExecutor(ThreadPoolExecutor):
    """Work in this process, where what is patched is patched."""

    def __init__(self, jobs, context):
        super().__init__(1)


def effect(name, score=9.0, **sizes):
    return name, {key: [value, 0.1] for key, value in sizes.items()}, score


def answer(kind, *effects, others=(), **more):
    named = [name for name, _, _ in effects]
    rivals = [list(others), *([] for _ in effects[1:])][: len(effects)]
    sizes, scores = ({each[0]: each[n] for each in effects} for n in (1, 2))
    told = {"effects": named, "alternatives": rivals, "sizes": sizes, "scores": scores}
    return {"kind": kind, "doubts": [], **told, **more}


def truth(*changes):
    told = [{"derivative": name, "share": share, "pivot": "whole"} for name, share in changes]
    return {"name": "case-0000", "airplane": "navajo", "changes": told, "failed": ""}


@pytest.mark.parametrize(
    ("wanted", "given"),
    [
        ("named alone", answer("named", effect("lift_slope", slope_change=0.25))),
        ("in the set", answer("one_of", effect("zero_lift"), others=["lift_slope"])),
        ("in the set", answer("named", effect("lift_slope"), effect("wind_change"))),
        ("in the set", answer("named", effect("lift_slope"), effect("side_force"))),
        ("wrong name", answer("named", effect("zero_lift"))),
        ("wrong name", answer("named", effect("lift_slope_from_a_time"))),
        ("wrong set", answer("one_of", effect("zero_lift"), others=["side_force"])),
        ("in the set", answer("one_of", effect("lift_slope"), doubts=["a check"])),
        ("unknown", answer("unknown")),
        ("none", answer("no_gap")),
        ("no answer", {"kind": "refused"}),
    ],
)
def test_an_answer_has_one_outcome(wanted, given):
    (term,) = score_case(truth(("CL_alpha", 0.2)), given).terms
    assert term.outcome == wanted
    assert term.partial == ("from_a_time" in str(given))


def test_a_control_is_named_by_the_sizes_beyond_their_bounds():
    given = answer("named", effect("control_moments", elevator_change=0.01, rudder_change=-0.35))
    (rudder,) = score_case(truth(("Cn_dr", -0.3)), given).terms
    (elevator,) = score_case(truth(("Cm_de", -0.3)), given).terms
    assert (rudder.outcome, rudder.inside) == ("named alone", True)
    assert (elevator.outcome, elevator.inside) == ("wrong name", None)


def test_a_told_size_is_held_against_the_share_of_the_whole():
    """The parasite drag of the model is 0.557 m²; a fifth of it is 0.111 m²."""
    for told, inside in ((0.15, True), (0.30, False)):
        given = answer("named", effect("belly_pod", drag_area_m2=told))
        assert score_case(truth(("CD_0", 0.2)), given).terms[0].inside is inside


def test_the_significance_is_that_of_the_true_effect_or_of_the_whole_gap():
    given = answer("unknown", effect("side_force", 8.0), significance=10.0)
    assert score_case(truth(("CY_beta", 0.2)), given).terms[0].significance == 8.0
    assert score_case(truth(("Cl_p", 0.2)), given).terms[0].significance == 10.0
    assert score_case(truth(("Cl_p", 0.2), ("Cn_r", 0.2)), given).terms[0].significance is None


def test_several_changes_are_found_one_by_one():
    told = map(effect, ("dihedral_effect", "roll_damping", "wind_change"))
    given = answer("one_of", *told, others=["side_force"])
    told = truth(("CY_beta", 0.2), ("Cl_p", 0.3), ("Cn_r", -0.4))
    found = score_case(told, given | {"closure": 0.9, "held_out": 0.7})
    assert [term.outcome for term in found.terms] == ["in the set", "named alone", "wrong set"]
    assert (found.others, found.closure, found.held_out) == (1, 0.9, 0.7)


def test_terms_stand_in_groups_by_strength_derivative_and_airplane(tmp_path, capsys):
    cases = [truth(("CL_alpha", 0.2)), truth(("Cl_p", 0.2), ("Cn_r", 0.3), ("CD_0", 0.3))]
    cases[1]["name"] = "case-0001"
    closures = {"closure": 0.9, "held_out": 0.6}
    given = answer("named", effect("lift_slope", slope_change=0.25), **closures)
    seal(tmp_path / "seal", 1, cases)
    lines = [json.dumps(given | {"name": case["name"]}) for case in cases]
    (tmp_path / "results.jsonl").write_text("\n".join(lines), "utf-8")
    (tmp_path / "failed.json").write_text("{}", "utf-8")
    terms = [each.terms[0] for each in score(tmp_path)][:1]
    names = [name for name, _ in rows_of(terms, "single")]
    assert names == ["single", "single, 7σ or more", "CL_alpha", "navajo"]
    assert main(["derivatives", "score", "--out", str(tmp_path), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["single"][0]["named_alone"] == 1
    assert document["single"][0]["alone_percent"] == "21 to 100"
    assert document["several"][0]["others"] == 1
    assert main(["derivatives", "score", "--out", str(tmp_path)]) == 0
    assert "median closure of the flight held out: 0.60" in capsys.readouterr().out
