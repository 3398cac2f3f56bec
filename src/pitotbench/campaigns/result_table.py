"""The results of campaigns as a table, the files made of them, and one stored result flown again.

`results.parquet` holds the rows of one plan, in its order, with the logs and cases of the folder
next to it. The index of a store holds the rows of all its results, with all fields of their cases:
DuckDB, Polars and pandas open it. Parts that it lacks are added; it is made again where it is
missing or cut, or holds a part that is gone; a part that is replaced removes it.
"""

import ast
import json
import os
import re
import shutil
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pitotbench.calibration.options import options_from
from pitotbench.campaigns.digests import file_sha256
from pitotbench.campaigns.progress import say
from pitotbench.campaigns.store import (
    INDEX,
    PARTS,
    STATES,
    Document,
    ResultStore,
    all_columns,
    row_columns,
    rows_of,
    sections_of,
    stored,
)
from pitotbench.campaigns.task import Row, Task, perform_task
from pitotbench.catalog import explain
from pitotbench.logbook.columns import atomic, write_text
from pitotbench.records import BadInputError, NoAnswerError
from pitotbench.records.case import Case, DataSystem
from pitotbench.records.case_file import case_columns, case_of_table, write_case
from pitotbench.records.entries import CASE_SUFFIXES
from pitotbench.records.intake import toml_table
from pitotbench.show.columns import inert
from pitotbench.show.markup import Section
from pitotbench.show.reader_units import BENCH, Units

if TYPE_CHECKING:
    from pandas import DataFrame
    from pyarrow import Table

RESULTS, STORE = "results.parquet", "store"
SEAL = "index.sha256"  # next to the index: the digest of its file
_OF_ALL = ("flight", "name", "state", "reason")  # the columns of an index, whatever is stored
_GROUP = 10_000  # flights whose rows are in memory at a time
_MOST_ANSWERS = 100  # short answers that a page shows; the table of results holds all
_MOST_FAILURES = 1_000  # sentences that are printed and shown; the store holds all


def require_own_folder(target: Path) -> None:
    """Raise BadInputError for a folder that holds something else than a campaign."""
    own = (target / RESULTS, target / STORE)
    if target.exists() and (
        not target.is_dir() or (any(target.iterdir()) and not any(path.exists() for path in own))
    ):
        raise BadInputError(
            f"{target} exists and holds no campaign's results; choose another --out"
        )


@dataclass(slots=True)
class Gathered:
    """A folder's results: number of rows, failures in words, and the parts of the page."""

    rows: int = 0
    failed: int = 0
    failures: list[str] = field(default_factory=list)
    sections: list[Section] = field(default_factory=list)


def gather(
    folder: Path, store: ResultStore, tasks: Iterable[Task], varied: tuple[str, ...]
) -> Gathered:
    """Write the tasks' rows, in plan order, to the folder's table; return what the page needs.

    An earlier table is replaced only where there is a row. The table of one plan is the same bit
    for bit, however often it was interrupted and however many processes flew it.
    """
    from pyarrow.parquet import ParquetWriter

    found = Gathered()
    groups = _groups(store, tasks, varied, found)
    first = next(groups, None)
    if first is None:
        return found
    with atomic(folder / RESULTS) as scratch:
        table = _table(first)
        with ParquetWriter(scratch, table.schema) as writer:
            writer.write_table(table)
            for rows in groups:
                writer.write_table(_table(rows).cast(table.schema))
    return found


def _table(rows: list[dict[str, Any]]) -> "Table":
    # Large, as pandas is everywhere here: a driver that flies does without.
    from pandas import DataFrame
    from pyarrow import Table

    return Table.from_pandas(DataFrame(rows), preserve_index=False)


def _groups(
    store: ResultStore, tasks: Iterable[Task], varied: tuple[str, ...], found: Gathered
) -> Iterator[list[dict[str, Any]]]:
    rows: list[dict[str, Any]] = []
    flights = 0
    for task in tasks:
        document = store.find(task.key)
        if document is None:
            continue
        found.failed += len(document["failures"])
        found.failures += document["failures"][: max(_MOST_FAILURES - len(found.failures), 0)]
        if len(found.sections) < _MOST_ANSWERS:
            found.sections += [
                each if task.draw else replace(each, html="") for each in sections_of(document)
            ]
        before = len(rows)
        rows += _planned_rows(document, varied)
        found.rows += len(rows) - before
        flights += 1
        if flights % _GROUP == 0 and rows:
            yield rows
            rows = []
    if rows:
        yield rows


