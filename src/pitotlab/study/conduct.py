"""Conduct the study: plan, fly, answer every claim, show."""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import pandas as pd
from rich.console import Console
from rich.table import Table

from pitotbench.campaigns.fleet import Failure, run_tasks
from pitotbench.logbook.columns import atomic, write_text
from pitotbench.records import BadInputError, NoAnswerError
from pitotbench.records.outputs import require_folder
from pitotbench.show.columns import outside
from pitotbench.simulation.maneuvers import MANEUVERS, PAPER_MANEUVERS
from pitotlab.study.claims import CLAIMS, Finding
from pitotlab.study.content import study_page_of
from pitotlab.study.measures import Measured, lost_sortie, measure_sortie
from pitotlab.study.reductions import Sortie, claim_sorties
from pitotlab.study.sweeps import SWEEPS
from pitotlab.study.tables import TABLES, StudyTables

EXPLAINED = 5  # one of this many seeds also flies the rare settings and the sweeps


def plan_sorties(seeds: int, sweeps: bool = True) -> list[Sortie]:
    """Return the sorties of seeds 1 to `seeds`.

    All seeds fly the sorties of the claims. A fifth of them also fly the experiments that explain
    and, with
    `sweeps`, the sweeps.
    """
    flown: list[Sortie] = []
    for seed in range(1, seeds + 1):
        rare = seed <= -(-seeds // EXPLAINED)
        flown += [
            _swept(sortie) if rare and sweeps else sortie for sortie in claim_sorties(seed, rare)
        ]
        if rare and sweeps:
            flown += [extra for sweep in SWEEPS.values() for extra in sweep.sorties(seed)]
    return sorted(flown, key=lambda sortie: -(MANEUVERS[sortie.case.maneuver].minutes or 0.0))


def _swept(sortie: Sortie) -> Sortie:
    """Return the sortie with the reductions of the sweeps added where it is in light turbulence."""
    usual = sortie.setting == "light" and sortie.variant == "standard"
    if not usual or sortie.case.maneuver not in PAPER_MANEUVERS:
        return sortie
    more = tuple(
        reduction
        for sweep in SWEEPS.values()
        for reduction in sweep.reductions(sortie.case.maneuver)
    )
    return replace(sortie, reductions=(*sortie.reductions, *more))


@dataclass(frozen=True, slots=True)
class StudyRequest:
    """The request for a study: its seeds (1 to `seeds`, of truth and sensors), its folders, its
    processes.

    `sweeps`: answer the open questions of the paper as well. `docs`: a folder for `study.md` and
    its pictures.
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
    """The tables, the answers by claim, the pages, the failures in words, and the number of lost
    flights.
    """

    evidence: StudyTables
    findings: dict[str, Finding]
    pages: tuple[Path, ...]
    failures: tuple[str, ...]
    lost: int


def run_study(request: StudyRequest) -> StudyResult:
    """Fly the study, answer every claim, and write report.html and the tables; with `docs` also
    write study.md.

    The same seeds give the same numbers on any number of processes. Raises BadInputError for a
    request that makes no sense, NoAnswerError where nothing could be flown.
    """
    if request.tables is not None:
        return _answered(request, _read(request.tables), (), 0)
    measured = fly_sorties(
        plan_sorties(request.seeds, request.sweeps), request.jobs, request.scheduler
    )
    failures = tuple(text for done in measured for text in done.failures)
    if not any(done.fits for done in measured):
        raise NoAnswerError("no flight gave a result: " + "; ".join(failures[:3]))
    return _answered(
        request, StudyTables.of(measured), failures, sum(not done.flights for done in measured)
    )


def fly_sorties(
    sorties: Sequence[Sortie], jobs: int | None = None, scheduler: str | None = None
) -> list[Measured]:
    """Return the measurements of each sortie, in order. One that could not be flown has the reason
    instead.
    """
    results = run_tasks(measure_sortie, sorties, jobs, scheduler, "flying")
    return [
        lost_sortie(sortie, result.reason) if isinstance(result, Failure) else result
        for sortie, result in zip(sorties, results, strict=True)
    ]


def _read(folder: Path) -> StudyTables:
    """Return the tables of an earlier run."""
    try:
        return StudyTables.of_tables(
            {name: pd.read_parquet(folder / f"{name}.parquet") for name in TABLES}
        )
    except FileNotFoundError as error:
        raise BadInputError(
            f"{error.filename}: not there; --tables takes the --out of an earlier study"
        ) from error


def _answered(
    request: StudyRequest, evidence: StudyTables, failures: tuple[str, ...], lost: int
) -> StudyResult:
    findings = {number: claim.answer(evidence) for number, claim in CLAIMS.items()}
    return StudyResult(evidence, findings, _write(request, evidence, findings), failures, lost)


def _write(
    request: StudyRequest, evidence: StudyTables, findings: dict[str, Finding]
) -> tuple[Path, ...]:
    from pitotlab.study.page import study_html, write_document  # loads the drawing library

    page = study_page_of(evidence, findings)
    try:
        request.out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadInputError(
            f"{request.out}: cannot be made: {error.strerror}; choose another --out"
        ) from error
    report = request.out / "report.html"
    write_text(report, study_html(page))
    for name in TABLES:
        with atomic(request.out / f"{name}.parquet") as scratch:
            getattr(evidence, name).to_parquet(scratch, index=False)
    return (report, write_document(page, request.docs)) if request.docs else (report,)


_NAMED = 5  # failures that are printed in full


def command(parser: argparse.ArgumentParser, words: Sequence[str]) -> None:
    """Fly the paper's simulator study again, answer its claims, and print the verdicts and the
    paths of the pages.

    Writes report.html and the numbers as Parquet; with --docs also study.md and its pictures. One
    seed gives an impression in a minute; the paper's claims are answered with 30.
    """
    parser.add_argument(
        "--seeds", type=int, default=1, help="truth and sensor seeds 1 to N (default: 1)"
    )
    parser.add_argument(
        "--claims-only", action="store_true", help="leave out what the paper left open"
    )
    parser.add_argument("--jobs", type=int, help="processes (default: one a core)")
    parser.add_argument("--scheduler", help="address of a dask scheduler, tcp://host:port")
    parser.add_argument(
        "--out", type=Path, default=Path("out", "study"), help="folder (default: %(default)s)"
    )
    parser.add_argument(
        "--docs", type=Path, help="write study.md and its pictures into this folder"
    )
    parser.add_argument(
        "--tables", type=Path, help="answer from the tables of an earlier --out; nothing is flown"
    )
    options = parser.parse_args(words)
    for folder in (options.out, options.docs):
        if folder is not None:
            require_folder(folder)
    sweeps, more = not options.claims_only, (options.jobs, options.scheduler, options.tables)
    result = run_study(StudyRequest(options.seeds, sweeps, options.out, options.docs, *more))
    print_result(result)
    if result.lost:
        raise NoAnswerError(f"{result.lost} flights could not be flown; the pages leave them out")


def print_result(result: StudyResult) -> None:
    """Print the verdict of every claim, the pages, and the failures."""
    console = Console(highlight=False)
    table = Table("claim", "the paper", "ours", "verdict", show_lines=True)
    for number, finding in result.findings.items():
        table.add_row(number, CLAIMS[number].words, finding.ours, finding.verdict)
    console.print(table)
    for page in result.pages:
        console.print(outside(f"written: {page}"), soft_wrap=True)
    for text in result.failures[:_NAMED]:
        console.print(outside(f"no answer: {text}"), soft_wrap=True)
    if len(result.failures) > _NAMED:
        console.print(f"and {len(result.failures) - _NAMED} more: column failed of fits.parquet")
