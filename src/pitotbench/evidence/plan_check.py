"""The forecast against flights: the same maneuvers flown in simulated turbulence, many seeds, and calibrated."""

from collections.abc import Sequence
from dataclasses import replace
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pandas as pd

from pitotbench import bench
from pitotbench.bench.plan.forecasting import forecast
from pitotbench.bench.plan.plan_request import PlanRequest
from pitotbench.calibrate import CalibrationOptions
from pitotbench.records.calibration import Calibration
from pitotbench.records.case import Case
from pitotbench.records.flight import Flight
from pitotbench.units import KNOT, Array


def flown_bounds(request: PlanRequest, systems: Sequence[str], seeds: Sequence[int]) -> pd.DataFrame:
    """Fly every maneuver of the request and calibrate what every system records: one row a flight and system.

    Columns: maneuver, das, seed, minutes, two_sigma_kt (mean over the wanted speeds), error_kt (true rms error) and
    coverage (share of the speeds inside 2σ).
    """
    rows = []
    for maneuver in request.maneuvers:
        case = replace(request.case(maneuver), turbulence=request.base.turbulence)
        for seed in seeds:
            flight = bench.fly(replace(case, truth_seed=seed, sensor_seed=seed))
            for system in systems:
                result = bench.calibrate(bench.sense(flight, system), CalibrationOptions())
                rows.append({"maneuver": maneuver, "das": system, "seed": seed, **_scored(request, flight, result)})
    return pd.DataFrame(rows)


def _scored(request: PlanRequest, flight: Flight, result: Calibration) -> dict[str, float]:
    curve, speeds = result.curve, request.airspeeds
    bound, correction = (_at(speeds, curve.indicated_airspeed, y) for y in (curve.two_sigma, curve.correction))
    error = correction - bench.true_correction(flight.case.pressure_error, speeds)
    return {
        "minutes": flight.duration / 60.0,
        "two_sigma_kt": float(np.mean(bound)) / KNOT,
        "error_kt": float(np.sqrt(np.mean(error**2))) / KNOT,
        "coverage": float(np.mean(np.abs(error) <= bound)),
    }


def _at(speeds: Array, known: Array, values: Array) -> Array:
    return np.interp(speeds, known, values)


def compare_bounds(request: PlanRequest, flown: pd.DataFrame) -> pd.DataFrame:
    """Predicted against flown bounds, one row a maneuver and system.

    Columns: maneuver, turbulence, das, flights, minutes, predicted_kt, flown_kt, flown_se_kt (standard error),
    ratio, error_kt (rms over flights), coverage.
    """
    groups = flown.groupby(["maneuver", "das"], sort=False)
    table = groups.agg(
        flights=("seed", "size"),
        minutes=("minutes", "mean"),
        flown_kt=("two_sigma_kt", "mean"),
        flown_se_kt=("two_sigma_kt", "sem"),
        error_kt=("error_kt", _rms),
        coverage=("coverage", "mean"),
    ).reset_index()
    table["predicted_kt"] = [
        forecast(replace(request, system=str(das)), str(name)).mean / KNOT
        for name, das in zip(table.maneuver, table.das, strict=True)
    ]
    return table.assign(turbulence=request.base.turbulence, ratio=table.predicted_kt / table.flown_kt)


def _rms(values: "pd.Series[float]") -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def check_plan(
    turbulences: Sequence[str], systems: Sequence[str], seeds: int, out: Path, flown_file: Path | None = None
) -> pd.DataFrame:
    """Fly (or read what was flown from `flown_file`), compare, and write plan.md and plan.png into `out`."""
    from pitotbench.evidence.pages.plan_check_page import (  # loads the drawing library
        add_reference,
        check_page,
        check_picture,
    )

    requests = {name: PlanRequest(Case(turbulence=name)) for name in turbulences}
    if flown_file is not None and flown_file.exists():
        flown = pd.read_csv(flown_file)
    else:
        flights = [
            flown_bounds(request, systems, range(1, seeds + 1)).assign(turbulence=name)
            for name, request in requests.items()
        ]
        flown = pd.concat(flights)
        if flown_file is not None:
            flown.to_csv(flown_file, index=False)
    parts = [compare_bounds(request, flown[flown.turbulence == name]) for name, request in requests.items()]
    table = add_reference(pd.concat(parts, ignore_index=True))
    out.mkdir(parents=True, exist_ok=True)
    check_picture(table, out / "plan.png")
    (out / "plan.md").write_text(check_page(table, _provenance(table)), encoding="utf-8")
    return table


def _provenance(table: pd.DataFrame) -> str:
    draws = PlanRequest(Case()).draws
    return (
        f"{table.flights.min()} to {table.flights.max()} flights a cell (seeds from 1), {draws} draws a forecast;\n"
        f"pitotbench {version('pitotbench')}, JSBSim {version('jsbsim')}, {datetime.now(UTC):%Y-%m-%d}.\n"
        "`python scripts/check_plan.py` repeats it."
    )
