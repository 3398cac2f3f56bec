"""The house: contracts of the imports, and files that say what they are."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


@pytest.mark.parametrize("room", ["calibrate", "reconcile"])
def test_a_judge_loads_without_the_truth(room):
    """Importing it must not bring in the records of truth, the simulator or the sensors."""
    code = (
        "import sys, types\n"
        "package = types.ModuleType('pitotbench'); package.__path__ = [sys.argv[1]]\n"
        "sys.modules['pitotbench'] = package\n"  # without the public page, which names everything
        f"import pitotbench.{room}\n"
        "bad = [m for m in sys.modules if m.startswith(('pitotbench.simulate', 'pitotbench.sense',"
        " 'pitotbench.records.flight', 'pitotbench.records.case', 'jsbsim', 'matplotlib'))]\n"
        "sys.exit(','.join(bad) or 0)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, str(ROOT / "src" / "pitotbench")], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr


def test_scripts_are_short():
    for script in (ROOT / "scripts").glob("*.py"):
        assert len(script.read_text(encoding="utf-8").splitlines()) <= 40, script.name


@pytest.mark.parametrize("name", ["utils", "helpers", "common", "misc"])
def test_no_file_says_nothing(name):
    assert not list((ROOT / "src").rglob(f"{name}.py"))
