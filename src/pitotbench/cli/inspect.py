"""`pitotbench inspect`: what a log holds, and what can be learned from it."""

import argparse
import sys
from pathlib import Path

from pitotbench.cli.shared_flags import add_mapping, mapping_advice, read_logs


def add(parser: argparse.ArgumentParser) -> None:
    """Add the flags of `pitotbench inspect`."""
    parser.add_argument("log", type=Path, metavar="LOG", help="log file (.csv, .parquet, .mat, .ulg, .bin, .igc)")
    add_mapping(parser)
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    parser.add_argument("--report", type=Path, help="also write a page with pictures (HTML)")


def run(options: argparse.Namespace) -> int:
    """Print the account of the log, and write its page where asked for; return exit code 0."""
    from rich.console import Console

    from pitotbench.bench.inspection import inspect_log
    from pitotbench.calibration.options import options_from
    from pitotbench.logbook.formats import PAGES, require_file
    from pitotbench.show.columns import json_text, outside
    from pitotbench.show.inspection import inspection_json, print_inspection

    if options.report is not None:
        require_file(options.report, PAGES, [options.log])
    (log,) = read_logs([options.log], options.mapping)
    found = inspect_log(log, options_from(mapping_advice(options, [log])))
    if options.report is not None:
        from pitotbench.logbook.columns import write_text
        from pitotbench.show.pages import inspection_page

        write_text(options.report, inspection_page(options.log.name, log, found))
    if options.json:
        sys.stdout.write(json_text(inspection_json(found)))
        return 0
    console = Console(highlight=False, soft_wrap=True)
    console.print(outside(options.log.name, "bold"))
    print_inspection(found, console)
    return 0
