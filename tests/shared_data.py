"""Where the real logs are: read in place, never copied; a test without them is skipped with a
reason.
"""

import os
from pathlib import Path

import pytest


def _found() -> Path:
    """The folder in PITOTBENCH_DATA, else the nearest `shared/data` beside a folder that holds this
    file.
    """
    given = os.environ.get("PITOTBENCH_DATA")
    beside = (parent / "shared" / "data" for parent in Path(__file__).resolve().parents)
    return (
        Path(given)
        if given
        else next((place for place in beside if place.is_dir()), Path("shared", "data"))
    )


ROOT = _found()


def real_log(*parts: str) -> Path:
    """The path of a real log, or skip."""
    path = ROOT.joinpath(*parts)
    if not path.exists():
        pytest.skip(f"no {path.name}: set PITOTBENCH_DATA to the folder of the real logs")
    return path


def shared_case(*parts: str) -> Path:
    """The path of a small input of another recorder, beside the real logs, or skip."""
    return real_log("..", "cases", *parts)
