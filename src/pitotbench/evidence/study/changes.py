"""Changes to a flight after it was flown, so that one flight answers many questions.

Ground velocity is air velocity plus wind, and a slow or uniform wind does not change the motion through the air. So
a change of wind is exact when it is added to the ground velocity of the same flight. A change that acts only on the
sensors is exact for the same reason.
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
SIDESLIP_ERROR = 0.0005  # of q_c a degree squared: 1.25 % at 5°, our estimate for a probe next to the fuselage
TURNING = 10.0 * DEGREE  # of bank: above it the airplane turns
Change = Callable[[Flight, float], Flight]


def _none(flight: Flight, level: float) -> Flight:
    return flight


def _with(flight: Flight, **channels: Array) -> Flight:
    return replace(flight, channels={**flight.channels, **channels})


def _with_wind(flight: Flight, speed: Array, direction: float) -> Flight:
    """Return the flight with more wind toward a direction [rad], of a speed [m/s] at each sample."""
    north, east = speed * np.cos(direction), speed * np.sin(direction)
    return _with(
        flight,
        velocity_north=flight["velocity_north"] + north,
        velocity_east=flight["velocity_east"] + east,
    )


def _direction(flight: Flight) -> float:
    """Draw a direction [rad] from the seed, so that it does not depend on the maneuver's headings."""
    return float(np.random.default_rng([flight.case.truth_seed, 83]).uniform(0.0, 2.0 * np.pi))


def wind_change(flight: Flight, knots_a_minute: float) -> Flight:
    """Return the flight in a wind that grows steadily with time toward a random direction."""
    since = (flight["time"] - flight["time"].mean()) / MINUTE
    return _with_wind(flight, knots_a_minute * KNOT * since, _direction(flight))


def shear(flight: Flight, knots_a_hundred_feet: float) -> Flight:
    """Return the flight in a wind that grows with altitude toward a random direction."""
    above = (flight["altitude"] - flight["altitude"].mean()) / HUNDRED_FEET
    return _with_wind(flight, knots_a_hundred_feet * KNOT * above, _direction(flight))


def vertical_speed(flight: Flight, times: float) -> Flight:
    """Return the flight at the same airspeed with the vertical speed multiplied and less ground speed."""
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
    """Return the flight with a constant sideslip; the probe loses `SIDESLIP_ERROR` of q_c a degree squared."""
    return _slipping(flight, np.full(len(flight), degrees))


def sideslip_in_turns(flight: Flight, degrees: float) -> Flight:
    """Return the flight with sideslip in turns only, as without rudder: where the bank is above ten degrees."""
    return _slipping(flight, np.where(np.abs(flight["roll"]) > TURNING, degrees, 0.0))


def _slipping(flight: Flight, degrees: Array) -> Flight:
    impact = flight["total_pressure"] - flight["static_pressure"]
    return _with(flight, total_pressure=flight["total_pressure"] - SIDESLIP_ERROR * degrees**2 * impact)


def twice_the_rate(flight: Flight, level: float) -> Flight:
    """Return the flight with one more sample between every two, for systems faster than the simulator.

    The frequencies of the air data are far below the simulator's Nyquist frequency of 50 Hz, so linear
    interpolation is accurate enough.
    """
    time = flight["time"]
    near = np.setdiff1d(np.arange(len(time) - 1), gaps(time) - 1)  # rows without a gap after them

    def between(values: Array) -> Array:
        return np.insert(values, near + 1, 0.5 * (values[near] + values[near + 1]))

    circular = {"heading": np.unwrap(flight["heading"])}
    channels = {name: between(values) for name, values in {**flight.channels, **circular}.items()}
    order = np.insert(np.arange(len(time)), near + 1, near)
    return Flight(flight.case, channels, flight.segment[order], flight.on_condition[order])


def _truth(spec: PressureErrorSpec) -> Change:
    return lambda flight, level: replace(flight, case=replace(flight.case, pressure_error=spec))


def error_size(flight: Flight, times: float) -> Flight:
    """Return the flight with its pressure error multiplied."""
    spec = flight.case.pressure_error
    larger = replace(spec, parameters=tuple(times * k for k in spec.parameters))
    return replace(flight, case=replace(flight.case, pressure_error=larger))


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
        "error size": error_size,
        "constant truth": _truth(PressureErrorSpec(model="bias", parameters=(-0.02,))),
        "linear truth": _truth(PressureErrorSpec(model="linear", parameters=(0.03, -0.025))),
        "quadratic truth": _truth(PressureErrorSpec(model="quadratic", parameters=(0.08, -0.09, 0.02))),
        "knee truth": _truth(
            PressureErrorSpec(model="table", airspeed=_KNEE, values=(0.01, 0.01, -0.01, -0.02, -0.02))
        ),
    },
)
