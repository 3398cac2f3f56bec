"""`pitotbench inspect`: what a log holds, and what can be learned from it."""

import argparse
from pathlib import Path

from pitotbench.cli.shared_flags import (
    asked_flags,
    flag,
    read_logs,
    require_page,
    shared,
    stated_facts,
    tell,
)
from pitotbench.records.calibration_request import FACTS, CalibrationRequest

FLAGS = (
    flag(
        "log",
        type=Path,
        metavar="LOG",
        help="log (.csv, .xlsx, .igc, .ulg, .bin, .mat, .parquet …), or a folder or .zip of logs",
    ),
    *asked_flags(CalibrationRequest, only=("mapping", "airspeed_sensor", *FACTS)),
    *shared("units", "json", "report"),
)


def run(options: argparse.Namespace) -> int:
    """Print the account of the log, and write its page where asked for; return exit code 0."""
    from pitotbench.bench.questions import inspect
    from pitotbench.logbook.bundle import is_bundle
    from pitotbench.records.outputs import file_name
    from pitotbench.show.inspection import (
        inspection_json,
        inspection_tree,
        summaries_json,
        summaries_tree,
    )

    require_page(options.report, [options.log])
    if is_bundle(options.log) and options.mapping is None:
        from pitotbench.bench.contents import flights_of

        flights = flights_of(options.log)
        if len(flights) > 1:
            tell(options, lambda: summaries_json(flights), lambda: summaries_tree(flights))
            return 0
    (log,) = read_logs(
        [options.log],
        options.mapping,
        airspeed_sensor=options.airspeed_sensor,
        facts=stated_facts(options),
    )
    found = inspect(log, options.mapping)
    tell(
        options,
        lambda: inspection_json(found),
        lambda: inspection_tree(found, log),
        f"What {file_name(options.log)} holds",
    )
    return 0
