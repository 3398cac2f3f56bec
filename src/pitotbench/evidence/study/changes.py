"""What can be changed about a flight after it was flown, so that one flight answers many questions.

Ground velocity is air velocity plus wind, and a slow or uniform wind leaves the motion through the air alone:
a changed wind is added to the ground velocity of the same flight, exactly. The same holds for what only the
sensors feel.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from pitotbench import bench
from pitotbench.catalog import Catalog
from pitotbench.records.case import PressureErrorSpec
from pitotbench.records.flight import Flight
from pitotbench.timeline import gaps
from pitotbench.units import DEGREE, FOOT, KNOT, Array

MINUTE, HUNDRED_FEET = 60.0, 100.0 * FOOT
SIDESLIP_ERROR = 0.0005  # of q_c a degree squared: 1.25 % at 5°, our estimate for a probe beside the fuselage
TURNING = 10.0 * DEGREE  # of bank: a turn
Change = Callable[[Flight, float], Flight]


def _none(flight: Flight, level: float) -> Flight:
    return flight


def _with(flight: Flight, **channels: Array) -> Flight:
    return replace(flight, channels={**flight.channels, **channels})


def _with_wind(flight: Flight, speed: Array, direction: float) -> Flight:
    """More wind of a speed [m/s] a sample, toward a direction [rad]."""
    north, east = speed * np.cos(direction), speed * np.sin(direction)
    return _with(
        flight,
        velocity_north=flight["velocity_north"] + north,
        velocity_east=flight["velocity_east"] + east,
    )


def _direction(flight: Flight) -> float:
    """A direction that depends on the seed: a change of wind knows nothing of the maneuver's headings."""
    return float(np.random.default_rng([flight.case.truth_seed, 83]).uniform(0.0, 2.0 * np.pi))


def wind_change(flight: Flight, knots_a_minute: float) -> Flight:
    """A wind that grows steadily toward a random direction, with the clock of the flight."""
    since = (flight["time"] - flight["time"].mean()) / MINUTE
    return _with_wind(flight, knots_a_minute * KNOT * since, _direction(flight))


def shear(flight: Flight, knots_a_hundred_feet: float) -> Flight:
    """A wind that grows with altitude toward a random direction."""
    above = (flight["altitude"] - flight["altitude"].mean()) / HUNDRED_FEET
    return _with_wind(flight, knots_a_hundred_feet * KNOT * above, _direction(flight))


def vertical_speed(flight: Flight, times: float) -> Flight:
    """The same airspeed flown with the vertical speed multiplied: the path is steeper, its shadow shorter."""
    wind = bench.wind_toward(flight.case.wind)
    north, east = flight["velocity_north"] - wind[0], flight["velocity_east"] - wind[1]
    down = flight["velocity_down"]
    level, steeper = np.hypot(north, east), np.clip(times * down, -20.0, 20.0)
    shrink = np.sqrt(np.maximum(level**2 + down**2 - steeper**2, 0.0)) / level
    return _with(
        flight,
        velocity_north=wind[0] + shrink * north,
        velocity_east=wind[1] + shrink * east,
        velocity_down=steeper,
    )


def steady_sideslip(flight: Flight, degrees: float) -> Flight:
    """A probe that loses `SIDESLIP_ERROR` of q_c a degree squared, the whole flight slipping."""
    return _slipping(flight, np.full(len(flight), degrees))


def sideslip_in_turns(flight: Flight, degrees: float) -> Flight:
    """The same in turns only, as without rudder: wherever the bank is above ten degrees."""
    return _slipping(flight, np.where(np.abs(flight["roll"]) > TURNING, degrees, 0.0))


def _slipping(flight: Flight, degrees: Array) -> Flight:
    impact = flight["total_pressure"] - flight["static_pressure"]
    return _with(flight, total_pressure=flight["total_pressure"] - SIDESLIP_ERROR * degrees**2 * impact)


def twice_the_rate(flight: Flight, level: float) -> Flight:
    """The flight with a sample between every two, for systems faster than the simulator.

    What moves the air data lies far below the simulator's Nyquist frequency of 50 Hz, so a straight line
    between its samples is close enough.
    """
    time = flight["time"]
    near = np.setdiff1d(np.arange(len(time) - 1), gaps(time) - 1)  # rows with no gap behind them

    def between(values: Array) -> Array:
        return np.insert(values, near + 1, 0.5 * (values[near] + values[near + 1]))

    circular = {"heading": np.unwrap(flight["heading"])}
    channels = {name: between(values) for name, values in {**flight.channels, **circular}.items()}
    order = np.insert(np.arange(len(time)), near + 1, near)
    return Flight(flight.case, channels, flight.segment[order], flight.on_condition[order])


def _truth(spec: PressureErrorSpec) -> Change:
    return lambda flight, level: replace(flight, case=replace(flight.case, pressure_error=spec))


_KNEE_KT = (90.0, 110.0, 120.0, 130.0, 170.0)  # a curve with a knee, as of a static source behind a flap
_KNEE = tuple(knots * KNOT for knots in _KNEE_KT)

CHANGES: Catalog[Change] = Catalog(
    "change",
    {
        "none": _none,
        "wind change": wind_change,
        "shear": shear,
        "vertical speed": vertical_speed,
        "steady sideslip": steady_sideslip,
        "sideslip in turns": sideslip_in_turns,
        "twice the rate": twice_the_rate,
        "constant truth": _truth(PressureErrorSpec(model="bias", parameters=(-0.02,))),
        "linear truth": _truth(PressureErrorSpec(model="linear", parameters=(0.03, -0.025))),
        "quadratic truth": _truth(PressureErrorSpec(model="quadratic", parameters=(0.08, -0.09, 0.02))),
        "knee truth": _truth(
            PressureErrorSpec(model="table", airspeed=_KNEE, values=(0.01, 0.01, -0.01, -0.02, -0.02))
        ),
    },
)
