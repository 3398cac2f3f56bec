"""Measure on simulated flights how much the altitude equation narrows the bound, and whether a plan foresees it.

The error is the static source's. The receiver stands alone: its height has a white error of 0.3 m and a slow one of
2 m over 90 s, and its velocity 0.05 m/s, once a second.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pandas as pd

from pitotbench import bench
from pitotbench.bench.plan.forecasting import forecast
from pitotbench.bench.plan.plan_request import PlanRequest
from pitotbench.bench.truth_comparison import compare_altitude, compare_curve_at
from pitotbench.calibrate import CalibrationOptions
from pitotbench.evidence.experiment import NO_LIMIT, Budget, Experiment, Row, Trial, run_experiment
from pitotbench.records.case import Case, PressureErrorSpec
from pitotbench.sense import data_system
from pitotbench.simulate import PAPER_MANEUVERS
from pitotbench.units import FOOT, KNOT

TRIANGLE, HEIGHT, VELOCITY = "triangle", "height", "height and velocity"
LOOKS = (TRIANGLE, HEIGHT, VELOCITY)
ALTITUDE = 3350.0 * FOOT  # m: light turbulence is 0.5 m/s there (MIL-F-8785C, Fig. 7)
_TURBULENCE = "light"
_RECEIVER = replace(data_system("20/1"), velocity_noise=0.05, altitude_noise=0.3, altitude_drift=2.0)


def request_with(look: str) -> PlanRequest:
    """Return the request for a plan whose calibration uses the triangle alone, the height, or the velocity too."""
    return PlanRequest(
        Case(turbulence=_TURBULENCE, altitude=ALTITUDE, pressure_error=PressureErrorSpec(location="static")),
        system=replace(_RECEIVER, vertical_velocity="recorded" if look == VELOCITY else "missing"),
        options=CalibrationOptions(error_location="static", use_altitude=False)
        if look == TRIANGLE
        else CalibrationOptions(),
    )


def flown_with_height(trial: Trial, looks: tuple[str, ...]) -> list[Row]:
    """Fly a maneuver of the plan and calibrate it with every look; return a row for each.

    Columns: maneuver, turbulence, receiver, seed, two_sigma_kt (mean over the wanted speeds), coverage (share of
    the speeds inside 2σ), two_sigma_ft and coverage_ft (of the altitude correction; NaN where there is none).
    """
    request = request_with(TRIANGLE)
    case = replace(request.case(trial.maneuver), turbulence=trial.turbulence)
    flight = bench.fly(replace(case, truth_seed=trial.seed, sensor_seed=trial.seed))
    rows: list[Row] = []
    for look in looks:
        given = request_with(look)
        log = bench.sense(flight, given.das)
        curve = bench.calibrate(log, given.options).curve
        height = compare_altitude(curve, case.pressure_error, float(np.median(log.static_pressure)))
        found = compare_curve_at(curve, case.pressure_error, request.airspeeds)
        rows.append(
            {
                "maneuver": trial.maneuver,
                "turbulence": trial.turbulence,
                "receiver": look,
                "seed": trial.seed,
                "two_sigma_kt": found.mean_two_sigma / KNOT,
                "coverage": found.inside,
                "two_sigma_ft": height.mean_two_sigma / FOOT if height else np.nan,
                "coverage_ft": height.inside if height else np.nan,
            }
        )
    return rows


def check_forecasts_with_height(
    seeds: Sequence[int], budget: Budget = NO_LIMIT, maneuvers: Sequence[str] = PAPER_MANEUVERS
) -> pd.DataFrame:
    """Fly, forecast and compare; return one row for each maneuver and receiver.

    Columns: maneuver, receiver, flights, predicted_kt, flown_kt, flown_se_kt, ratio (predicted / flown),
    predicted_share and flown_share (of the triangle's bound, nan for the triangle), coverage, two_sigma_ft,
    coverage_ft.
    """
    experiment = Experiment(flown_with_height, tuple(maneuvers), (_TURBULENCE,), LOOKS, "receiver")
    flown = run_experiment(experiment, seeds, budget)
    table = (
        flown.groupby(["maneuver", "receiver"], sort=False)
        .agg(
            flights=("seed", "size"),
            flown_kt=("two_sigma_kt", "mean"),
            flown_se_kt=("two_sigma_kt", "sem"),
            coverage=("coverage", "mean"),
            two_sigma_ft=("two_sigma_ft", "mean"),
            coverage_ft=("coverage_ft", "mean"),
        )
        .reset_index()
    )
    cells = zip(table.maneuver, table.receiver, strict=True)
    table["predicted_kt"] = [forecast(request_with(look), name).mean / KNOT for name, look in cells]
    table["ratio"] = table.predicted_kt / table.flown_kt
    for kind in ("predicted", "flown"):
        alone = table[table.receiver == TRIANGLE].set_index("maneuver")[f"{kind}_kt"]
        share = table[f"{kind}_kt"] / table.maneuver.map(alone)
        table[f"{kind}_share"] = np.where(table.receiver == TRIANGLE, np.nan, share)
    return table
