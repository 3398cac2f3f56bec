"""Published bounds for the same fit, each from its equations, compared with the truth in the same
way as ours.

All but the filter start from output error with white residuals (Jacobian J, residual v, both as
airspeed). They differ in how they treat the autocorrelation of the residual. Nothing else in the
project uses them.
"""

from argparse import ArgumentParser
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
import pandas as pd
from scipy.signal import fftconvolve

from pitotbench import air
from pitotbench.calibration import calibrate
from pitotbench.calibration.covering import CoveringFit, fit_covering
from pitotbench.calibration.covering_problem import Structure
from pitotbench.calibration.leg_points import fixed_speed_points
from pitotbench.calibration.observations import Observations, observe
from pitotbench.calibration.options import CalibrationOptions
from pitotbench.calibration.output_error import airspeed_outputs, fit_scalar
from pitotbench.calibration.prediction import CurveMap, PredictionModel
from pitotbench.campaigns.fleet import require_all, run_tasks
from pitotbench.campaigns.flights import (
    Comparison,
    compare_curve,
    rms,
    scored,
    sense,
    true_correction,
)
from pitotbench.estimation.restricted_likelihood import solve
from pitotbench.pressure_error import MODELS, REFERENCE_PRESSURE
from pitotbench.records import NoAnswerError
from pitotbench.records.case import PressureErrorSpec
from pitotbench.records.flight import Flight
from pitotbench.records.legs import FixedSpeedPoint
from pitotbench.records.log import FlightLog
from pitotbench.show.columns import frame_rows
from pitotbench.simulation import sortie
from pitotbench.simulation.maneuvers import PAPER_MANEUVERS
from pitotbench.units import KNOT, Array
from pitotlab.experiment import FIRST_SCORED_SEED, Row, Trial, random_case
from pitotlab.tables import frame_columns, markdown_table

BARTLETT_SECONDS = 20.0
# 1σ of wind north and east [m/s] and scale [-]: at the start, and of the walk in a second.
_FILTER_START, _FILTER_WALK = (10.0, 10.0, 0.1), (0.02, 0.02, 1e-4)
_FILTER_NOISE = 1.0  # m/s


def compare_points(points: Sequence[FixedSpeedPoint], truth: PressureErrorSpec) -> Comparison:
    """Compare fixed-speed points with the truth at their airspeeds."""
    airspeed, correction, two_sigma = np.array(
        [(point.indicated_airspeed, point.correction, point.two_sigma) for point in points]
    ).T
    return Comparison(correction - true_correction(truth, airspeed), two_sigma)


@dataclass(frozen=True, slots=True)
class PeerCase:
    """A fit with white residuals: Jacobian (n, p), residual (n,) [m/s], sample interval [s]."""

    jacobian: Array
    residual: Array
    interval: float


def white(case: PeerCase) -> Array:
    """Return the Cramér-Rao bound σ² (J'J)⁻¹ (Klein and Morelli 2006, ch. 6), (p, p)."""
    return np.asarray(np.var(case.residual) * np.linalg.inv(case.jacobian.T @ case.jacobian))


def colored(case: PeerCase) -> Array:
    """Return the bound of Morelli and Klein (1997): unbiased autocorrelation, all lags."""
    n = len(case.residual)
    lags = np.arange(-(n - 1), n)
    correlation = fftconvolve(case.residual, case.residual[::-1]) / (n - np.abs(lags))
    return _sandwich(case, correlation)


def bartlett(case: PeerCase) -> Array:
    """Return the bound of Newey and West (1987), with Bartlett weights over 20 s."""
    n, width = len(case.residual), BARTLETT_SECONDS / case.interval
    lags = np.arange(-(n - 1), n)
    weight = np.clip(1.0 - np.abs(lags) / width, 0.0, None)
    scores = case.jacobian * case.residual[:, None]
    smooth = np.stack([fftconvolve(column, weight, mode="same") for column in scores.T], axis=1)
    inverse = np.linalg.inv(case.jacobian.T @ case.jacobian)
    return np.asarray(inverse @ (scores.T @ smooth) @ inverse)


def _sandwich(case: PeerCase, correlation: Array) -> Array:
    """Return (J'J)⁻¹ [Σ_i Σ_j J_i R(i − j) J_j'] (J'J)⁻¹, with R at all lags, (2n − 1,)."""
    n = len(case.residual)
    smooth = np.stack(
        [fftconvolve(column, correlation)[n - 1 : 2 * n - 1] for column in case.jacobian.T], axis=1
    )
    inverse = np.linalg.inv(case.jacobian.T @ case.jacobian)
    return np.asarray(inverse @ (case.jacobian.T @ smooth) @ inverse)


