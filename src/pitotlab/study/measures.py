"""What is measured on a sortie: every reduction at its flight, its data points, and the pilot's
workload.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from pitotbench.calibration import calibrate
from pitotbench.calibration.leg_points import cross_check
from pitotbench.calibration.options import CalibrationOptions
from pitotbench.calibration.output_error import OutputErrorFit
from pitotbench.campaigns.flights import (
    compare_wind,
    rms,
    score,
    true_correction,
    wind_toward,
)
from pitotbench.records import BadInputError, NoAnswerError
from pitotbench.records.calibration import Calibration
from pitotbench.records.flight import Flight
from pitotbench.records.log import FlightLog
from pitotbench.sensing.recorder import CALIBRATION_CHANNELS
from pitotbench.simulation.maneuvers import MANEUVERS
from pitotbench.simulation.sortie import fly
from pitotbench.units import DEGREE, FOOT, KNOT, Array, Booleans
from pitotlab.experiment import Row
from pitotlab.study.reductions import TURNING, WALK, Reduction, Sortie, sense_for
from pitotlab.study.velocity_fit import fit_velocity

# From stop to stop.
TRAVEL = {"elevator": 40.0 * DEGREE, "aileron": 40.0 * DEGREE, "throttle_left": 1.0}
FELT = 0.02  # of the travel, some millimeters of a yoke: a smaller change is no hand movement (our estimate)
CONTROL_RATE = 10.0  # Hz, ten times the rate of hand movements
_WINDOW = 1.0  # s
DENSITY_EDGES = np.arange(90.0, 172.5, 2.5)  # kt
BLOCK = 5.0  # s, about the memory of a gust: residuals averaged over it count as independent
_CHANNELS = (
    *CALIBRATION_CHANNELS, *TRAVEL, "position_north", "position_east", "calibrated_airspeed",
    "roll", "pitch", "heading", "angle_of_attack", "sideslip",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Workload:
    """The workload of one flight.

    It is the number of reversals a minute of each control, the share of seconds in which a control
    moved, and the share of the time to be flown on condition that was out of tolerance.
    """

    reversals: dict[str, float]
    duty: float
    out_of_tolerance: float


def workload(flight: Flight) -> Workload:
    """Return the workload of a flight, from its control positions and tolerances."""
    step = max(1, round(len(flight) / flight.duration / CONTROL_RATE))
    controls = {name: flight[name][::step] / travel for name, travel in TRAVEL.items()}
    minutes = flight.duration / 60.0
    moved = np.any([_moved(control) for control in controls.values()], axis=0)
    meant = np.char.startswith(flight.segment[::step], MANEUVERS[flight.case.maneuver].kind)
    return Workload(
        reversals={name: reversals(control) / minutes for name, control in controls.items()},
        duty=float(np.mean(moved)),
        out_of_tolerance=1.0 - float(np.mean(flight.on_condition[::step][meant])),
    )


def reversals(control: Array, felt: float = FELT) -> int:
    """Return how often a control [share of travel] reverses by more than `felt`."""
    count, direction, extreme = 0, 0, float(control[0])
    for value in control.tolist():
        if direction >= 0 and value < extreme - felt:
            count, direction, extreme = count + (direction > 0), -1, value
        elif direction <= 0 and value > extreme + felt:
            count, direction, extreme = count + (direction < 0), 1, value
        elif (direction >= 0 and value > extreme) or (direction <= 0 and value < extreme):
            extreme = value if direction else extreme
    return count


def _moved(control: Array) -> Array:
    """Return for each window of one second whether the control moved by more than `FELT`."""
    width = round(_WINDOW * CONTROL_RATE)
    windows = control[: len(control) // width * width].reshape(-1, width)
    return np.asarray(np.ptp(windows, axis=1) > FELT)


def reduction_row(reduction: Reduction) -> Row:
    """Return the settings of a fit, as the columns by which rows are selected."""
    options = reduction.options
    return {
        "das": reduction.das,
        "model": options.model,
        "method": options.method,
        "form": reduction.form,
        "wind": options.wind,
        "down": options.use_down,
        "on_condition": options.on_condition,
        "change": reduction.change,
        "level": reduction.level,
        "noise": reduction.noise,
        "gps_noise": reduction.gps_noise,
        "given_down": reduction.given_down,
        "alone": reduction.alone,
    }


def fit(flight: Flight, log: FlightLog, reduction: Reduction) -> tuple[Row, Calibration | None]:
    """Fit a log and compare it with the truth of its flight. `failed` is the reason where there are
    no numbers.

    Of a fit of several outputs only their residuals are measured: it gives no calibration.
    """
    row, result = reduction_row(reduction) | {"failed": ""}, None
    try:
        if reduction.form == "vector":
            row |= _outputs(fit_velocity(log, reduction.options))
        else:
            result = calibrate(log, reduction.options)
            row |= _scores(result, flight) | _criteria(result)
    except (NoAnswerError, BadInputError) as error:
        row["failed"] = str(error)
    return row, result


def _outputs(fitted: OutputErrorFit) -> Row:
    """Return 2σ of the residual of each output of a fit of several, and pooled over them [kt of
    true airspeed].

    Pooled is the root of the mean square over the outputs: an output without residual lowers it.
    """
    each = 2.0 * fitted.deviation / KNOT
    names = [f"two_sigma_{axis}_kt" for axis in ("north", "east", "down")]
    return {"pooled_two_sigma_kt": rms(each), **dict(zip(names, each.tolist(), strict=False))}


def _scores(result: Calibration, flight: Flight) -> Row:
    """Return the errors of curve and wind."""
    scores = score(result, flight)
    north, _ = compare_wind(result.known_wind, wind_toward(flight.case.wind)[:2]).error
    return {
        "samples": scores.samples,
        "residual_two_sigma_kt": scores.residual_two_sigma / KNOT,
        "smooth_two_sigma_kt": 2.0 * float(np.std(result.residuals.airspeed)) / KNOT,
        "two_sigma_kt": scores.two_sigma / KNOT,
        "rms_error_kt": scores.curve_rms_error / KNOT,
        "coverage": scores.curve_coverage,
        "wind_north_error_kt": float(north) / KNOT,
    }


def _criteria(result: Calibration) -> Row:
    """Return Schwarz's criterion (1978) of all residuals as if white, and of means over blocks."""
    count = len(result.parameters) + 2
    time, airspeed = result.residuals.time, result.residuals.airspeed
    block = np.floor((time - time[0]) / BLOCK).astype(np.intp)
    _, member, size = np.unique(block, return_inverse=True, return_counts=True)
    means = np.bincount(member, airspeed) / size
    return {"white_criterion": _schwarz(airspeed, count), "block_criterion": _schwarz(means, count)}


