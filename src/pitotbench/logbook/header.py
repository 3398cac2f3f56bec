"""The TOML header of a log, in whatever format it came."""

import tomllib
from collections.abc import Mapping
from typing import Any

WARNINGS = "warnings"  # header entry: what was noticed when the log was read or made


def parse_header(text: str) -> tuple[dict[str, Any], list[str]]:
    """The table of a header, and a warning where the text is not TOML: it is then kept line by line."""
    try:
        return tomllib.loads(text), []
    except (ValueError, RecursionError):  # not TOML, a number of thousands of digits, thousands of brackets
        return {"comments": text.splitlines()}, ["the header's lines are not TOML; they are kept as text"]


def earlier_warnings(header: Mapping[str, Any]) -> list[str]:
    """The warnings that a header carries. Entries that are not text are left out, with a warning that says so."""
    found = header.get(WARNINGS, [])
    entries = found if isinstance(found, list | tuple) else [found]
    texts = [entry for entry in entries if isinstance(entry, str)]
    if len(texts) == len(entries):
        return texts
    return [*texts, "the header's `warnings` holds entries that are not text; they are left out"]
