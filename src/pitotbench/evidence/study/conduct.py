"""Conduct the study: plan, fly, answer every claim, show."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from pitotbench.bench.fleet import Failure, run_tasks
from pitotbench.evidence.study.claims import CLAIMS, Finding
from pitotbench.evidence.study.measured_sorties import Measured, lost_sortie, measure_sortie
from pitotbench.evidence.study.page_content import study_page_of
from pitotbench.evidence.study.settings import Sortie
from pitotbench.evidence.study.sorties import plan_sorties
from pitotbench.evidence.study.study_tables import TABLES, StudyTables
from pitotbench.logbook import atomic, write_text
from pitotbench.records.errors import BadInputError, NoAnswerError


@dataclass(frozen=True, slots=True)
class StudyRequest:
    """The request for a study: its seeds (1 to `seeds`, of truth and sensors), its folders, its processes.

    `sweeps`: answer the open questions of the paper as well. `docs`: a folder for `study.md` and its pictures.
    `tables`: the folder `out` of an earlier run, whose tables are used instead of new flights.
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
    """The tables, the answers by claim, the pages, the failures in words, and the number of lost flights."""

    evidence: StudyTables
    findings: dict[str, Finding]
    pages: tuple[Path, ...]
    failures: tuple[str, ...]
    lost: int


def run_study(request: StudyRequest) -> StudyResult:
    """Fly the study, answer every claim, and write report.html and the tables; with `docs` also write study.md.

    The same seeds give the same numbers on any number of processes.
    Raises BadInputError for a request that makes no sense, NoAnswerError where nothing could be flown.
    """
    if request.tables is not None:
        return _answered(request, _read(request.tables), (), 0)
    measured = fly_sorties(plan_sorties(request.seeds, request.sweeps), request.jobs, request.scheduler)
    failures = tuple(text for done in measured for text in done.failures)
    if not any(done.fits for done in measured):
        raise NoAnswerError("no flight gave a result: " + "; ".join(failures[:3]))
    return _answered(request, StudyTables.of(measured), failures, sum(not done.flights for done in measured))


def fly_sorties(sorties: Sequence[Sortie], jobs: int | None = None, scheduler: str | None = None) -> list[Measured]:
    """Return the measurements of each sortie, in order. One that could not be flown has the reason instead."""
    results = run_tasks(measure_sortie, sorties, jobs, scheduler, "flying")
    return [
        lost_sortie(sortie, result.reason) if isinstance(result, Failure) else result
        for sortie, result in zip(sorties, results, strict=True)
    ]


def _read(folder: Path) -> StudyTables:
    """Return the tables of an earlier run."""
    try:
        return StudyTables.of_tables({name: pd.read_parquet(folder / f"{name}.parquet") for name in TABLES})
    except FileNotFoundError as error:
        raise BadInputError(f"{error.filename}: not there; --tables takes the --out of an earlier study") from error


def _answered(request: StudyRequest, evidence: StudyTables, failures: tuple[str, ...], lost: int) -> StudyResult:
    findings = {number: claim.answer(evidence) for number, claim in CLAIMS.items()}
    return StudyResult(evidence, findings, _write(request, evidence, findings), failures, lost)


def _write(request: StudyRequest, evidence: StudyTables, findings: dict[str, Finding]) -> tuple[Path, ...]:
    from pitotbench.evidence.pages.study_page import study_html, write_document  # loads the drawing library

    page = study_page_of(evidence, findings)
    try:
        request.out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadInputError(f"{request.out}: cannot be made: {error.strerror}; choose another --out") from error
    report = request.out / "report.html"
    write_text(report, study_html(page))
    for name in TABLES:
        with atomic(request.out / f"{name}.parquet") as scratch:
            getattr(evidence, name).to_parquet(scratch, index=False)
    return (report, write_document(page, request.docs)) if request.docs else (report,)
