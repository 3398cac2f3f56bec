"""`pitotbench study`: fly the study, print the verdict of every claim, and write the pages."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from pitotbench.records.errors import BadInputError, NoAnswerError

if TYPE_CHECKING:
    from pitotbench.evidence.study.conduct import StudyResult

_NAMED = 5  # failures that are printed in full


def add(parser: argparse.ArgumentParser) -> None:
    """Add the flags of `pitotbench study`."""
    parser.add_argument("--seeds", type=int, default=1, help="truth and sensor seeds 1 to N (default: 1)")
    parser.add_argument("--claims-only", action="store_true", help="leave out what the paper left open")
    parser.add_argument("--jobs", type=int, help="processes (default: one a core)")
    parser.add_argument("--scheduler", help="address of a dask scheduler, tcp://host:port")
    parser.add_argument("--out", type=Path, default=Path("out", "study"), help="folder (default: %(default)s)")
    parser.add_argument("--docs", type=Path, help="write study.md and its pictures into this folder")
    parser.add_argument("--tables", type=Path, help="answer from the tables of an earlier --out; nothing is flown")


def run(options: argparse.Namespace) -> int:
    """Fly the study, print the verdicts and the pages' paths.

    Raises BadInputError for numbers below 1, NoAnswerError where flights were lost.
    """
    if options.seeds < 1 or (options.jobs is not None and options.jobs < 1):
        raise BadInputError("--seeds and --jobs count from 1")
    from pitotbench.evidence.study.conduct import StudyRequest, run_study  # loads the simulator
    from pitotbench.logbook.outputs import require_folder

    for folder in (options.out, options.docs):
        if folder is not None:
            require_folder(folder)
    request = StudyRequest(
        options.seeds,
        not options.claims_only,
        options.out,
        options.docs,
        options.jobs,
        options.scheduler,
        options.tables,
    )
    result = run_study(request)
    print_result(result)
    if result.lost:
        raise NoAnswerError(f"{result.lost} flights could not be flown; the pages leave them out")
    return 0


def print_result(result: "StudyResult") -> None:
    """Print the verdict of every claim, the pages, and the failures."""
    from rich.console import Console
    from rich.table import Table

    from pitotbench.evidence.study.claims import CLAIMS
    from pitotbench.show.terminal import outside

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
