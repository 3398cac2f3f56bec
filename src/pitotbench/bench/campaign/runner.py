"""Fly many cases and keep what comes out: plan, run, store, and a page that shows it."""

import os
import sys
from dataclasses import dataclass, field
from pathlib import Path

import pandas as pd
from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

from pitotbench.bench.campaign.perform import TaskOutcome, executor_for, run_tasks
from pitotbench.bench.campaign.results_folder import RESULTS, appearing_folder, results_table
from pitotbench.bench.campaign.tasks import Task, plan_tasks
from pitotbench.calibrate import CalibrationOptions
from pitotbench.records.case import Case
from pitotbench.records.case_file import write_case
from pitotbench.records.errors import NoAnswerError


@dataclass(frozen=True, slots=True)
class CampaignRequest:
    """What the command line asks for; names may be comma lists or `all`."""

    maneuvers: str
    systems: str
    models: str = "inverse+"
    seeds: int = 1
    base: Case = field(default_factory=Case)
    options: CalibrationOptions = field(default_factory=CalibrationOptions)
    out: Path = Path("out")
    jobs: int | None = None
    scheduler: str | None = None
    log_format: str = "parquet"


@dataclass(frozen=True, slots=True)
class CampaignResult:
    """The table of results, what failed in words, and where everything lies."""

    table: pd.DataFrame
    failures: tuple[str, ...]
    folder: Path


def run_campaign(request: CampaignRequest) -> CampaignResult:
    """Fly, sense, calibrate, score and show a campaign; the folder appears whole or not at all.

    Raises BadInputError or UnknownNameError before anything is flown where the request makes no sense, and
    NoAnswerError where no flight gave a result.
    """
    # A first plan with no folder refuses wrong names before a folder exists.
    tasks = _tasks(request, "")
    jobs = request.jobs or min(os.cpu_count() or 1, len(tasks))
    with appearing_folder(request.out) as scratch, executor_for(jobs, request.scheduler) as executor:
        tasks = _tasks(request, str(scratch.resolve()))
        with _progress() as bar:
            line = bar.add_task("flying", total=len(tasks))
            outcomes = run_tasks(tasks, executor, lambda: bar.advance(line))
        table = results_table(outcomes)
        failures = tuple(text for outcome in outcomes for text in outcome.failures)
        if not len(table):
            raise NoAnswerError("no flight gave a result: " + "; ".join(failures[:3]))
        table.to_parquet(scratch / RESULTS, index=False)
        (scratch / "report.html").write_text(_page(request, tasks[0], table, outcomes, failures), encoding="utf-8")
    return CampaignResult(table, failures, request.out)


def _tasks(request: CampaignRequest, folder: str) -> list[Task]:
    return plan_tasks(
        request.base,
        request.maneuvers,
        request.systems,
        request.models,
        request.seeds,
        request.options,
        folder,
        request.log_format,
    )


def _page(
    request: CampaignRequest,
    task: Task,
    table: pd.DataFrame,
    outcomes: list[TaskOutcome],
    failures: tuple[str, ...],
) -> str:
    from pitotbench.show.report import campaign_page  # loads the drawing library: only when a page is made

    subtitle = (
        f"{', '.join(dict.fromkeys(table.das))} Hz · {request.base.turbulence} turbulence · "
        f"{request.seeds} seed{'s' if request.seeds > 1 else ''} · simulated flights of {request.base.aircraft}"
    )
    sections = [section for outcome in outcomes for section in outcome.sections]
    return campaign_page(subtitle, table, sections, failures, write_case(task.case))


def _progress() -> Progress:
    """A bar on standard error; quiet when that is not a terminal."""
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    return Progress(*columns, console=Console(stderr=True), disable=not sys.stderr.isatty(), transient=True)
