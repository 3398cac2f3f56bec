"""Conduct the study: plan, fly, answer every claim, show."""

import argparse
from collections.abc import Mapping, Sequence
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
from pitotlab.study.claims import CLAIMS
from pitotlab.study.content import study_text, table_text
from pitotlab.study.measures import Measured, measure_sortie
from pitotlab.study.questions import Finding
from pitotlab.study.reductions import SETTINGS, Sortie, claim_sorties
from pitotlab.study.sweeps import SWEEPS
from pitotlab.study.tables import TABLES, StudyTables

EXPLAINED = 5  # one of this many seeds also flies the rare settings and the sweeps
ANSWERS = "claims.csv"
_NAMED = 5  # failures that are printed in full


def plan_sorties(
    seeds: int, sweeps: bool = True, first: int = 1, settings: Sequence[str] = ()
) -> list[Sortie]:
    """Return the sorties of `seeds` seeds from `first` on, the longest first.

    All seeds fly the sorties of the claims. A fifth of them also fly the experiments that explain
    and, with `sweeps`, the sweeps. Where `settings` are named, all seeds fly all of these alone.
    """
    flown: list[Sortie] = []
    for seed in range(first, first + seeds):
        rare = bool(settings) or seed - first < -(-seeds // EXPLAINED)
        asked = list(claim_sorties(seed, rare, seed == first))
        if settings:
            asked = [sortie for sortie in asked if sortie.setting in settings]
        flown += map(_swept, asked) if rare and sweeps else asked
    return sorted(flown, key=lambda sortie: -(MANEUVERS[sortie.case.maneuver].minutes or 0.0))


def _swept(sortie: Sortie) -> Sortie:
    """Return the sortie with the reductions of the sweeps added where it is in light turbulence."""
    maneuver = sortie.case.maneuver
    if (sortie.setting, sortie.variant) != ("light", "standard") or maneuver not in PAPER_MANEUVERS:
        return sortie
    more = (one for sweep in SWEEPS.values() for one in sweep.reductions(maneuver))
    return replace(sortie, reductions=(*sortie.reductions, *more))


@dataclass(frozen=True, slots=True)
class StudyRequest:
    """The request for a study: its seeds (`seeds` from `first` on, of truth and sensors), the settings
    that are flown (all where none is named), its folders, its processes.

    `sweeps`: answer the open questions of the paper as well. `tables`: the folders `out` of earlier
    runs, whose tables are joined and used instead of new flights.
    """

    seeds: int = 1
    first: int = 1
    settings: str = ""
    sweeps: bool = True
    out: Path = Path("out/study")
    jobs: int | None = None
    scheduler: str | None = None
    tables: Sequence[Path] = ()

    def __post_init__(self) -> None:
        if self.seeds < 1 or (self.jobs is not None and self.jobs < 1):
            raise BadInputError("--seeds and --jobs count from 1")


@dataclass(frozen=True, slots=True)
class StudyResult:
    """The tables, the answers by claim, the page or the folder of the tables, the failures in words,
    the flights lost.
    """

    evidence: StudyTables
    findings: Mapping[str, Finding]
    page: Path
    failures: tuple[str, ...] = ()
    lost: int = 0


def run_study(request: StudyRequest) -> StudyResult:
    """Fly the study and write its tables; of all settings, answer every claim and write report.md.

    The same seeds give the same numbers on any number of processes. Raises BadInputError for a
    request that makes no sense, NoAnswerError where nothing could be flown.
    """
    if request.tables:
        return _answered(request, _read(request.tables))
    settings = request.settings.split(",") if request.settings else []
    for name in settings:
        SETTINGS[name]  # raises for an unknown name
    sorties = plan_sorties(request.seeds, request.sweeps, request.first, settings)
    measured = fly_sorties(sorties, request.jobs, request.scheduler)
    failures = tuple(text for done in measured for text in done.failures)
    if not any(done.fits for done in measured):
        raise NoAnswerError("no flight gave a result: " + "; ".join(failures[:3]))
    lost = sum(not done.flights for done in measured)
    evidence = StudyTables.of(measured)
    # A claim takes flights of several settings: a part of them waits for `tables`.
    answered = _written(request, evidence) if settings else _answered(request, evidence)
    return replace(answered, failures=failures, lost=lost)


def fly_sorties(
    sorties: Sequence[Sortie], jobs: int | None = None, scheduler: str | None = None
) -> list[Measured]:
    """Return the measurements of each sortie, in order, or why it could not be flown."""
    results = run_tasks(measure_sortie, sorties, jobs, scheduler, "flying")
    return [
        Measured(failures=(f"{s.case.maneuver} seed {s.case.truth_seed} {s.setting}: {r.reason}",))
        if isinstance(r, Failure)
        else r
        for s, r in zip(sorties, results, strict=True)
    ]


def _read(folders: Sequence[Path]) -> StudyTables:
    """Return the tables of earlier runs, joined."""
    try:
        tables = {
            name: pd.concat([pd.read_parquet(each / f"{name}.parquet") for each in folders])
            for name in TABLES
        }
    except FileNotFoundError as error:
        raise BadInputError(
            f"{error.filename}: not there; --tables takes the --out of an earlier study"
        ) from error
    return StudyTables.of_tables(tables)


def _written(request: StudyRequest, evidence: StudyTables) -> StudyResult:
    """Write the tables."""
    try:
        request.out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadInputError(
            f"{request.out}: cannot be made: {error.strerror}; choose another --out"
        ) from error
    for name in TABLES:
        with atomic(request.out / f"{name}.parquet") as scratch:
            getattr(evidence, name).to_parquet(scratch, index=False)
    return StudyResult(evidence, {}, request.out)


def _answered(request: StudyRequest, evidence: StudyTables) -> StudyResult:
    """Write the tables, answer every claim, and write the page and the answers."""
    _written(request, evidence)
    findings = {number: claim.answer(evidence) for number, claim in CLAIMS.items()}
    page = request.out / "report.md"
    write_text(page, study_text(evidence, findings))
    told = [(number, found.verdict, found.ours) for number, found in findings.items()]
    pd.DataFrame(told, columns=["claim", "verdict", "ours"]).to_csv(
        request.out / ANSWERS, index=False, lineterminator="\n"
    )
    return StudyResult(evidence, findings, page)


def command(parser: argparse.ArgumentParser, words: Sequence[str]) -> None:
    """Fly the paper's simulator study again, answer its claims, and print the verdicts and the
    path of the page.

    Writes report.md and the numbers as Parquet. One seed gives an impression in a minute; the
    paper's claims are answered with 30.
    """
    add = parser.add_argument
    add("--seeds", type=int, default=1, help="truth and sensor seeds, that many (default: 1)")
    add("--first", type=int, default=1, help="first seed (default: 1)")
    add("--settings", default="", help=f"fly these alone, for --tables: {', '.join(SETTINGS)}")
    add("--claims-only", action="store_true", help="leave out what the paper left open")
    add("--jobs", type=int, help="processes (default: one a core)")
    add("--scheduler", help="address of a dask scheduler, tcp://host:port")
    add("--out", type=Path, default=Path("out", "study"), help="folder (default: %(default)s)")
    add(
        "--tables",
        type=Path,
        nargs="+",
        default=(),
        help="answer from the tables of earlier --out folders, joined; nothing is flown",
    )
    asked = vars(parser.parse_args(words))
    require_folder(asked["out"])
    result = run_study(StudyRequest(sweeps=not asked.pop("claims_only"), **asked))
    print_result(result)
    if result.lost:
        raise NoAnswerError(f"{result.lost} flights could not be flown; the page leaves them out")


def questions_command(parser: argparse.ArgumentParser, words: Sequence[str]) -> None:
    """Print the answers to what the paper left open, from the tables of `study --settings light`."""
    parser.add_argument("tables", type=Path, nargs="+", metavar="OUT", help="of earlier studies")
    evidence = _read(parser.parse_args(words).tables)
    print(
        f"{len(evidence.seeds)} seeds, {len(evidence.flights)} flights, {len(evidence.fits):,} fits"
    )
    for name, sweep in SWEEPS.items():
        reply = sweep.answer(evidence)
        print(f"\n{name}: {sweep.question}\n{reply.words}")
        for table in reply.tables:
            print(table_text(table))


def print_result(result: StudyResult) -> None:
    """Print the verdict of every claim, the path of the page, and the failures."""
    console = Console(highlight=False)
    table = Table("claim", "the paper", "ours", "verdict", show_lines=True)
    for number, finding in result.findings.items():
        table.add_row(number, CLAIMS[number].rule.words, finding.ours, finding.verdict)
    if result.findings:
        console.print(table)
    console.print(outside(f"written: {result.page}"), soft_wrap=True)
    for text in result.failures[:_NAMED]:
        console.print(outside(f"no answer: {text}"), soft_wrap=True)
    if len(result.failures) > _NAMED:
        console.print(f"and {len(result.failures) - _NAMED} more: column failed of fits.parquet")
