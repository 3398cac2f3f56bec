"""Write tables as TOML text, which the standard library can only read. The text reads back to an equal table."""

import json
import re
from collections.abc import Mapping
from datetime import date, datetime, time
from typing import Any

import numpy as np

_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")


def write_toml(table: Mapping[str, Any]) -> str:
    """Return the TOML text of a table of strings, numbers, booleans, dates, lists and tables.

    Floats have the fewest digits that read back to the same value. Raises TypeError for a value of another type.
    """
    return "\n".join(_lines(table, ())).strip("\n") + "\n"


def _lines(table: Mapping[str, Any], path: tuple[str, ...]) -> list[str]:
    """Return the lines of a table: plain entries first, then sub-tables."""
    # In TOML an entry after the heading of a sub-table belongs to the sub-table.
    lines = [f"{_key(k)} = {_value(v)}" for k, v in table.items() if not _is_table(v) and not _is_tables(v)]
    for name, value in table.items():
        inner = (*path, name)
        heading = ".".join(_key(part) for part in inner)
        if _is_table(value):
            lines += ["", f"[{heading}]", *_lines(value, inner)]
        elif _is_tables(value):
            for entry in value:
                lines += ["", f"[[{heading}]]", *_lines(entry, inner)]
    return lines


def _is_table(value: object) -> bool:
    return isinstance(value, Mapping)


def _is_tables(value: object) -> bool:
    return isinstance(value, list | tuple) and len(value) > 0 and all(_is_table(entry) for entry in value)


def _key(name: str) -> str:
    return name if _BARE_KEY.fullmatch(name) else _string(name)


def _string(text: str) -> str:
    # JSON and TOML have the same escapes, but JSON does not escape the delete character.
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _value(value: Any) -> str:
    if isinstance(value, bool | np.bool_):
        return "true" if value else "false"
    if isinstance(value, str):
        return _string(value)
    if isinstance(value, int | np.integer):
        return str(int(value))
    if isinstance(value, float | np.floating):
        return repr(float(value))
    if isinstance(value, datetime | date | time):
        return value.isoformat()
    if isinstance(value, list | tuple | np.ndarray):
        return "[" + ", ".join(_value(entry) for entry in value) + "]"
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{_key(k)} = {_value(v)}" for k, v in value.items()) + "}"
    raise TypeError(f"TOML holds no {type(value).__name__}: {value!r}")
