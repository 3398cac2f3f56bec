"""The numbers of one fit and of one flight that the tables hold."""

import numpy as np

from pitotbench import bench
from pitotbench.bench.truth_comparison import compare_curve, compare_wind, rms, scored
from pitotbench.calibrate.output_error import OutputErrorFit
from pitotbench.evidence.experiment import Row
from pitotbench.evidence.study.changes import TURNING
from pitotbench.evidence.study.looks import Look
from pitotbench.evidence.study.velocity_fit import fit_velocity
from pitotbench.evidence.study.workload import workload
from pitotbench.records.calibration import Calibration
from pitotbench.records.errors import BadInputError, NoAnswerError
from pitotbench.records.flight import Flight
from pitotbench.records.log import FlightLog
from pitotbench.units import FOOT, KNOT, Array

DENSITY_EDGES = np.arange(90.0, 172.5, 2.5)  # kt
BLOCK = 5.0  # s, about the memory of a gust: residuals averaged over it count as independent
_SPLIT = 130.0 * KNOT  # the speed at which Step Decrease changes its heading


def look_row(look: Look) -> Row:
    """Return the settings of a fit, as the columns by which rows are selected."""
    options = look.options
    return {
        "das": look.das,
        "model": options.model,
        "method": options.method,
        "form": look.form,
        "wind": options.wind,
        "down": options.use_down,
        "on_condition": options.on_condition,
        "change": look.change,
        "level": look.level,
        "noise": look.noise,
        "gps_noise": look.gps_noise,
        "given_down": look.given_down,
        "alone": look.alone,
    }


def fit(flight: Flight, log: FlightLog, look: Look) -> tuple[Row, Calibration | None]:
    """Fit a log and compare it with the truth of its flight. `failed` is the reason where there are no numbers.

    Of a fit of several outputs only their residuals are measured: it gives no calibration.
    """
    try:
        if look.form == "vector":
            return {**look_row(look), "failed": "", **_outputs(fit_velocity(log, look.options))}, None
        result = bench.calibrate(log, look.options)
    except (NoAnswerError, BadInputError) as error:
        return {**look_row(look), "failed": str(error)}, None
    score = bench.score(result, flight)
    row: Row = {
        **look_row(look),
        "failed": "",
        "samples": score.samples,
        "residual_two_sigma_kt": score.residual_two_sigma / KNOT,
        "smooth_two_sigma_kt": 2.0 * float(np.std(result.residuals.airspeed)) / KNOT,
        "two_sigma_kt": score.two_sigma / KNOT,
        "rms_error_kt": score.curve_rms_error / KNOT,
        "coverage": score.curve_coverage,
        **_error_parts(result, flight),
        **_criteria(result),
    }
    return row, result


def _outputs(fitted: OutputErrorFit) -> Row:
    """Return 2σ of the residual of each output of a fit of several, and pooled over them [kt of true airspeed].

    Pooled is the root of the mean square over the outputs: an output without residual lowers it.
    """
    each = 2.0 * np.std(fitted.residuals, axis=1) / KNOT
    names = [f"two_sigma_{axis}_kt" for axis in ("north", "east", "down")]
    return {"pooled_two_sigma_kt": rms(each), **dict(zip(names, each.tolist(), strict=False))}


def _error_parts(result: Calibration, flight: Flight) -> Row:
    """Return the mean error of the curve, that of its lower half minus that of its upper half, and the error of the
    wind, all in kt."""
    error = compare_curve(result.curve, flight.case.pressure_error).error
    slow = result.curve.indicated_airspeed[scored(result.curve)] < _SPLIT
    tilt = float(np.mean(error[slow]) - np.mean(error[~slow])) if slow.any() else 0.0
    north, east = compare_wind(result.wind, bench.wind_toward(flight.case.wind)[:2]).error
    return {
        "mean_error_kt": float(np.mean(error)) / KNOT,
        "tilt_kt": tilt / KNOT,
        "wind_north_error_kt": float(north) / KNOT,
        "wind_east_error_kt": float(east) / KNOT,
    }


def _criteria(result: Calibration) -> Row:
    """Return Schwarz's criterion (1978) from all residuals as if white, and from means over blocks of `BLOCK`."""
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
    return {
        "minutes": flight.duration / 60.0,
        "on_condition_minutes": float(np.mean(flight.on_condition)) * flight.duration / 60.0,
        "vertical_speed_fpm": float(np.std(flight["velocity_down"])) / FOOT * 60.0,
        "altitude_ft": float(np.std(flight["altitude"])) / FOOT,
        "turning_percent": 100.0 * float(np.mean(np.abs(flight["roll"]) > TURNING)),
        "slowing_kt_a_second": _slowing(flight) / KNOT,
        "reversals_a_minute": sum(effort.reversals.values()),
        **{f"reversals_{control}": rate for control, rate in effort.reversals.items()},
        "duty_percent": 100.0 * effort.duty,
        "out_of_tolerance_percent": 100.0 * effort.out_of_tolerance,
    }


def _slowing(flight: Flight) -> float:
    """Return the 95th percentile of the deceleration over ground [m/s²], on condition."""
    speed = np.hypot(flight["velocity_north"], flight["velocity_east"])
    rate = np.gradient(speed, flight["time"])[flight.on_condition]
    return -float(np.percentile(rate, 5.0)) if len(rate) else 0.0


def density_rows(flight: Flight) -> list[Row]:
    """Return the seconds of a flight in each bin of calibrated airspeed."""
    counts, _ = np.histogram(flight["calibrated_airspeed"] / KNOT, DENSITY_EDGES)
    seconds = counts * flight.duration / len(flight)
    middle = 0.5 * (DENSITY_EDGES[1:] + DENSITY_EDGES[:-1])
    return [{"airspeed_kt": float(v), "seconds": float(s)} for v, s in zip(middle, seconds, strict=True)]
