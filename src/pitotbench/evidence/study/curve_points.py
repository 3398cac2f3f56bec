"""Curves to look at: a calibration over airspeed, and the points of the conventional method beside it."""

import numpy as np

from pitotbench import air, bench
from pitotbench.calibrate import fixed_speed
from pitotbench.evidence.study.looks import Look
from pitotbench.evidence.study.measures import Row
from pitotbench.records.calibration import Calibration
from pitotbench.records.flight import Flight
from pitotbench.records.log import FlightLog
from pitotbench.units import KNOT

_FEWEST = 4  # legs of a speed


def curve_rows(flight: Flight, look: Look, result: Calibration) -> list[Row]:
    """A curve [kt] with the 2σ of its method, the 2σ of the residual and the truth, over indicated airspeed."""
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
    """The four-leg method at each speed of a 4-Leg log: calibrated minus indicated airspeed [kt].

    The conventional reduction: the mean ground velocity of every leg on condition, one true airspeed a circuit.
    """
    if log.segment is None or log.on_condition is None or log.total_temperature is None:
        return []
    names = np.array([name if name.startswith("leg") else "" for name in log.segment])
    rows: list[Row] = []
    for speed in dict.fromkeys(name.split()[1] for name in names if name):
        of_speed = np.char.startswith(names, f"leg {speed} ") & log.on_condition
        legs = [of_speed & (names == name) for name in dict.fromkeys(names[of_speed].tolist())]
        if len(legs) == _FEWEST:
            rows.append(_point(log, of_speed, legs))
    return rows


def _point(log: FlightLog, rows: np.ndarray, legs: list[np.ndarray]) -> Row:
    north = np.array([log.velocity_north[leg].mean() for leg in legs])
    east = np.array([log.velocity_east[leg].mean() for leg in legs])
    found = fixed_speed(np.hypot(north, east), np.arctan2(east, north))
    static, impact = float(log.static_pressure[rows].mean()), float(log.impact_pressure[rows].mean())
    assert log.total_temperature is not None
    mach = air.mach_from_impact_pressure(impact, static)
    temperature = air.air_temperature(float(log.total_temperature[rows].mean()), mach)
    true_impact = air.impact_pressure_from_true_airspeed(found.true_airspeed, static, temperature)
    indicated = float(air.calibrated_airspeed(impact))
    return {
        "kind": "fixed speed",
        "airspeed_kt": indicated / KNOT,
        "correction_kt": (float(air.calibrated_airspeed(true_impact)) - indicated) / KNOT,
    }
