"""Curves for the pictures: a calibration over airspeed, its data, and the points of the conventional method."""

import numpy as np

from pitotbench import air, bench
from pitotbench.evidence.experiment import Row
from pitotbench.evidence.study.looks import Look
from pitotbench.records.calibration import Calibration
from pitotbench.records.errors import BadInputError
from pitotbench.records.flight import Flight
from pitotbench.records.log import FlightLog
from pitotbench.units import KNOT

_PUBLISHED = bench.CalibrationOptions(error_location="impact")
_DATA_POINTS = 600  # of a picture


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


def data_rows(log: FlightLog, look: Look, result: Calibration) -> list[Row]:
    """Return some samples of a log as the published figures show them.

    Each is the calibrated airspeed [kt] by the GPS velocity as logged and the wind of the result, minus the
    indicated airspeed [kt]. Raises BadInputError for a log without temperature.
    """
    used = np.flatnonzero(result.residuals.used)
    few = log.select(used[:: max(1, len(used) // _DATA_POINTS)])
    wind = result.wind
    north, east = few.velocity_north - wind.north.value, few.velocity_east - wind.east.value
    down = few.velocity_down if few.velocity_down is not None and look.options.use_down else np.zeros(len(few))
    mach = air.mach_from_impact_pressure(few.impact_pressure, few.static_pressure)
    if few.total_temperature is None:
        raise BadInputError("the data of a picture need the temperature")
    temperature = air.air_temperature(few.total_temperature, mach)
    impact = air.impact_pressure_from_true_airspeed(
        np.sqrt(north**2 + east**2 + down**2), few.static_pressure, temperature
    )
    indicated = air.calibrated_airspeed(few.impact_pressure)
    gained = air.calibrated_airspeed(impact) - indicated
    return [
        {
            "kind": "data",
            "on_condition": look.options.on_condition,
            "airspeed_kt": float(speed) / KNOT,
            "correction_kt": float(value) / KNOT,
        }
        for speed, value in zip(indicated, gained, strict=True)
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
