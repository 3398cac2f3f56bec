"""Run a command of the bench in this checkout, whether the bench is installed or not."""

import sys
from pathlib import Path


def run_command(name: str, description: str | None) -> int:
    """Run the command of this name and return its exit code."""
    sys.path.insert(0, str(Path(__file__).parents[1] / "src"))
    from pitotbench.cli.app import run_alone

    return run_alone(name, description)
