"""What every set of flights with a hidden truth needs: its seeds, intervals of counts, and rows in a
file that survive a stop.

Nothing here knows the product: the independent generator uses it too.
"""

import csv
from argparse import ArgumentParser
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, fields
from pathlib import Path
from typing import TypeVar

from scipy.stats import binomtest

DEVELOPMENT_BELOW, SCORED_FROM = 50_000, 600_000
AnyRow = TypeVar("AnyRow")


def seeds_of(parser: ArgumentParser, words: str) -> range:
    """Return the seeds A to B − 1 of `A:B`, all of development or all scored.

    Ends the command where they are not.
    """
    first, _, behind = words.partition(":")
    if not (first.isdigit() and behind.isdigit() and int(first) < int(behind)):
        parser.error(f"--seeds {words!r}: give two whole numbers, such as 1000:1008")
    seeds = range(int(first), int(behind))
    if seeds[-1] >= DEVELOPMENT_BELOW and seeds[0] < SCORED_FROM:
        parser.error(
            f"seeds {seeds[0]} to {seeds[-1]}: stay below {DEVELOPMENT_BELOW} (development) or begin "
            f"at {SCORED_FROM} or above (scored)"
        )
    return seeds


def wilson(hits: int, cases: int) -> tuple[float, float]:
    """Return the 95 % interval of a share (Wilson 1927); from 0 to 1 without cases."""
    if not cases:
        return 0.0, 1.0
    found = binomtest(hits, cases).proportion_ci(method="wilson")
    return float(found.low), float(found.high)


def read_rows(path: Path, kind: type[AnyRow]) -> list[AnyRow]:
    """Return the rows of a file, none where there is no file; a row that breaks off is cut from it.

    Raises ValueError for a file with other columns.
    """
    if not path.exists():
        return []
    whole = path.read_bytes()
    kept = whole[: whole.rfind(b"\n") + 1]
    if kept != whole:
        path.write_bytes(kept)
    columns = fields(kind)  # type: ignore[arg-type]
    lines = list(csv.reader(kept.decode("utf-8").splitlines()))
    if lines and lines[0] != [field.name for field in columns]:
        raise ValueError(f"{path} has other columns than are written now: give another --out")
    return [
        kind(*(field.type(cell) for field, cell in zip(columns, line, strict=True)))  # type: ignore[operator]
        for line in lines[1:]
    ]


@contextmanager
def append_to(path: Path, kind: type[AnyRow]) -> Iterator[Callable[[AnyRow], None]]:
    """Yield what appends a row to a file; a new file gets a line of names first."""
    with path.open("a", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        if not file.tell():
            writer.writerow([field.name for field in fields(kind)])  # type: ignore[arg-type]

        def append(row: AnyRow) -> None:
            cells = asdict(row).values()  # type: ignore[call-overload]
            writer.writerow(" ".join(str(cell).split()) for cell in cells)
            file.flush()

        yield append
