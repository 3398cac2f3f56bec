"""The index of a store: one Parquet table of all its results, made from the parts.

DuckDB, Polars and pandas open it. It is made again where it is missing or cut, or lacks a part. A part that is
replaced removes it.
"""

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from pitotbench.bench.campaign.result_store import INDEX, ResultStore
from pitotbench.bench.campaign.stored_result import all_columns, row_columns, rows_of
from pitotbench.bench.fleet.saying import say
from pitotbench.logbook import atomic

_GROUP = 10_000  # parts whose rows are in memory at a time


def indexed(store: ResultStore) -> Path:
    """Return the index of a store, brought up to date. Raises BadInputError where it cannot be written."""
    path = store.folder / INDEX
    keys = [*store.keys()]
    if not _is_of(path, keys, store):
        _make(path, keys, store)
    return path


def _is_of(path: Path, keys: list[str], store: ResultStore) -> bool:
    try:
        if not path.exists():
            return False
        known = pq.read_table(path, columns=["flight"]).column("flight").unique().to_pylist()
    except (pa.ArrowException, OSError, KeyError, ValueError):
        say(f"{path}: cannot be read; it is made again from the {len(keys):,} parts")
        return False
    return set(known) == set(keys)


def _make(path: Path, keys: list[str], store: ResultStore) -> None:
    groups = [
        pa.Table.from_pandas(pd.DataFrame([*_rows(store, keys[begin : begin + _GROUP])]), preserve_index=False)
        for begin in range(0, len(keys), _GROUP)
    ]
    # A field that only some flights have is empty for the others.
    table = pa.concat_tables(groups or [pa.table({"flight": []})], promote_options="permissive")
    with atomic(path) as scratch:
        pq.write_table(table, scratch, row_group_size=_GROUP)


def _rows(store: ResultStore, keys: list[str]) -> Iterator[dict[str, Any]]:
    for key in keys:
        document = store.find(key)
        if document is None:
            yield {"flight": key, "state": "cut"}
            continue
        common = _common(document)
        rows = [row_columns(row) | {"calibration": row.calibration} for row in rows_of(document)]
        yield from (common | row for row in rows or [{}])


def _common(document: Mapping[str, Any]) -> dict[str, Any]:
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
