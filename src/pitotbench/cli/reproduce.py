"""`pitotbench reproduce`: fly one stored result of a campaign again, and compare."""

import argparse
import sys
from dataclasses import asdict
from pathlib import Path

from pitotbench.cli.app import DONE, NO_ANSWER


def add(parser: argparse.ArgumentParser) -> None:
    """Add the flags of `pitotbench reproduce`."""
    parser.add_argument(
        "result",
        type=Path,
        metavar="RESULT",
        help="folder of a campaign and a flight, as out/circle-20_1/circle-seed1",
    )
    parser.add_argument("--json", action="store_true", help="print one JSON document")


def run(options: argparse.Namespace) -> int:
    """Fly the result again; return exit code 0 where every number is the same bit for bit, else 3."""
    from pitotbench.bench.result_table import reproduce
    from pitotbench.show.columns import json_text, printable

    found = reproduce(options.result)
    if options.json:
        sys.stdout.write(json_text(asdict(found)))
        return NO_ANSWER if found.differences else DONE
    for what in ("code", "aircraft", "versions", "host"):
        was, now = found.stored[what], found.here[what]
        print(printable(f"{what}: {was}" if was == now else f"{what}: {was} stored, {now} now"))
    for line in found.differences:
        print(printable(f"differs: {line}"))
    if not found.differences:
        print(printable(f"{found.name}: {found.rows} rows, the same bit for bit"))
    return NO_ANSWER if found.differences else DONE
