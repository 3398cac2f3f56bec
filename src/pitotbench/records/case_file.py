"""Write a Case as TOML and read it back. A key ends in its unit: `altitude_ft = 6000`,
`wind.speed_kt = 15`.
"""

import json
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import Field, fields, is_dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args, get_type_hints

import tomli_w

from pitotbench.catalog import explain
from pitotbench.records import BadInputError
from pitotbench.records.case import Case, Place, broken_rules
from pitotbench.units import SUFFIXES, Suffix

if TYPE_CHECKING:
    from pydantic import TypeAdapter

# No column of a log is a frequency, so the table of column suffixes lacks it.
CASE_SUFFIXES: dict[str, Suffix] = {**SUFFIXES, "hz": Suffix("frequency", 1.0, "Hz")}


def write_case(case: Case) -> str:
    """Return the TOML text of a case. `read_case` turns it into an equal case, bit for bit.

    Raises TypeError for a value that TOML cannot hold.
    """
    return tomli_w.dumps(case_table(case))


def case_table(case: Case, omit: Sequence[str] = ()) -> dict[str, Any]:
    """Return a case as a plain table whose keys end in units, without the fields named in `omit`."""
    return {key: value for name, key, value in _entries(case) if name not in omit}


def read_case(source: Path | str) -> Case:
    """Read a case from a TOML file, or from TOML text (any string with a line break or an equals
    sign).

    Missing keys keep their defaults. Raises BadInputError that lists every problem with its key.
    """
    name, text = _text(source)
    try:
        table = tomllib.loads(text)
    except RecursionError as error:
        raise BadInputError(f"{name}: not valid TOML: nested too deeply") from error
    except ValueError as error:  # not TOML, or a number of thousands of digits
        raise BadInputError(f"{name}: not valid TOML: {error}") from error
    return case_of_table(table, name)


def case_of_table(table: Mapping[str, Any], name: str = "case") -> Case:
    """Return the case of a table whose keys end in units, as TOML is read. `name` begins the
    message of an error.

    Missing keys keep their defaults. Raises BadInputError that lists every problem with its key.
    """
    reading = _Reading()
    tree = reading.record(Case, table, ())
    problems = [*reading.problems, *broken_rules(tree, reading.written)]
    case = _validated(tree, reading, problems)
    if problems or case is None:
        count = f"{len(problems)} problem{'s' if len(problems) > 1 else ''}"
        raise BadInputError(f"{name}: {count}\n" + "\n".join(f"  {line}" for line in problems))
    return case


def case_columns(case: Case) -> dict[str, Any]:
    """Return every number, text and list of a case by its path with its unit, such as
    `wind.speed_kt`.

    Unlike `case_table`, a quantity is always in the unit of its field: the last digit may be
    rounded. A list of tables, such as the effects, is text.
    """
    return dict(_columns(case, ""))


def _columns(record: Any, path: str) -> Iterator[tuple[str, Any]]:
    for entry in fields(record):
        value, suffix = getattr(record, entry.name), entry.metadata.get("suffix")
        key = path + _canonical_key(entry)
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
    if path.exists() and not path.is_file():
        raise BadInputError(f"{source}: not a regular file; a case is a TOML file")
    try:
        return str(source), path.read_text(encoding="utf-8")
    except OSError as error:
        raise BadInputError(
            f"{source}: cannot be read as a case file: {error.strerror or error}"
        ) from error
    except UnicodeDecodeError as error:
        raise BadInputError(f"{source}: not UTF-8 text; a case is a TOML file") from error


def _validated(tree: dict[str, Any], reading: "_Reading", problems: list[str]) -> Case | None:
    """Return the case of a tree of fields, or None with the type errors appended to `problems`."""
    # Through JSON: pydantic's strict mode then accepts lists for tuples, but not the text '15' for
    # the number 15.
    from pydantic import ValidationError

    try:
        return _adapter().validate_json(json.dumps(tree), strict=True)
    except ValidationError as error:
        for item in error.errors():
            if (
                item["type"] == "dataclass_type"
            ):  # `reading` has said which fields the table would have
                continue
            place = tuple(str(part) for part in item["loc"])
            problems.append(
                f"{reading.written(place)}: {item['msg'].lower().replace('an object', 'a table')}, "
                f"not {item['input']!r}"
            )
    except TypeError:  # a date, which TOML knows and JSON does not
        problems.append("a value is neither number, text, boolean, list nor table: a date or time")
    return None