def _planned_rows(document: Document, varied: tuple[str, ...]) -> Iterator[dict[str, Any]]:
    """Give the rows of a flight: the contract's columns, the fields that vary, the flight's key."""
    columns = all_columns(document) if varied else {}
    extra = {name: value for field in varied for name, value in _entries(columns, field)}
    labeled = any(label for label, _ in document["calibrations"])
    for row in rows_of(document):
        label = {"calibration": row.calibration} if labeled else {}
        yield {**row_columns(row), **label, **extra, "flight": document["key"]}


def _entries(columns: Mapping[str, Any], path: str) -> Iterator[tuple[str, Any]]:
    """Give the names and values that a field of a plan sets, by its path.

    It is a value in the plan's own unit, every column of a table, or an entry of a list of tables
    such as `effects.0.parameters.latency_s`. A flight that lacks the field has None.
    """
    below = [name for name in columns if name.startswith(f"{path}.")]
    first, _, deeper = path.partition(".")
    if path in columns or below:
        yield from ((name, columns[name]) for name in below or [path])
    elif isinstance(columns.get(first), str):
        value = json.loads(columns[first])
        for part in deeper.split("."):
            entries = dict(enumerate(value)) if isinstance(value, list) else value or {}
            value = entries.get(int(part) if part.isdigit() else part)
        yield path, value
    else:
        noun, _, suffix = path.rpartition("_")
        for name, value in columns.items():
            if noun and name.rpartition("_")[0] == noun:
                factor = CASE_SUFFIXES[name.rpartition("_")[2]].factor
                value = (np.asarray(value) * factor / CASE_SUFFIXES[suffix].factor).tolist()
                yield path, value
                return
        yield path, None


def publish_files(folder: Path, store: ResultStore, tasks: Iterable[Task]) -> None:
    """Make the folders of logs and of cases from the store, in place of an earlier campaign's."""
    fresh = {name: folder / f".{name}-new" for name in ("logs", "cases")}
    for place in fresh.values():
        shutil.rmtree(place, ignore_errors=True)
        place.mkdir()
    for task in tasks:
        document = store.find(task.key)
        if document is None:
            continue
        for name in document["logs"]:
            _link(store.log(task.key, name), fresh["logs"] / f"{task.name}-{name}")
        if task.keep_logs == "all":
            write_text(fresh["cases"] / f"{task.name}.toml", write_case(task.case))
    for name, place in fresh.items():
        shutil.rmtree(folder / name, ignore_errors=True)
        if any(place.iterdir()):
            place.rename(folder / name)
        else:
            place.rmdir()


def _link(source: Path, target: Path) -> None:
    """Give a kept log its name in the folder, without a second copy where the disk can do that."""
    with suppress(FileExistsError):
        try:
            os.link(source, target)
        except FileExistsError:
            raise
        except OSError:
            shutil.copyfile(source, target)


def result_table(folders: Sequence[Path]) -> "DataFrame":
    """Return the rows of all results of campaigns, failures included, each flight once.

    The columns are those of results.parquet, all fields of the cases, the state and what made the
    result. Raises BadInputError for a folder without a store.
    """
    import pandas as pd

    for folder in folders:
        if not (folder / STORE / PARTS).is_dir():
            raise BadInputError(f"{folder}: holds no stored results of a campaign")
    tables = [pd.read_parquet(_indexed(ResultStore(folder / STORE))) for folder in folders]
    if len(tables) == 1:
        return tables[0]
    seen: set[str] = set()
    for number, table in enumerate(tables):
        tables[number] = table[~table.flight.isin(seen)]
        seen |= set(table.flight)
    return pd.concat(tables, ignore_index=True)


def _indexed(store: ResultStore) -> Path:
    """Return the index of a store, brought up to date: the parts that it lacks are read.

    Raises BadInputError where it cannot be written.
    """
    import pyarrow as pa
    from pyarrow.parquet import read_table
    from pyarrow.parquet import write_table as write_parquet_table

    path, seal = store.folder / INDEX, store.folder / SEAL
    keys = [*store.keys()]
    held = _flights_held(path, seal, keys)
    lacking = [key for key in keys if key not in held]
    if lacking or not held:
        groups = [read_table(path)] if held else []
        groups += [
            _table([*_indexed_rows(store, lacking[at : at + _GROUP])])
            for at in range(0, len(lacking), _GROUP)
        ]
        # A field that only some flights have is empty for the others.
        empty = pa.table({name: pa.array([], pa.string()) for name in _OF_ALL})
        table = pa.concat_tables(groups or [empty], promote_options="permissive").sort_by("flight")
        with atomic(path) as scratch:
            write_parquet_table(table, scratch, row_group_size=_GROUP)
        write_text(seal, file_sha256(path))
    return path


