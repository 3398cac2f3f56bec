"""`pitotbench campaign`: fly a campaign, and print the table of results and the failures."""

import argparse
import re
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from pitotbench.cli.exit_codes import DONE, NO_ANSWER
from pitotbench.cli.shared_flags import add_wind, stated_wind
from pitotbench.records.errors import BadInputError

if TYPE_CHECKING:
    from pitotbench.bench.campaign.runner import CampaignRequest

_TABLE_WIDTH = 140  # columns of text, so that the lines of the campaign's table are never folded


def add(parser: argparse.ArgumentParser) -> None:
    """Add the flags of `pitotbench campaign`."""
    from pitotbench.simulate.maneuvers import MANEUVERS, PAPER_MANEUVERS

    parser.add_argument(
        "--maneuver",
        required=True,
        help=f"{', '.join(MANEUVERS)}, a comma list, all ({', '.join(PAPER_MANEUVERS)}) or every",
    )
    parser.add_argument("--das", required=True, help="20/1, 50/50, 100/100, any A/G in Hz, a comma list, or all")
    parser.add_argument(
        "--model",
        default="inverse+",
        help="model, comma list, auto, or all: inverse+, quadratic, linear, bias (default: %(default)s)",
    )
    parser.add_argument("--method", default="covering", help="covering or paper (default: %(default)s)")
    parser.add_argument("--turbulence", default="light", help="none, light or moderate (default: %(default)s)")
    add_wind(parser)
    parser.add_argument("--pilot", default="none", help="none, good or busy (default: %(default)s)")
    parser.add_argument("--aircraft", default="navajo", help="aircraft to fly (default: %(default)s)")
    parser.add_argument(
        "--seeds", type=int, default=1, help="flights of each maneuver: truth and sensor seeds 1 to N (default: 1)"
    )
    parser.add_argument("--jobs", type=int, help="processes (default: one a core)")
    parser.add_argument(
        "--scheduler", help="address of a dask scheduler, tcp://host:port, whose workers see the folder of --out"
    )
    parser.add_argument("--log-format", default="parquet", help="parquet, csv or mat (default: %(default)s)")
    parser.add_argument("--no-report", action="store_true", help="write tables and logs, but no page")
    parser.add_argument("--out", type=Path, help="folder for the results (default: out/<maneuver>-<das>)")


def run(options: argparse.Namespace) -> int:
    """Fly the campaign, print its table and the failures; return exit code 0, or 3 where a flight or fit failed."""
    from rich.console import Console

    from pitotbench.bench.campaign.results_folder import RESULTS
    from pitotbench.bench.campaign.runner import run_campaign
    from pitotbench.show.campaign_table import print_campaign
    from pitotbench.show.terminal import outside

    result = run_campaign(request_of(options))
    console = Console(highlight=False, soft_wrap=True)
    console.width = max(console.width, _TABLE_WIDTH)
    print_campaign(result.table, console)
    for text in result.failures:
        console.print(outside(f"failed: {text}", "red"))
    console.print(outside(f"results: {result.folder / RESULTS}"))
    if not options.no_report:
        console.print(outside(f"report:  {result.folder / 'report.html'}"))
    return NO_ANSWER if result.failures else DONE


def request_of(options: argparse.Namespace) -> "CampaignRequest":
    """Return the request of the parsed flags. Raises BadInputError for a value that makes no sense."""
    from pitotbench.bench.campaign.runner import CampaignRequest
    from pitotbench.calibrate.options import CalibrationOptions
    from pitotbench.records.case import Case

    _check(options)
    wind = stated_wind(options)
    base = replace(Case(), aircraft=options.aircraft, turbulence=options.turbulence, pilot=options.pilot, wind=wind)
    return CampaignRequest(
        maneuvers=options.maneuver,
        systems=options.das,
        models=options.model,
        seeds=options.seeds,
        base=base,
        options=CalibrationOptions(method=options.method),
        out=_folder(options),
        jobs=options.jobs,
        scheduler=options.scheduler,
        log_format=options.log_format,
        report=not options.no_report,
    )


def _check(options: argparse.Namespace) -> None:
    """Refuse unknown names and counts below one."""
    from pitotbench.logbook import FORMATS
    from pitotbench.records.case import PILOTS, TURBULENCE_SEVERITY

    _require("turbulence", options.turbulence, list(TURBULENCE_SEVERITY))
    _require("pilot", options.pilot, list(PILOTS))
    _require("log format", f".{options.log_format}", list(FORMATS))
    if options.seeds < 1 or (options.jobs is not None and options.jobs < 1):
        raise BadInputError("--seeds and --jobs count from 1")


def _require(kind: str, value: str, known: list[str]) -> None:
    from pitotbench.catalog import explain

    if value not in known:
        raise BadInputError(explain(kind, value, known))


def _folder(options: argparse.Namespace) -> Path:
    """Return the folder of the results. Raises BadInputError where it cannot be made."""
    from pitotbench.logbook.outputs import require_folder

    out: Path = options.out or Path("out", _folder_name(options.maneuver, options.das))
    if not out.name:
        raise BadInputError("--out: a campaign replaces its folder as a whole; name a folder for its results alone")
    require_folder(out)
    return out


def _folder_name(maneuver: str, das: str) -> str:
    return "-".join(re.sub(r"[^A-Za-z0-9_]+", "_", part) for part in (maneuver, das))
