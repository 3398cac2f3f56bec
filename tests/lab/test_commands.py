"""The table of measurements, and the parts of the product that the laboratory names in strings."""

import ast
import re
import subprocess
import sys
from dataclasses import asdict, replace
from functools import cache, partial
from importlib import import_module
from pathlib import Path

import pytest
from tests.bench.test_null_tables import are_close

import pitotlab
from pitotbench.bench import workflow
from pitotbench.bench.null_flights import NULL_FLIGHTS, null_distribution_of
from pitotbench.bench.null_tables import packed, read_packed, read_table
from pitotbench.cli.app import main as bench
from pitotbench.records.case import Case, EffectSpec
from pitotbench.records.case_file import write_case
from pitotbench.simulation.modified import install_variant
from pitotlab.__main__ import COMMANDS, main
from pitotlab.coverage import COVERED
from pitotlab.null_tables import SETTING, stock_cards
from pitotlab.speed import ratios
from pitotlab.speed.commands import Line
from pitotlab.tables import FIGURES, write_figures

FOLDER = Path(pitotlab.__file__).parent
SCRIPTS = FOLDER.parents[1] / "scripts"
NAMED = {
    name
    for file in FOLDER.rglob("*.py")
    for name in re.findall(r'"(pitot(?:bench|lab)(?:\.\w+)+)[":]', file.read_text("utf-8"))
}


PATCHED = {
    found
    for file in FOLDER.rglob("*.py")
    for found in re.findall(r'patch\("([\w.]+)"', file.read_text("utf-8"))
}


@pytest.mark.parametrize("name", COMMANDS)
def test_every_measurement_tells_its_flags(name, capsys):
    with pytest.raises(SystemExit) as ended:
        main([*name.split(), "--help"])
    assert ended.value.code == 0
    assert f"pitotlab {name}" in capsys.readouterr().out


def test_an_unknown_measurement_is_refused_with_the_names(capsys):
    assert main(["nothing"]) == 2
    assert "blind pooled" in capsys.readouterr().out
    assert main([]) == 0


def test_a_limit_that_is_exceeded_is_printed_and_ends_with_1(monkeypatch, capsys):
    lines = [Line("a fit", 1.8, "", 1.0, "of a log"), Line("a flight", 1.2, "", 1.25)]
    monkeypatch.setitem(ratios.PARTS, "fits", lambda: iter(lines))
    assert main(["speed", "--only", "fits"]) == 1
    first, second, last = capsys.readouterr().out.splitlines()
    assert first.split() == ["a", "fit", "1.80", "(limit", "1.00;", "of", "a", "log)", "exceeded"]
    assert "exceeded" not in second
    assert last == "exceeded: 1: a fit"
    monkeypatch.setitem(ratios.PARTS, "fits", lambda: iter(lines[1:]))
    assert main(["speed", "--only", "fits"]) == 0


def test_the_page_has_a_place_for_every_number_that_a_command_writes(tmp_path, monkeypatch):
    """Each number is between its marks, and only there."""
    page = tmp_path / "page.md"
    page.write_bytes(FIGURES.read_bytes())
    monkeypatch.setattr(ratios, "write_figures", partial(write_figures, page=page))
    for figure in ("fit", "memory"):
        lines = [Line("measured", 7.77, figure=figure)]
        monkeypatch.setitem(ratios.PARTS, "fits", lambda lines=lines: iter(lines))
        assert main(["speed", "--only", "fits", "--page"]) == 0
        assert f"<!-- {figure} -->7.8<!-- / -->" in page.read_text("utf-8")
    parts = ("part share", "parts right", "parts", "parts wrong")
    covered = [f"{s}, {n}" for s in COVERED for n in ("inside", "cells", "below", "flights")]
    write_figures(dict.fromkeys((*parts, *covered), "5"), page)
    rest = r"(<!-- [^/]* -->).*?(<!-- / -->)"
    before, after = (re.sub(rest, r"\1\2", p.read_text("utf-8")) for p in (FIGURES, page))
    assert before == after
    assert not re.search(r"-->(?!5<|7\.8<)[^<]*<!-- / ", page.read_text("utf-8"))
    with pytest.raises(ValueError, match="no place for the number 'speed'"):
        write_figures({"speed": "1"}, page)


