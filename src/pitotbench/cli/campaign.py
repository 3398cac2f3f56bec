"""`pitotbench campaign`: fly a campaign, and print the table of results and the failures."""

import argparse
import re
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from pitotbench.cli.shared_flags import (
    DONE,
    NO_ANSWER,
    flag,
    require_known,
    shared,
    stated_wind,
    tell,
)
from pitotbench.records import BadInputError
from pitotbench.simulation.maneuvers import MANEUVERS, PAPER_MANEUVERS

if TYPE_CHECKING:
    from pitotbench.campaigns.campaign import CampaignRequest


FLAGS = (
    flag(
        "plan",
        nargs="?",
        type=Path,
        metavar="PLAN.toml",
        help="plan of the campaign (docs/scale.md)",
    ),
    flag(
        "--maneuver",
        help=f"{', '.join(MANEUVERS)}, a comma list, all ({', '.join(PAPER_MANEUVERS)}) or every",
    ),
    flag("--das", help="20/1, 50/50, 100/100, any A/G in Hz, a comma list, or all"),
    flag(
        "--model",
        default="inverse+",
        help="model, comma list, auto, or all: inverse+, quadratic, linear, bias (default: "
        "%(default)s)",
    ),
    flag("--method", default="covering", help="covering or paper (default: %(default)s)"),
    flag("--turbulence", default="light", help="none, light or moderate (default: %(default)s)"),
    *shared("wind", "units"),
    flag("--pilot", default="none", help="none, good or busy (default: %(default)s)"),
    flag(
        "--aircraft",
        default="navajo",
        help="aircraft: a name, or the path of a JSBSim file or folder (default: %(default)s)",
    ),
    flag(
        "--seeds",
        default="1",
        help="flights of each maneuver: truth and sensor seeds 1 to N, or a range such as "
        "501-1000 (default: 1)",
    ),
    flag("--log-format", default="parquet", help="parquet, csv or mat (default: %(default)s)"),
    flag(
        "--out", type=Path, help="folder for the results (default: out/<maneuver>-<das> or <plan>)"
    ),
    # how a campaign runs, not what it flies
    flag("--jobs", type=int, help="processes (default: one a core)"),
    flag(
        "--scheduler",
        help="address of a dask scheduler, tcp://host:port or tls://host:port, instead of "
        "processes",
    ),
    flag(
        "--security",
        type=Path,
        metavar="FILE",
        help="TOML file with ca, cert and key for a tls:// scheduler",
    ),
    flag("--shard", metavar="K/N", help="fly the K-th of N parts of the plan"),
    flag(
        "--time-limit",
        type=float,
        default=900.0,
        metavar="S",
        help="seconds a flight may take (default: %(default)g)",
    ),
    flag(
        "--memory-limit",
        type=float,
        default=2.0,
        metavar="GB",
        help="memory of a flight (default: %(default)g GB)",
    ),
    flag(
        "--keep-logs",
        default="all",
        help="none, failed (logs that could not be calibrated) or all (default: all)",
    ),
    flag("--no-report", action="store_true", help="write tables and logs, but no page"),
    flag(
        "--retry-failed",
        action="store_true",
        help="fly the flights again that are stored as failed",
    ),
    flag(
        "--progress",
        default="auto",
        help="bar, lines (one a minute), json, none or auto (default: auto)",
    ),
    flag(
        "--dry-run",
        action="store_true",
        help="print what would be flown, the minutes and the bytes; fly nothing",
    ),
)


def run(options: argparse.Namespace) -> int:
    """Fly the campaign, print table and failures; return 0, or 3 if a flight or a fit failed."""
    from pitotbench.campaigns.campaign import PAGE, run_campaign
    from pitotbench.campaigns.result_table import RESULTS
    from pitotbench.show.campaign import campaign_tree
    from pitotbench.show.tree import Node, Sentence

    request = request_of(options)
    if options.dry_run:
        from pitotbench.campaigns.costs import forecast_of_costs

        for line in forecast_of_costs(request):
            print(line)
        return DONE
    result = run_campaign(request)
    stored = f"flights: {result.found:,} found in the store, {result.flown:,} flown"
    page = f"open this page: {result.folder / PAGE}"
    answers = [] if options.no_report else result.answers
    nodes: list[Node] = [
        *campaign_tree(result.table, answers, result.failures, result.drawn),
        *([Sentence(stored)] if result.found else []),
        Sentence(f"results: {result.folder / RESULTS}"),
        *([] if options.no_report else [Sentence(page)]),
    ]
    tell(options, dict, lambda: nodes)
    return NO_ANSWER if result.failures else DONE


