"""The long coverage campaign: run it within a budget of time and write what was measured, with seeds and date."""

import os
import sys
from collections.abc import Callable
from concurrent.futures import Executor
from datetime import UTC, datetime
from functools import partial
from importlib.metadata import version
from pathlib import Path
from time import monotonic

import pandas as pd
from rich.console import Console
from rich.progress import Progress

from pitotbench.campaign.coverage import FIRST_SCORED_SEED, Trial, score_trial, summarize, trials
from pitotbench.campaign.flight_store import FlightStore
from pitotbench.campaign.run import executor_for
from pitotbench.simulate import PAPER_MANEUVERS

_SEEDS_A_ROUND = 2

Score = Callable[[Trial], list[dict[str, object]]]


def verify(
    seeds: int, out: Path, jobs: int | None = None, minutes: float | None = None, flights: Path | None = None
) -> pd.DataFrame:
    """Fly up to `seeds` seeds of every cell and write coverage.csv, coverage.png and coverage.md into `out`.

    `flights`: a folder where flights are kept from one campaign to the next.
    """
    score = partial(score_trial, store=None if flights is None else FlightStore(flights))
    begun = monotonic()
    rows: list[dict[str, object]] = []
    done = 0
    quiet = not sys.stderr.isatty()
    with (
        executor_for(jobs or os.cpu_count() or 1, None) as pool,
        Progress(console=Console(stderr=True), disable=quiet) as bar,
    ):
        line = bar.add_task("seeds", total=seeds)
        while done < seeds and (minutes is None or monotonic() - begun < 60.0 * minutes):
            count = min(_SEEDS_A_ROUND, seeds - done)
            rows += _round(pool, score, trials(list(PAPER_MANEUVERS), count, FIRST_SCORED_SEED + done))
            done += count
            bar.advance(line, count)
    table = pd.DataFrame(rows)
    _write(table, done, out, (monotonic() - begun) / 60.0)
    return table


def _round(pool: Executor | None, score: Score, flown: list[Trial]) -> list[dict[str, object]]:
    results = map(score, flown) if pool is None else pool.map(score, flown)
    return [row for result in results for row in result]


def _write(rows: pd.DataFrame, seeds: int, out: Path, minutes: float) -> None:
    from pitotbench.show.coverage import coverage_page, coverage_picture  # loads the drawing library

    cells = summarize(rows)
    out.mkdir(parents=True, exist_ok=True)
    cells.to_csv(out / "coverage.csv", index=False, float_format="%.4f", lineterminator="\n")
    coverage_picture(cells, out / "coverage.png")
    failures = int((rows["failed"] != "").sum())
    provenance = (
        f"Seeds {FIRST_SCORED_SEED} to {FIRST_SCORED_SEED + seeds - 1}, {seeds} flights a cell, "
        f"{len(rows):,} calibrations, {failures} without an answer, {minutes:.0f} min, "
        f"pitotbench {version('pitotbench')}, JSBSim {version('jsbsim')}, {datetime.now(UTC):%Y-%m-%d}."
    )
    (out / "coverage.md").write_text(coverage_page(cells, provenance), encoding="utf-8")
