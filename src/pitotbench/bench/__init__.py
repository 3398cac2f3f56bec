"""The conductor: fly, record, calibrate, and hold the answer against the truth. Only this room sees all stages."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from pitotbench import air
from pitotbench.calibrate import CalibrationOptions as CalibrationOptions
from pitotbench.calibrate import calibrate as calibrate
from pitotbench.calibrate import calibrate_together as calibrate_together
from pitotbench.calibrate.gps_legs.leg_points import cross_check as cross_check
from pitotbench.calibrate.gps_legs.leg_points import fixed_speed_points as fixed_speed_points
from pitotbench.logbook import atomic, write_log
from pitotbench.pressure_error import MODELS, PressureErrorCurve, TableCurve
from pitotbench.records.calibration import Calibration, ErrorCurve
from pitotbench.records.case import Case, PressureErrorSpec, Wind
from pitotbench.records.flight import Flight
from pitotbench.records.log import FlightLog
from pitotbench.records.score import Score
from pitotbench.sense import data_system, record, write_truth
from pitotbench.simulate import MANEUVERS
from pitotbench.simulate import fly as fly
from pitotbench.simulate.maneuvers.card import override
from pitotbench.units import KNOT, Array, Booleans, MetersPerSecond

SCORED_RANGE = (100.0 * KNOT, 160.0 * KNOT)  # indicated airspeed over which curves are scored and averaged


def fly_to_log(case: Case, path: Path, truth: bool = False) -> FlightLog:
    """Fly a case, record it with its own data system and write the log; the truth beside it where asked for."""
    flight = fly(case)
    log = record(flight, case.das, case.sensor_seed)
    write_log(log, path)
    if truth:
        write_truth(flight, path)
    return log


def write_text(path: Path, text: str) -> None:
    """Write a text file whole or not at all."""
    with atomic(path) as scratch:
        scratch.write_text(text, encoding="utf-8")


def sense(flight: Flight, das: str) -> FlightLog:
    """The log that a named data system (`20/1`, any `A/G`) makes of a flight, with the case's sensor seed."""
    return record(flight, data_system(das), flight.case.sensor_seed)


def with_das(case: Case, das: str) -> Case:
    """The same case with another data system."""
    return replace(case, das=data_system(das))


def tolerances(case: Case) -> dict[str, float]:
    """Half-widths of the tolerances on the case's card [SI], by channel of the flight."""
    card = override(MANEUVERS[case.maneuver].card, case.card)
    return {
        "calibrated_airspeed": card.airspeed_tolerance,
        "heading": card.heading_tolerance,
        "altitude": card.altitude_tolerance,
    }


def true_curve(spec: PressureErrorSpec) -> PressureErrorCurve | TableCurve:
    """The known pressure error of a case."""
    if spec.model == "table":
        return TableCurve(spec.airspeed, spec.values)
    return PressureErrorCurve(MODELS[spec.model], spec.parameters, spec.reference_pressure)


def true_correction(spec: PressureErrorSpec, indicated_airspeed: MetersPerSecond) -> MetersPerSecond:
    """True calibrated minus indicated airspeed [m/s] at indicated airspeeds [m/s]."""
    impact = true_curve(spec).impact_pressure(air.impact_pressure(indicated_airspeed))
    return air.calibrated_airspeed(impact) - indicated_airspeed


def wind_toward(wind: Wind) -> Array:
    """The mean wind as a velocity toward north, east and down [m/s], (3,)."""
    level = -wind.speed
    return np.array([level * np.cos(wind.from_direction), level * np.sin(wind.from_direction), -wind.up])


def scored(curve: ErrorCurve) -> Booleans:
    """Mask of the curve's points inside the scored range of indicated airspeed."""
    low, high = SCORED_RANGE
    inside: Booleans = (curve.indicated_airspeed > low - 0.01) & (curve.indicated_airspeed < high + 0.01)
    return inside if bool(inside.any()) else np.ones_like(inside)


def score(calibration: Calibration, flight: Flight) -> Score:
    """Hold a calibration against the truth of the flight behind its log.

    The true wind is the case's mean wind: what turbulence adds on average belongs to the error.
    """
    curve, inside = calibration.curve, scored(calibration.curve)
    error = (curve.correction - true_correction(flight.case.pressure_error, curve.indicated_airspeed))[inside]
    wind = np.array([calibration.wind.north.value, calibration.wind.east.value])
    return Score(
        minutes=flight.duration / 60.0,
        samples=calibration.samples,
        residual_two_sigma=calibration.residual_two_sigma,
        two_sigma=float(np.mean(curve.two_sigma[inside])),
        curve_rms_error=float(np.sqrt(np.mean(error**2))),
        wind_error=float(np.linalg.norm(wind - wind_toward(flight.case.wind)[:2])),
        curve_coverage=float(np.mean(np.abs(error) <= curve.two_sigma[inside])),
        on_condition_share=float(np.mean(flight.on_condition)),
    )
