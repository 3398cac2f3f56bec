"""The table of measurements, and the parts of the product that the laboratory names in strings."""

import ast
import re
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

import pitotlab
from pitotlab.__main__ import COMMANDS, main

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
    assert "blind score" in capsys.readouterr().out
    assert main([]) == 0


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
    """A name that only passes through its module, or is read elsewhere, would be patched without
    any effect.
    """
    module, _, attribute = name.rpartition(".")
    parsed = ast.parse(Path(import_module(module).__file__).read_text("utf-8"))
    functions = [node for node in parsed.body if isinstance(node, ast.FunctionDef | ast.ClassDef)]
    read = {node.id for each in functions for node in ast.walk(each) if isinstance(node, ast.Name)}
    assert attribute in read
