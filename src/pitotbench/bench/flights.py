"""Fly a case, sense a flight, and give the error curve and the wind that are known for it."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from pitotbench import air
from pitotbench.logbook import write_log
from pitotbench.pressure_error import MODELS, PressureErrorCurve, TableCurve
from pitotbench.records.case import Case, DataSystem, PressureErrorSpec, Wind
from pitotbench.records.flight import Flight
from pitotbench.records.log import FlightLog
from pitotbench.sense import data_system, record, write_truth
from pitotbench.simulate import fly
from pitotbench.simulate.maneuvers.scaled_card import card_of
from pitotbench.units import Array, Meters, MetersPerSecond


def flown(case: Case) -> FlightLog:
    """Fly a case and record it with its data system."""
    return record(fly(case), case.das, case.sensor_seed)


def fly_to_log(case: Case, path: Path, truth: bool = False) -> FlightLog:
    """Fly a case, record it with its data system and write the log; with `truth`, write the truth next to it."""
    flight = fly(case)
    log = record(flight, case.das, case.sensor_seed)
    write_log(log, path)
    if truth:
        write_truth(flight, path)
    return log


def sense(flight: Flight, das: str | DataSystem) -> FlightLog:
    """Return the log of a flight by a data system or its name (`20/1`, any `A/G`), with the case's sensor seed.

    Raises BadInputError for a name or a rate that no data system has.
    """
    system = data_system(das) if isinstance(das, str) else das
    return record(flight, system, flight.case.sensor_seed)


def with_das(case: Case, das: str) -> Case:
    """Return the same case with another data system."""
    return replace(case, das=data_system(das))


def tolerances(case: Case) -> dict[str, float]:
    """Return the half-widths of the tolerances on the case's card [SI], by channel of the flight."""
    card = card_of(case)
    return {
        "calibrated_airspeed": card.airspeed_tolerance,
        "heading": card.heading_tolerance,
        "altitude": card.altitude_tolerance,
    }


def true_curve(spec: PressureErrorSpec) -> PressureErrorCurve | TableCurve:
    """Return the known pressure error of a case."""
    if spec.model == "table":
        return TableCurve(spec.airspeed, spec.values)
    return PressureErrorCurve(MODELS[spec.model], spec.parameters, spec.reference_pressure)


def true_correction(spec: PressureErrorSpec, indicated_airspeed: MetersPerSecond) -> MetersPerSecond:
    """Return true calibrated minus indicated airspeed [m/s] at indicated airspeeds [m/s]."""
    impact = true_curve(spec).impact_pressure(air.impact_pressure(indicated_airspeed))
    return air.calibrated_airspeed(impact) - indicated_airspeed


def true_altitude_correction(
    spec: PressureErrorSpec, indicated_airspeed: MetersPerSecond, static_pressure: float
) -> Meters:
    """Return true minus indicated pressure altitude [m] at indicated airspeeds [m/s].

    `static_pressure` [Pa] is the indicated one. Only an error of the static source changes it.
    """
    if spec.location != "static":
        return np.zeros_like(indicated_airspeed)
    indicated = air.impact_pressure(indicated_airspeed)
    error = true_curve(spec).impact_pressure(indicated) - indicated
    return air.pressure_altitude(static_pressure - error) - air.pressure_altitude(static_pressure)


def wind_toward(wind: Wind) -> Array:
    """Return the mean wind as a velocity toward north, east and down [m/s], (3,)."""
    level = -wind.speed
    return np.array([level * np.cos(wind.from_direction), level * np.sin(wind.from_direction), -wind.up])
