"""The scorings of the coverage campaign: combinations of wind, systematic errors and stated accuracies."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from pitotbench import air, bench
from pitotbench.calibrate import Accuracies, CalibrationOptions
from pitotbench.catalog import Catalog
from pitotbench.records.flight import Flight
from pitotbench.records.log import FlightLog
from pitotbench.sense import SYSTEMS
from pitotbench.units import Array

STATED = Accuracies(temperature_k=1.0, recovery_factor=0.02, static_pressure_pa=50.0, velocity_mps=0.1)
SLOW_CHANGE, SLOW_TIME = 1.0, 600.0  # a random walk: rms change [m/s] after a time [s]

InWind = Callable[[Flight, int], tuple[Flight, Array]]
WithErrors = Callable[[FlightLog, int], FlightLog]


@dataclass(frozen=True, slots=True)
class Scoring:
    """One way to fly, sense and calibrate, for which the coverage is measured.

    `in_wind` takes a flight and a seed and returns the flight in a changed wind with its mean wind toward north and
    east [m/s]. `with_errors` takes a log and a seed and returns the log with sensor errors. `options` are those of
    the calibration.
    """

    name: str
    systems: tuple[str, ...]
    options: CalibrationOptions
    in_wind: InWind
    with_errors: WithErrors
    against_paper: bool = False


def steady(flight: Flight, seed: int) -> tuple[Flight, Array]:
    """Return the flight unchanged, in the wind of its case."""
    return flight, bench.wind_toward(flight.case.wind)[:2]


def slow(flight: Flight, seed: int) -> tuple[Flight, Array]:
    """Return the flight in a wind that changes as a random walk.

    The airplane flies relative to the air, so its ground velocity changes with the wind.
    """
    elapsed = flight["time"] - flight["time"][0]
    steps = np.random.default_rng([seed, 79]).standard_normal((2, int(elapsed[-1]) + 2))
    walk = np.cumsum(steps, axis=1) * SLOW_CHANGE / np.sqrt(2.0 * SLOW_TIME)
    change = np.stack([np.interp(elapsed, np.arange(walk.shape[1]), part) for part in walk])
    moved = {f"velocity_{axis}": flight[f"velocity_{axis}"] + part for axis, part in _axes(change)}
    mean = bench.wind_toward(flight.case.wind)[:2] + change.mean(axis=1)
    return replace(flight, channels={**flight.channels, **moved}), mean


def as_sensed(log: FlightLog, seed: int) -> FlightLog:
    """Return the log without further errors."""
    return log


def systematic(log: FlightLog, seed: int) -> FlightLog:
    """Return the log with constant errors drawn from the stated accuracies.

    Raises ValueError for a log without a temperature.
    """
    draw = 0.5 * np.random.default_rng([seed, 78]).standard_normal(5)
    if log.total_temperature is None:
        raise ValueError("a synthetic log has a total temperature")
    mach = air.mach_from_impact_pressure(log.impact_pressure, log.static_pressure)
    recovery = 0.2 * STATED.recovery_factor * draw[1] * mach**2 * log.total_temperature
    velocity = STATED.velocity_mps * draw[3:5]
    return replace(
        log,
        total_temperature=log.total_temperature + STATED.temperature_k * draw[0] + recovery,
        static_pressure=log.static_pressure + STATED.static_pressure_pa * draw[2],
        velocity_north=log.velocity_north + velocity[0],
        velocity_east=log.velocity_east + velocity[1],
    )


def _axes(values: Array) -> list[tuple[str, Array]]:
    return list(zip(("north", "east"), values, strict=True))


_ALL = (
    Scoring("constant wind", tuple(SYSTEMS), CalibrationOptions(), steady, as_sensed, against_paper=True),
    Scoring("systematic errors", tuple(SYSTEMS), CalibrationOptions(accuracies=STATED), steady, systematic),
    Scoring("slow wind", ("50/50",), CalibrationOptions(wind="drifting"), slow, as_sensed),
)
SCORINGS: Catalog[Scoring] = Catalog("scoring", {scoring.name: scoring for scoring in _ALL})
