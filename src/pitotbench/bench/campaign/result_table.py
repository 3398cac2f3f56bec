"""The results of one campaign or of several as a table, with rows chosen, averaged and written."""

from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from pitotbench.bench.campaign.result_store import PARTS, ResultStore
from pitotbench.bench.campaign.results_folder import STORE
from pitotbench.bench.campaign.store_index import indexed
from pitotbench.bench.campaign.stored_result import STATES
from pitotbench.catalog import explain
from pitotbench.logbook import atomic
from pitotbench.records.errors import BadInputError


def result_table(folders: Sequence[Path]) -> pd.DataFrame:
    """Return the rows of all results of campaigns, failures included, each flight once.

    The columns are those of results.parquet, all fields of the cases, the state and what made the result.
    Raises BadInputError for a folder without a store.
    """
    for folder in folders:
        if not (folder / STORE / PARTS).is_dir():
            raise BadInputError(f"{folder}: holds no stored results of a campaign")
    tables = [pd.read_parquet(indexed(ResultStore(folder / STORE))) for folder in folders]
    if len(tables) == 1:
        return tables[0]
    seen: set[str] = set()
    kept = []
    for table in tables:
        kept.append(table[~table.flight.isin(seen)])
        seen |= set(table.flight)
    return pd.concat(kept, ignore_index=True)


def chosen_rows(table: pd.DataFrame, where: str | None, state: str | None) -> pd.DataFrame:
    """Return the rows of a state for which an expression of pandas holds. Raises BadInputError for a wrong one."""
    if state is not None:
        if state not in STATES:
            raise BadInputError(explain("state", state, list(STATES)))
        table = table[table.state == state]
    if where is None:
        return table
    try:
        # The parser of Python would run any code; a name after @ would reach into this program.
        if "@" in where or "__" in where:
            raise ValueError("names of columns, numbers and texts only")
        return table.query(where)
    except Exception as error:  # pandas raises many kinds
        raise BadInputError(f"--where {where!r}: {error}") from error


def means(table: pd.DataFrame, by: Sequence[str]) -> pd.DataFrame:
    """Return the means of the numbers over all rows with the same values in the columns `by`, and their count."""
    require_columns(table, by)
    numbers = ["minutes", "residual_two_sigma_kt", "two_sigma_kt", "curve_rms_error_kt", "curve_coverage", "cpu_s"]
    groups = table.groupby(list(by), sort=False)
    return groups[numbers].mean().assign(rows=groups.size()).reset_index()


def require_columns(table: pd.DataFrame, names: Sequence[str]) -> None:
    """Raise BadInputError for a name that is no column."""
    for name in names:
        if name not in table.columns:
            raise BadInputError(explain("column", name, list(table.columns)))


def write_table(table: pd.DataFrame, path: Path) -> None:
    """Write a table as .parquet or .csv, whole or not at all. Raises BadInputError for another ending."""
    if path.suffix not in (".parquet", ".csv"):
        raise BadInputError(f"{path}: the name must end in .parquet or .csv")
    with atomic(path) as scratch:
        if path.suffix == ".parquet":
            table.to_parquet(scratch, index=False)
        else:
            table.to_csv(scratch, index=False)
