"""Run the long coverage campaign within a budget of time, and write the results with their seeds and date."""

from collections.abc import Sequence
from functools import partial
from pathlib import Path

import pandas as pd

from pitotbench.bench.flight_store import FlightStore
from pitotbench.evidence.bounds.coverage import TURBULENCE, score_trial, summarize
from pitotbench.evidence.bounds.scorings import SCORINGS
from pitotbench.evidence.experiment import NO_LIMIT, Budget, Experiment, made_with, run_experiment
from pitotbench.evidence.random_truth import FIRST_SCORED_SEED
from pitotbench.logbook import atomic, write_text
from pitotbench.simulate import PAPER_MANEUVERS


def verify(
    seeds: int,
    out: Path,
    budget: Budget = NO_LIMIT,
    scorings: Sequence[str] = tuple(SCORINGS),
    flights: Path | None = None,
) -> pd.DataFrame:
    """Score up to `seeds` seeds of every cell and write coverage.csv, coverage.png and coverage.md into `out`.

    `flights` is a folder in which flights are kept for the next campaign. A budget of 0 minutes flies nothing and
    writes the files from the kept rows.
    """
    score = partial(score_trial, store=None if flights is None else FlightStore(flights))
    experiment = Experiment(score, PAPER_MANEUVERS, TURBULENCE, tuple(scorings), "scoring")
    rows = run_experiment(experiment, range(FIRST_SCORED_SEED, FIRST_SCORED_SEED + seeds), budget)
    _write(rows, out)
    return rows


def _write(rows: pd.DataFrame, out: Path) -> None:
    from pitotbench.evidence.pages.coverage_page import coverage_page, coverage_picture  # loads the drawing library

    order = {name: place for place, name in enumerate(SCORINGS)}
    cells = summarize(rows.sort_values("scoring", key=lambda names: names.map(order), kind="stable"))
    out.mkdir(parents=True, exist_ok=True)
    with atomic(out / "coverage.csv") as scratch:
        cells.to_csv(scratch, index=False, float_format="%.6f", lineterminator="\n")
    coverage_picture(cells, out / "coverage.png")
    failures = int((rows["failed"] != "").sum())
    provenance = (
        f"Seeds {rows['seed'].min()} to {rows['seed'].max()}, {len(rows):,} calibrations, "
        f"{failures} without an answer, {made_with()}."
    )
    write_text(out / "coverage.md", coverage_page(cells, provenance))
