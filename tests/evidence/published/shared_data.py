"""Where the real logs are: read in place, never copied; a test without them is skipped with a reason."""

import os
from pathlib import Path

import pytest

ROOT = Path(os.environ.get("PITOTBENCH_DATA", Path(__file__).parents[4] / "shared" / "data"))


def real_log(*parts: str) -> Path:
    """The path of a real log, or skip."""
    path = ROOT.joinpath(*parts)
    if not path.exists():
        pytest.skip(f"no {path.name}: set PITOTBENCH_DATA to the folder of the real logs")
    return path
