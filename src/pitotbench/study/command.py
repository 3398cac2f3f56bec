"""The study as the command line asks for it, and what is printed."""

import argparse

from rich.console import Console
from rich.table import Table

from pitotbench.study import StudyRequest, run_study
from pitotbench.study.claims import CLAIMS

_NAMED = 5  # failures that are printed in full


def request_of(options: argparse.Namespace) -> StudyRequest:
    """The request of the parsed flags. Raises BadInputError for a value that makes no sense."""
    return StudyRequest(options.seeds, options.out, options.docs, options.jobs, options.scheduler)


def run_and_print(request: StudyRequest) -> bool:
    """Run it, print the verdict of every claim and name the pages; true where every flight was flown."""
    result = run_study(request)
    console = Console(highlight=False)
    table = Table("claim", "the paper", "ours", "verdict", show_lines=True)
    for number, finding in result.findings.items():
        table.add_row(number, CLAIMS[number].words, finding.ours, finding.verdict)
    console.print(table)
    for page in result.pages:
        console.print(f"written: {page}", markup=False, soft_wrap=True)
    for text in result.failures[:_NAMED]:
        console.print(f"no answer: {text}", markup=False, soft_wrap=True)
    if len(result.failures) > _NAMED:
        console.print(f"and {len(result.failures) - _NAMED} more: column failed of fits.parquet")
    return not result.lost
