"""Measure the Circle's banks, the time for set-up, the conventional methods, and two systems in one
flight.
"""

from argparse import ArgumentParser
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from pitotbench import air
from pitotbench.calibration import calibrate
from pitotbench.calibration.options import USUAL
from pitotbench.campaigns.fleet import require_all, run_tasks
from pitotbench.campaigns.flights import Comparison, compare_curve, rms, sense, true_correction
from pitotbench.pressure_error import MODELS
from pitotbench.records.case import PressureErrorSpec
from pitotbench.records.flight import Flight
from pitotbench.records.log import FlightLog
from pitotbench.sensing.recorder import CALIBRATION_CHANNELS
from pitotbench.sensing.sampling import data_system
from pitotbench.show.columns import frame_rows
from pitotbench.show.style import BLUE, ORANGE, SKY, canvas
from pitotbench.simulation.maneuvers import PAPER_MANEUVERS
from pitotbench.simulation.properties import HORSEPOWER
from pitotbench.simulation.sortie import fly
from pitotbench.units import KNOT, Array
from pitotlab.experiment import Row, made_with
from pitotlab.study.conventional import (
    AIRSPEEDS,
    BLOCK,
    against_truth,
    cone,
    fit_points,
    pacer,
    tower,
)
from pitotlab.study.measures import TRAVEL, workload
from pitotlab.study.reductions import COVERING, NAMES, PAPER, PAPER_ORDER, case_of
from pitotlab.study.tables import Spread, rank_agreement, signed
from pitotlab.tables import frame_columns, markdown_table

if TYPE_CHECKING:
    from matplotlib.axes import Axes

RESULTS = Path(__file__).parents[1] / "results" / "methods"
BANKS = (10.0, 20.0, 30.0, 45.0)  # deg
SET_UP = 2.0  # min between airspeeds (Martos et al. 2011, III.A)
HELD = ("circle", "race_track", "four_leg")  # maneuvers with set-up between their four airspeeds
RUNS_BETWEEN = 3
FLY_BY = 150.0  # m, the height above the sea of a fly-by: a field at sea level and a pass at 500 ft
# Height of a receiver that wanders by 2 m, as height does in practice.
SYSTEM = replace(data_system("50/50"), altitude_drift=2.0)
SPEED = replace(COVERING, error_location="static", use_altitude=False)
HEIGHT = replace(SPEED, use_altitude=True)
REDUCTIONS = {
    "paper": PAPER,
    "speed": SPEED,
    "height": HEIGHT,
    "usual speed": replace(SPEED, accuracies=USUAL),
    "usual height": replace(HEIGHT, accuracies=USUAL),
}
STATIC = PressureErrorSpec(location="static")
# The second system has a smaller error of another slope, as a mast beside the fuselage may have.
SECOND = PressureErrorSpec(parameters=(0.010, -0.008, 0.004), location="static")
_FELT = ("calibrated_airspeed", "roll", "power_left", "power_right")
_CHANNELS = (*CALIBRATION_CHANNELS, *TRAVEL, *_FELT)
OLDER = {
    "tower fly-by": "Tower fly-by",
    "pacer": "Pacer",
    "cone, level": "Trailing cone, level runs",
    "cone, slowing": "Trailing cone, Step Decrease",
}
Tables = dict[str, list[Row]]


def measure_seed(seed: int) -> Tables:
    """Fly everything of one seed; return the rows of `banks`, `methods` and `systems`."""
    flights = {m: _fly(seed, m) for m in PAPER_MANEUVERS}
    rows: Tables = {"banks": [], "methods": [], "systems": []}
    level = _powers(flights["race_track"], "leg")
    rows["banks"] += [_bank_row(seed, bank, level) for bank in BANKS]
    for maneuver, flight in flights.items():
        smooth = calibrate(sense(_fly(seed, maneuver, "smooth"), SYSTEM), PAPER)
        log = sense(flight, SYSTEM)
        row: Row = {"method": maneuver, "minutes": _minutes(flight)}
        row["smooth_residual_kt"] = smooth.residual_two_sigma / KNOT
        off = with_constant_errors(log, np.random.default_rng([seed, 35]))
        for reduction, options in REDUCTIONS.items():
            result = calibrate(off if reduction.startswith("usual") else log, options)
            row |= _scored(reduction, compare_curve(result.curve, STATIC))
            row |= {"residual_kt": result.residual_two_sigma / KNOT} if reduction == "paper" else {}
        rows["methods"].append(row)
        rows["systems"].append({"maneuver": maneuver, **two_systems(flight)})
    fly_by = _fly(seed, "race_track", card={"dwell_s": 20.0}, altitude=FLY_BY)
    flown = (fly_by, flights["race_track"], flights["race_track"], flights["step_decrease"])
    reads = (tower, pacer, cone, cone)
    for number, (method, read, flight) in enumerate(zip(OLDER, reads, flown, strict=True)):
        rng = np.random.default_rng([seed, number, 34])
        answer = fit_points(read(flight, sense(flight, SYSTEM), rng))
        row = {"method": method, "minutes": _minutes(flight)}
        rows["methods"].append(row | _scored("usual speed", against_truth(answer, STATIC)))
    return {name: [{"seed": seed, **row} for row in each] for name, each in rows.items()}


