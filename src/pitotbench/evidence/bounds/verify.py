"""The long coverage campaign: run it within a budget of time and write what was measured, with seeds and date."""

import os
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import partial
from importlib.metadata import version
from pathlib import Path
from time import monotonic

import pandas as pd
from rich.console import Console
from rich.progress import Progress

from pitotbench.bench.campaign.perform import executor_for
from pitotbench.bench.flight_store import FlightStore
from pitotbench.evidence.bounds.coverage import FIRST_SCORED_SEED, score_trial, summarize, trials
from pitotbench.evidence.bounds.scorings import SCORINGS
from pitotbench.logbook import atomic
from pitotbench.simulate import PAPER_MANEUVERS

_SEEDS_A_ROUND = 2


@dataclass(frozen=True, slots=True)
class Budget:
    """What a campaign may use: processes, minutes (None for no limit), a folder of flights, and a Parquet file of
    the rows scored before by the same code, which are not scored again."""

    jobs: int | None = None
    minutes: float | None = None
    flights: Path | None = None
    rows: Path | None = None


def verify(
    seeds: int, out: Path, budget: Budget = Budget(), scorings: Sequence[str] = tuple(SCORINGS)
) -> pd.DataFrame:
    """Score up to `seeds` seeds of every cell and write coverage.csv, coverage.png and coverage.md into `out`.

    Ends after the round in which the minutes are over: 0 writes what the kept rows hold.
    """
    rows = _kept(budget.rows)
    begun = monotonic()
    with (
        executor_for(budget.jobs or os.cpu_count() or 1, None) as pool,
        Progress(console=Console(stderr=True), disable=not sys.stderr.isatty()) as bar,
    ):
        line = bar.add_task("seeds", total=seeds)
        for first, count in _rounds(seeds):
            rows = _with_round(rows, pool, first, count, scorings, budget)
            bar.advance(line, count)
            if budget.minutes is not None and monotonic() - begun > 60.0 * budget.minutes:
                break
    asked = rows[rows["scoring"].isin(list(scorings)) & (rows["seed"] < FIRST_SCORED_SEED + seeds)]
    _write(asked, out)
    return asked


def _rounds(seeds: int) -> Iterator[tuple[int, int]]:
    for begin in range(0, seeds, _SEEDS_A_ROUND):
        yield FIRST_SCORED_SEED + begin, min(_SEEDS_A_ROUND, seeds - begin)


def _with_round(
    rows: pd.DataFrame, pool: Executor | None, first: int, count: int, scorings: Sequence[str], budget: Budget
) -> pd.DataFrame:
    """The rows with those of seeds `first` and on, for the scorings not scored before."""
    seeds = range(first, first + count)
    missing = [s for s in scorings if not set(seeds) <= set(rows.loc[rows["scoring"] == s, "seed"])]
    if not missing:
        return rows
    store = None if budget.flights is None else FlightStore(budget.flights)
    score = partial(score_trial, store=store, asked=missing)
    flown = trials(list(PAPER_MANEUVERS), count, first)
    results = map(score, flown) if pool is None else pool.map(score, flown)
    again = rows["seed"].isin(seeds) & rows["scoring"].isin(missing)
    new = pd.DataFrame([row for result in results for row in result])
    rows = pd.concat([rows[~again], new], ignore_index=True) if len(rows) else new
    if budget.rows is not None:
        budget.rows.parent.mkdir(parents=True, exist_ok=True)
        with atomic(budget.rows) as scratch:
            rows.to_parquet(scratch)
    return rows


def _kept(path: Path | None) -> pd.DataFrame:
    if path is not None and path.exists():
        return pd.read_parquet(path)
    return pd.DataFrame({"scoring": pd.Series(dtype=str), "seed": pd.Series(dtype=int)})


def _write(rows: pd.DataFrame, out: Path) -> None:
    from pitotbench.evidence.pages.coverage_page import coverage_page, coverage_picture  # loads the drawing library

    order = {name: place for place, name in enumerate(SCORINGS)}
    cells = summarize(rows.sort_values("scoring", key=lambda names: names.map(order), kind="stable"))
    out.mkdir(parents=True, exist_ok=True)
    cells.to_csv(out / "coverage.csv", index=False, float_format="%.6f", lineterminator="\n")
    coverage_picture(cells, out / "coverage.png")
    failures = int((rows["failed"] != "").sum())
    provenance = (
        f"Seeds {rows['seed'].min()} to {rows['seed'].max()}, {len(rows):,} calibrations, "
        f"{failures} without an answer, "
        f"pitotbench {version('pitotbench')}, JSBSim {version('jsbsim')}, {datetime.now(UTC):%Y-%m-%d}."
    )
    (out / "coverage.md").write_text(coverage_page(cells, provenance), encoding="utf-8")
