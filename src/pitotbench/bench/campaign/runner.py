"""Run a campaign: plan its flights, fly them, store the results and write a page."""

from dataclasses import dataclass, field
from pathlib import Path

import pandas as pd

from pitotbench.bench.campaign.perform import TaskOutcome, lost_task, perform_task
from pitotbench.bench.campaign.results_folder import RESULTS, appearing_folder, results_table
from pitotbench.bench.campaign.tasks import Task, plan_tasks
from pitotbench.bench.fleet import Failure, run_tasks
from pitotbench.calibrate import CalibrationOptions
from pitotbench.logbook import write_text
from pitotbench.records.case import Case
from pitotbench.records.case_file import write_case
from pitotbench.records.errors import NoAnswerError


@dataclass(frozen=True, slots=True)
class CampaignRequest:
    """The request for a campaign, as the command line makes it. Names may be comma lists or `all`."""

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
    report: bool = True


@dataclass(frozen=True, slots=True)
class CampaignResult:
    """The table of results, the failures in words, and the paths of the files."""

    table: pd.DataFrame
    failures: tuple[str, ...]
    folder: Path


def run_campaign(request: CampaignRequest) -> CampaignResult:
    """Fly, sense, calibrate, score and show a campaign. Its folder appears complete or not at all.

    Raises BadInputError or UnknownNameError for a bad request, before anything is flown. Raises NoAnswerError
    where no flight gave a result.
    """
    # A first plan without a folder finds wrong names before the folder is made.
    _tasks(request, "")
    with appearing_folder(request.out) as scratch:
        tasks = _tasks(request, str(scratch.resolve()))
        results = run_tasks(perform_task, tasks, request.jobs, request.scheduler, "flying")
        outcomes = [
            lost_task(task, result) if isinstance(result, Failure) else result
            for task, result in zip(tasks, results, strict=True)
        ]
        table = results_table(outcomes)
        failures = tuple(text for outcome in outcomes for text in outcome.failures)
        if not len(table):
            raise NoAnswerError("no flight gave a result: " + "; ".join(failures[:3]))
        table.to_parquet(scratch / RESULTS, index=False)
        if request.report:
            write_text(scratch / "report.html", _page(request, tasks[0], table, outcomes, failures))
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
        request.report,
    )


def _page(
    request: CampaignRequest,
    task: Task,
    table: pd.DataFrame,
    outcomes: list[TaskOutcome],
    failures: tuple[str, ...],
) -> str:
    from pitotbench.show.report import campaign_page  # it loads the drawing library, which only a page needs

    subtitle = (
        f"{', '.join(dict.fromkeys(table.das))} Hz · {request.base.turbulence} turbulence · "
        f"{request.seeds} seed{'s' if request.seeds > 1 else ''} · simulated flights of {request.base.aircraft}"
    )
    sections = [section for outcome in outcomes for section in outcome.sections]
    return campaign_page(subtitle, table, sections, failures, write_case(task.case))
