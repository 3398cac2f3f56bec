"""Read mapping files, which give the columns of a foreign log our names.

Such a log may be in several files.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cache, partial
from importlib import resources
from pathlib import Path
from types import GenericAlias
from typing import Any

from pitotbench.catalog import Catalog
from pitotbench.logbook.columns import plain_name
from pitotbench.records import BadInputError
from pitotbench.records.intake import toml_table, toml_text


@dataclass(frozen=True, slots=True)
class Renamed:
    """One column of a foreign log, perhaps absent, and its name here: theirs * factor + offset."""

    theirs: str
    name: str
    factor: float = 1.0
    offset: float = 0.0
    optional: bool = False


@dataclass(frozen=True, slots=True)
class MappedFile:
    """One file of a log: its name patterns, its join onto the time base (see `JOINS`), its columns.

    The first pattern for which there is a file counts. An `optional` file may be absent. `another`
    airspeed sensor stands in the place of the first file where it is asked for.
    """

    patterns: tuple[str, ...]
    join: str
    columns: tuple[Renamed, ...]
    optional: bool = False
    another: bool = False

    @property
    def pattern(self) -> str:
        """The first pattern, by which messages name the file."""
        return self.patterns[0]


@dataclass(frozen=True, slots=True)
class Mapping:
    """A mapping: its files, and calibration choices that suit such logs.

    The first file gives the time base.

    `refuse` says why such a log cannot be calibrated, empty where it can. `kind` is that of the
    aircraft that carry such a recorder, such as `drone`; empty where any may. `shipped`: it is of a
    recorder's own format, which prescribes the units.
    """

    title: str
    files: tuple[MappedFile, ...]
    calibrate: dict[str, str | float | bool | dict[str, float]]
    refuse: str = ""
    kind: str = ""
    shipped: bool = False


JOINS = ("last", "nearest", "linear")


def shipped() -> Catalog[str]:
    """Return the mappings that come with the bench, as TOML texts by name."""
    folder = resources.files("pitotbench.logbook") / "mappings"
    files = sorted((f for f in folder.iterdir() if f.name.endswith(".toml")), key=lambda f: f.name)
    return Catalog(
        "mapping", {f.name.removesuffix(".toml"): f.read_text(encoding="utf-8") for f in files}
    )


def find_mapping(name: str | Path) -> Mapping:
    """Return the mapping of a shipped name or of a TOML file.

    Raises UnknownNameError for a name that is not shipped, BadInputError for a file that is missing
    or wrong.
    """
    path = Path(name)
    if path.suffix != ".toml":
        return replace(parse_mapping(str(name), shipped()[str(name)]), shipped=True)
    return parse_mapping(str(path), toml_text(path, "a mapping"))


def parse_mapping(name: str, text: str) -> Mapping:
    """Return a mapping from TOML text. Raises BadInputError that lists all problems."""
    from pydantic import ValidationError

    try:
        document = _document().model_validate(toml_table(text))
    except ValidationError as error:
        lines = [f"{'.'.join(map(str, e['loc']))}: {e['msg'].lower()}" for e in error.errors()]
        raise BadInputError(f"mapping {name}: " + "; ".join(lines)) from error
    except ValueError as error:  # not TOML, or a number of thousands of digits
        raise BadInputError(f"mapping {name}: not valid TOML: {error}") from error
    if bool(document.columns) == bool(document.files) and not document.refuse:
        raise BadInputError(f"mapping {name}: give either [columns] or [[files]]")
    for file in document.files:
        if file.join not in JOINS:
            raise BadInputError(
                f"mapping {name}: unknown join {file.join!r}. Known: {', '.join(JOINS)}"
            )
    mapped = tuple(
        MappedFile(
            (f.file,) if isinstance(f.file, str) else tuple(f.file),
            f.join,
            _renamed(f.columns),
            f.optional or f.another,
            f.another,
        )
        for f in document.files
    ) or (MappedFile(("*",), JOINS[0], _renamed(document.columns)),)
    return Mapping(document.title, mapped, document.calibrate, document.refuse, document.kind)


def recognized(names: Iterable[str]) -> str | None:
    """Return the shipped mapping whose columns a table has, by its name; None where there is none.

    An entry of its list `recognize` is a column, or a list of columns of which one must be there.
    """
    here = {plain_name(name) for name in names}
    for name, text in shipped().items():
        wanted = [
            {plain_name(each) for each in ([entry] if isinstance(entry, str) else entry)}
            for entry in toml_table(text).get("recognize", [])
        ]
        if wanted and all(here & entry for entry in wanted):
            return name
    return None


@cache
def _document() -> Any:
    """Return the model of a mapping file: its tables and keys.

    Made when asked for: pydantic is slow to load.
    """
    from pydantic import ConfigDict, create_model

    make: Any = partial(create_model, __config__=ConfigDict(extra="forbid"))
    target = make(
        "Target", name=(str, ...), factor=(float, 1.0), offset=(float, 0.0), optional=(bool, False)
    )
    columns = GenericAlias(dict, (str, str | target))  # of types that are made here
    file = make(
        "File",
        file=(str | list[str], "*"),
        join=(str, "last"),
        optional=(bool, False),
        another=(bool, False),
        columns=(columns, ...),
    )
    return make(
        "Document",
        title=(str, ""),
        recognize=(list[str | list[str]], []),
        refuse=(str, ""),
        kind=(str, ""),
        columns=(columns, {}),
        files=(GenericAlias(list, file), []),
        calibrate=(dict[str, str | float | bool | dict[str, float]], {}),
    )


def _renamed(columns: dict[str, Any]) -> tuple[Renamed, ...]:
    return tuple(
        Renamed(theirs, ours)
        if isinstance(ours, str)
        else Renamed(theirs, ours.name, ours.factor, ours.offset, ours.optional)
        for theirs, ours in columns.items()
    )
