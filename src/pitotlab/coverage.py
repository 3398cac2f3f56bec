"""Measure how often the bounds contain the truth, over flights with random truth and noise of
unknown level.
"""

from argparse import ArgumentParser
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from pathlib import Path

import numpy as np
import pandas as pd

from pitotbench import air
from pitotbench.bench.calibrations import DEFAULTS
from pitotbench.calibration import calibrate
from pitotbench.calibration.options import Accuracies, CalibrationOptions, options_from
from pitotbench.campaigns.flights import compare_curve, rms, scored, sense, wind_toward
from pitotbench.catalog import Catalog
from pitotbench.records import NoAnswerError
from pitotbench.records.calibration import Calibration
from pitotbench.records.flight import Flight
from pitotbench.records.log import FlightLog
from pitotbench.sensing.sampling import SYSTEMS
from pitotbench.simulation.maneuvers import PAPER_MANEUVERS
from pitotbench.simulation.sortie import fly
from pitotbench.units import KNOT, Array
from pitotlab import experiment as lab
from pitotlab.made import RESULTS, write_made
from pitotlab.tables import FIGURES, PAPER, write_figures

STATED = Accuracies(
    temperature_k=1.0, recovery_factor=0.02, static_pressure_pa=50.0, velocity_mps=0.1
)
SLOW_CHANGE = 1.0  # m/s rms in ten minutes

InWind = Callable[[Flight, int], tuple[Flight, Array]]
WithErrors = Callable[[FlightLog, int], FlightLog]


@dataclass(frozen=True, slots=True)
class Scoring:
    """One way to fly, sense and calibrate, for which the coverage is measured.

    `in_wind` takes a flight and a seed and returns the flight in a changed wind with its mean wind
    toward north and east [m/s]. `with_errors` takes a log and a seed and returns the log with
    sensor errors. `options` are those of the calibration.
    """

    name: str
    systems: tuple[str, ...]
    options: CalibrationOptions
    in_wind: InWind
    with_errors: WithErrors
    against_paper: bool = False


def steady(flight: Flight, seed: int) -> tuple[Flight, Array]:
    """Return the flight unchanged, in the wind of its case."""
    return flight, wind_toward(flight.case.wind)[:2]


def slow(flight: Flight, seed: int) -> tuple[Flight, Array]:
    """Return the flight in a wind that changes as a random walk."""
    moved, change = lab.in_walking_wind(flight, SLOW_CHANGE, seed)
    return moved, wind_toward(flight.case.wind)[:2] + change


def as_sensed(log: FlightLog, seed: int) -> FlightLog:
    """Return the log without further errors."""
    return log


def systematic(log: FlightLog, seed: int) -> FlightLog:
    """Return the log with constant errors drawn from the stated accuracies.

    Raises ValueError for a log without a temperature.
    """
    draw = 0.5 * np.random.default_rng([seed, 78]).standard_normal(5)
    if log.total_temperature is None:
        raise ValueError("a synthetic log has a total temperature")
    mach = air.mach_from_impact_pressure(log.impact_pressure, log.static_pressure)
    recovery = 0.2 * STATED.recovery_factor * draw[1] * mach**2 * log.total_temperature
    velocity = STATED.velocity_mps * draw[3:5]
    return replace(
        log,
        total_temperature=log.total_temperature + STATED.temperature_k * draw[0] + recovery,
        static_pressure=log.static_pressure + STATED.static_pressure_pa * draw[2],
        velocity_north=log.velocity_north + velocity[0],
        velocity_east=log.velocity_east + velocity[1],
    )


