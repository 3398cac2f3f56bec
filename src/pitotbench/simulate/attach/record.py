"""The record of an attached aircraft, which lies in the aircraft's folder."""

import tomllib
from dataclasses import asdict
from functools import cache
from pathlib import Path
from typing import Any

import tomli_w

from pitotbench.records.attached import Attached

FILE = "attached.toml"


def write_record(folder: Path, attached: Attached) -> None:
    """Write the record into an aircraft's folder."""
    table = {k: list(v) if isinstance(v, tuple) else v for k, v in asdict(attached).items()}
    (folder / FILE).write_text(tomli_w.dumps(table), encoding="utf-8")


@cache
def read_record(folder: Path) -> Attached | None:
    """Return the record in an aircraft's folder; None where the aircraft has an autopilot of its own."""
    file = folder / FILE
    if not file.is_file():
        return None
    table = tomllib.loads(file.read_text(encoding="utf-8"))
    entries: dict[str, Any] = {k: tuple(v) if isinstance(v, list) else v for k, v in table.items()}
    return Attached(**entries)
