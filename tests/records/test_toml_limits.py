"""TOML of others: one place reads it, within limits, and refuses it by its path."""

import re
from pathlib import Path

import pytest

import pitotbench
from pitotbench.campaigns.plan_file import read_plan
from pitotbench.logbook.mapping import find_mapping
from pitotbench.records import BadInputError
from pitotbench.records.case_file import read_case
from pitotbench.show.reader_units import reader_units
from pitotbench.simulation.aircraft_files import read_record

DOTS = ".".join("x" * 30_000) + " = 1"
DEEP = "x = " + "[" * 3000


def test_one_module_alone_reads_toml():
    package = Path(pitotbench.__file__).parent
    found = [
        file.relative_to(package).as_posix()
        for file in package.rglob("*.py")
        if re.search(r"^\s*(import|from) tomllib", file.read_text(encoding="utf-8"), re.MULTILINE)
    ]
    assert found == ["records/intake.py"]


def case_of_plan(path):
    plan = path.with_name("plan.toml")
    plan.write_text(f"case = '{path.name}'")
    return read_plan(plan)


def record_of(path):
    path.rename(path.with_name("attached.toml"))
    return read_record(path.parent)


@pytest.mark.parametrize("text", [DOTS, DEEP], ids=["dots", "deep"])
@pytest.mark.parametrize("read", [read_case, read_plan, case_of_plan, find_mapping, record_of])
def test_toml_that_takes_minutes_or_gigabytes_is_refused(read, text, tmp_path):
    path = tmp_path / "x.toml"
    path.write_text(text)
    with pytest.raises(BadInputError, match=r"(not valid TOML: .*(dots|deeply)|not the record)"):
        read(path)


def test_a_configuration_is_read_within_limits(tmp_path, monkeypatch):
    path = tmp_path / "x.toml"
    path.write_text(DOTS)
    monkeypatch.setenv("PITOTBENCH_CONFIG", str(path))
    with pytest.raises(BadInputError, match=r"x\.toml: not valid TOML: a key has too many dots"):
        reader_units("")


def test_a_file_that_is_too_large_is_not_read(tmp_path):
    path = tmp_path / "x.toml"
    with path.open("wb") as file:
        file.truncate(17 << 20)
    with pytest.raises(BadInputError, match="cannot be read as a plan: it is larger than 16 MB"):
        read_plan(path)