_AS_STATED = CalibrationOptions(accuracies=STATED)
_ALL = (
    Scoring("constant wind", tuple(SYSTEMS), CalibrationOptions(), steady, as_sensed, True),
    Scoring("command", tuple(SYSTEMS), options_from(DEFAULTS), steady, as_sensed),
    Scoring("systematic errors", tuple(SYSTEMS), _AS_STATED, steady, systematic),
    Scoring("slow wind", ("50/50",), CalibrationOptions(wind="drifting"), slow, as_sensed),
)
SCORINGS: Catalog[Scoring] = Catalog("scoring", {scoring.name: scoring for scoring in _ALL})
TURBULENCE = ("none", "light", "moderate")
# The tables of results by scoring.
COVERED = {
    "constant wind": "coverage, the paper's law",
    "command": "coverage, the command's defaults",
}


def score_trial(trial: lab.Trial, scorings: tuple[str, ...]) -> list[lab.Row]:
    """Fly a trial once; return a row for each scoring and data system."""
    flight = fly(lab.random_case(trial))
    log_of = cache(partial(_sensed, flight, trial.seed))  # scorings in one air share their logs
    return [row for name in scorings for row in _rows(trial, flight, SCORINGS[name], log_of)]


def _sensed(flight: Flight, seed: int, in_wind: InWind, system: str) -> FlightLog:
    return sense(in_wind(flight, seed)[0], system)


def _rows(
    trial: lab.Trial, flight: Flight, scoring: Scoring, log_of: Callable[[InWind, str], FlightLog]
) -> Iterator[lab.Row]:
    flown, wind = scoring.in_wind(flight, trial.seed)
    for system in scoring.systems:
        log = scoring.with_errors(log_of(scoring.in_wind, system), trial.seed)
        base = trial.cell | {"scoring": scoring.name, "das": system}
        as_published = CalibrationOptions(method="paper")
        try:
            ours = calibrate(log, scoring.options)
            paper = calibrate(log, as_published) if scoring.against_paper else ours
        except NoAnswerError as error:
            yield base | {"failed": str(error)}
            continue
        yield base | {"failed": ""} | _figures(flown, wind, ours, paper)


def _figures(flight: Flight, wind: Array, ours: Calibration, paper: Calibration) -> lab.Row:
    curve, truth, inside = ours.curve, flight.case.pressure_error, scored(ours.curve)
    found = compare_curve(curve, truth)
    return {
        **lab.compared(ours, truth, wind),
        "white_coverage": replace(found, two_sigma=curve.white_two_sigma[inside]).inside,
        "mean_error_kt": float(np.mean(found.error)) / KNOT,
        "paper_rms_error_kt": compare_curve(paper.curve, truth).rms_error / KNOT,
        "residual_two_sigma_kt": ours.residual_two_sigma / KNOT,
        "finite": bool(np.all(np.isfinite(found.two_sigma)) and np.all(found.two_sigma > 0.0)),
    }


def summarize(rows: pd.DataFrame) -> pd.DataFrame:
    """Return one line for each cell: shares [%] with their standard errors, errors and bounds [kt]."""
    good = rows[rows["failed"] == ""]
    groups = good.groupby(["scoring", "maneuver", "turbulence", "das"], sort=False)
    table = pd.DataFrame({"flights": groups.size()})
    for name in ("coverage", "band_coverage", "wind_coverage", "white_coverage"):
        table[f"{name}_percent"] = 100.0 * groups[name].mean()
    table["coverage_se_percent"] = 100.0 * groups["coverage"].sem()
    table["two_sigma_kt"] = groups["two_sigma_kt"].mean()
    for name in ("rms_error_kt", "paper_rms_error_kt"):
        table[name] = groups[name].apply(rms)
    table["bias_kt"] = groups["mean_error_kt"].mean()
    table["bias_over_se"] = groups["mean_error_kt"].mean() / groups["mean_error_kt"].sem()
    table["residual_two_sigma_kt"] = groups["residual_two_sigma_kt"].mean()
    return table.reset_index()


