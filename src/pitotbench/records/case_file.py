"""Write a Case as TOML and read it back.

A key ends in its unit: `altitude_ft = 6000`, `wind.speed_kt = 15`.
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import tomli_w

from pitotbench.records import BadInputError
from pitotbench.records.case import Case, broken_rules
from pitotbench.records.entries import (
    CASE_SUFFIXES,
    canonical_key,
    record_of_table,
    same_dimension,
)
from pitotbench.records.intake import toml_table, toml_text


def write_case(case: Case) -> str:
    """Return the TOML text of a case. `read_case` turns it into an equal case, bit for bit.

    Raises TypeError for a value that TOML cannot hold.
    """
    return tomli_w.dumps(case_table(case))


def case_table(case: Case, omit: Sequence[str] = ()) -> dict[str, Any]:
    """Return a case as a plain table whose keys end in units, without the fields in `omit`."""
    return {key: value for name, key, value in _entries(case) if name not in omit}


def read_case(source: Path | str) -> Case:
    """Read a case from a TOML file, or from a text: any with a line break or an equals sign.

    Missing keys keep their defaults. Raises BadInputError that lists every problem with its key.
    """
    name, text = _text(source)
    try:
        table = toml_table(text)
    except ValueError as error:  # not TOML, or a number of thousands of digits
        raise BadInputError(f"{name}: not valid TOML: {error}") from error
    return case_of_table(table, name)


def case_of_table(table: Mapping[str, Any], name: str = "case") -> Case:
    """Return the case of a table whose keys end in units, as TOML is read.

    `name` begins the message of an error.

    Missing keys keep their defaults. Raises BadInputError that lists every problem with its key.
    """
    return record_of_table(Case, table, name, broken_rules)


def case_columns(case: Case) -> dict[str, Any]:
    """Return a case's numbers, texts and lists by path with unit, such as `wind.speed_kt`.

    Unlike `case_table`, a quantity is always in the unit of its field: the last digit may be
    rounded. A list of tables, such as the effects, is text.
    """
    return dict(_columns(case, ""))


def _columns(record: Any, path: str) -> Iterator[tuple[str, Any]]:
    for entry in fields(record):
        value, suffix = getattr(record, entry.name), entry.metadata.get("suffix")
        key = path + canonical_key(entry)
        if is_dataclass(value):
            yield from _columns(value, f"{key}.")
        elif suffix:
            factor = CASE_SUFFIXES[suffix].factor
            yield key, [v / factor for v in value] if isinstance(value, tuple) else value / factor
        elif isinstance(value, Mapping):
            yield from ((f"{key}.{name}", inner) for name, inner in value.items())
        else:
            plain = _plain(value)
            tables = isinstance(plain, list) and any(isinstance(each, dict) for each in plain)
            yield key, json.dumps(plain) if tables else plain


def _text(source: Path | str) -> tuple[str, str]:
    # A path has no line break and hardly ever an equals sign; TOML text has one of them, unless it
    # is empty.
    if isinstance(source, str) and ("\n" in source or "=" in source or not source):
        return "case", source
    path = Path(source)
    if path.suffix.lower() not in (".toml", ""):
        raise BadInputError(
            f"{source}: not a case; a case is a TOML file that ends in .toml, a log is read by "
            "calibrate"
        )
    return str(source), toml_text(path, "a case file")


def _entries(record: Any) -> Iterator[tuple[str, str, Any]]:
    """Yield the field name, the key and the value as written, for every field of a record."""
    for entry in fields(record):
        value, suffix = getattr(record, entry.name), entry.metadata.get("suffix")
        if suffix:
            yield entry.name, *_in_unit(entry.name, value, suffix)
        else:
            yield entry.name, entry.name, _plain(value)


def _plain(value: Any) -> Any:
    if is_dataclass(value):
        return {key: inner for _, key, inner in _entries(value)}
    if isinstance(value, tuple | list):
        return [_plain(entry) for entry in value]
    if isinstance(value, Mapping):
        return {key: _plain(entry) for key, entry in value.items()}
    return value


def _in_unit(name: str, value: float | tuple[float, ...], suffix: str) -> tuple[str, Any]:
    """Return key and value in a unit, or in SI where no number in that unit reads back exactly."""
    # A case must read back bit for bit, also where 100 kt in m/s has no exact decimal in knots.
    values = value if isinstance(value, tuple) else (value,)
    written = [_exact(v, CASE_SUFFIXES[suffix].factor) for v in values]
    if any(w is None for w in written):
        suffix = next(
            s for s, u in same_dimension(suffix).items() if u.factor == 1.0 and u.offset == 0.0
        )
        written = [float(v) for v in values]
    return f"{name}_{suffix}", written if isinstance(value, tuple) else written[0]


def _exact(value: float, factor: float) -> float | None:
    """Return the shortest number that times the factor is exactly the value, None without one."""
    near = value / factor
    return next((w for w in (round(near, 6), round(near, 12), near) if w * factor == value), None)