def request_of(options: argparse.Namespace) -> "CampaignRequest":
    """Return the request of the parsed flags. Raises BadInputError for a senseless value."""
    from pitotbench.calibration.options import CalibrationOptions
    from pitotbench.campaigns.campaign import CampaignRequest
    from pitotbench.records.case import Case
    from pitotbench.simulation.sortie import scaled_case

    _check(options)
    base = replace(
        Case(),
        aircraft=options.aircraft,
        turbulence=options.turbulence,
        pilot=options.pilot,
        wind=stated_wind(options),
    )
    base = scaled_case(base)
    return CampaignRequest(
        maneuvers=options.maneuver or "",
        systems=options.das or "",
        models=options.model,
        seeds=options.seeds,
        base=base,
        options=CalibrationOptions(method=options.method),
        out=_folder(options),
        jobs=options.jobs,
        scheduler=options.scheduler,
        log_format=options.log_format,
        plan=options.plan,
        shard=_shard(options.shard),
        security=options.security,
        time_limit=options.time_limit,
        memory_limit=options.memory_limit,
        keep_logs=options.keep_logs,
        retry_failed=options.retry_failed,
        progress=options.progress,
        report=not options.no_report,
        units=options.units,
    )


def _check(options: argparse.Namespace) -> None:
    """Refuse unknown names, counts below one, and limits that are none."""
    from pitotbench.campaigns.campaign import STYLES
    from pitotbench.campaigns.plan_file import seeds_of
    from pitotbench.campaigns.task import KEEP_LOGS
    from pitotbench.logbook.formats import FORMATS
    from pitotbench.records.case import PILOTS, TURBULENCE_SEVERITY

    if options.plan is None and not (options.maneuver and options.das):
        raise BadInputError("give a plan file, or --maneuver and --das")
    if options.plan is not None and (options.maneuver or options.das):
        raise BadInputError(
            "a plan file names the maneuvers and the data systems; leave out --maneuver and --das"
        )
    names: dict[str, tuple[str, Iterable[str]]] = {
        "turbulence": (options.turbulence, TURBULENCE_SEVERITY),
        "pilot": (options.pilot, PILOTS),
        "log format": (f".{options.log_format}", FORMATS),
        "choice of logs": (options.keep_logs, KEEP_LOGS),
        "progress": (options.progress, STYLES),
    }
    for what, (name, known) in names.items():
        require_known(what, name, known)
    seeds_of(options.seeds)
    if options.jobs is not None and options.jobs < 1:
        raise BadInputError("--jobs counts from 1")
    if not (options.time_limit > 0 and options.memory_limit > 0):
        raise BadInputError("--time-limit and --memory-limit are above 0")


def _shard(text: str | None) -> tuple[int, int] | None:
    if text is None:
        return None
    try:
        part, parts = (int(number) for number in text.split("/"))
    except ValueError as error:
        raise BadInputError(f"--shard {text!r}: give K/N, such as 2/8") from error
    if not 1 <= part <= parts:
        raise BadInputError(f"--shard {text}: the part counts from 1 to {parts}")
    return part, parts


def _folder(options: argparse.Namespace) -> Path:
    """Return the folder of the results. Raises BadInputError where it cannot be made."""
    from pitotbench.records.outputs import require_folder

    name = (
        options.plan.stem
        if options.plan is not None
        else "-".join(
            re.sub(r"[^A-Za-z0-9_]+", "_", part) for part in (options.maneuver, options.das)
        )
    )
    out: Path = options.out or Path("out", name)
    if not out.name:
        raise BadInputError(
            "--out: a campaign replaces its folder as a whole; name a folder for its results alone"
        )
    require_folder(out)
    return out
