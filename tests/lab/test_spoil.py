"""Spoiled logs of all formats: an answer or one line, whatever the damage; `tests.lab.spoil` takes
more.
"""

import os
from pathlib import Path

import pytest
from tests.lab.spoil import FAULTS, Result, _fault, judge_all, spoil

COUNT = 100

pytestmark = pytest.mark.skipif(
    not hasattr(os, "fork"), reason="each input is run in a process of its own"
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("spoiled")


@pytest.fixture(scope="module")
def results(folder) -> list[Result]:
    return judge_all(range(1, COUNT + 1), folder)


def test_no_input_brings_a_fault_about(results):
    assert [each for each in results if each.fault] == []


def test_the_inputs_are_of_many_kinds_and_some_are_answered(results):
    assert len({each.file for each in results}) > 12
    assert len({each.damage for each in results}) > 12
    assert {0, 2} <= {each.code for each in results}


def test_a_run_goes_on_where_it_stopped_with_the_same_inputs(results, folder):
    table = folder / "results.csv"
    lines = table.read_text("utf-8").splitlines(keepends=True)
    table.write_text("".join(lines[:COUNT]), "utf-8")  # without the last input
    again = judge_all(range(1, COUNT + 1), folder)
    assert again[:-1] == results[:-1]
    assert (again[-1].file, again[-1].damage, again[-1].code) == (
        results[-1].file,
        results[-1].damage,
        results[-1].code,
    )
    assert table.read_text("utf-8").splitlines(keepends=True)[:COUNT] == lines[:COUNT]


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
