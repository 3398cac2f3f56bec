"""Conduct the study: plan, fly, answer every claim, show."""

import os
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
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

from pitotbench.bench.campaign.perform import executor_for
from pitotbench.evidence.study.claims import CLAIMS, Finding
from pitotbench.evidence.study.measured_sorties import Measured, measure_sortie
from pitotbench.evidence.study.page_content import study_page_of
from pitotbench.evidence.study.settings import Sortie
from pitotbench.evidence.study.sorties import plan_sorties
from pitotbench.evidence.study.study_tables import TABLES, StudyTables
from pitotbench.records.errors import BadInputError, NoAnswerError


@dataclass(frozen=True, slots=True)
class StudyRequest:
    """How many seeds (1 to `seeds`, truth and sensors), where to write, how many processes or which cluster.

    `sweeps`: fly what the paper left open as well. `docs`: a folder that gets `study.md` and its pictures.
    `tables`: the `out` of an earlier run, whose numbers are told again instead of flying.
    """

    seeds: int = 1
    sweeps: bool = True
    out: Path = Path("out/study")
    docs: Path | None = None
    jobs: int | None = None
    scheduler: str | None = None
    tables: Path | None = None

    def __post_init__(self) -> None:
        if self.seeds < 1 or (self.jobs is not None and self.jobs < 1):
            raise BadInputError("--seeds and --jobs count from 1")


@dataclass(frozen=True, slots=True)
class StudyResult:
    """The numbers, the answers by claim, the pages, what gave no answer in words, how many flights were lost."""

    evidence: StudyTables
    findings: dict[str, Finding]
    pages: tuple[Path, ...]
    failures: tuple[str, ...]
    lost: int


def run_study(request: StudyRequest) -> StudyResult:
    """Fly the study, answer every claim, write report.html and the tables of numbers; with `docs` study.md too.

    The same seeds give the same numbers on any number of processes.
    Raises BadInputError for a request that makes no sense, NoAnswerError where nothing could be flown.
    """
    if request.tables is not None:
        return _answered(request, _read(request.tables), (), 0)
    measured = _fly(request)
    failures = tuple(text for done in measured for text in done.failures)
    if not any(done.fits for done in measured):
        raise NoAnswerError("no flight gave a result: " + "; ".join(failures[:3]))
    return _answered(request, StudyTables.of(measured), failures, sum(not done.flights for done in measured))


def _fly(request: StudyRequest) -> list[Measured]:
    sorties, measured = plan_sorties(request.seeds, request.sweeps), []
    with executor_for(request.jobs or os.cpu_count() or 1, request.scheduler) as executor, _progress() as bar:
        line = bar.add_task("flying", total=len(sorties))
        for done in _results(executor, sorties):
            measured.append(done)
            bar.advance(line)
    return measured


def _read(folder: Path) -> StudyTables:
    """The numbers of an earlier run."""
    try:
        return StudyTables.of_tables({name: pd.read_parquet(folder / f"{name}.parquet") for name in TABLES})
    except FileNotFoundError as error:
        raise BadInputError(f"{error.filename}: not there; --tables takes the --out of an earlier study") from error


def _answered(request: StudyRequest, evidence: StudyTables, failures: tuple[str, ...], lost: int) -> StudyResult:
    findings = {number: claim.answer(evidence) for number, claim in CLAIMS.items()}
    return StudyResult(evidence, findings, _write(request, evidence, findings), failures, lost)


def _results(executor: Executor | None, sorties: Sequence[Sortie]) -> Iterator[Measured]:
    """In the order of the plan, whatever the order in which they end."""
    return map(measure_sortie, sorties) if executor is None else executor.map(measure_sortie, sorties)


def _write(request: StudyRequest, evidence: StudyTables, findings: dict[str, Finding]) -> tuple[Path, ...]:
    from pitotbench.evidence.pages.study_page import study_html, write_document  # loads the drawing library

    page = study_page_of(evidence, findings)
    try:
        request.out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadInputError(f"{request.out}: cannot be made: {error.strerror}; choose another --out") from error
    report = request.out / "report.html"
    report.write_text(study_html(page), encoding="utf-8")
    for name in TABLES:
        getattr(evidence, name).to_parquet(request.out / f"{name}.parquet", index=False)
    return (report, write_document(page, request.docs)) if request.docs else (report,)


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
