"""The tables of docs/aircraft.md on airplanes that the bench did not write."""

from collections.abc import Sequence
from typing import Any

import pandas as pd

from pitotbench.evidence.bounds.aircraft_flights import FirstFlight, speeds_of
from pitotbench.show.columns import Column, markdown_table

_FLOWN: tuple[Column[Any], ...] = (
    Column("airplane", lambda row: f"`{row.aircraft}`"),
    Column("engines and speeds", lambda row: speeds_of(row.aircraft)),
    Column("flights", lambda row: str(row.flights)),
    Column("without an answer", lambda row: str(row.failed)),
    Column("on condition, mean [%]", lambda row: f"{row.on_condition_percent:.1f}"),
    Column("the worst flight [%]", lambda row: f"{row.least_on_condition_percent:.0f}"),
    Column("curve inside [%]", lambda row: f"{row.coverage_percent:.1f} ± {row.coverage_se_percent:.1f}"),
    Column("mean 2σ [kt]", lambda row: f"{row.two_sigma_kt:.2f}"),
    Column("rms error [kt]", lambda row: f"{row.rms_error_kt:.2f}"),
)
_FIRST: tuple[Column[FirstFlight], ...] = (
    Column("airplane", lambda one: f"`{one.aircraft}`"),
    Column("clock [s]", lambda one: f"{one.wall:.1f}"),
    Column("processor [s]", lambda one: f"{one.cpu:.1f}"),
    Column("outcome", lambda one: one.failure or "flown and recorded"),
)


def foreign_table(table: pd.DataFrame) -> str:
    """Return one line (Markdown) an airplane, all maneuvers together, of the summary of its flights."""
    return markdown_table(_FLOWN, list(table[table["maneuver"] == "all"].itertuples()))


def first_flights_table(times: Sequence[FirstFlight]) -> str:
    """Return one line (Markdown) an airplane: the time from the path of its file to its first recorded flight."""
    return markdown_table(_FIRST, times)