def _schwarz(values: Array, count: int) -> float:
    return float(len(values) * np.log(np.mean(values**2)) + count * np.log(len(values)))


def flight_row(flight: Flight) -> Row:
    """Return the times of a flight, its changes of altitude and speed, and its workload."""
    effort = workload(flight)
    speed = np.hypot(flight["velocity_north"], flight["velocity_east"])
    rate = np.gradient(speed, flight["time"])[flight.on_condition]
    return {
        "minutes": flight.duration / 60.0,
        "on_condition_minutes": float(np.mean(flight.on_condition)) * flight.duration / 60.0,
        "vertical_speed_fpm": float(np.std(flight["velocity_down"])) / FOOT * 60.0,
        "altitude_ft": float(np.std(flight["altitude"])) / FOOT,
        "turning_percent": 100.0 * float(np.mean(np.abs(flight["roll"]) > TURNING)),
        # The 95th percentile of the deceleration over ground.
        "slowing_kt_a_second": -float(np.percentile(rate, 5.0)) / KNOT if len(rate) else 0.0,
        "reversals_a_minute": sum(effort.reversals.values()),
        **{f"reversals_{control}": rate for control, rate in effort.reversals.items()},
        "duty_percent": 100.0 * effort.duty,
        "out_of_tolerance_percent": 100.0 * effort.out_of_tolerance,
    }


