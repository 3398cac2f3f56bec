"""The command of `scripts/verify_aircraft.py`: fly, summarize, write, print."""

from pathlib import Path

from pitotbench.evidence.bounds.aircraft_flights import fly_foreign, summarize_foreign, time_first_flight
from pitotbench.evidence.experiment import Budget
from pitotbench.evidence.pages.aircraft_tables import first_flights_table, foreign_table
from pitotbench.logbook import atomic


def verify_aircraft(seeds: range, names: tuple[str, ...], budget: Budget, out: Path) -> str:
    """Fly airplanes, write aircraft-flights.csv into `out`, and return the table (Markdown) and each failure."""
    rows = fly_foreign(seeds, names, budget)
    table = summarize_foreign(rows)
    out.mkdir(parents=True, exist_ok=True)
    with atomic(out / "aircraft-flights.csv") as scratch:
        table.to_csv(scratch, index=False, float_format="%.4f", lineterminator="\n")
    failed = rows[rows["failed"] != ""].itertuples()
    return "\n".join([foreign_table(table), *(f"{r.aircraft} {r.maneuver} {r.seed}: {r.failed}" for r in failed)])


def time_first_flights(names: tuple[str, ...]) -> str:
    """Return the times (Markdown) from the path of an aircraft file to its first recorded flight."""
    return first_flights_table([time_first_flight(name) for name in names])
