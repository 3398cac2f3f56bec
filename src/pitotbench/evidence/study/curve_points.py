"""Curves for the pictures: a calibration over airspeed, and the points of the conventional method."""

from pitotbench import bench
from pitotbench.evidence.experiment import Row
from pitotbench.evidence.study.looks import Look
from pitotbench.records.calibration import Calibration
from pitotbench.records.flight import Flight
from pitotbench.records.log import FlightLog
from pitotbench.units import KNOT

_PUBLISHED = bench.CalibrationOptions(error_location="impact")


def curve_rows(flight: Flight, look: Look, result: Calibration) -> list[Row]:
    """Return the points of a curve [kt] with the 2σ of its method, the 2σ of the residual, and the truth."""
    curve = result.curve
    truth = bench.true_correction(flight.case.pressure_error, curve.indicated_airspeed)
    columns = zip(curve.indicated_airspeed, curve.correction, curve.two_sigma, truth, strict=True)
    residual = result.residual_two_sigma / KNOT
    return [
        {
            "kind": look.options.method,
            "on_condition": look.options.on_condition,
            "airspeed_kt": float(speed) / KNOT,
            "correction_kt": float(value) / KNOT,
            "two_sigma_kt": float(bound) / KNOT,
            "residual_two_sigma_kt": residual,
            "truth_kt": float(true) / KNOT,
        }
        for speed, value, bound, true in columns
    ]


def fixed_speed_rows(log: FlightLog) -> list[Row]:
    """Return the four-leg points of a log: calibrated minus indicated airspeed [kt] at indicated airspeeds [kt]."""
    return [
        {
            "kind": "fixed speed",
            "airspeed_kt": point.indicated_airspeed / KNOT,
            "correction_kt": point.correction / KNOT,
        }
        for point in bench.cross_check(log, _PUBLISHED)
        if point.method == "four_leg"
    ]
