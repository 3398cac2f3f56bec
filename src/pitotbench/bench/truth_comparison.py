"""Compare answers with the truth: the errors of a curve, of points and of a wind, with their 2σ."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Union

import numpy as np

from pitotbench.bench.flights import true_altitude_correction, true_correction, wind_toward
from pitotbench.records.calibration import Calibration, ErrorCurve, WindEstimate
from pitotbench.records.case import PressureErrorSpec
from pitotbench.records.fixed_speed_point import FixedSpeedPoint
from pitotbench.records.flight import Flight
from pitotbench.records.score import Score
from pitotbench.units import KNOT, Array, Booleans, MetersPerSecond

if TYPE_CHECKING:
    from pandas import Series

SCORED_RANGE = (100.0 * KNOT, 160.0 * KNOT)  # of indicated airspeed: curves are scored and averaged inside it


@dataclass(frozen=True, slots=True)
class Comparison:
    """Errors of estimates, estimate minus truth, and their stated 2σ, (n,) each.

    Both are in m/s, in m for altitudes, or in knots where they come from a table in knots. The means are in the
    same unit.
    """

    error: Array
    two_sigma: Array

    @property
    def inside(self) -> float:
        """Share of the errors that are within their 2σ."""
        return float(np.mean(np.abs(self.error) <= self.two_sigma))

    @property
    def all_inside(self) -> bool:
        """Whether every error is within its 2σ."""
        return bool(np.all(np.abs(self.error) <= self.two_sigma))

    @property
    def mean_error(self) -> float:
        """Mean of the errors."""
        return float(np.mean(self.error))

    @property
    def rms_error(self) -> float:
        """Root mean square of the errors."""
        return rms(self.error)

    @property
    def mean_two_sigma(self) -> float:
        """Mean of the 2σ."""
        return float(np.mean(self.two_sigma))


def rms(values: Union[Array, "Series[float]"]) -> float:
    """Root mean square of an array of any shape, in its units.

    NaN in an array gives NaN; NaN in a pandas Series is a missing number and is skipped.
    """
    return float(np.sqrt(np.mean(np.square(values))))


def scored(curve: ErrorCurve) -> Booleans:
    """Return the mask of the curve's points inside the scored range of indicated airspeed, or all where none is."""
    low, high = SCORED_RANGE
    inside: Booleans = (curve.indicated_airspeed > low - 0.01) & (curve.indicated_airspeed < high + 0.01)
    return inside if bool(inside.any()) else np.ones_like(inside)


def compare_curve(curve: ErrorCurve, truth: PressureErrorSpec) -> Comparison:
    """Compare a curve with the truth at its scored points."""
    error, inside = curve.correction - true_correction(truth, curve.indicated_airspeed), scored(curve)
    return Comparison(error[inside], curve.two_sigma[inside])


def compare_curve_at(curve: ErrorCurve, truth: PressureErrorSpec, airspeeds: MetersPerSecond) -> Comparison:
    """Compare a curve with the truth at indicated airspeeds [m/s], (n,), interpolated between its points."""
    correction, two_sigma = (
        np.interp(airspeeds, curve.indicated_airspeed, values) for values in (curve.correction, curve.two_sigma)
    )
    return Comparison(correction - true_correction(truth, airspeeds), two_sigma)


def compare_altitude(curve: ErrorCurve, truth: PressureErrorSpec, static_pressure: float) -> Comparison | None:
    """Compare the altitude correction with the truth at the scored points [m]; None where the curve has none.

    `static_pressure` [Pa] is the median of the log.
    """
    if curve.altitude_correction is None or curve.altitude_two_sigma is None:
        return None
    inside = scored(curve)
    true = true_altitude_correction(truth, curve.indicated_airspeed, static_pressure)
    return Comparison((curve.altitude_correction - true)[inside], curve.altitude_two_sigma[inside])


def compare_points(points: Sequence[FixedSpeedPoint], truth: PressureErrorSpec) -> Comparison:
    """Compare fixed-speed points with the truth at their airspeeds."""
    airspeed, correction, two_sigma = np.array(
        [(point.indicated_airspeed, point.correction, point.two_sigma) for point in points]
    ).T
    return Comparison(correction - true_correction(truth, airspeed), two_sigma)


def compare_wind(wind: WindEstimate, truth: Array) -> Comparison:
    """Compare an estimated wind with the true one toward north and east [m/s], (2,)."""
    estimates = (wind.north, wind.east)
    error = np.array([each.value for each in estimates]) - truth
    return Comparison(error, np.array([each.two_sigma for each in estimates]))


def score(calibration: Calibration, flight: Flight) -> Score:
    """Compare a calibration with the truth of the flight behind its log.

    The true wind is the case's mean wind. The mean of the turbulence over the flight counts as an error.
    Raises PressureErrorRangeError where the true curve has no solution at an airspeed of the calibration.
    """
    curve = compare_curve(calibration.curve, flight.case.pressure_error)
    wind = compare_wind(calibration.wind, wind_toward(flight.case.wind)[:2])
    return Score(
        minutes=flight.duration / 60.0,
        samples=calibration.samples,
        residual_two_sigma=calibration.residual_two_sigma,
        two_sigma=curve.mean_two_sigma,
        curve_rms_error=curve.rms_error,
        wind_error=float(np.linalg.norm(wind.error)),
        curve_coverage=curve.inside,
        on_condition_share=float(np.mean(flight.on_condition)),
    )
