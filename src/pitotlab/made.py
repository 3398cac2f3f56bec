"""How each table of results was made."""

import csv
import subprocess
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from pitotbench.logbook.columns import atomic

RESULTS = Path(__file__).parent / "results"
TABLES = RESULTS / "tables.csv"


@dataclass(frozen=True, slots=True)
class Made:
    """How a table was made: the rows of the page that it stands behind, build, date, seeds, command."""

    table: str
    rows: str
    build: str
    date: str
    seeds: str
    command: str


def read_made() -> list[Made]:
    """Return how each table of results was made."""
    with TABLES.open(encoding="utf-8", newline="") as file:
        return [Made(**row) for row in csv.DictReader(file)]


def write_made(table: str, **changes: str) -> None:
    """State that a table was made anew by this build today, with what else of it changed."""
    today = {"build": said_by_git("rev-parse", "--short=8", "HEAD")}
    today["date"] = f"{datetime.now(UTC):%Y-%m-%d}"
    rows = [replace(m, **today, **changes) if m.table == table else m for m in read_made()]
    write_rows(TABLES, rows)


def said_by_git(*words: str) -> str:
    """Return what git says in the checkout, or nothing where there is none."""
    done = subprocess.run(
        ["git", *words], cwd=RESULTS, capture_output=True, encoding="utf-8", check=False
    )
    return done.stdout.strip()


def write_rows(path: Path, rows: Sequence[Any]) -> None:
    """Write records of one kind as CSV, a column a field."""
    with atomic(path) as scratch, scratch.open("w", encoding="utf-8", newline="") as file:
        table = csv.DictWriter(file, [f.name for f in fields(rows[0])], lineterminator="\n")
        table.writeheader()
        table.writerows(map(asdict, rows))
