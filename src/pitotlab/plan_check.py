"""Compare forecasts with flights: fly the same maneuvers in simulated turbulence with many seeds
and calibrate.

With an error of the static source the altitude equation narrows the bound. The receiver then stands
alone: its height has a white error of 0.3 m and a slow one of 2 m over 90 s, and its velocity 0.05
m/s, once a second.
"""

from argparse import ArgumentParser
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from pitotbench import air
from pitotbench.bench.planner import PlanRequest, forecast
from pitotbench.calibration import calibrate
from pitotbench.calibration.options import CalibrationOptions
from pitotbench.campaigns.flights import Comparison, rms, scored, sense, true_correction
from pitotbench.logbook.columns import write_text
from pitotbench.records.calibration import ErrorCurve
from pitotbench.records.case import Case, DataSystem, PressureErrorSpec
from pitotbench.records.flight import Flight
from pitotbench.records.log import FlightLog
from pitotbench.sensing.recorder import known_curve
from pitotbench.sensing.sampling import data_system
from pitotbench.simulation.maneuvers import MANEUVERS, PAPER_MANEUVERS
from pitotbench.simulation.sortie import fly
from pitotbench.units import FOOT, KNOT, Meters, MetersPerSecond
from pitotlab import experiment as lab

TRIANGLE, HEIGHT, VELOCITY = "triangle", "height", "height and velocity"
LOOKS = (TRIANGLE, HEIGHT, VELOCITY)
ALTITUDE = 3350.0 * FOOT  # m: light turbulence is 0.5 m/s there (MIL-F-8785C, Fig. 7)
_TURBULENCE = "light"
_RECEIVER = replace(
    data_system("20/1"), velocity_noise=0.05, altitude_noise=0.3, altitude_drift=2.0
)


def true_altitude_correction(
    spec: PressureErrorSpec, indicated_airspeed: MetersPerSecond, static_pressure: float
) -> Meters:
    """Return true minus indicated pressure altitude [m] at indicated airspeeds [m/s].

    `static_pressure` [Pa] is the indicated one. Only an error of the static source changes it.
    """
    if spec.location != "static":
        return np.zeros_like(indicated_airspeed)
    indicated = air.impact_pressure(indicated_airspeed)
    error = known_curve(spec).impact_pressure(indicated) - indicated
    return air.pressure_altitude(static_pressure - error) - air.pressure_altitude(static_pressure)


def compare_curve_at(
    curve: ErrorCurve, truth: PressureErrorSpec, airspeeds: MetersPerSecond
) -> Comparison:
    """Compare a curve with the truth at indicated airspeeds [m/s], (n,), interpolated between its
    points.
    """
    correction, two_sigma = (
        np.interp(airspeeds, curve.indicated_airspeed, values)
        for values in (curve.correction, curve.two_sigma)
    )
    return Comparison(correction - true_correction(truth, airspeeds), two_sigma)


def compare_altitude(
    curve: ErrorCurve, truth: PressureErrorSpec, static_pressure: float
) -> Comparison | None:
    """Compare the altitude correction with the truth at the scored points [m]; None where the curve
    has none.

    `static_pressure` [Pa] is the median of the log.
    """
    if curve.altitude_correction is None or curve.altitude_two_sigma is None:
        return None
    inside = scored(curve)
    true = true_altitude_correction(truth, curve.indicated_airspeed, static_pressure)
    return Comparison((curve.altitude_correction - true)[inside], curve.altitude_two_sigma[inside])


def request_with(look: str) -> PlanRequest:
    """Return the request for a plan whose calibration uses the triangle alone, the height, or the
    velocity too.
    """
    return PlanRequest(
        Case(
            turbulence=_TURBULENCE,
            altitude=ALTITUDE,
            pressure_error=PressureErrorSpec(location="static"),
        ),
        system=replace(_RECEIVER, vertical_velocity="recorded" if look == VELOCITY else "missing"),
        options=CalibrationOptions(error_location="static", use_altitude=False)
        if look == TRIANGLE
        else CalibrationOptions(),
    )


