"""Parse the TOML header of a log. All formats have the same header."""

import tomllib
from collections.abc import Mapping
from typing import Any

MAPPING = "mapping"  # header entry: the shipped mapping by which a log was recognized
WARNINGS = "warnings"  # header entry: remarks made when the log was read or written


def parse_header(text: str) -> tuple[dict[str, Any], list[str]]:
    """Return the table of a header and a list of warnings. Text that is not TOML is kept line by line."""
    try:
        return tomllib.loads(text), []
    except (ValueError, RecursionError):  # not TOML, a number of thousands of digits, thousands of brackets
        return {"comments": text.splitlines()}, ["the header's lines are not TOML; they are kept as text"]


def earlier_warnings(header: Mapping[str, Any]) -> list[str]:
    """Return the warnings in a header. Entries that are not text are ignored, and a warning says so."""
    found = header.get(WARNINGS, [])
    entries = found if isinstance(found, list | tuple) else [found]
    texts = [entry for entry in entries if isinstance(entry, str)]
    if len(texts) == len(entries):
        return texts
    return [*texts, "the header's `warnings` holds entries that are not text; they are ignored"]
