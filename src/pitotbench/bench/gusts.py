"""Add gusts to a flight in smooth air, by Dryden turbulence drawn at random along it.

The spectra are those of MIL-F-8785C (1980), 3.7.2.1, above 2,000 ft: longitudinal H(s) ∝ 1/(1 +
s/a) and lateral H(s) ∝ (1 + √3 s/a)/(1 + s/a)² with a = V/L. Both have the same variance. At low
frequencies the lateral gust has half the power of the longitudinal one. The axes of the simulator's
turbulence are fixed to the ground and do not turn with the airplane. The longitudinal axis is the
direction that the wind comes from, mirrored about north; this was found from simulated flights.
"""

from dataclasses import replace
from math import sqrt

import numpy as np
from scipy.linalg import solve_banded

from pitotbench import air
from pitotbench.effects.air import LENGTH as LENGTH_FT
from pitotbench.records.case import TURBULENCE_SEVERITY, Case
from pitotbench.records.flight import Flight
from pitotbench.timeline import interval
from pitotbench.units import FOOT, Array

LENGTH = LENGTH_FT * FOOT  # of the Dryden spectra, above 2,000 ft
# of one isotropic process with the mean low-frequency power of both components
MEAN_LENGTH = 0.75 * LENGTH
# MIL-F-8785C, Fig. 7: standard deviation [ft/s] at heights [ft], by severity.
_HEIGHTS = (500.0, 1750.0, 3750.0, 7500.0, 15000.0)
_DEVIATIONS = {0: (0.0,) * 5, 1: (3.2, 2.2, 1.5, 0.0, 0.0), 2: (4.2, 3.6, 3.3, 1.6, 0.0)}
_STEP = 0.1  # s between two samples of the gust: one draw serves flights of any rate


def gust_deviation(case: Case) -> float:
    """Return the deviation [m/s] of each horizontal gust component at the height of a case."""
    severity = TURBULENCE_SEVERITY[case.turbulence]
    return float(np.interp(case.altitude / FOOT, _HEIGHTS, _DEVIATIONS[severity])) * FOOT


def with_gusts(flight: Flight, turbulence: str, seed: int) -> Flight:
    """Return the smooth flight with the airspeed and total pressure that turbulence gives it.

    The ground velocity does not change: the airplane is too heavy to follow gusts of this length.
    """
    case = replace(flight.case, turbulence=turbulence, truth_seed=seed, sensor_seed=seed)
    deviation = gust_deviation(case)
    if deviation == 0.0:
        return replace(flight, case=case)
    gust = deviation * _gust(flight, seed)
    north, east = (
        flight[f"velocity_{axis}"] - flight[f"wind_{axis}"] - part
        for axis, part in zip(("north", "east"), gust, strict=True)
    )
    down = flight["velocity_down"] - flight["wind_down"]
    airspeed = np.sqrt(north**2 + east**2 + down**2)
    impact = air.impact_pressure_from_true_airspeed(
        airspeed, flight["static_pressure"], flight["air_temperature"]
    )
    changed = {"true_airspeed": airspeed, "total_pressure": flight["static_pressure"] + impact}
    return replace(flight, case=case, channels={**flight.channels, **changed})


def _gust(flight: Flight, seed: int) -> Array:
    """Return a gust toward north and east of unit variance, (2, n), at the flight's samples."""
    rows = np.arange(0, len(flight), round(_STEP / interval(flight["time"])))
    time, rate = flight["time"][rows], flight["true_airspeed"][rows] / LENGTH
    along, across = (
        _dryden(time, rate, np.random.default_rng([seed, axis, 1750])) for axis in (0, 1)
    )
    axis = -flight.case.wind.from_direction
    north = np.cos(axis) * along[0] - np.sin(axis) * across[1]
    east = np.sin(axis) * along[0] + np.cos(axis) * across[1]
    return np.stack([np.interp(flight["time"], time, part) for part in (north, east)])


def _dryden(time: Array, rate: Array, rng: np.random.Generator) -> tuple[Array, Array]:
    """Return a longitudinal and a lateral gust of unit variance, (n,) each, from one white noise.

    Two states of unit and half variance, x' = −a x + √(2a) w and y' = a (x − y), integrated exactly
    over steps of any length. The lateral gust is (√3 x + (1 − √3) y)/√2.
    """
    first, second = rng.standard_normal((len(time), 2)).T
    step = np.diff(time) * rate[1:]
    decay = np.exp(-step)
    left_x = np.maximum(1.0 - decay * decay, 1e-15)
    left_xy = 0.5 - decay * decay * (step + 0.5)
    left_y = 0.5 - decay * decay * (step * step + step + 0.5)
    common, own = (
        first[1:] / np.sqrt(left_x),
        np.sqrt(np.maximum(left_y - left_xy * left_xy / left_x, 0.0)),
    )
    x = _recursion(decay, float(first[0]), left_x * common)
    start = float(0.5 * first[0] + 0.5 * second[0])
    y = _recursion(decay, start, decay * step * x[:-1] + left_xy * common + own * second[1:])
    lateral = (sqrt(3.0) * x + (1.0 - sqrt(3.0)) * y) / sqrt(2.0)
    return x, lateral


def _recursion(decay: Array, start: float, pushes: Array) -> Array:
    """Return x with x₀ the start and xₖ = decayₖ xₖ₋₁ + pushₖ, (n + 1,)."""
    bands = np.stack([np.ones(len(decay) + 1), np.append(-decay, 0.0)])
    return np.asarray(solve_banded((1, 0), bands, np.append(start, pushes)))
