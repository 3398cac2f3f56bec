"""Records of tables whose keys end in units, as TOML is read: `altitude_ft = 6000`."""

import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import Field, fields, is_dataclass
from functools import cache
from typing import TYPE_CHECKING, Any, TypeVar, cast, get_args, get_type_hints

from pitotbench.catalog import explain
from pitotbench.records import BadInputError
from pitotbench.units import SUFFIXES, Suffix

if TYPE_CHECKING:
    from pydantic import TypeAdapter

# No column of a log is a frequency, so the table of column suffixes lacks it.
CASE_SUFFIXES: dict[str, Suffix] = {**SUFFIXES, "hz": Suffix("frequency", 1.0, "Hz")}

T = TypeVar("T")
Place = tuple[str, ...]
Rules = Callable[[Any, Callable[[Place], str]], Iterable[str]]


def record_of_table(kind: type[T], table: Mapping[str, Any], name: str, rules: Rules) -> T:
    """Return the record of a kind from a table.

    `name` begins the message of an error; `rules` yields those that a tree of fields [SI] breaks,
    each with the key as the table spells it.

    Missing keys keep their defaults. Raises BadInputError that lists every problem with its key.
    """
    reading = _Reading()
    tree = reading.record(kind, table, ())
    problems = [*reading.problems, *rules(tree, reading.written)]
    found = _validated(kind, tree, reading, problems)
    if problems or found is None:
        count = f"{len(problems)} problem{'s' if len(problems) > 1 else ''}"
        raise BadInputError(f"{name}: {count}\n" + "\n".join(f"  {line}" for line in problems))
    return found


def _validated(
    kind: type[T], tree: dict[str, Any], reading: "_Reading", problems: list[str]
) -> T | None:
    """Return the record of a tree of fields, or None with its type errors put to `problems`."""
    # Through JSON: pydantic's strict mode then accepts lists for tuples, but not the text '15' for
    # the number 15.
    from pydantic import ValidationError

    try:
        return cast(T, _adapter(cast(Any, kind)).validate_json(json.dumps(tree), strict=True))
    except ValidationError as error:
        for item in error.errors():
            # `reading` has said which fields the table would have.
            if item["type"] == "dataclass_type":
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
def _adapter(kind: Any) -> "TypeAdapter[Any]":
    from pydantic import TypeAdapter  # slow to load, and slow to make

    return TypeAdapter(kind)


class _Reading:
    """Turn keys with units into fields; collect the problems and the spelling of each field."""

    def __init__(self) -> None:
        self.problems: list[str] = []
        self._spelled: dict[Place, str] = {}

    def written(self, place: Place) -> str:
        """Return the path of a field as the file spells it."""
        return ".".join(self._spelled.get(place[: i + 1], part) for i, part in enumerate(place))

    def record(self, kind: type, table: object, place: Place) -> Any:
        """Return a record's fields from a table; any other value is noted and returned."""
        if not isinstance(table, Mapping):
            example = ", ".join(f"{canonical_key(f)} = …" for f in fields(kind)[:2])
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
        """Return the field that a key names and its unit, or note a problem and return None."""
        known = {f.name: f for f in fields(kind)}
        base, _, suffix = key.rpartition("_")
        if key in known and "suffix" not in known[key].metadata:
            return key, None
        if key in known:
            problem = f"the unit is missing: write {canonical_key(known[key])}"
        elif base not in known or "suffix" not in known[base].metadata:
            problem = explain("key", key, [canonical_key(f) for f in known.values()])
        else:
            units = same_dimension(known[base].metadata["suffix"])
            if suffix in units:
                return base, CASE_SUFFIXES[suffix]
            problem = explain(f"unit of {base}", suffix, list(units))
        self.problems.append(f"{'.'.join((*map(str, place), key))}: {problem}")
        return None


def same_dimension(suffix: str) -> dict[str, Suffix]:
    dimension = CASE_SUFFIXES[suffix].dimension
    return {name: unit for name, unit in CASE_SUFFIXES.items() if unit.dimension == dimension}


def canonical_key(entry: "Field[Any]") -> str:
    suffix = entry.metadata.get("suffix")
    return f"{entry.name}_{suffix}" if suffix else entry.name


def _to_si(value: Any, unit: Suffix) -> Any:
    if isinstance(value, list):
        return [_to_si(entry, unit) for entry in value]
    number = isinstance(value, int | float) and not isinstance(value, bool)
    return value * unit.factor if number else value
