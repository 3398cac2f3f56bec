"""The experiment engine: measure cells × seeds × reductions into one table of rows, which is saved as it
grows.

A cell is a maneuver in one turbulence. Every cell is flown once with every seed. A reduction is one way
to sense and calibrate a flight, and each flight has several reductions. Saved rows are not measured
again, so that an interrupted experiment can be continued. The truth of a trial is drawn from its
seed: a wind and a pressure error.
"""

from argparse import ArgumentParser, Namespace
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import partial
from importlib.metadata import version
from itertools import chain, product
from pathlib import Path
from time import monotonic

import numpy as np
import pandas as pd

from pitotbench.campaigns.fleet import open_fleet, require_all
from pitotbench.campaigns.flights import compare_curve, compare_wind, scored
from pitotbench.campaigns.progress import progress
from pitotbench.logbook.columns import atomic
from pitotbench.records.calibration import Calibration
from pitotbench.records.case import Case, PressureErrorSpec, Wind
from pitotbench.records.flight import Flight
from pitotbench.units import KNOT, Array

OUT = Path("out", "lab")  # where measurements are written unless told otherwise
Row = dict[str, object]
WALK_TIME = 600.0  # s
_SEEDS_A_ROUND = 2  # the rows are saved and the time is checked after this many seeds of every cell


@dataclass(frozen=True, slots=True)
class Trial:
    """One flight of an experiment: its cell (maneuver and turbulence) and its seed."""

    maneuver: str
    turbulence: str
    seed: int

    @property
    def cell(self) -> Row:
        """The columns of the trial in each of its rows."""
        return {"maneuver": self.maneuver, "turbulence": self.turbulence, "seed": self.seed}


Task = tuple[Trial, tuple[str, ...]]  # a trial and the reductions to measure


@dataclass(frozen=True, slots=True)
class Experiment:
    """The cells and the reductions of an experiment.

    `measure(trial, reductions)` flies a trial once and returns its rows, one or more for each reduction. A
    row has the columns `maneuver`, `turbulence` and `seed` of the trial, and the reduction in the column
    named `reduction_column`.
    """

    measure: Callable[[Trial, tuple[str, ...]], Sequence[Row]]
    maneuvers: tuple[str, ...]
    turbulences: tuple[str, ...]
    reductions: tuple[str, ...]
    reduction_column: str

    def trials(self, seeds: Sequence[int]) -> list[Trial]:
        """Return all trials, seed by seed, so that each cell has had equally many at any time."""
        every = product(seeds, self.maneuvers, self.turbulences)
        return [Trial(name, air, seed) for seed, name, air in every]


@dataclass(frozen=True, slots=True)
class Budget:
    """The resources of an experiment.

    They are the number of processes (None: one for each core), the minutes (None: no limit), and a
    Parquet file of the rows measured before by the same code (None: no rows are saved).
    """

    jobs: int | None = None
    minutes: float | None = None
    rows: Path | None = None

    def rounds(self, seeds: Sequence[int]) -> Iterator[Sequence[int]]:
        """Return the seeds in rounds: one, where no rows are saved and the time has no limit."""
        limited = self.minutes is not None or self.rows is not None
        count = _SEEDS_A_ROUND if limited else max(len(seeds), 1)
        return (seeds[begin : begin + count] for begin in range(0, len(seeds), count))


NO_LIMIT = Budget()


def run_experiment(
    experiment: Experiment, seeds: Sequence[int], budget: Budget = NO_LIMIT
) -> pd.DataFrame:
    """Measure every reduction of every cell with every seed; return the rows of the experiment, the
    saved ones included.

    The experiment ends after the round in which the time is over, and returns complete seeds only.
    With 0 minutes it returns saved rows alone. Raises the first error of a trial; the rows of
    earlier rounds are saved.
    """
    table, begun = _kept(budget.rows), monotonic()
    total = len(experiment.trials(seeds))
    with open_fleet(budget.jobs, tasks=total) as fleet, progress("flights", total) as step:
        for some in budget.rounds(seeds):
            trials = experiment.trials(some)
            tasks = _missing(experiment, trials, table)
            for _ in range(len(trials) - len(tasks)):
                step()
            measured = require_all(fleet.perform(partial(_measured, experiment), tasks, step))
            table = _with_rows(table, [*chain.from_iterable(measured)], budget.rows)
            if budget.minutes is not None and monotonic() - begun > 60.0 * budget.minutes:
                break
    return _asked(experiment, seeds, table)


def _measured(experiment: Experiment, task: Task) -> Sequence[Row]:
    return experiment.measure(*task)


def _missing(experiment: Experiment, trials: Sequence[Trial], table: pd.DataFrame) -> list[Task]:
    """Return the trials with missing rows, each with the reductions that the table has no rows of."""
    columns = ["maneuver", "turbulence", "seed", experiment.reduction_column]
    known = set(table[columns].itertuples(index=False, name=None)) if len(table) else set()
    tasks = []
    for trial in trials:
        cell = (*trial.cell.values(),)
        lacking = tuple(each for each in experiment.reductions if (*cell, each) not in known)
        tasks += [(trial, lacking)] if lacking else []
    return tasks


def _kept(path: Path | None) -> pd.DataFrame:
    return pd.read_parquet(path) if path is not None and path.exists() else pd.DataFrame()


