"""Fly a case, sense a flight, and compare answers with the truth of the flight."""

import re
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Union

import numpy as np

from pitotbench import air
from pitotbench.logbook.formats import write_log
from pitotbench.records.calibration import Calibration, ErrorCurve, WindEstimate
from pitotbench.records.case import SLOWEST_RATE, Case, DataSystem, PressureErrorSpec, Wind
from pitotbench.records.flight import Flight, Score
from pitotbench.records.forecast import BriefedLeg
from pitotbench.records.log import FlightLog
from pitotbench.sensing.recorder import known_curve, record, write_truth
from pitotbench.sensing.sampling import data_system
from pitotbench.simulation.aircraft_files import SimulationError
from pitotbench.simulation.sortie import card_of, fly
from pitotbench.units import KNOT, Array, Booleans, MetersPerSecond

if TYPE_CHECKING:
    from pandas import Series


def flown(case: Case) -> FlightLog:
    """Fly a case and record it with its data system."""
    return sense(fly(case))


def fly_to_log(case: Case, path: Path, truth: bool = False) -> FlightLog:
    """Fly a case, record it with its data system, and write the log, with `truth` that too.

    The truth is written next to the log.
    """
    flight = fly(case)
    log = sense(flight)
    write_log(log, path)
    if truth:
        write_truth(flight, path)
    return log


def sense(flight: Flight, das: str | DataSystem | None = None) -> FlightLog:
    """Return the log of a flight by a data system, with the case's sensor seed.

    The system may be given by its name (`20/1`, any `A/G`); None is that of the case.

    Raises BadInputError for a name or a rate that no data system has.
    """
    system = data_system(das) if isinstance(das, str) else das
    return record(flight, system or flight.case.das, flight.case.sensor_seed)


BRIEFED = ("heading", "calibrated_airspeed", "roll")  # channels that a briefing is made of


def briefing_of(flight: Flight) -> tuple[BriefedLeg, ...]:
    """Return the legs of a flight as its pilot is briefed, without the times to settle."""
    edges = np.flatnonzero(flight.segment[1:] != flight.segment[:-1]) + 1
    parts = np.split(np.arange(len(flight)), edges)
    named = [(str(flight.segment[rows[0]]), rows) for rows in parts]
    return tuple(
        BriefedLeg(
            what=re.sub(r"( to)? \d+ kt.*", "", label),
            seconds=float(np.ptp(flight["time"][rows])),
            bank=float(np.median(flight["roll"][rows])),
            heading=float(flight["heading"][rows[-1]]),
            airspeed=float(flight["calibrated_airspeed"][rows[-1]]),
            turned=float(np.ptp(np.unwrap(flight["heading"][rows]))),
        )
        for label, rows in named
        if not label.startswith("settle")
    )


@cache
def briefing(aircraft: str, maneuver: str) -> tuple[BriefedLeg, ...]:
    """Return the legs of a maneuver for an aircraft's pilot, () where there is nothing to fly.

    No maneuver is named then, or the aircraft cannot fly it.
    """
    case = Case(aircraft, maneuver, turbulence="none", integration_rate=SLOWEST_RATE)
    with suppress(SimulationError):
        return briefing_of(fly(case, channels=BRIEFED)) if maneuver else ()
    return ()


def tolerances(case: Case) -> dict[str, float]:
    """Return half-widths of tolerances on the case's card [SI], by channel of the flight."""
    card = card_of(case)
    return {
        "calibrated_airspeed": card.airspeed_tolerance,
        "heading": card.heading_tolerance,
        "altitude": card.altitude_tolerance,
    }


def true_correction(
    spec: PressureErrorSpec, indicated_airspeed: MetersPerSecond
) -> MetersPerSecond:
    """Return true calibrated minus indicated airspeed [m/s] at indicated airspeeds [m/s]."""
    impact = known_curve(spec).impact_pressure(air.impact_pressure(indicated_airspeed))
    return air.calibrated_airspeed(impact) - indicated_airspeed


def wind_toward(wind: Wind) -> Array:
    """Return the mean wind as a velocity toward north, east and down [m/s], (3,)."""
    level = -wind.speed
    return np.array(
        [level * np.cos(wind.from_direction), level * np.sin(wind.from_direction), -wind.up]
    )


# Of indicated airspeed [m/s]: curves are scored and averaged inside it.
SCORED_RANGE = (100.0 * KNOT, 160.0 * KNOT)


@dataclass(frozen=True, slots=True)
class Comparison:
    """Errors of estimates, estimate minus truth, and their stated 2σ, (n,) each.

    The unit is m/s, m for altitudes, or knots where they come from a table in knots. The means are
    in the same unit.
    """

    error: Array
    two_sigma: Array

    @property
    def inside(self) -> float:
        """Share of the errors that are within their 2σ."""
        return float(np.mean(np.abs(self.error) <= self.two_sigma))

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
    """Return the mask of a curve's points in the scored airspeed range, of all if none is inside.

    The airspeeds are indicated.
    """
    low, high = SCORED_RANGE
    inside: Booleans = (curve.indicated_airspeed > low - 0.01) & (
        curve.indicated_airspeed < high + 0.01
    )
    return inside if bool(inside.any()) else np.ones_like(inside)


def compare_curve(curve: ErrorCurve, truth: PressureErrorSpec) -> Comparison:
    """Compare a curve with the truth at its scored points."""
    error, inside = (
        curve.correction - true_correction(truth, curve.indicated_airspeed),
        scored(curve),
    )
    return Comparison(error[inside], curve.two_sigma[inside])


def compare_wind(wind: WindEstimate, truth: Array) -> Comparison:
    """Compare an estimated wind with the true one toward north and east [m/s], (2,)."""
    estimates = (wind.north, wind.east)
    error = np.array([each.value for each in estimates]) - truth
    return Comparison(error, np.array([each.two_sigma for each in estimates]))


def score(calibration: Calibration, flight: Flight) -> Score:
    """Compare a calibration with the truth of the flight behind its log.

    The true wind is the case's mean wind. The mean of the turbulence over the flight counts as an
    error. Raises PressureErrorRangeError where the true curve has no solution at an airspeed of the
    calibration.
    """
    curve = compare_curve(calibration.curve, flight.case.pressure_error)
    wind = compare_wind(calibration.known_wind, wind_toward(flight.case.wind)[:2])
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
