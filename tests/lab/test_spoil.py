"""Spoiled logs of all formats: an answer or one line, whatever the damage; `tests.lab.spoil` takes
more.
"""

import os

import pytest
from tests.lab.spoil import FAULTS, Result, _fault, judge_all, spoil

COUNT = 150

pytestmark = pytest.mark.skipif(
    not hasattr(os, "fork"), reason="each input is run in a process of its own"
)


@pytest.fixture(scope="module")
def results(tmp_path_factory) -> list[Result]:
    return judge_all(range(1, COUNT + 1), tmp_path_factory.mktemp("spoiled"))


def test_no_input_brings_a_fault_about(results):
    assert [each for each in results if each.fault] == []


def test_the_inputs_are_of_many_kinds_and_some_are_answered(results):
    assert len({each.file for each in results}) > 12
    assert len({each.damage for each in results}) > 12
    assert {0, 2} <= {each.code for each in results}


def test_a_run_goes_on_where_it_stopped_with_the_same_inputs(results, tmp_path):
    first = judge_all(range(1, 4), tmp_path)
    table = (tmp_path / "results.csv").read_text("utf-8")
    assert judge_all(range(1, 4), tmp_path) == first
    assert (tmp_path / "results.csv").read_text("utf-8") == table
    assert [(e.file, e.damage, e.code) for e in first] == [
        (e.file, e.damage, e.code) for e in results[:3]
    ]


@pytest.mark.parametrize(
    ("fault", "ended"),
    [
        ("traceback", ("inspect", 2, "", "Exception ignored in: x\npitotbench: bad", 0)),
        ("exit 1", ("inspect", 1, "", "pitotbench: unexpected: KeyError", 0)),
        ("memory", ("inspect", 2, "", "pitotbench: bad", 3 << 30)),
        ("stray output", ("inspect", 2, "rows", "pitotbench: bad", 0)),
        ("stray output", ("inspect", 0, "rows", "bad header 0x1", 0)),
        ("invalid JSON", ("inspect json", 0, '{"a": NaN}', "", 0)),
        ("crash", ("inspect", -11, "", "", 0)),
        ("", ("inspect json", 0, '{"a": null}', "", 0)),
        ("", ("inspect", 3, "", "pitotbench: the log does not determine", 0)),
    ],
)
def test_a_fault_is_seen(fault, ended):
    assert _fault(*ended) == fault
    assert not fault or fault in FAULTS


def test_an_input_is_that_of_its_seed(tmp_path, results):
    files = [tmp_path / "a.csv"]
    files[0].write_text(
        "time_s,impact_pressure_pa\n" + "\n".join(f"{i},{i * 2}" for i in range(50)), "utf-8"
    )
    made = [spoil(7, files, tmp_path / name) for name in ("one", "two")]
    read = [
        sorted((p.name, p.read_bytes()) for p in (tmp_path / name).iterdir())
        for name in ("one", "two")
    ]
    assert read[0] == read[1]
    assert made[0][1:3] == made[1][1:3]