def with_constant_errors(log: FlightLog, rng: np.random.Generator) -> FlightLog:
    """Return a log whose temperature, static pressure and GPS velocity are off, by draws from the
    usual accuracies.

    The same draws meet every maneuver of a seed: they are of the airplane.
    """
    temperature, static, north, east = 0.5 * rng.standard_normal(4)
    assert log.total_temperature is not None  # every simulated log has it
    return replace(
        log,
        total_temperature=log.total_temperature + USUAL.temperature_k * temperature,
        static_pressure=log.static_pressure + USUAL.static_pressure_pa * static,
        velocity_north=log.velocity_north + USUAL.velocity_mps * north,
        velocity_east=log.velocity_east + USUAL.velocity_mps * east,
    )


def _fly(seed: int, maneuver: str, setting: str = "light", **changes: Any) -> Flight:
    case = case_of(setting, maneuver, seed, pressure_error=STATIC, **changes)
    return fly(case, channels=_CHANNELS)


def _minutes(flight: Flight) -> float:
    return flight.duration / 60.0


def _scored(reduction: str, found: Comparison) -> Row:
    name = reduction.replace(" ", "_")
    return {
        f"{name}_error_kt": found.rms_error / KNOT,
        f"{name}_bound_kt": found.mean_two_sigma / KNOT,
        f"{name}_inside": found.inside,
    }


def _powers(flight: Flight, kind: str) -> Array:
    """Return the mean power [hp] at each airspeed, fastest first, in the segments of a kind."""
    power = (flight["power_left"] + flight["power_right"]) / HORSEPOWER
    speeds: dict[str, list[str]] = {}
    for name in dict.fromkeys(flight.segment):
        if name.startswith(kind):
            speeds.setdefault(name.split()[1], []).append(name)
    return np.array([power[np.isin(flight.segment, names)].mean() for names in speeds.values()])


def _bank_row(seed: int, bank: float, level: Array) -> Row:
    card = {"bank_deg": bank, "bank_limit_deg": max(35.0, bank + 5.0)}
    flight = _fly(seed, "circle", card=card)
    circling = np.char.startswith(flight.segment, "circle")
    held = np.degrees(np.abs(flight["roll"][circling]))
    extra = _powers(flight, "circle") - level
    row: Row = {
        "bank_deg": bank,
        "minutes": _minutes(flight),
        "circle_minutes": _minutes(flight) * float(np.mean(circling)) / (RUNS_BETWEEN + 1),
        "extra_power_hp": float(extra.mean()),
        "extra_power_slowest_hp": float(extra[-1]),
        "out_percent": 100.0 * workload(flight).out_of_tolerance,
        "bank_wander_deg": float(np.std(held)),
    }
    log = sense(flight, SYSTEM)
    row["residual_kt"] = calibrate(log, PAPER).residual_two_sigma / KNOT
    return row | _scored("speed", compare_curve(calibrate(log, SPEED).curve, STATIC))