@cache
def _adapter() -> "TypeAdapter[Case]":
    from pydantic import TypeAdapter  # slow to load, and slow to make

    return TypeAdapter(Case)


class _Reading:
    """Turn keys with units into fields; collect the problems and the spelling of each field."""

    def __init__(self) -> None:
        self.problems: list[str] = []
        self._spelled: dict[Place, str] = {}

    def written(self, place: Place) -> str:
        """Return the path of a field as the file spells it."""
        return ".".join(self._spelled.get(place[: i + 1], part) for i, part in enumerate(place))

    def record(self, kind: type, table: object, place: Place) -> Any:
        """Return the fields of a record from a table. Another value is noted as a problem and
        returned.
        """
        if not isinstance(table, Mapping):
            example = ", ".join(f"{_canonical_key(f)} = …" for f in fields(kind)[:2])
            self.problems.append(
                f"{self.written(place)}: give a table of fields, {{ {example} }}, not {table!r}"
            )
            return table
        found: dict[str, Any] = {}
        hints = get_type_hints(kind)
        for key, value in table.items():
            entry = self._field(kind, key, place)
            if entry is None:
                continue
            name, unit = entry
            here = (*place, name)
            if name in found:
                self.problems.append(
                    f"{self.written(here)} and {key}: one quantity, given twice; keep one"
                )
                continue
            self._spelled[here] = key
            found[name] = _to_si(value, unit) if unit else self._nested(hints[name], value, here)
        return found

    def _nested(self, hint: Any, value: object, place: Place) -> Any:
        if is_dataclass(hint) and isinstance(hint, type):
            return self.record(hint, value, place)
        inner = next((arg for arg in get_args(hint) if is_dataclass(arg)), None)
        if isinstance(inner, type) and isinstance(value, list):
            return [self.record(inner, entry, (*place, str(i))) for i, entry in enumerate(value)]
        return value

    def _field(self, kind: type, key: str, place: Place) -> tuple[str, Suffix | None] | None:
        """Return the field that a key names and its unit; for an unknown key, note a problem and
        return None.
        """
        known = {f.name: f for f in fields(kind)}
        base, _, suffix = key.rpartition("_")
        if key in known and "suffix" not in known[key].metadata:
            return key, None
        if key in known:
            problem = f"the unit is missing: write {_canonical_key(known[key])}"
        elif base not in known or "suffix" not in known[base].metadata:
            problem = explain("key", key, [_canonical_key(f) for f in known.values()])
        else:
            units = _same_dimension(known[base].metadata["suffix"])
            if suffix in units:
                return base, CASE_SUFFIXES[suffix]
            problem = explain(f"unit of {base}", suffix, list(units))
        self.problems.append(f"{'.'.join((*map(str, place), key))}: {problem}")
        return None


def _same_dimension(suffix: str) -> dict[str, Suffix]:
    dimension = CASE_SUFFIXES[suffix].dimension
    return {name: unit for name, unit in CASE_SUFFIXES.items() if unit.dimension == dimension}


def _canonical_key(entry: "Field[Any]") -> str:
    suffix = entry.metadata.get("suffix")
    return f"{entry.name}_{suffix}" if suffix else entry.name


def _to_si(value: Any, unit: Suffix) -> Any:
    if isinstance(value, list):
        return [_to_si(entry, unit) for entry in value]
    number = isinstance(value, int | float) and not isinstance(value, bool)
    return value * unit.factor if number else value


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
    """Return key and value in a unit.

    They are in SI where no number in that unit reads back to exactly the same value.
    """
    # A case must read back bit for bit, also where 100 kt in m/s has no exact decimal in knots.
    values = value if isinstance(value, tuple) else (value,)
    written = [_exact(v, CASE_SUFFIXES[suffix].factor) for v in values]
    if any(w is None for w in written):
        suffix = next(
            s for s, u in _same_dimension(suffix).items() if u.factor == 1.0 and u.offset == 0.0
        )
        written = [float(v) for v in values]
    return f"{name}_{suffix}", written if isinstance(value, tuple) else written[0]


def _exact(value: float, factor: float) -> float | None:
    """Return the shortest number that, times the factor, is exactly the value; None where there is
    none.
    """
    near = value / factor
    return next((w for w in (round(near, 6), round(near, 12), near) if w * factor == value), None)
