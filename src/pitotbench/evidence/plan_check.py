"""Compare forecasts with flights: fly the same maneuvers in simulated turbulence with many seeds and calibrate."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pandas as pd

from pitotbench import bench
from pitotbench.bench.plan.forecasting import forecast
from pitotbench.bench.plan.plan_request import PlanRequest
from pitotbench.bench.truth_comparison import compare_curve_at, rms
from pitotbench.calibrate import CalibrationOptions
from pitotbench.evidence.experiment import NO_LIMIT, Budget, Experiment, Row, Trial, made_with, run_experiment
from pitotbench.logbook import write_text
from pitotbench.records.case import Case
from pitotbench.simulate import MANEUVERS
from pitotbench.units import KNOT


def flown_experiment(turbulences: Sequence[str], systems: Sequence[str]) -> Experiment:
    """Return the experiment: every maneuver of a plan in each turbulence, calibrated for every system."""
    return Experiment(flown_bounds, tuple(MANEUVERS), tuple(turbulences), tuple(systems), "das")


def flown_bounds(trial: Trial, systems: tuple[str, ...]) -> list[Row]:
    """Fly a maneuver of a plan and calibrate the log of every system; return a row for each system.

    Columns: maneuver, turbulence, das, seed, minutes, two_sigma_kt (mean over the wanted speeds), error_kt (true
    rms error) and coverage (share of the speeds inside 2σ).
    """
    request = PlanRequest(Case(turbulence=trial.turbulence))
    case = replace(request.case(trial.maneuver), turbulence=trial.turbulence)
    flight = bench.fly(replace(case, truth_seed=trial.seed, sensor_seed=trial.seed))
    rows: list[Row] = []
    for system in systems:
        curve = bench.calibrate(bench.sense(flight, system), CalibrationOptions()).curve
        found = compare_curve_at(curve, case.pressure_error, request.airspeeds)
        rows.append(
            {
                "maneuver": trial.maneuver,
                "turbulence": trial.turbulence,
                "das": system,
                "seed": trial.seed,
                "minutes": flight.duration / 60.0,
                "two_sigma_kt": found.mean_two_sigma / KNOT,
                "error_kt": found.rms_error / KNOT,
                "coverage": found.inside,
            }
        )
    return rows


def compare_bounds(request: PlanRequest, flown: pd.DataFrame) -> pd.DataFrame:
    """Return predicted and flown bounds, one row for each maneuver and system.

    Columns: maneuver, turbulence, das, flights, minutes, predicted_kt, flown_kt, flown_se_kt (standard error),
    ratio, error_kt (rms over flights), coverage.
    """
    groups = flown.groupby(["maneuver", "das"], sort=False)
    table = groups.agg(
        flights=("seed", "size"),
        minutes=("minutes", "mean"),
        flown_kt=("two_sigma_kt", "mean"),
        flown_se_kt=("two_sigma_kt", "sem"),
        error_kt=("error_kt", rms),
        coverage=("coverage", "mean"),
    ).reset_index()
    table["predicted_kt"] = [
        forecast(replace(request, system=str(das)), str(name)).mean / KNOT
        for name, das in zip(table.maneuver, table.das, strict=True)
    ]
    return table.assign(turbulence=request.base.turbulence, ratio=table.predicted_kt / table.flown_kt)


def check_plan(
    turbulences: Sequence[str],
    systems: Sequence[str],
    seeds: int,
    out: Path,
    budget: Budget = NO_LIMIT,
    heights: pd.DataFrame | None = None,
) -> pd.DataFrame:
    """Fly the trials that the budget's rows lack, compare, and write plan.md and plan.png into `out`.

    `heights` is the table of `height_check.check_height`, for a section of the page.
    """
    from pitotbench.evidence.pages.plan_check_page import (  # it loads the drawing library
        add_reference,
        check_page,
        check_picture,
    )

    flown = run_experiment(flown_experiment(turbulences, systems), range(1, seeds + 1), budget)
    requests = {name: PlanRequest(Case(turbulence=name)) for name in turbulences}
    parts = [compare_bounds(request, flown[flown.turbulence == name]) for name, request in requests.items()]
    table = add_reference(pd.concat(parts, ignore_index=True))
    out.mkdir(parents=True, exist_ok=True)
    check_picture(table, out / "plan.png")
    write_text(out / "plan.md", check_page(table, _provenance(table), heights))
    return table


def _provenance(table: pd.DataFrame) -> str:
    draws = PlanRequest(Case()).draws
    return (
        f"{table.flights.min()} to {table.flights.max()} flights a cell (seeds from 1), {draws} draws a forecast;\n"
        f"{made_with()}.\n"
        "`python scripts/check_plan.py` repeats it."
    )
