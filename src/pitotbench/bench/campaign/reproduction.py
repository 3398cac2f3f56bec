"""Fly a stored result again and compare."""

import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pitotbench.bench.campaign.perform import Row, perform_task
from pitotbench.bench.campaign.tasks import Task
from pitotbench.bench.result_table import STORE
from pitotbench.bench.store import Document, ResultStore, row_columns, rows_of, stored
from pitotbench.calibrate.options import options_from
from pitotbench.records.case import DataSystem
from pitotbench.records.case_file import case_of_table
from pitotbench.records.errors import BadInputError


@dataclass(frozen=True, slots=True)
class Reproduction:
    """A stored flight and the same flight flown again: what made each, and the numbers that differ.

    `differences` are lines with both numbers; empty where every number is the same bit for bit.
    """

    name: str
    rows: int
    stored: dict[str, Any]
    here: dict[str, Any]
    differences: tuple[str, ...]


def reproduce(result: Path) -> Reproduction:
    """Fly a stored result again in this process, and compare every number of its rows.

    `result` is the folder of a campaign with the name or the key of a flight, such as
    `out/circle-20_1/circle-seed1`, or the file of a part. Raises BadInputError where there is no such result.
    """
    document = _document(result)
    again, _ = stored(_task(document), perform_task(_task(document)))
    before, after = rows_of(document), rows_of(again)
    differences = tuple(_differences(before, after))
    return Reproduction(document["name"], len(after), document["made"], again["made"], differences)


def _document(result: Path) -> Document:
    if result.suffix == ".json":
        found = ResultStore(result.parents[2]).find(result.stem) if len(result.parents) > 2 else None
    else:
        store = ResultStore(result.parent / STORE)
        found = store.find(result.name)
        named = (document for key in [*store.keys()] if (document := store.find(key)) is not None)
        found = found or next((each for each in named if each["name"] == result.name), None)
    if found is None:
        raise BadInputError(f"{result}: no stored flight; give the folder of a campaign and a flight's name or key")
    return found


def _task(document: Document) -> Task:
    return Task(
        document["name"],
        document["key"],
        case_of_table(tomllib.loads(document["case"])),
        tuple(DataSystem(**system) for system in document["das"]),
        tuple((label, options_from(options)) for label, options in document["calibrations"]),
        keep_logs="none",
    )


def _differences(before: tuple[Row, ...], after: tuple[Row, ...]) -> Iterator[str]:
    if len(before) != len(after):
        yield f"rows: {len(before)} stored, {len(after)} now"
    for old, new in zip(before, after, strict=False):
        place = f"{old.das} {old.model} {old.calibration}".strip()
        for (name, was), now in zip(row_columns(old).items(), row_columns(new).values(), strict=True):
            if was != now and not (was != was and now != now):  # NaN equals NaN here
                yield f"{place} {name}: {was} stored, {now} now"
