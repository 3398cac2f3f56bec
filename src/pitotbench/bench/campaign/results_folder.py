"""The folder of a campaign: its table, logs, cases and page are made from the store when its flights have ended."""

import os
import shutil
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from pitotbench.bench.campaign.result_store import Document, ResultStore
from pitotbench.bench.campaign.stored_result import all_columns, row_columns, rows_of, sections_of
from pitotbench.bench.campaign.tasks import Task
from pitotbench.logbook import atomic, write_text
from pitotbench.records.case_file import write_case
from pitotbench.records.errors import BadInputError
from pitotbench.show.section import Section

RESULTS, STORE = "results.parquet", "store"
_GROUP = 10_000  # flights whose rows are in memory at a time
_MOST_FAILURES = 1_000  # sentences that are printed and shown; the store holds all


def require_own_folder(target: Path) -> None:
    """Raise BadInputError for a folder that holds something else than a campaign."""
    own = (target / RESULTS, target / STORE)
    if target.exists() and (
        not target.is_dir() or (any(target.iterdir()) and not any(path.exists() for path in own))
    ):
        raise BadInputError(f"{target} exists and holds no campaign's results; choose another --out")


@dataclass(slots=True)
class Gathered:
    """What the folder shows of the results: the number of rows, the failures in words, the parts of the page."""

    rows: int = 0
    failed: int = 0
    failures: list[str] = field(default_factory=list)
    sections: list[Section] = field(default_factory=list)
    missing: int = 0


def gather(folder: Path, store: ResultStore, tasks: Iterable[Task], varied: tuple[str, ...]) -> Gathered:
    """Write the rows of the tasks to the table of the folder, in the order of the plan; return what the page needs.

    An earlier table is replaced only where there is a row. The table of one plan is the same bit for bit, however
    often it was interrupted and however many processes flew it.
    """
    found = Gathered()
    groups = _groups(store, tasks, varied, found)
    first = next(groups, None)
    if first is None:
        return found
    with atomic(folder / RESULTS) as scratch:
        table = _table(first)
        with pq.ParquetWriter(scratch, table.schema) as writer:
            writer.write_table(table)
            for rows in groups:
                writer.write_table(_table(rows).cast(table.schema))
    return found


def _table(rows: list[dict[str, Any]]) -> pa.Table:
    return pa.Table.from_pandas(pd.DataFrame(rows), preserve_index=False)


def _groups(
    store: ResultStore, tasks: Iterable[Task], varied: tuple[str, ...], found: Gathered
) -> Iterator[list[dict[str, Any]]]:
    rows: list[dict[str, Any]] = []
    flights = 0
    for task in tasks:
        document = store.find(task.key)
        if document is None:
            found.missing += 1
            continue
        _note(document, task, found)
        rows += _rows(document, varied)
        flights += 1
        if flights % _GROUP == 0 and rows:
            found.rows += len(rows)
            yield rows
            rows = []
    if rows:
        found.rows += len(rows)
        yield rows


def _note(document: Document, task: Task, found: Gathered) -> None:
    if document["failures"]:
        found.failed += len(document["failures"])
        room = _MOST_FAILURES - len(found.failures)
        found.failures += document["failures"][: max(room, 0)]
    if task.draw:
        found.sections += sections_of(document)


def _rows(document: Document, varied: tuple[str, ...]) -> Iterator[dict[str, Any]]:
    """Give the rows of a flight: the columns of the contract, the fields that the plan varies, and its key."""
    columns = all_columns(document) if varied else {}
    extra = {name: columns.get(name) for name in varied}
    labeled = any(label for label, _ in document["calibrations"])
    for row in rows_of(document):
        label = {"calibration": row.calibration} if labeled else {}
        yield {**row_columns(row), **label, **extra, "flight": document["key"]}


def publish_files(folder: Path, store: ResultStore, tasks: Iterable[Task]) -> None:
    """Make the folders of logs and of cases from the store. Those of an earlier campaign are replaced."""
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