@pytest.mark.parametrize("script", ["lab.py", "reproduce_study.py"])
def test_scripts_run_from_a_checkout_that_is_not_installed(script, tmp_path):
    done = subprocess.run(
        [sys.executable, str(SCRIPTS / script), "--help"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
    )
    assert "study" in done.stdout


@pytest.mark.parametrize("name", sorted(NAMED))
def test_what_is_named_in_a_string_exists(name):
    module, _, attribute = name.rpartition(".")
    assert hasattr(import_module(module), attribute) or import_module(name)


@pytest.mark.parametrize("name", sorted(PATCHED))
def test_what_is_patched_is_read_where_it_is_patched(name):
    """A name that is read elsewhere would be patched without any effect."""
    module, _, attribute = name.rpartition(".")
    parsed = ast.parse(Path(import_module(module).__file__).read_text("utf-8"))
    functions = [node for node in parsed.body if isinstance(node, ast.FunctionDef | ast.ClassDef)]
    read = {node.id for each in functions for node in ast.walk(each) if isinstance(node, ast.Name)}
    assert attribute in read


@pytest.mark.long
@pytest.mark.parametrize("number", [0, 9])
def test_a_null_table_flown_anew_is_the_shipped_one(number):
    """Where this fails, `python -m pitotlab nulls` flies the tables anew under another FORMAT."""
    card = [*stock_cards()][number]
    shipped = read_table(card, NULL_FLIGHTS, SETTING)
    flown = read_packed(packed(null_distribution_of(card, setting=SETTING, keep=False)))
    assert are_close(asdict(flown), asdict(shipped))


@pytest.fixture
def few_null_flights(monkeypatch):
    """Half of the null flights, with the floor of the first ones for what follows."""
    first = cache(lambda: null_distribution_of(*asked[0]))
    asked = []

    def null_flights(card, flights, *rest):
        asked.append((card, flights // 2, *rest))
        return first()

    monkeypatch.setattr(workflow, "null_distribution_of", null_flights)


@pytest.mark.long
@pytest.mark.usefixtures("few_null_flights")
def test_a_patched_airplane_is_reconciled_and_its_loop_closes(tmp_path, monkeypatch, capsys):
    """What it hides beside its patch is found and patched; a new flight shows no gap with it."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PITOTBENCH_CACHE", str(tmp_path / "cache"))
    weak = EffectSpec("power_deficit", {"left_fraction": 0.06, "right_fraction": 0.0})
    install_variant("navajo", "pod", [EffectSpec("belly_pod", {"drag_area_m2": 0.15})])
    card = {"maneuver": "circle", "turbulence": "none", "card": {"speeds_kt": [150.0, 110.0]}}
    case = Case(aircraft="navajo+pod", effects=(weak,), **card)
    Path("case.toml").write_text(write_case(case), encoding="utf-8")
    assert bench(["fly", "case.toml", "-o", "log.csv"]) == 0
    asked = ["reconcile", "log.csv", "--aircraft", "navajo+pod", "--close", "found"]
    # The circle tells a set of causes: somebody chooses.
    assert bench([*asked, "--choose", "power_deficit"]) == 0
    told = capsys.readouterr().out
    assert "power deficit (left fraction 0.06" in told
    assert "Judged again with it, the log shows no significant gap." in told
    other = replace(case, truth_seed=7, sensor_seed=7)
    Path("other.toml").write_text(write_case(other), encoding="utf-8")
    assert bench(["fly", "other.toml", "-o", "other.csv"]) == 0
    assert bench(["reconcile", "other.csv", "--aircraft", "navajo+pod+found"]) == 0
    assert "no significant gap" in capsys.readouterr().out.splitlines()
