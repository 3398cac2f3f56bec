"""The methods against which the source measures itself: tower fly-by, pacer and trailing cone, as
sensors.

Each gives points of the pressure error. Their errors are of two kinds: a point's own, and those
that all points of a flight share, which no number of passes makes smaller. The sizes are ours,
written beside each method.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pitotbench import air
from pitotbench.campaigns.flights import Comparison, true_correction
from pitotbench.pressure_error import MODELS
from pitotbench.records.case import PressureErrorSpec
from pitotbench.records.flight import Flight
from pitotbench.records.log import FlightLog
from pitotbench.units import KNOT, Array
from pitotlab.study.reductions import TURNING

AIRSPEEDS = np.arange(100.0, 161.0, 2.0) * KNOT  # indicated, at which curves are scored
# One standard deviation of each error of a method.
HEIGHT = 1.0  # m, of a fly-by
BLOCK_CHECK = 5.0  # Pa between tower and airplane, compared when parked
PACER = 0.25 * KNOT  # of the pacer's own calibration
READING = 0.5 * KNOT  # in formation
CONE = 0.002  # of the cone itself [of q_c]
TUBE_ZERO = 3.0  # Pa, of the cone's transducer
LAG = 1.0  # s, of the pressure in the cone's tube
BLOCK = 5.0  # s over which the cone's samples are averaged
_READ = 2.0  # s over which a gauge is read as the airplane passes the tower

Rows = NDArray[np.intp]


@dataclass(frozen=True, slots=True)
class Points:
    """Points of a pressure error: indicated impact pressure and Δp, (n,) [Pa].

    `own` is 1σ of a point's own error [Pa], (n,), or None where the scatter of the points tells it.
    A row of `shared`, (k, n), is 1σ at each point of one error that all points have together [Pa].
    """

    impact_pressure: Array
    pressure_error: Array
    own: Array | None
    shared: Array


def fit_points(points: Points, model: str = "inverse+") -> tuple[Array, Array]:
    """Return the correction and its 2σ [m/s] at `AIRSPEEDS` by weighted least squares."""
    true_impact = points.impact_pressure + points.pressure_error
    reference = PressureErrorSpec().reference_pressure
    terms = MODELS[model]
    basis = terms.basis(points.impact_pressure / reference)
    share = points.pressure_error / true_impact
    own = points.own
    if own is None:
        left = share - basis @ np.linalg.lstsq(basis, share, rcond=None)[0]
        freedom = len(share) - basis.shape[1]
        own = np.sqrt(left @ left / freedom) * true_impact
    shared = points.shared / true_impact
    weight = np.linalg.inv(np.diag((own / true_impact) ** 2) + shared.T @ shared)
    covariance = np.linalg.inv(basis.T @ weight @ basis)
    found = covariance @ basis.T @ weight @ share
    indicated = air.impact_pressure(AIRSPEEDS)
    at = terms.basis(indicated / reference)
    true = indicated / (1.0 - at @ found)
    slope = air.calibrated_airspeed_slope(true) * true**2 / indicated
    two_sigma = 2.0 * slope * np.sqrt(np.einsum("ij,jk,ik->i", at, covariance, at))
    return air.calibrated_airspeed(true) - AIRSPEEDS, two_sigma


def against_truth(answer: tuple[Array, Array], truth: PressureErrorSpec) -> Comparison:
    """Compare a correction at `AIRSPEEDS`, with its 2σ, with the truth [m/s]."""
    return Comparison(answer[0] - true_correction(truth, AIRSPEEDS), answer[1])


def _legs(flight: Flight, log: FlightLog) -> list[Rows]:
    """Return the rows of the log on each straight leg."""
    segment = flight.segment[np.searchsorted(flight["time"], log.time - 1e-6)]
    return [
        np.flatnonzero(segment == name) for name in dict.fromkeys(segment) if name.startswith("leg")
    ]


def _true(flight: Flight, log: FlightLog, channel: str) -> Array:
    return np.interp(log.time, flight["time"], flight[channel])


def tower(flight: Flight, log: FlightLog, rng: np.random.Generator) -> Points:
    """Return a point a pass: static pressure against the tower's, reduced to the height."""
    static, temperature = (_true(flight, log, n) for n in ("static_pressure", "air_temperature"))
    points = []
    check = BLOCK_CHECK * rng.standard_normal()
    for rows in _legs(flight, log):
        near = rows[np.abs(log.time[rows] - log.time[rows].mean()) <= 0.5 * _READ]
        density = static[near].mean() / (air.GAS_CONSTANT * temperature[near].mean())
        own = HEIGHT * air.GRAVITY * density
        error = (log.static_pressure - static)[near].mean() + own * rng.standard_normal() + check
        points.append((log.impact_pressure[near].mean(), error, own, BLOCK_CHECK))
    impact, errors, each, shared = np.array(points).T
    return Points(impact, errors, each, shared[None, :])


def pacer(flight: Flight, log: FlightLog, rng: np.random.Generator) -> Points:
    """Return a point a leg: the airspeed of a calibrated airplane in formation against our own."""
    true = _true(flight, log, "total_pressure") - _true(flight, log, "static_pressure")
    points = []
    calibration = PACER * rng.standard_normal()
    for rows in _legs(flight, log):
        read = air.calibrated_airspeed(true[rows]).mean() + READING * rng.standard_normal()
        own = air.calibrated_airspeed(log.impact_pressure[rows]).mean()
        paced, indicated = (float(air.impact_pressure(v)) for v in (read + calibration, own))
        slope = float(air.calibrated_airspeed_slope(paced))
        points.append((indicated, paced - indicated, READING / slope, PACER / slope))
    impact, errors, each, shared = np.array(points).T
    return Points(impact, errors, each, shared[None, :])


def cone(flight: Flight, log: FlightLog, rng: np.random.Generator) -> Points:
    """Return a point each `BLOCK` of straight flight: the airplane's static pressure against the
    cone's.

    The cone has an error in proportion to the impact pressure, its tube a lag and its transducer a
    zero.
    """
    static = _true(flight, log, "static_pressure")
    impact = _true(flight, log, "total_pressure") - static
    # A pure delay: to first order the lag of a tube.
    behind = np.interp(log.time - LAG, log.time, static)
    seen = behind + CONE * rng.standard_normal() * impact + TUBE_ZERO * rng.standard_normal()
    straight = np.abs(_true(flight, log, "roll")) < TURNING
    block = np.floor(log.time / BLOCK).astype(int)
    # A block that a turn cuts short counts too: it holds as little lag.
    kept = [np.flatnonzero((block == b) & straight) for b in np.unique(block[straight])]
    mean = np.array([log.impact_pressure[rows].mean() for rows in kept])
    error = np.array([(log.static_pressure - seen)[rows].mean() for rows in kept])
    return Points(mean, error, None, np.array([CONE * mean, np.full(len(mean), TUBE_ZERO)]))