def _flights_held(path: Path, seal: Path, keys: list[str]) -> set[str]:
    """Return the flights of an index that is whole and holds no part that is gone, else none.

    An index without flights is made again.
    """
    from pandas import read_parquet

    if not path.is_file():
        return set()
    if not seal.is_file() or seal.read_bytes() != file_sha256(path).encode():
        say(f"{path}: cut, changed or old; it is made again from the {len(keys):,} parts")
        return set()
    held = set(read_parquet(path, columns=["flight"]).flight)
    return held if held <= set(keys) else set()


def _indexed_rows(store: ResultStore, keys: list[str]) -> Iterator[dict[str, Any]]:
    for key in keys:
        document = store.find(key)
        if document is None:
            yield {"flight": key, "name": key, "state": "damaged", "reason": "damaged part"}
            continue
        common = _common(document)
        rows = [row_columns(row) | {"calibration": row.calibration} for row in rows_of(document)]
        yield from (common | row for row in rows or [{}])


def _common(document: Document) -> dict[str, Any]:
    made = document["made"]
    columns = {
        name: json.dumps(value) if isinstance(value, list) else value
        for name, value in all_columns(document).items()
    }
    return columns | {
        "flight": document["key"],
        "name": document["name"],
        "state": document["state"],
        "reason": "; ".join(document["failures"]),
        "code": made["code"],
        "aircraft_files": made["aircraft"],
        **{f"{name}_version": number for name, number in made["versions"].items()},
        "host": made["host"],
        "cpu_s": made["cpu_s"],
        "wall_s": made["wall_s"],
    }


# What an expression for rows may hold: names, constants, comparisons and arithmetic. Any call could
# run code.
_ALLOWED = (
    ast.Expression, ast.BoolOp, ast.And, ast.Or, ast.UnaryOp, ast.Not, ast.Invert, ast.USub, ast.UAdd, ast.BinOp,
    ast.BitAnd, ast.BitOr, ast.Add, ast.Sub, ast.Mult, ast.Div, ast.Compare, ast.cmpop, ast.Name, ast.Load,
    ast.Constant, ast.List, ast.Tuple,
)  # fmt: skip
# of a column that is no name in Python, such as `das.gps_rate_hz`
_QUOTED_NAME = re.compile(r"`[\w. +-]*`")


def _require_comparison(where: str) -> None:
    """Raise ValueError for an expression that could run code: all but comparisons of columns."""
    for node in ast.walk(ast.parse(_QUOTED_NAME.sub("column", where.strip()), mode="eval")):
        if not isinstance(node, _ALLOWED):
            raise ValueError(
                "compare columns with numbers and texts only, with and, or, not, in, + - * /"
            )


def chosen_rows(table: "DataFrame", where: str | None, state: str | None) -> "DataFrame":
    """Return the rows of a state for which an expression of pandas holds.

    Raises BadInputError for a wrong one.
    """
    if state is not None:
        if state not in STATES:
            raise BadInputError(explain("state", state, list(STATES)))
        table = table[table.state == state]
    if where is None:
        return table
    try:
        _require_comparison(where)
        return table.query(where)
    except Exception as error:  # pandas raises many kinds
        raise BadInputError(f"--where {where!r}: {error}") from error


def varied_columns(table: "DataFrame") -> list[str]:
    """Return the columns of an index that tell its flights apart.

    Beside the maneuver, the rates and the seeds these are the label of a calibration, and the
    fields of a case with several values.
    """
    skipped = {"maneuver", "truth_seed", "sensor_seed", "das.air_rate_hz", "das.gps_rate_hz"}
    fields = {"calibration", *case_columns(Case())} - skipped
    return [
        name
        for name in table.columns
        if (name in fields or ("." in name and name not in skipped))
        and len(table[name].dropna().unique()) > 1
    ]


def means(table: "DataFrame", by: Sequence[str]) -> "DataFrame":
    """Return the means of the numbers over all rows alike in the columns `by`, and their count."""
    require_columns(table, by)
    averaged = (
        "minutes",
        "residual_two_sigma_kt",
        "two_sigma_kt",
        "curve_rms_error_kt",
        "curve_coverage",
        "cpu_s",
    )
    numbers = [name for name in averaged if name in table.columns]  # failures alone have few
    groups = table.groupby(list(by), sort=False)
    return groups[numbers].mean().assign(rows=groups.size()).reset_index()


