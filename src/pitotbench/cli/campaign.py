"""A campaign as the command line asks for it: from flags to a request, and the table that is printed."""

import argparse
import re
from dataclasses import replace
from pathlib import Path

from rich.console import Console

from pitotbench.bench.campaign.results_folder import RESULTS
from pitotbench.bench.campaign.runner import CampaignRequest, run_campaign
from pitotbench.calibrate import CalibrationOptions
from pitotbench.catalog import explain
from pitotbench.flags import wind_of
from pitotbench.logbook import FORMATS
from pitotbench.logbook.outputs import require_folder
from pitotbench.records.case import PILOTS, TURBULENCE_SEVERITY, Case
from pitotbench.records.errors import BadInputError
from pitotbench.show.campaign_table import print_campaign
from pitotbench.show.terminal import outside

_TABLE_WIDTH = 140  # columns: the campaign's table never folds


def request_of(options: argparse.Namespace) -> CampaignRequest:
    """The request of the parsed flags. Raises BadInputError for a value that makes no sense."""
    _require("turbulence", options.turbulence, list(TURBULENCE_SEVERITY))
    _require("pilot", options.pilot, list(PILOTS))
    _require("log format", f".{options.log_format}", list(FORMATS))
    if options.seeds < 1 or (options.jobs is not None and options.jobs < 1):
        raise BadInputError("--seeds and --jobs count from 1")
    wind = wind_of(options)
    base = replace(Case(), aircraft=options.aircraft, turbulence=options.turbulence, pilot=options.pilot, wind=wind)
    out = options.out or Path("out", _folder_name(options.maneuver, options.das))
    if not out.name:
        raise BadInputError("--out: a campaign replaces its folder as a whole; name a folder of its own")
    require_folder(out)
    return CampaignRequest(
        maneuvers=options.maneuver,
        systems=options.das,
        models=options.model,
        seeds=options.seeds,
        base=base,
        options=CalibrationOptions(method=options.method),
        out=out,
        jobs=options.jobs,
        scheduler=options.scheduler,
        log_format=options.log_format,
    )


def run_and_print(request: CampaignRequest) -> bool:
    """Run it, print the table, name the report and what failed; true where nothing failed."""
    result = run_campaign(request)
    console = Console(highlight=False, soft_wrap=True)
    console.width = max(console.width, _TABLE_WIDTH)
    print_campaign(result.table, console)
    for text in result.failures:
        console.print(outside(f"failed: {text}", "red"))
    console.print(outside(f"results: {result.folder / RESULTS}"))
    console.print(outside(f"report:  {result.folder / 'report.html'}"))
    return not result.failures


def _require(kind: str, value: str, known: list[str]) -> None:
    if value not in known:
        raise BadInputError(explain(kind, value, known))


def _folder_name(maneuver: str, das: str) -> str:
    return "-".join(re.sub(r"[^A-Za-z0-9_]+", "_", part) for part in (maneuver, das))