def _with_rows(table: pd.DataFrame, rows: Sequence[Row], path: Path | None) -> pd.DataFrame:
    """Return the table with more rows added, and save it where a file is given."""
    if not rows:
        return table
    new = pd.DataFrame(list(rows))
    table = pd.concat([table, new], ignore_index=True) if len(table) else new
    if path is not None:
        path.parent.mkdir(parents=True, exist_ok=True)
        with atomic(path) as scratch:
            table.to_parquet(scratch)
    return table


def _asked(experiment: Experiment, seeds: Sequence[int], table: pd.DataFrame) -> pd.DataFrame:
    """Return the rows of an experiment among all rows of a file."""
    if not len(table):
        return table
    wanted = {
        "maneuver": experiment.maneuvers,
        "turbulence": experiment.turbulences,
        experiment.reduction_column: experiment.reductions,
        "seed": seeds,
    }
    asked = [table[column].isin(list(values)) for column, values in wanted.items()]
    return table[np.all(asked, axis=0)]


def in_walking_wind(flight: Flight, rms: float, seed: int) -> tuple[Flight, Array]:
    """Return the flight in a wind that changes as a random walk, and the mean change north and east
    [m/s].

    `rms` is the change after ten minutes [m/s]. The airplane flies relative to the air, so its ground
    velocity changes with the wind.
    """
    elapsed = flight["time"] - flight["time"][0]
    steps = np.random.default_rng([seed, 79]).standard_normal((2, int(elapsed[-1]) + 2))
    walk = np.cumsum(steps, axis=1) * rms / np.sqrt(2.0 * WALK_TIME)
    change = np.stack([np.interp(elapsed, np.arange(walk.shape[1]), part) for part in walk])
    names = ("velocity_north", "velocity_east")
    moved = {name: flight[name] + part for name, part in zip(names, change, strict=True)}
    return replace(flight, channels={**flight.channels, **moved}), change.mean(axis=1)


def compared(found: Calibration, truth: PressureErrorSpec, wind: Array) -> Row:
    """Return the shares of curve, band and wind inside 2σ, the 2σ and the error [kt]."""
    curve = compare_curve(found.curve, truth)
    band = replace(curve, two_sigma=found.curve.simultaneous_two_sigma[scored(found.curve)])
    return {
        "coverage": curve.inside,
        "band_coverage": float(band.inside == 1.0),
        "wind_coverage": compare_wind(found.known_wind, wind).inside,
        "two_sigma_kt": curve.mean_two_sigma / KNOT,
        "rms_error_kt": curve.rms_error / KNOT,
    }


def write_table(table: pd.DataFrame, path: Path, digits: int) -> None:
    """Write a table of measured numbers as CSV."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with atomic(path) as scratch:
        table.to_csv(scratch, index=False, float_format=f"%.{digits}f", lineterminator="\n")


def made_with() -> str:
    """Return the versions and the date, for a page of measured numbers."""
    return (
        f"pitotbench {version('pitotbench')}, JSBSim {version('jsbsim')}, "
        f"{datetime.now(UTC):%Y-%m-%d}"
    )


FIRST_SCORED_SEED = 100_001  # development uses only seeds below this one
STRONGEST_WIND = 25.0 * KNOT
# The parameters of the error curve: those of the default curve, and their standard deviations.
CENTER = np.array(PressureErrorSpec().parameters)
SPREAD = np.array([0.03, 0.004, 0.03])
_CALM_FLIGHTS = 20


def random_parameters(rng: np.random.Generator) -> Array:
    """Draw the parameters of an Inverse+ error curve, (3,)."""
    return np.asarray(CENTER + SPREAD * rng.standard_normal(3))


def random_case(trial: Trial) -> Case:
    """Return the case of a trial, with its wind and its pressure error drawn from the seed.

    In calm air 20 flights in different winds are reused: only the sensor noise and the pressure
    error are new.
    """
    flown = trial.seed
    if trial.turbulence == "none":
        flown = FIRST_SCORED_SEED + (trial.seed - FIRST_SCORED_SEED) % _CALM_FLIGHTS
    rng = np.random.default_rng([trial.seed, 77])
    # The wind of the flight comes from the seed that is flown, below. This draw is not used: it
    # takes the first two numbers of the stream, so that the parameters are those with which the
    # committed campaign was flown.
    _random_wind(rng)
    parameters = tuple(float(k) for k in random_parameters(rng))
    return Case(
        maneuver=trial.maneuver,
        turbulence=trial.turbulence,
        wind=_random_wind(np.random.default_rng([flown, 77])),
        pressure_error=PressureErrorSpec(parameters=parameters),
        truth_seed=flown,
        sensor_seed=trial.seed,
    )


def _random_wind(rng: np.random.Generator) -> Wind:
    """Draw a wind of any direction, distributed evenly over a disk of velocities."""
    speed, direction = STRONGEST_WIND * np.sqrt(rng.uniform()), rng.uniform(0.0, 2.0 * np.pi)
    return Wind(speed=float(speed), from_direction=float(direction))


def add_budget(parser: ArgumentParser) -> None:
    """Add the flags of a budget to a command."""
    add = parser.add_argument
    add("--jobs", type=int, help="processes (default: one a core)")
    add("--minutes", type=float, help="stop after so many minutes, with whole seeds only")
    add("--rows", type=Path, help="Parquet file of rows measured before (delete it with a change)")


def budget_of(options: Namespace) -> Budget:
    """Return the budget that the flags of a command ask for."""
    return Budget(options.jobs, options.minutes, options.rows)