def require_columns(table: "DataFrame", names: Sequence[str]) -> None:
    """Raise BadInputError for a name that is no column."""
    for name in names:
        if name not in table.columns:
            raise BadInputError(explain("column", name, list(table.columns)))


def write_table(table: "DataFrame", path: Path) -> None:
    """Write a table as .parquet or .csv, whole or not at all.

    Raises BadInputError for another ending.

    In a CSV, a text that a spreadsheet would take for a formula begins with an apostrophe.
    """
    if path.suffix not in (".parquet", ".csv"):
        raise BadInputError(f"{path}: the name must end in .parquet or .csv")
    with atomic(path) as scratch:
        if path.suffix == ".parquet":
            table.to_parquet(scratch, index=False)
        else:
            texts = table.select_dtypes(exclude=["number", "bool"])
            safe = table.assign(**{str(name): texts[name].map(inert) for name in texts})
            safe.rename(columns=inert).to_csv(scratch, index=False)


def _document(result: Path) -> Document:
    if result.suffix == ".json":
        found = (
            ResultStore(result.parents[2]).find(result.stem) if len(result.parents) > 2 else None
        )
    else:
        store = ResultStore(result.parent / STORE)
        found = store.find(result.name)
        named = (document for key in [*store.keys()] if (document := store.find(key)) is not None)
        found = found or next((each for each in named if each["name"] == result.name), None)
    if found is None:
        raise BadInputError(
            f"{result}: no stored flight; give the folder of a campaign and a flight's name or key"
        )
    return found


def write_page(result: Path, target: Path | None) -> tuple[Path, tuple[str, ...]]:
    """Fly a stored result again in this process, compare every number, and write its page.

    The page goes by default into the folder of its campaign. `result` is the folder of a campaign
    with the name or the key of a flight, such as `out/circle-20_1/circle-seed1`, or the file of a
    part. Returns the file of the page, and a line for each number that differs from the stored one.
    Raises BadInputError where there is no such result, and NoAnswerError for a flight that has
    none.
    """
    from pandas import DataFrame

    document = _document(result)
    task = replace(_task(document), draw=BENCH.words)
    again, _ = stored(task, perform_task(task))
    if not again["rows"]:
        raise NoAnswerError("; ".join(again["failures"]))
    rows, path = rows_of(again), target or result.with_name(f"{result.name}.html")
    table = DataFrame([row_columns(row) for row in rows])
    write_text(path, page_of(task.case, table, sections_of(again), document["failures"]))
    return path, tuple(_differences(rows_of(document), rows))


def page_of(
    first: Case,
    table: "DataFrame",
    sections: Sequence[Section],
    failures: Sequence[str],
    units: Units = BENCH,
    drawn: Sequence[str] = (),
) -> str:
    """Return the page of results in HTML, in the reader's units.

    `first` is the case of the first flight, `drawn` as for `means_of`.
    """
    # It loads the drawing library, which only a page needs.
    from pitotbench.show.pages import campaign_page

    seeds = table.seed.nunique()
    subtitle = (
        f"{', '.join(dict.fromkeys(table.das))} Hz · {', '.join(dict.fromkeys(table.turbulence))} "
        f"turbulence · {seeds} seed{'s' if seeds > 1 else ''} · simulated flights of "
        f"{first.aircraft}"
    )
    return campaign_page(subtitle, table, sections, failures, write_case(first), units, drawn)


def _task(document: Document) -> Task:
    return Task(
        document["name"],
        document["key"],
        case_of_table(toml_table(document["case"])),
        tuple(DataSystem(**system) for system in document["das"]),
        tuple((label, options_from(options)) for label, options in document["calibrations"]),
        keep_logs="none",
    )


def _differences(before: tuple[Row, ...], after: tuple[Row, ...]) -> Iterator[str]:
    if len(before) != len(after):
        yield f"rows: {len(before)} stored, {len(after)} now"
    for old, new in zip(before, after, strict=False):
        place = f"{old.das} {old.model} {old.calibration}".strip()
        for (name, was), now in zip(
            row_columns(old).items(), row_columns(new).values(), strict=True
        ):
            if was != now and not (was != was and now != now):  # NaN equals NaN here
                yield f"{place} {name}: {was} stored, {now} now"
