"""How each table of results was made."""

import csv
from dataclasses import dataclass
from pathlib import Path

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