COVARIANCES: dict[str, Callable[[PeerCase], Array]] = {
    "white residuals (Cramér-Rao)": white,
    "colored residuals, all lags": colored,
    "HAC, Bartlett 20 s": bartlett,
}


def _gradient(curve: CurveMap, theta: Array) -> Array:
    """Return the slopes of a curve with all parameters, (c, p); those of the wind are zero."""
    count = curve.model.error_count
    gradient = np.zeros((len(curve.correction(theta[:count])), curve.model.count))
    gradient[:, :count] = curve.correction_gradient(theta[:count])
    return gradient


def peer_rows(flight: Flight, das: str) -> list[Row]:
    """Return coverage and bound of each peer and of our fit on one flight: a row each, in m/s."""
    log = sense(flight, das)
    ours = calibrate(log)
    speeds, inside = ours.curve.indicated_airspeed, scored(ours.curve)
    truth = true_correction(flight.case.pressure_error, speeds)
    model = PredictionModel(MODELS["inverse+"], REFERENCE_PRESSURE)
    obs = observe(log, CalibrationOptions())
    theta, case = _white_case(model, obs)
    curve = CurveMap(model, speeds)
    gradient = _gradient(curve, theta)
    error = curve.correction(theta[: model.error_count]) - truth
    rows = []
    for name, covariance in COVARIANCES.items():
        variance = np.einsum("cp,pq,cq->c", gradient, covariance(case), gradient)
        rows.append(_row(name, error[inside], variance[inside]))
    value, variance = scale_filter(log, obs, speeds)
    rows.append(_row("1 Hz filter of wind and scale", (value - truth)[inside], variance[inside]))
    rows += _spread_rows(log, flight)
    beside_truth = compare_curve(ours.curve, flight.case.pressure_error)
    return [*rows, _row("pitotbench", beside_truth.error, (0.5 * beside_truth.two_sigma) ** 2)]


def _spread_rows(log: FlightLog, flight: Flight) -> list[Row]:
    """Return the rows of legs and turns at one speed each, with a bound from the scatter of
    redundant solutions.

    For four legs this is the bound of Gray (1998). There is no row where the maneuver does not hold
    a speed on enough headings.
    """
    try:
        points = [point for point in fixed_speed_points(log) if point.spread is not None]
    except NoAnswerError:
        return []
    if not points:
        return []
    error = compare_points(points, flight.case.pressure_error).error
    spread = np.array([point.spread for point in points])
    return [_row("per-point spread, fixed speed", error, spread**2)]


def _white_case(model: PredictionModel, obs: Observations) -> tuple[Array, PeerCase]:
    fit = fit_scalar(model, obs)
    residuals, jacobian = airspeed_outputs(model, obs.as_held())(fit.theta)
    return fit.theta, PeerCase(jacobian[0], residuals[0], float(np.median(np.diff(obs.time))))


def _row(name: str, error: Array, variance: Array) -> dict[str, object]:
    found = Comparison(error, 2.0 * np.sqrt(np.maximum(variance, 0.0)))
    return {
        "bound": name,
        "coverage": found.inside,
        "negative": bool(np.any(variance < 0.0)),
        "two_sigma": found.mean_two_sigma,
        "rms_error": found.rms_error,
    }


def scale_filter(log: FlightLog, obs: Observations, speeds: Array) -> tuple[Array, Array]:
    """Run a 1 Hz extended Kalman filter of the wind and one airspeed scale, as small autopilots do.

    The state is the wind W toward north and east [m/s] and the scale s in |V_ground − W| = s ·
    V_true(q_ci). Returns the correction [m/s] at indicated airspeeds [m/s], and its variance
    [m²/s²].
    """
    step = max(1, round(1.0 / float(np.median(np.diff(obs.time)))))
    mach = air.mach_from_impact_pressure(obs.impact_pressure, obs.static_pressure)
    temperature = obs.probe_temperature / (1.0 + obs.probe_heating * mach**2)
    measured = air.true_airspeed(obs.impact_pressure, obs.static_pressure, temperature)[::step]
    north, east = obs.held_north[::step], obs.held_east[::step]
    state, spread = np.array([0.0, 0.0, 1.0]), np.diag(np.square(_FILTER_START))
    for v_north, v_east, speed in zip(north, east, measured, strict=True):
        spread = spread + np.diag(np.square(_FILTER_WALK))
        x, y = v_north - state[0], v_east - state[1]
        through = float(np.hypot(x, y))
        slope = np.array([-x / through, -y / through, -speed])
        gain = spread @ slope / (slope @ spread @ slope + _FILTER_NOISE**2)
        state = state + gain * -(through - state[2] * speed)
        spread = spread - np.outer(gain, slope @ spread)
    return (state[2] - 1.0) * speeds, np.full(len(speeds), spread[2, 2]) * speeds**2