def two_systems(flight: Flight) -> Row:
    """Calibrate two air-data systems of one flight alone and together; return errors and bounds as
    columns.

    Gusts and the GPS are common to both systems, so that two fits do not have independent errors.
    The mean of the two systems meets the wind once. Their difference needs neither wind nor GPS: it
    is fitted from means over blocks. Its error is independent of the mean's where the two systems
    are equally noisy.
    """
    case = flight.case
    other = replace(
        flight, case=replace(case, pressure_error=SECOND, sensor_seed=case.sensor_seed + 1000)
    )
    one, two = sense(flight, SYSTEM), sense(other, SYSTEM)
    two = replace(one, impact_pressure=two.impact_pressure, static_pressure=two.static_pressure)
    alone = [calibrate(log, SPEED) for log in (one, two)]
    half = replace(
        one,
        impact_pressure=0.5 * (one.impact_pressure + two.impact_pressure),
        static_pressure=0.5 * (one.static_pressure + two.static_pressure),
    )
    middle = calibrate(half, SPEED)
    difference, its_two_sigma = system_difference(one, two)
    row: Row = {}
    for name, result, truth, sign in zip("ab", alone, (STATIC, SECOND), (0.5, -0.5), strict=True):
        row |= _scored(f"{name}_alone", compare_curve(result.curve, truth))
        at = AIRSPEEDS + sign * difference
        between = sign * np.interp(at, AIRSPEEDS, difference)
        mean, bound = (
            np.interp(at, middle.curve.indicated_airspeed, values)
            for values in (middle.curve.correction, middle.curve.two_sigma)
        )
        both = (mean + between, np.hypot(bound, 0.5 * its_two_sigma))
        row |= _scored(f"{name}_both", against_truth(both, truth))
    one_wind, other_wind = (each.known_wind for each in alone)
    north = other_wind.north.value - one_wind.north.value
    row["wind_gap_kt"] = float(np.hypot(north, other_wind.east.value - one_wind.east.value)) / KNOT
    slower, faster = AIRSPEEDS - 0.5 * difference, AIRSPEEDS + 0.5 * difference
    true = true_correction(STATIC, slower) - true_correction(SECOND, faster)
    return row | _scored("difference", Comparison(difference - true, its_two_sigma))


def system_difference(one: FlightLog, two: FlightLog) -> tuple[Array, Array]:
    """Return the airspeed of `two` minus that of `one`, and its 2σ [m/s], where their mean is
    `AIRSPEEDS`.

    It is the correction of `one` minus that of `two`. It comes from the two impact pressures alone.
    """
    block = np.unique(np.floor(one.time / BLOCK), return_inverse=True)[1]
    size = np.bincount(block)
    a, b = (np.bincount(block, log.impact_pressure) / size for log in (one, two))
    middle, reference = 0.5 * (a + b), PressureErrorSpec().reference_pressure
    terms, share = MODELS["inverse+"], (b - a) / middle
    # Blocks of the same length have the same noise [Pa]; slow ones tell less of the share.
    basis, weight = terms.basis(middle / reference), middle * np.sqrt(size)
    rows = basis * weight[:, None]
    found = np.linalg.lstsq(rows, share * weight, rcond=None)[0]
    left = (share - basis @ found) * weight
    covariance = np.linalg.inv(rows.T @ rows) * (left @ left) / (len(left) - len(found))
    pressure = air.impact_pressure(AIRSPEEDS)
    at, slope = (
        terms.basis(pressure / reference),
        pressure * air.calibrated_airspeed_slope(pressure),
    )
    return slope * (at @ found), 2.0 * slope * np.sqrt(np.einsum("ij,jk,ik->i", at, covariance, at))


def fly_methods(seeds: int, jobs: int | None = None) -> dict[str, pd.DataFrame]:
    """Return the rows of seeds 1 to `seeds` by table."""
    done = require_all(run_tasks(measure_seed, range(1, seeds + 1), jobs, label="seeds"))
    return {name: pd.DataFrame([row for each in done for row in each[name]]) for name in KEYS}


def summarize(rows: pd.DataFrame, key: str, provenance: str) -> pd.DataFrame:
    """Return a row a cell: means and deviations over seeds, and rms of the true errors."""
    cells = []
    for name, group in rows.groupby(key, sort=False):
        cell: Row = {key: name, "seeds": group["seed"].nunique()}
        for column in group.columns.difference(["seed", key], sort=False):
            values = group[column].dropna()
            if str(column).endswith("error_kt"):
                cell[str(column)] = rms(values) if len(values) else np.nan
                continue
            spread = Spread.of(values)
            cell |= {str(column): spread.mean, f"{column}_sd": spread.deviation}
        cells.append(cell)
    return pd.DataFrame(cells).assign(made=provenance)


KEYS = {"banks": "bank_deg", "methods": "method", "systems": "maneuver"}


