"""Run a command of the bench or a measurement of the laboratory in this checkout, installed or not."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "src"))


def run_command(name: str, description: str | None) -> int:
    """Run the command of this name and return its exit code."""
    from pitotbench.cli.app import run_alone

    return run_alone(name, description)


def run_measurement(*first: str) -> int:
    """Run the measurement that these words and those of the command line name; return its exit
    code.
    """
    from pitotlab.__main__ import main

    return main([*first, *sys.argv[1:]])
