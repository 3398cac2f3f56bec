"""What several commands share: exit codes, flags, how these are read, how an answer is printed."""

import argparse
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

from pitotbench.catalog import explain
from pitotbench.records import BadInputError
from pitotbench.records.calibration_request import (
    FACTS,
    FILES,
    NamedFile,
    Reading,
    asked_fields,
)

if TYPE_CHECKING:
    from pitotbench.logbook.assembly import Part
    from pitotbench.records.calibration import ErrorCurve
    from pitotbench.records.case import Wind
    from pitotbench.records.log import FlightLog, Provenance
    from pitotbench.show.tree import Node

T = TypeVar("T")
R = TypeVar("R", bound=Reading)


DONE = 0
UNFORESEEN = 1  # an unexpected error, or a reader that closed the pipe
BAD_INPUT = 2  # the code of argparse for a wrong flag
NO_ANSWER = 3  # not converged, not observable, or flights lost
INTERRUPTED = 130  # the convention of shells: 128 plus the number of SIGINT


# No dataclasses: that import takes longer than all else that `--help` needs.
class Flag(NamedTuple):
    """A flag or an argument of a command, as `add_argument` takes it."""

    names: tuple[str, ...]
    settings: dict[str, Any]


def flag(*names: str, **settings: Any) -> Flag:
    """A flag by its names and its settings: those of `ArgumentParser.add_argument`."""
    return Flag(names, settings)


# Flags that several commands have, by the word that asks for them.
_SHARED: dict[str, tuple[Flag, ...]] = {
    "wind": (
        flag(
            "--wind-kt",
            type=float,
            default=15.0,
            help="wind speed [kt] (default: %(default)g)",
        ),
        flag(
            "--wind-from-deg",
            type=float,
            default=300.0,
            help="direction the wind is from [°] (default: %(default)g)",
        ),
    ),
    "record": (
        flag(
            "--record",
            type=Path,
            metavar="FILE.html",
            help="also write the record for the file, two pages to print (HTML): inputs with "
            "SHA-256, settings, versions, answer and checks",
        ),
    ),
    "units": (
        flag(
            "--units",
            default="",
            metavar="UNIT,...",
            help="what is read, in your units: kt|km/h|mph|m/s,ft|m,degc|degf,inhg|hpa, such as "
            "km/h,m (default: those of the line `units` in your pitotbench.toml, else "
            "kt,ft,degc,inhg; JSON and CSV keep the units of their keys)",
        ),
    ),
    "table": (
        flag(
            "--table",
            type=Path,
            metavar="FILE",
            help="also write KCAS by KIAS and the altitude correction by height: .csv, .html "
            "(to print) or .xml (a JSBSim system that reads as the airplane's airspeed indicator)",
        ),
    ),
    "json": (
        flag(
            "--json",
            action="store_true",
            help="print one JSON document, a list where there are several answers",
        ),
    ),
    "report": (
        flag(
            "--report",
            type=Path,
            help="also write a page with pictures (HTML)",
        ),
    ),
}


def shared(*names: str) -> list[Flag]:
    """Return flags that several commands have, by the words of their table."""
    return [each for name in names for each in _SHARED[name]]


def asked_flags(*records: type, only: Sequence[str] = ()) -> list[Flag]:
    """Return the flags of the fields of some records, of all or of those named."""
    return [
        flag(each.metadata["flag"], dest=each.name, **each.metadata["settings"])
        for each in asked_fields(*records)
        if not only or each.name in only
    ]


def read_logs(
    paths: Sequence[Path],
    mapping: str | None,
    parameters: Mapping[str, float] | None = None,
    part: "Part" = (None, None),
    airspeed_sensor: int | None = None,
    facts: Mapping[str, Any] | None = None,
) -> "list[FlightLog]":
    """Read logs, or the same part of each, with what is stated of the flight (`FACTS`).

    Raises BadInputError as `read_log` does.
    """
    from pitotbench.logbook.reading import read_log

    return [
        read_log(path, mapping, parameters, part, airspeed_sensor, **(facts or {}))
        for path in paths
    ]


def stated_part(options: argparse.Namespace) -> "Part":
    """Return the part of a log that `--from`, `--to` and `--without` state [s].

    Raises BadInputError for a moment that is none.
    """
    from pitotbench.logbook.assembly import part_of

    return part_of(options.begin, options.end, options.without or ())


def stated_facts(options: argparse.Namespace) -> dict[str, str]:
    """Return what flags state of the flight, by name."""
    return {name: text for name in FACTS if (text := getattr(options, name, None))}


def stated_wind(options: argparse.Namespace) -> "Wind":
    """Return the mean wind of the parsed flags.

    Raises BadInputError for an impossible speed or direction.
    """
    from pitotbench.records.case import Wind
    from pitotbench.units import DEGREE, KNOT

    if not 0.0 <= options.wind_kt <= 100.0:
        raise BadInputError(
            f"--wind-kt {options.wind_kt:g}: the bench flies in 0 to 100 kt of wind"
        )
    if not isfinite(options.wind_from_deg):
        raise BadInputError(
            f"--wind-from-deg {options.wind_from_deg:g}: give the direction in degrees, 0 to 360"
        )
    return Wind(speed=options.wind_kt * KNOT, from_direction=options.wind_from_deg % 360.0 * DEGREE)


