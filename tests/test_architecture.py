"""The shape of the project: what may import what, how fast it loads, and its public names and
commands.
"""

import argparse
import ast
import json
import pkgutil
import subprocess
import sys
import tomllib
from graphlib import TopologicalSorter
from importlib import import_module
from pathlib import Path

import grimp
import pytest

import pitotbench
from pitotbench.cli.app import COMMANDS, command_line

SOURCE = Path(pitotbench.__file__).parent
SLOW = {
    "numpy",
    "scipy",
    "pandas",
    "pyarrow",
    "matplotlib",
    "jsbsim",
    "rich",
    "pydantic",
    "jinja2",
} | {
    "bokeh",
    "tornado",
}


def loaded_after(code):
    """The modules that a fresh Python has loaded after some code, which may end in SystemExit."""
    ending = "import json, sys; print(json.dumps(sorted(sys.modules)), file=sys.stderr)"
    wrapped = f"try:\n    {code}\nexcept SystemExit:\n    pass\n{ending}"
    done = subprocess.run(
        [sys.executable, "-c", wrapped], capture_output=True, text=True, check=True
    )
    return set(json.loads(done.stderr.splitlines()[-1]))


@pytest.mark.parametrize(
    ("owner", "package"), [("simulation", "jsbsim"), ("show", "matplotlib"), ("browser", "bokeh")]
)
def test_a_package_with_one_owner_is_kept_from_all_other_modules(owner, package):
    """A module that the contract does not list might import the package unseen."""
    settings = tomllib.loads((SOURCE.parents[1] / "pyproject.toml").read_text(encoding="utf-8"))
    (contract,) = (
        each
        for each in settings["tool"]["importlinter"]["contracts"]
        if each["name"].startswith(f"Only {owner} imports")
    )
    assert package in contract["forbidden_modules"]
    own = {f"pitotbench.{module.name}" for module in pkgutil.iter_modules(pitotbench.__path__)}
    assert own - {*contract["source_modules"]} == {f"pitotbench.{owner}", "pitotbench.__main__"}


@pytest.mark.parametrize("package", ["calibration", "reconciliation"])
def test_calibrator_and_reconciler_load_without_the_truth(package):
    """Importing all of one must bring in neither the records of truth, nor the simulator, nor the
    sensors.
    """
    path = f"pitotbench.{package}"
    loaded = loaded_after(
        f"import pkgutil, importlib; package = importlib.import_module({path!r}); "
        "[importlib.import_module(m.name) for m in pkgutil.walk_packages(package.__path__, "
        f"{path + '.'!r})]"
    )
    hidden = ("simulation", "sensing", "records.flight", "records.case")
    truth = tuple(f"pitotbench.{name}" for name in hidden)
    assert len([name for name in loaded if name.startswith(f"{path}.")]) > 10
    assert [name for name in loaded if name.startswith((*truth, "jsbsim", "matplotlib"))] == []


def command(*arguments):
    """Code that runs the command line with these arguments."""
    return f"from pitotbench.cli import main; main({list(arguments)})"


# The help of `campaign` lists the maneuvers, whose table needs NumPy.
QUICK = [[], *([each.name] for each in COMMANDS if each.name != "campaign")]


@pytest.mark.parametrize(
    "code",
    ["import pitotbench", command("--version"), *(command(*quick, "--help") for quick in QUICK)],
)
def test_import_help_and_version_load_no_slow_package(code):
    """Nor does a command load the module of another."""
    loaded = loaded_after(code)
    assert "pitotbench" in loaded
    assert SLOW & loaded == set()
    own = {"pitotbench.cli.app"} | {each.module for each in COMMANDS if f"'{each.name}'" in code}
    assert [each.name for each in COMMANDS if each.module in loaded - own] == []


def test_only_the_page_loads_bokeh():
    loaded = loaded_after(command("calibrate", "no-such-file.csv"))
    assert "pitotbench.cli.calibrate" in loaded
    assert {"bokeh", "tornado", "pitotbench.browser"} & loaded == set()


def test_the_help_of_a_campaign_loads_no_slow_package_but_numpy():
    assert SLOW & loaded_after(command("campaign", "--help")) == {"numpy"}
    text = command_line().format_help()
    assert all(row.name in text and row.summary in text for row in COMMANDS)


def test_who_flies_a_card_again_loads_nothing_of_the_reconciler():
    from pitotbench.campaigns.flights import flown

    loaded = loaded_after(f"import {flown.__module__}")
    assert flown.__module__ in loaded
    assert [name for name in loaded if name.startswith("pitotbench.reconciliation")] == []


def test_the_driver_of_a_campaign_holds_no_tables_while_it_flies():
    """Pandas and Arrow are half of its memory, and its tables are made at the end."""
    loaded = loaded_after("import pitotbench.campaigns.campaign")
    assert {"pandas", "pyarrow"} & loaded == set()


@pytest.mark.parametrize("package", ["pitotbench", "pitotlab"])
def test_no_files_import_one_another_in_a_circle(package):
    """Imports inside functions and for type checkers count: who reads a file reads them as well."""
    graph = grimp.build_graph(package)
    arrows = {each: graph.find_modules_directly_imported_by(each) for each in graph.modules}
    TopologicalSorter(arrows).prepare()  # raises CycleError, which names the files


@pytest.mark.parametrize("name", pitotbench.__all__)
def test_every_public_name_resolves_and_says_what_it_is(name):
    value = getattr(pitotbench, name)
    if name != "__version__":
        assert value.__name__ == name
        # A data class without a docstring gets its signature as one.
        assert value.__doc__
        assert not value.__doc__.startswith(f"{name}(")


def test_type_checkers_and_python_take_a_public_name_from_the_same_module():
    tree = ast.parse((SOURCE / "__init__.py").read_text(encoding="utf-8"))
    block = next(node for node in tree.body if isinstance(node, ast.If))
    stated = {node.names[0].name: node.module for node in block.body}
    assert stated == {name: f"pitotbench.{module}" for name, module in pitotbench._MODULES.items()}
    # Where Python imports a package of the name of a function, it would put it in the function's
    # place.
    assert not {path.stem for path in SOURCE.iterdir()} & {*pitotbench.__all__}
    assert dir(pitotbench) == sorted(pitotbench.__all__)
    with pytest.raises(AttributeError, match="pitotbench"):
        _ = pitotbench.no_such_name


@pytest.mark.parametrize("row", COMMANDS, ids=lambda row: row.name)
def test_every_command_has_a_summary_flags_with_help_and_a_run_function(row):
    module = import_module(row.module)
    parser = argparse.ArgumentParser()
    for each in module.FLAGS:
        parser.add_argument(*each.names, **each.settings)
    assert row.summary
    assert [action.dest for action in parser._actions if not action.help] == []
    assert len(parser._actions) > 1
    assert callable(module.run)


def test_who_reads_stored_results_waits_for_no_estimator():
    loaded = loaded_after("import pitotbench.campaigns.result_table")
    assert "pitotbench.calibration.options" in loaded
    assert {"scipy", "pitotbench.calibration.reduction"} & loaded == set()