def command(parser: ArgumentParser, words: Sequence[str]) -> None:
    """Fly the Circle's banks, the maneuvers and older methods with set-up, and two systems at once;
    print tables.

    Ten seeds take about eight minutes of processor time. The tables and pictures are those of the
    documentation.
    """
    add = parser.add_argument
    add("--seeds", type=int, default=10, help="seeds 1 to N (default: %(default)s)")
    add("--jobs", type=int, help="processes (default: one a core)")
    add("--out", type=Path, default=RESULTS, help="folder of the tables (default: %(default)s)")
    add("--again", action="store_true", help="fly nothing; print the tables that are there")
    add("--pictures", type=Path, help="write the pictures of the page into this folder")
    options = parser.parse_args(words)
    if not options.again:
        options.out.mkdir(parents=True, exist_ok=True)
        for name, rows in fly_methods(options.seeds, options.jobs).items():
            table = summarize(rows, KEYS[name], made_with())
            table.to_csv(options.out / f"{name}.csv", index=False, float_format="%.4f")
    shown = read_tables(options.out)
    for name, table in shown.items():
        print(f"\n{name}\n{markdown_table(frame_columns(table), frame_rows(table))}")
    print("\n".join(orders(pd.read_csv(options.out / "methods.csv"))))
    if options.pictures is not None:
        draw(pd.read_csv(options.out / "methods.csv"), options.pictures)


def in_the_air(methods: pd.DataFrame) -> "pd.Series[float]":
    """Return the minutes of each method with the set-up between its airspeeds."""
    held = methods["method"].isin([*HELD, *OLDER]) & (methods["method"] != "cone, slowing")
    return methods["minutes"] + SET_UP * RUNS_BETWEEN * held


# The columns of a table as people read them: heading, column of the file, digits.
HEADINGS = {
    "banks": (
        ("bank [°]", "bank_deg", 0),
        ("one circle [min]", "circle_minutes", 2),
        ("recorded [min]", "minutes", 1),
        ("more power than level [hp]", "extra_power_hp", 0),
        ("the same at 100 kt [hp]", "extra_power_slowest_hp", 0),
        ("bank wanders, 1σ [°]", "bank_wander_deg", 1),
        ("out of tolerance [%]", "out_percent", 1),
        ("residual 2σ [kt]", "residual_kt", 2),
        ("true rms error [kt]", "speed_error_kt", 3),
        ("covering 2σ [kt]", "speed_bound_kt", 3),
    ),
    "methods": (
        ("method", "method", 0),
        ("recorded [min]", "minutes", 1),
        ("with set-up [min]", "air", 1),
        ("residual 2σ, smooth air [kt]", "smooth_residual_kt", 3),
        ("residual 2σ, light turbulence [kt]", "residual_kt", 2),
        ("true error, published method [kt]", "paper_error_kt", 3),
        ("true error [kt]", "speed_error_kt", 3),
        ("covering 2σ [kt]", "speed_bound_kt", 3),
        ("true error with height [kt]", "height_error_kt", 3),
        ("covering 2σ with height [kt]", "height_bound_kt", 3),
        ("true error, sensors off [kt]", "usual_speed_error_kt", 2),
        ("2σ, sensors off [kt]", "usual_speed_bound_kt", 2),
        ("true error with height, sensors off [kt]", "usual_height_error_kt", 2),
        ("2σ with height, sensors off [kt]", "usual_height_bound_kt", 2),
    ),
    "systems": (
        ("maneuver", "maneuver", 0),
        ("2σ of A alone [kt]", "a_alone_bound_kt", 3),
        ("2σ of A with B [kt]", "a_both_bound_kt", 3),
        ("2σ of B alone [kt]", "b_alone_bound_kt", 3),
        ("2σ of B with A [kt]", "b_both_bound_kt", 3),
        ("A with B inside 2σ [%]", "a_both_inside", 0),
        ("two winds of one flight differ [kt]", "wind_gap_kt", 3),
        ("true error of A − B [kt]", "difference_error_kt", 4),
        ("2σ of A − B [kt]", "difference_bound_kt", 3),
        ("A − B inside 2σ [%]", "difference_inside", 0),
    ),
}


def read_tables(folder: Path = RESULTS) -> dict[str, pd.DataFrame]:
    """Return the tables of a measurement as people read them, the unit in each heading."""
    found = {name: pd.read_csv(folder / f"{name}.csv") for name in KEYS}
    found["methods"]["air"] = in_the_air(found["methods"])
    return {
        name: pd.DataFrame({head: _cells(table, c, digits) for head, c, digits in HEADINGS[name]})
        for name, table in found.items()
    }