def verify(
    seeds: int,
    out: Path,
    budget: lab.Budget = lab.NO_LIMIT,
    scorings: Sequence[str] = tuple(SCORINGS),
    first: int = lab.FIRST_SCORED_SEED,
) -> pd.DataFrame:
    """Score up to `seeds` seeds of every cell, from `first` on, and write coverage.csv into `out`.

    A budget of 0 minutes flies nothing and writes the table from the kept rows.
    """
    cells = (PAPER_MANEUVERS, TURBULENCE, tuple(scorings))
    experiment = lab.Experiment(score_trial, *cells, "scoring")
    rows = lab.run_experiment(experiment, range(first, first + seeds), budget)
    _write(rows, out)
    return rows


def _write(rows: pd.DataFrame, out: Path) -> None:
    order = [*SCORINGS].index
    rows = rows.sort_values("scoring", key=lambda names: names.map(order), kind="stable")
    cells = summarize(rows)
    lab.write_table(cells, out / "coverage.csv", 6)
    failures = int((rows["failed"] != "").sum())
    print(f"{len(rows):,} calibrations, {failures} without an answer")
    for name, group in cells.groupby("scoring", sort=False):
        print(f"{name}: {_verdict(group)}")


def write_results(rows: pd.DataFrame, first: int, seeds: int) -> None:
    """Write the committed table, and of each scoring the numbers of the pages and how it was made."""
    lab.write_table(summarize(rows), RESULTS / "coverage.csv", 6)
    for scoring, made in COVERED.items():
        these = rows[(rows["scoring"] == scoring) & (rows["failed"] == "")]
        flown = these.groupby(["maneuver", "turbulence", "seed"])["coverage"].mean()
        flights = 100.0 * flown.to_numpy(float)
        mean, deviation = np.mean(flights), np.std(flights, ddof=1) / np.sqrt(len(flights))
        cells = summarize(these)
        share, error = cells.coverage_percent, cells.coverage_se_percent
        numbers = {
            "inside": f"{mean:.1f} ± {deviation:.1f}",
            "cells": f"{share.min():.1f} to {share.max():.1f}",
            "below": str(int((share + 3.0 * error < 95.0).sum())),
            "flights": str(cells.flights.min()),
        }
        write_figures({f"{scoring}, {name}": number for name, number in numbers.items()}, FIGURES)
        write_figures({f"{scoring}, inside": f"{mean:.1f}"}, PAPER)
        asked = f"--scorings '{scoring}' --first {first} --seeds {seeds}"
        write_made(made, seeds=f"{first} to {first + seeds - 1}", command=f"coverage {asked}")


def _verdict(cells: pd.DataFrame) -> str:
    share, band = cells.coverage_percent, cells.band_coverage_percent
    return (
        f"{cells.flights.min()} flights a cell, {share.min():.1f} to {share.max():.1f} % of the "
        f"curve over {len(cells)} cells, mean {share.mean():.1f}; whole curves inside their band "
        f"{band.min():.1f} to {band.max():.1f} %"
    )


def command(parser: ArgumentParser, words: Sequence[str]) -> None:
    """Fly the coverage campaign: every maneuver, data system and turbulence, seeds never used in
    development.

    Writes coverage.csv (one line a cell) and prints a line a scoring. About 25 CPU seconds a seed.
    """
    add = parser.add_argument
    add("--seeds", type=int, default=400, help="flights a cell (default: %(default)s)")
    add(
        "--first", type=int, default=lab.FIRST_SCORED_SEED, help="first seed (default: %(default)s)"
    )
    add("--scorings", default=",".join(SCORINGS), help="names, by commas (default: %(default)s)")
    add("--out", type=Path, default=lab.OUT, help="folder (default: %(default)s)")
    add(
        "--page", action="store_true", help="write the numbers of the pages, of all seeds asked for"
    )
    lab.add_budget(parser)
    options = parser.parse_args(words)
    names = [SCORINGS[name].name for name in options.scorings.split(",")]
    rows = verify(options.seeds, options.out, lab.budget_of(options), names, options.first)
    if options.page:
        write_results(rows, options.first, options.seeds)
