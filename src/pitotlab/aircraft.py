"""Fly airplanes that the bench did not write: how well they fly, and how often the bound holds the
truth.
"""

from argparse import ArgumentParser
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pitotbench.calibration import calibrate
from pitotbench.campaigns.flights import rms, sense, wind_toward
from pitotbench.records import BadInputError, NoAnswerError
from pitotbench.show.columns import Column
from pitotbench.simulation.aircraft import find_aircraft
from pitotbench.simulation.aircraft_files import read_record
from pitotbench.simulation.maneuvers import MANEUVERS, PAPER_MANEUVERS
from pitotbench.simulation.sortie import fly, scaled_case
from pitotlab import experiment as lab
from pitotlab.tables import markdown_table

FOREIGN = ("c172x", "pa28", "J3Cub", "c310", "DHC6", "pc7", "T38", "B747", "aerosonde")
SYSTEM = "20/1"


def fly_foreign(
    seeds: range, aircraft: tuple[str, ...] = FOREIGN, budget: lab.Budget = lab.NO_LIMIT
) -> pd.DataFrame:
    """Fly airplanes through the paper's five maneuvers in light turbulence, one flight a seed;
    return the rows.

    Wind and pressure error are drawn from the seed as for the coverage campaign, the error scaled
    to the card of the airplane. A flight that fails is a row with the reason.
    """
    experiment = lab.Experiment(_flown, PAPER_MANEUVERS, ("light",), aircraft, "aircraft")
    return lab.run_experiment(experiment, seeds, budget)


def _flown(trial: lab.Trial, airplanes: tuple[str, ...]) -> list[lab.Row]:
    return [_flown_by(trial, name) for name in airplanes]


def _flown_by(trial: lab.Trial, aircraft: str) -> lab.Row:
    row = trial.cell | {"aircraft": aircraft}
    try:
        case = scaled_case(replace(lab.random_case(trial), aircraft=aircraft))
        flight = fly(case)
        found = calibrate(sense(flight, SYSTEM))
    except (BadInputError, NoAnswerError) as error:
        return row | {"failed": " ".join(str(error).split())}
    judged = np.char.startswith(flight.segment, MANEUVERS[trial.maneuver].kind)
    on_condition = float(flight.on_condition[judged].mean())
    times = {"minutes": flight.duration / 60.0, "on_condition": on_condition}
    wind = wind_toward(case.wind)[:2]
    return row | {"failed": "", **times, **lab.compared(found, case.pressure_error, wind)}


def summarize_foreign(rows: pd.DataFrame) -> pd.DataFrame:
    """Return one line an airplane and maneuver, and one for all maneuvers: shares [%], minutes,
    errors [kt].

    The standard error of the coverage takes flights as independent.
    """
    every = pd.concat([rows, rows.assign(maneuver="all")])
    groups = every.groupby(["aircraft", "maneuver"], sort=False)
    good = every[every["failed"] == ""].groupby(["aircraft", "maneuver"], sort=False)
    table = pd.DataFrame({"flights": groups.size()})
    table["failed"] = groups["failed"].apply(lambda said: int((said != "").sum()))
    table["minutes"] = good["minutes"].mean()
    for name in ("on_condition", "coverage", "band_coverage", "wind_coverage"):
        table[f"{name}_percent"] = 100.0 * good[name].mean()
    table["least_on_condition_percent"] = 100.0 * good["on_condition"].min()
    table["coverage_se_percent"] = 100.0 * good["coverage"].sem()
    table["two_sigma_kt"] = good["two_sigma_kt"].mean()
    table["rms_error_kt"] = good["rms_error_kt"].apply(rms)
    return table.reset_index()


def speeds_of(aircraft: str) -> str:
    """Return the kind of an airplane's engines and the speeds of its envelope, for a table."""
    found = read_record(find_aircraft(aircraft))
    if found is None:
        return "the bench's own"
    limit = "Mach 0.7" if found.mach_limited else "level"
    speeds = f"{found.stall_kt:.0f} to {found.fastest_kt:.0f} KCAS ({limit})"
    return f"{found.engines} × {found.engine_kind}, {speeds}"


_FLOWN: tuple[Column[Any], ...] = (
    Column("airplane", lambda row: f"`{row.aircraft}`"),
    Column("engines and speeds", lambda row: speeds_of(row.aircraft)),
    Column("flights", lambda row: str(row.flights)),
    Column("without an answer", lambda row: str(row.failed)),
    Column("on condition, mean [%]", lambda row: f"{row.on_condition_percent:.1f}"),
    Column("the worst flight [%]", lambda row: f"{row.least_on_condition_percent:.0f}"),
    Column(
        "curve inside [%]",
        lambda row: f"{row.coverage_percent:.1f} ± {row.coverage_se_percent:.1f}",
    ),
    Column("mean 2σ [kt]", lambda row: f"{row.two_sigma_kt:.2f}"),
    Column("rms error [kt]", lambda row: f"{row.rms_error_kt:.2f}"),
)


def verify_aircraft(seeds: range, names: tuple[str, ...], budget: lab.Budget, out: Path) -> str:
    """Fly airplanes, write aircraft-flights.csv into `out`; return the table and each failure."""
    rows = fly_foreign(seeds, names, budget)
    table = summarize_foreign(rows)
    lab.write_table(table, out / "aircraft-flights.csv", 4)
    failed = rows[rows["failed"] != ""].itertuples()
    flown = markdown_table(_FLOWN, list(table[table["maneuver"] == "all"].itertuples()))
    return "\n".join([flown, *(f"{r.aircraft} {r.maneuver} {r.seed}: {r.failed}" for r in failed)])


def command(parser: ArgumentParser, words: Sequence[str]) -> None:
    """Fly airplanes of JSBSim's library: how well they fly, how often the bound holds the truth.

    Writes aircraft-flights.csv and prints its table. About 80 CPU seconds a seed.
    """
    add = parser.add_argument
    add("--seeds", type=int, default=20, help="flights of each maneuver (default: %(default)s)")
    add("--first", type=int, default=40_001, help="first seed (default: %(default)s, development)")
    add("--aircraft", default=",".join(FOREIGN), help="comma list (default: %(default)s)")
    add("--out", type=Path, default=lab.OUT, help="folder (default: %(default)s)")
    lab.add_budget(parser)
    options = parser.parse_args(words)
    names = tuple(options.aircraft.split(","))
    seeds = range(options.first, options.first + options.seeds)
    print(verify_aircraft(seeds, names, lab.budget_of(options), options.out))