def _cells(table: pd.DataFrame, column: str, digits: int) -> "pd.Series[str]":
    """Return a column as text: a name, a share in percent, or a number with its deviation if any."""
    values = table[column]
    if column in ("method", "maneuver"):
        return values.map({**NAMES, **OLDER})
    if column.endswith("_inside"):
        return (100.0 * values).map("{:.0f}".format)
    spreads = table.get(f"{column}_sd", pd.Series(np.nan, index=table.index))
    pairs = zip(values, spreads, strict=True)
    return pd.Series([Spread(v, s, 0).text(digits) if np.isfinite(v) else "–" for v, s in pairs])


MEASURES = {
    "residual in smooth air": "smooth_residual_kt",
    "residual in light turbulence": "residual_kt",
    "true error of the published method": "paper_error_kt",
    "true error": "speed_error_kt",
    "covering 2σ": "speed_bound_kt",
    "true error with height": "height_error_kt",
    "covering 2σ with height": "height_bound_kt",
    "2σ, sensors off": "usual_speed_bound_kt",
    "2σ with height, sensors off": "usual_height_bound_kt",
    "recorded minutes": "minutes",
    "minutes with set-up": "air",
}


def orders(methods: pd.DataFrame) -> list[str]:
    """Return the order of the maneuvers by each measure, with τ against the published order."""
    table = methods.assign(air=in_the_air(methods)).set_index("method").loc[list(PAPER_ORDER)]
    lines = []
    for label, column in MEASURES.items():
        order = " < ".join(NAMES[str(m)] for m in table[column].sort_values().index)
        tau = rank_agreement(table[column].to_numpy(), np.arange(float(len(table))))
        lines.append(f"{label}: {order} (τ with the paper's order {signed(tau)})")
    return lines


def draw(methods: pd.DataFrame, folder: Path) -> None:
    """Write two pictures: residual against truth, and bound against minutes in the air."""
    folder.mkdir(parents=True, exist_ok=True)
    table = methods.assign(air=in_the_air(methods)).set_index("method")
    five, older = table.loc[list(PAPER_ORDER)], table.loc[list(OLDER)]
    with canvas(1, 1, 6.4, 3.9) as (figure, (axes,)):
        x, y = five["smooth_residual_kt"], five["speed_error_kt"]
        axes.errorbar(x, y, xerr=five["smooth_residual_kt_sd"], fmt="o", color=BLUE, ms=7)
        _label(axes, x, y)
        axes.set(
            title="A small residual is not a small error",
            xlabel="2σ of the residual in smooth air [kt]",
            ylabel="true rms error of the curve in light turbulence [kt]",
        )
        axes.margins(x=0.2, y=0.15)
        axes.set_ylim(bottom=0.0)
        figure.savefig(folder / "residual-and-truth.png", dpi=110, metadata={"Software": None})
    with canvas(1, 1, 7.4, 4.4) as (figure, (axes,)):
        speed, height = "usual_speed_bound_kt", "usual_height_bound_kt"
        for of, column, mark, color, label in (
            (five, speed, "o", BLUE, "GPS velocity"),
            (five, height, "o", SKY, "GPS velocity and height (static error)"),
            (older, speed, "s", ORANGE, "conventional methods"),
        ):
            axes.plot(of["air"], of[column], mark, color=color, label=label)
        _label(axes, table["air"], table[speed])
        axes.set(
            title="What a curve costs",
            xlabel="minutes in the air, with set-up between airspeeds [min]",
            ylabel="2σ of the curve, sensors as they usually are [kt]",
        )
        axes.set_xlim(0.0, 32.0)
        axes.set_ylim(bottom=0.0)
        axes.legend(loc="lower right")
        figure.savefig(folder / "bound-and-minutes.png", dpi=110, metadata={"Software": None})


def _label(axes: "Axes", x: "pd.Series[float]", y: "pd.Series[float]") -> None:
    """Name the dots, above them or, where another is close or the name long, below."""
    wide, high, names = float(np.ptp(x)), float(np.ptp(y)), {**NAMES, **OLDER}
    for name in x.index:
        right = (x - x[name]).between(0.0, 0.1 * wide) & ((y - y[name]).abs() < 0.1 * high)
        close, long = bool(right.drop(name).any()), len(names[name]) > 20
        axes.annotate(
            names[name], (float(x[name]), float(y[name])), (-4 if close else 6, -12 if close or long else 5),
            textcoords="offset points", fontsize=8.5, ha="right" if close else "left",
        )  # fmt: skip