def flown_with_height(trial: lab.Trial, looks: tuple[str, ...]) -> list[lab.Row]:
    """Fly a maneuver of the plan and calibrate it with every look; return a row for each.

    Columns: those of `flown_bounds`, receiver instead of das, two_sigma_ft and coverage_ft (of the
    altitude correction; NaN where there is none).
    """
    flight = _flown(request_with(TRIANGLE), trial)
    rows: list[lab.Row] = []
    for look in looks:
        given = request_with(look)
        row, log, curve = _calibrated(given, flight, given.das, given.options)
        height = compare_altitude(
            curve, flight.case.pressure_error, float(np.median(log.static_pressure))
        )
        row["two_sigma_ft"] = height.mean_two_sigma / FOOT if height else np.nan
        row["coverage_ft"] = height.inside if height else np.nan
        rows.append(trial.cell | row | {"receiver": look})
    return rows


def flown_bounds(trial: lab.Trial, systems: tuple[str, ...]) -> list[lab.Row]:
    """Fly a maneuver of a plan and calibrate the log of every system; return a row for each system.

    Columns: maneuver, turbulence, das, seed, minutes, two_sigma_kt (mean over the wanted speeds),
    error_kt (true rms error) and coverage (share of the speeds inside 2σ).
    """
    request = PlanRequest(Case(turbulence=trial.turbulence))
    flight, options = _flown(request, trial), request.options
    return [
        trial.cell | _calibrated(request, flight, das, options)[0] | {"das": das} for das in systems
    ]


def _flown(request: PlanRequest, trial: lab.Trial) -> Flight:
    case = replace(request.case(trial.maneuver), turbulence=trial.turbulence)
    return fly(replace(case, truth_seed=trial.seed, sensor_seed=trial.seed))


def _calibrated(
    request: PlanRequest, flight: Flight, das: str | DataSystem, options: CalibrationOptions
) -> tuple[lab.Row, FlightLog, ErrorCurve]:
    log = sense(flight, das)
    curve = calibrate(log, options).curve
    found = compare_curve_at(curve, flight.case.pressure_error, request.airspeeds)
    row: lab.Row = {"minutes": flight.duration / 60.0, "two_sigma_kt": found.mean_two_sigma / KNOT}
    return row | {"error_kt": found.rms_error / KNOT, "coverage": found.inside}, log, curve


# Columns of both comparisons.
_FLOWN = {
    "flights": ("seed", "size"),
    "flown_kt": ("two_sigma_kt", "mean"),
    "flown_se_kt": ("two_sigma_kt", "sem"),
}


def check_forecasts_with_height(
    seeds: Sequence[int],
    budget: lab.Budget = lab.NO_LIMIT,
    maneuvers: Sequence[str] = PAPER_MANEUVERS,
) -> pd.DataFrame:
    """Fly, forecast and compare; return one row for each maneuver and receiver.

    Columns: maneuver, receiver, flights, predicted_kt, flown_kt, flown_se_kt, ratio (predicted /
    flown), predicted_share and flown_share (of the triangle's bound, nan for the triangle),
    coverage, two_sigma_ft, coverage_ft.
    """
    experiment = lab.Experiment(
        flown_with_height, tuple(maneuvers), (_TURBULENCE,), LOOKS, "receiver"
    )
    groups = lab.run_experiment(experiment, seeds, budget).groupby(
        ["maneuver", "receiver"], sort=False
    )
    means = {name: (name, "mean") for name in ("coverage", "two_sigma_ft", "coverage_ft")}
    table = groups.agg(**_FLOWN, **means).reset_index()
    cells = zip(table.maneuver, table.receiver, strict=True)
    table["predicted_kt"] = [forecast(request_with(look), name).mean / KNOT for name, look in cells]
    table["ratio"] = table.predicted_kt / table.flown_kt
    for kind in ("predicted", "flown"):
        alone = table[table.receiver == TRIANGLE].set_index("maneuver")[f"{kind}_kt"]
        share = table[f"{kind}_kt"] / table.maneuver.map(alone)
        table[f"{kind}_share"] = np.where(table.receiver == TRIANGLE, np.nan, share)
    return table