def _rows(same: Row, **columns: Array | Booleans) -> list[Row]:
    """Return a row for each place of some columns, with the same entries in all."""
    values = [column.tolist() for column in columns.values()]
    return [same | dict(zip(columns, row, strict=True)) for row in zip(*values, strict=True)]


def density_rows(flight: Flight) -> list[Row]:
    """Return the seconds of a flight in each bin of calibrated airspeed."""
    counts, _ = np.histogram(flight["calibrated_airspeed"] / KNOT, DENSITY_EDGES)
    middle = 0.5 * (DENSITY_EDGES[1:] + DENSITY_EDGES[:-1])
    return _rows({}, airspeed_kt=middle, seconds=counts * flight.duration / len(flight))


def curve_rows(flight: Flight, reduction: Reduction, result: Calibration) -> list[Row]:
    """Return the points of a curve [kt] with its 2σ, the 2σ of the residual, and the truth."""
    curve, options = result.curve, reduction.options
    return _rows(
        {
            "kind": options.method,
            "on_condition": options.on_condition,
            "residual_two_sigma_kt": result.residual_two_sigma / KNOT,
        },
        airspeed_kt=curve.indicated_airspeed / KNOT,
        correction_kt=curve.correction / KNOT,
        two_sigma_kt=curve.two_sigma / KNOT,
        truth_kt=true_correction(flight.case.pressure_error, curve.indicated_airspeed) / KNOT,
    )


def fixed_speed_rows(log: FlightLog) -> list[Row]:
    """Return the four-leg points of a log: airspeed correction at indicated airspeed [kt]."""
    points = cross_check(log, CalibrationOptions(error_location="impact"))
    legs = [point for point in points if point.method == "four_leg"]
    return _rows(
        {"kind": "fixed speed"},
        airspeed_kt=np.array([point.indicated_airspeed for point in legs]) / KNOT,
        correction_kt=np.array([point.correction for point in legs]) / KNOT,
    )


@dataclass(frozen=True, slots=True)
class Measured:
    """The rows of a sortie by table, and the failures in words."""

    fits: Iterable[Row] = ()
    flights: Iterable[Row] = ()
    density: Iterable[Row] = ()
    curves: Iterable[Row] = ()
    failures: tuple[str, ...] = ()


def measure_sortie(sortie: Sortie) -> Measured:
    """Fly, sense, fit and measure a sortie. Raises BadInputError where the case cannot be flown."""
    case = sortie.case
    flight = fly(case, channels=_CHANNELS)
    key: Row = {
        "setting": sortie.setting,
        "variant": sortie.variant,
        "maneuver": case.maneuver,
        "seed": case.truth_seed,
    }

    def keyed(rows: Iterable[Row]) -> tuple[Row, ...]:
        return tuple(key | row for row in rows)

    fits, curves = _fits(flight, sortie)
    name = " ".join(map(str, key.values()))
    return Measured(
        fits=keyed(fits),
        flights=keyed([flight_row(flight)]),
        density=keyed(density_rows(flight) if sortie.density else ()),
        curves=keyed(curves),
        failures=tuple(f"{name}: {row['failed']}" for row in fits if row["failed"]),
    )


def _fits(flight: Flight, sortie: Sortie) -> tuple[list[Row], list[Row]]:
    """Return one row for each reduction, and the points of the curves where the sortie asks for them."""
    logs: dict[Reduction, tuple[Flight, FlightLog]] = {}
    rows, curves = [], []
    for reduction in sortie.reductions:
        if reduction.sensing not in logs:
            logs[reduction.sensing] = sense_for(flight, reduction)
        changed, log = logs[reduction.sensing]
        row, result = fit(changed, log, reduction)
        rows.append(row)
        walk = {"change": reduction.change, "level": reduction.level}
        published = reduction.options.method == "paper" and walk == WALK
        if sortie.curves and result is not None and published:
            curves += curve_rows(changed, reduction, result)
            curves += fixed_speed_rows(log) if reduction.options.on_condition else []
    return rows, curves