@dataclass(frozen=True, slots=True)
class _Fitted:
    """A covering fit of one log with its gradient (c, p), curve (c,) and truth (c,) [m/s]."""

    fit: CoveringFit
    gradient: Array
    curve: CurveMap
    truth: Array


def _fitted(flight: Flight, das: str) -> _Fitted:
    log = sense(flight, das)
    ours = calibrate(log)
    speeds = ours.curve.indicated_airspeed[scored(ours.curve)]
    model = PredictionModel(MODELS["inverse+"], REFERENCE_PRESSURE)
    obs = observe(log, CalibrationOptions())
    fit = fit_covering(Structure(model, (), False), obs, fit_scalar(model, obs).theta)
    curve = CurveMap(model, speeds)
    truth = true_correction(flight.case.pressure_error, speeds)
    return _Fitted(fit, _gradient(curve, fit.theta), curve, truth)


def known_noise_rows(fitted: Sequence[_Fitted]) -> list[Row]:
    """Return the rows of our estimator with the noise known: the mean over the cell's flights."""
    modes = [max(each.fit.nodes, key=lambda node: node.weight).noise for each in fitted]
    noise = np.mean(modes, axis=0)
    rows = []
    for each in fitted:
        step, covariance = solve(each.fit.problem, each.fit.noise_of(noise))
        variance = np.einsum("cp,pq,cq->c", each.gradient, covariance, each.gradient)
        k = (each.fit.theta + step)[: each.curve.model.error_count]
        error = each.curve.correction(k) - each.truth
        rows.append(_row("pitotbench, if the noise were known", error, variance))
    return rows


def comparison(
    seeds: int,
    turbulence: str = "light",
    systems: tuple[str, ...] = ("20/1", "50/50"),
    jobs: int | None = None,
) -> pd.DataFrame:
    """Compare all bounds on the same flights of all maneuvers: shares [%] and speeds [kt], means
    over flights.

    A task is a maneuver with all its flights. The estimator with known noise needs the fits of all
    of them, and a fit is not sent between processes.
    """
    work = partial(_maneuver_rows, seeds=seeds, turbulence=turbulence, systems=systems)
    rows = [row for found in require_all(run_tasks(work, PAPER_MANEUVERS, jobs)) for row in found]
    table = pd.DataFrame(rows)
    table = table.sort_values(["maneuver", "das"], kind="stable")
    groups = table.groupby(["maneuver", "das", "bound"], sort=False)
    return pd.DataFrame(
        {
            "inside 2σ [%]": 100.0 * groups["coverage"].mean(),
            "negative variance [% of flights]": 100.0 * groups["negative"].mean(),
            "mean 2σ [kt]": groups["two_sigma"].mean() / KNOT,
            "true rms error [kt]": groups["rms_error"].apply(rms) / KNOT,
        }
    ).reset_index()


def _maneuver_rows(
    maneuver: str, seeds: int, turbulence: str, systems: tuple[str, ...]
) -> list[Row]:
    """Return the rows of all flights of one maneuver, and those of the estimator with known noise."""
    rows: list[Row] = []
    fitted: dict[str, list[_Fitted]] = {das: [] for das in systems}
    for seed in range(FIRST_SCORED_SEED, FIRST_SCORED_SEED + seeds):
        flight = sortie.fly(random_case(Trial(maneuver, turbulence, seed)))
        for das in systems:
            rows += [{"maneuver": maneuver, "das": das} | row for row in peer_rows(flight, das)]
            fitted[das].append(_fitted(flight, das))
    for das, cell in fitted.items():
        rows += [{"maneuver": maneuver, "das": das} | row for row in known_noise_rows(cell)]
    return rows


def command(parser: ArgumentParser, words: Sequence[str]) -> None:
    """Hold the bounds that others publish against the truth together with ours, on the same flights; print
    a table.

    All maneuvers, light turbulence, 20/1 and 50/50 Hz, seeds never used in development.
    """
    add = parser.add_argument
    add("--seeds", type=int, default=40, help="flights a maneuver (default: %(default)s)")
    add("--jobs", type=int, help="processes (default: one a core, at most one a maneuver)")
    options = parser.parse_args(words)
    table = comparison(options.seeds, jobs=options.jobs)
    print(markdown_table(frame_columns(table, ".3g"), frame_rows(table)))