def compare_bounds(request: PlanRequest, flown: pd.DataFrame) -> pd.DataFrame:
    """Return predicted and flown bounds, one row for each maneuver and system.

    Columns: maneuver, turbulence, das, flights, minutes, predicted_kt, flown_kt, flown_se_kt
    (standard error), ratio, error_kt (rms over flights), coverage.
    """
    groups = flown.groupby(["maneuver", "das"], sort=False)
    first = {"flights": _FLOWN["flights"], "minutes": ("minutes", "mean")}
    table = groups.agg(
        **(first | _FLOWN), error_kt=("error_kt", rms), coverage=("coverage", "mean")
    ).reset_index()
    cells = zip(table.maneuver, table.das, strict=True)
    table["predicted_kt"] = [
        forecast(replace(request, system=das), name).mean / KNOT for name, das in cells
    ]
    return table.assign(
        turbulence=request.base.turbulence, ratio=table.predicted_kt / table.flown_kt
    )


def check_plan(
    turbulences: Sequence[str],
    systems: Sequence[str],
    seeds: int,
    out: Path,
    budget: lab.Budget = lab.NO_LIMIT,
    heights: pd.DataFrame | None = None,
) -> pd.DataFrame:
    """Fly the trials that the budget's rows lack, compare, and write plan.md and plan.png into
    `out`.

    `heights` is the table of `check_forecasts_with_height`, for a section of the page.
    """
    from pitotlab.pages import add_reference, check_page, check_picture

    experiment = lab.Experiment(
        flown_bounds, tuple(MANEUVERS), tuple(turbulences), tuple(systems), "das"
    )
    flown = lab.run_experiment(experiment, range(1, seeds + 1), budget)
    requests = {name: PlanRequest(Case(turbulence=name)) for name in turbulences}
    parts = [
        compare_bounds(request, flown[flown.turbulence == name])
        for name, request in requests.items()
    ]
    table = add_reference(pd.concat(parts, ignore_index=True))
    out.mkdir(parents=True, exist_ok=True)
    check_picture(table, out / "plan.png")
    write_text(out / "plan.md", check_page(table, _provenance(table), heights))
    return table


def _provenance(table: pd.DataFrame) -> str:
    draws = PlanRequest(Case()).draws
    return (
        f"{table.flights.min()} to {table.flights.max()} flights a cell (seeds from 1), {draws} "
        "draws a forecast;\n"
        f"{lab.made_with()}.\n"
        "`python -m pitotlab plan` repeats it."
    )


def command(parser: ArgumentParser, words: Sequence[str]) -> None:
    """Hold the planner's forecasts against flights. Writes plan.md and plan.png.

    `--rows FILE.parquet` keeps the flown bounds: a check cut short goes on, and a second one makes
    only the forecasts again. Flights with a static error come first; `--height-only` prints these
    alone.
    """
    parser.add_argument(
        "--seeds", type=int, default=16, help="flights a maneuver (default: %(default)s)"
    )
    parser.add_argument("--turbulence", default="light", help="comma list (default: %(default)s)")
    parser.add_argument(
        "--das", default="20/1,50/50,100/100", help="comma list (default: %(default)s)"
    )
    parser.add_argument("--out", type=Path, default=lab.OUT, help="folder (default: %(default)s)")
    parser.add_argument(
        "--height-seeds", type=int, default=12, help="with a static error (default: %(default)s)"
    )
    parser.add_argument(
        "--height-only", action="store_true", help="end after the flights with a static error"
    )
    lab.add_budget(parser)
    options = parser.parse_args(words)
    heights = check_forecasts_with_height(
        range(1, options.height_seeds + 1), lab.Budget(options.jobs)
    )
    print(heights.to_string(index=False, float_format="%.3f"), flush=True)
    if options.height_only:
        return
    turbulences, systems = options.turbulence.split(","), options.das.split(",")
    table = check_plan(
        turbulences, systems, options.seeds, options.out, lab.budget_of(options), heights
    )
    print(table.to_string(index=False, float_format="%.3f"))