def stated_numbers(flag: str, text: str, form: str, count: int | None = None) -> list[float]:
    """Return the numbers with commas between them of a flag.

    Raises BadInputError, with the form in which it takes them, for others and for another count.
    """
    parts = text.split(",")
    with suppress(ValueError):
        if count in (None, len(parts)):
            return [float(part) for part in parts]
    raise BadInputError(f"{flag} takes {form}; got {text!r}")


def require_known(what: str, name: str, known: Iterable[str]) -> None:
    """Raise BadInputError, with the known names and the nearest one, for an unknown name."""
    if name not in (names := list(known)):
        raise BadInputError(explain(what, name, names))


def say(line: str) -> None:
    """Tell on standard error how far a long command is."""
    from pitotbench.show.columns import printable

    print(printable(line), file=sys.stderr, flush=True)


def tell(
    options: argparse.Namespace,
    document: Callable[[], object],
    nodes: "Callable[[], Iterable[Node]]",
    title: str = "",
) -> None:
    """Write an answer on standard output: a JSON document with `--json`, else its tree.

    The tree is in the units of `--units`; where a command has the flag `-v`, the answer alone or
    all numbers. With a `title` the tree is also the page of `--report`, where one is asked for.
    """
    from pitotbench.show.reader_units import reader_units

    units = reader_units(getattr(options, "units", ""))
    if title:
        from pitotbench.show.markup import page_of

        write_page(options.report, lambda: page_of(title, nodes(), units))
    if getattr(options, "json", False):
        from pitotbench.show.columns import answer_text

        sys.stdout.write(answer_text(document()))
        return
    from rich.console import Console

    from pitotbench.show.renderers import print_tree
    from pitotbench.show.tree import ANSWER, NUMBERS, SOURCES

    depth = {None: SOURCES, False: ANSWER, True: NUMBERS}[getattr(options, "verbose", None)]
    print_tree(nodes(), Console(highlight=False, soft_wrap=True), units, depth)


def tell_each(
    options: argparse.Namespace,
    found: "Sequence[tuple[Path, T]]",
    document: "Callable[[T], dict[str, Any]]",
    tree: "Callable[[T], Iterable[Node]]",
) -> None:
    """Write the answers for several files: one JSON document or a list, or each below its name."""
    from pitotbench.show.tree import Heading

    documents = [document(answer) for _, answer in found] if options.json else []
    tell(
        options,
        lambda: documents[0] if len(documents) == 1 else documents,
        lambda: [Heading(path.name, tuple(tree(answer))) for path, answer in found],
    )


def stated_request(options: argparse.Namespace, record: "type[R]") -> "R":
    """Return what the flags of a record ask for, in its texts."""
    stated = {each.name: getattr(options, each.name) for each in asked_fields(record)}
    return record(**{name: _asked(name, each) for name, each in stated.items() if each is not None})


def _asked(name: str, value: object) -> Any:
    if name in FILES:
        return NamedFile(Path(str(value)), str(value))
    return tuple(value) if isinstance(value, list) else str(value)


def stated_choices(options: argparse.Namespace) -> dict[str, Any]:
    """Return the options of a calibration that the flags of a command state, by name."""
    from pitotbench.calibration.options import choices_of

    return choices_of(vars(options))


def require_table(options: argparse.Namespace, inputs: Sequence[Path]) -> None:
    """Raise BadInputError unless the file of `--table` can be written."""
    from pitotbench.records.outputs import require_file
    from pitotbench.show.deliverables import TABLES

    if options.table is not None:
        require_file(options.table, TABLES, inputs)


def require_page(path: Path | None, inputs: Iterable[Path] = ()) -> None:
    """Raise BadInputError unless a page can be written where a flag asks for one."""
    if path is not None:
        from pitotbench.records.outputs import PAGES, require_file

        require_file(path, PAGES, inputs)


def write_page(path: Path | None, page: Callable[[], str]) -> None:
    """Write a page, or another text, where a flag asks for it; only then it is made."""
    if path is not None:
        from pitotbench.logbook.columns import write_text

        write_text(path, page())


def write_table(
    options: argparse.Namespace,
    curves: "Mapping[str, ErrorCurve]",
    doubts: Mapping[str, Sequence[str]],
    made: "Provenance | None" = None,
) -> None:
    """Write the curves by configuration, with their doubts, where `--table` asks for them.

    `made` names the airplane and the day.
    """
    from pitotbench.records.outputs import file_name
    from pitotbench.show.deliverables import table_text

    subject = ", ".join(Path(file_name(path)).stem for path in options.logs)
    path = options.table
    write_page(path, lambda: table_text(path.suffix.lower(), curves, subject, doubts, made))
