"""A campaign as the command line asks for it: from flags to a request, and the table that is printed."""

import argparse
import re
from dataclasses import replace
from math import isfinite
from pathlib import Path

from rich.console import Console

from pitotbench.calibrate import CalibrationOptions
from pitotbench.campaign import CampaignRequest, run_campaign
from pitotbench.campaign.store import RESULTS
from pitotbench.catalog import explain
from pitotbench.logbook import FORMATS
from pitotbench.records.case import PILOTS, TURBULENCE_SEVERITY, Case, Wind
from pitotbench.records.errors import BadInputError
from pitotbench.show.tables import print_campaign
from pitotbench.units import DEGREE, KNOT

_TABLE_WIDTH = 140  # columns: the campaign's table never folds


def request_of(options: argparse.Namespace) -> CampaignRequest:
    """The request of the parsed flags. Raises BadInputError for a value that makes no sense."""
    _require("turbulence", options.turbulence, list(TURBULENCE_SEVERITY))
    _require("pilot", options.pilot, list(PILOTS))
    _require("log format", f".{options.log_format}", list(FORMATS))
    if options.seeds < 1 or (options.jobs is not None and options.jobs < 1):
        raise BadInputError("--seeds and --jobs count from 1")
    if not 0.0 <= options.wind_kt <= 100.0:
        raise BadInputError(f"--wind-kt {options.wind_kt:g}: the bench flies in 0 to 100 kt of wind")
    if not isfinite(options.wind_from_deg):
        raise BadInputError(f"--wind-from-deg {options.wind_from_deg:g}: give the direction in degrees, 0 to 360")
    wind = Wind(speed=options.wind_kt * KNOT, from_direction=options.wind_from_deg % 360.0 * DEGREE)
    base = replace(Case(), aircraft=options.aircraft, turbulence=options.turbulence, pilot=options.pilot, wind=wind)
    return CampaignRequest(
        maneuvers=options.maneuver,
        systems=options.das,
        models=options.model,
        seeds=options.seeds,
        base=base,
        options=CalibrationOptions(method=options.method),
        out=options.out or Path("out", _folder_name(options.maneuver, options.das)),
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
        console.print(f"failed: {text}", style="red", markup=False)
    console.print(f"results: {result.folder / RESULTS}", markup=False)
    console.print(f"report:  {result.folder / 'report.html'}", markup=False)
    return not result.failures


def _require(kind: str, value: str, known: list[str]) -> None:
    if value not in known:
        raise BadInputError(explain(kind, value, known))


def _folder_name(maneuver: str, das: str) -> str:
    return "-".join(re.sub(r"[^A-Za-z0-9_]+", "_", part) for part in (maneuver, das))
