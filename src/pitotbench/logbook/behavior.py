"""Judge drafted columns by what they do in flight.

A ground speed moves the position, a track is its course, and an outside temperature falls with
height.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pitotbench import air
from pitotbench.logbook.columns import Table, numbers
from pitotbench.logbook.guess import Guess
from pitotbench.scatter import NORMAL
from pitotbench.units import DEGREE, Array, to_si

_EARTH = 6371e3  # m, mean radius: a speed within 1 % is enough to distinguish units
_BASE = 2.0  # s to either side over which positions and heights are differenced
_MOVING = 5.0  # m/s, above which a course is known
_FEWEST = 16  # rows that show what a column does
_SAME_SPEED = 0.07  # of the speed; units of speed differ by 9 % or more
_SAME_COURSE = 1.5  # degrees rms: whole degrees, and positions to a meter
_DELAYED = 4.0  # degrees: half a second in a turn of 6 to 8 degrees a second
_STEADY = 5.0  # degrees about a constant, the magnetic variation
_CLIMBING = 0.5  # correlation with the change of height above which a vertical speed is one
_SAME_CLIMB = 0.25  # of the vertical speed; its units differ by a factor of 3 and more
_HEIGHTS = 250.0  # m between the 5 % and 95 % quantiles of height, over which a lapse shows
_OF_AIR = re.compile("air|amb|oat|out|sat|static|ta|total")  # in the name of a temperature
_COUNTED = re.compile("sat(?!.*temp)")  # in the name of what may be a number of satellites
_MOST_SATELLITES = 60  # in view of a receiver of all systems
_LAPSES = (-15e-3, -1.5e-3)  # K/m: of superadiabatic air at the ground, and under an inversion


@dataclass(frozen=True, slots=True)
class Movement:
    """What the log says of the flight, (n,) each, NaN where unknown.

    Time [s], velocity toward north and east, climb [m/s], height [m]. `absolute`: the size of the
    velocity is known.
    """

    time: Array
    velocity: tuple[Array, Array]
    climb: Array
    height: Array
    absolute: bool


def judged(table: Table, chosen: Sequence[Guess]) -> list[Guess]:
    """Return the guesses after a look at what their columns do.

    Units that the movement contradicts go, a heading that is the course becomes the track, a
    vertical speed gets its sign. A guess that its column contradicts carries a question. Where the
    log holds no position, velocity or height, the guesses stay as they are.
    """
    found = {guess.quantity: guess for guess in chosen}
    movement = _movement(table, found)
    if movement is None:
        return list(chosen)
    kept = []
    for guess in chosen:
        look = _LOOKS.get(guess.quantity)
        if look is not None:
            values = numbers(guess.theirs, table.column(guess.theirs)) * guess.factor
            seen = look(guess, values, movement)
            # In light wind a heading is nearly the track, for which another column stands.
            guess = guess if seen.quantity != guess.quantity and seen.quantity in found else seen
        kept.append(guess)
    return kept


def _movement(table: Table, found: Mapping[str, Guess]) -> Movement | None:
    certain = [name for name in _MOVES if name in found and len(found[name].units) == 1]
    known = {name: found[name].values(table) for name in certain}
    if "time" not in known or len(known["time"]) < _FEWEST:
        return None
    time = known["time"]
    if "static_pressure" in known:
        low = np.maximum(known["static_pressure"], 1.0)
        known["pressure_altitude"] = np.asarray(air.pressure_altitude(low))
    nothing = np.full(len(time), np.nan)
    height = known.get("pressure_altitude", known.get("altitude", nothing))
    velocity = known.get("velocity_north", nothing), known.get("velocity_east", nothing)
    absolute = {"latitude", "longitude"} <= known.keys()
    if absolute:
        latitude, longitude = known["latitude"], np.unwrap(np.nan_to_num(known["longitude"]))
        velocity = (
            _EARTH * _rate(time, latitude),
            _EARTH * _rate(time, longitude) * np.cos(latitude),
        )
    return Movement(time, velocity, _rate(time, height), height, absolute)


_MOVES = (
    "time",
    "latitude",
    "longitude",
    "velocity_north",
    "velocity_east",
    "static_pressure",
    "pressure_altitude",
    "altitude",
)


def _rate(time: Array, values: Array) -> Array:
    """The change of values a second over twice `_BASE`, or between rows of a slower log, (n,)."""
    rows = np.arange(len(time))
    after = np.maximum(np.searchsorted(time, time + _BASE), rows + 1).clip(max=len(time) - 1)
    before = np.minimum(np.searchsorted(time, time - _BASE), rows - 1).clip(min=0)
    with np.errstate(all="ignore"):
        return np.asarray((values[after] - values[before]) / (time[after] - time[before]))


def _look_at_speed(guess: Guess, values: Array, movement: Movement) -> Guess:
    """Keep the unit in which a speed over ground, or a component of it, moves the position."""
    north, east = np.abs(movement.velocity)
    moved = {"velocity_north": north, "velocity_east": east, "ground_speed": np.hypot(north, east)}
    speed = moved[guess.quantity]
    rows = np.isfinite(values) & (speed > _MOVING)
    if not movement.absolute or rows.sum() < _FEWEST:
        return guess
    for unit in guess.units:
        times = float(np.median(np.abs(to_si(values[rows], unit)) / speed[rows]))
        if abs(times - 1.0) < _SAME_SPEED:
            return replace(guess, units=(unit,), stated=True)
    return replace(
        guess,
        doubt=f"is it the {guess.quantity.replace('_', ' ')}? The position moves at another one",
    )


def _look_at_direction(guess: Guess, values: Array, movement: Movement) -> Guess:
    """Tell a course over ground, true or magnetic, from a heading."""
    north, east = movement.velocity
    rows = np.isfinite(values) & (np.hypot(north, east) > (_MOVING if movement.absolute else 0.0))
    if rows.sum() < _FEWEST:
        return guess
    turn = np.exp(1j * (to_si(values[rows], guess.units[0]) - np.arctan2(east, north)[rows]))
    middle = np.median(turn.real) + 1j * np.median(turn.imag)
    offset = abs(float(np.angle(middle))) / DEGREE
    scatter = NORMAL * float(np.median(np.abs(np.angle(turn / middle)))) / DEGREE
    if offset < _DELAYED and scatter < _SAME_COURSE:
        return replace(guess, quantity="track")
    if guess.quantity.endswith("heading") or not movement.absolute:
        return guess
    if scatter < _STEADY:
        return replace(guess, quantity="magnetic_track")
    return replace(guess, doubt="is it the track? The position moves on another course")


def _look_at_climb(guess: Guess, values: Array, movement: Movement) -> Guess:
    """Give a vertical speed the sign and the unit in which it is the change of height."""
    rows = np.isfinite(values + movement.climb)
    climb, down = movement.climb[rows], values[rows]
    agreement = -_agreement(climb, down)
    if len(climb) < _FEWEST or abs(agreement) < _CLIMBING:
        return guess
    size = np.sqrt(np.sum(climb**2) / np.sum(down**2))
    for unit in guess.units:
        if abs(size / float(to_si(1.0, unit)) - 1.0) < _SAME_CLIMB:
            factor = float(np.sign(agreement)) * guess.factor
            return replace(guess, units=(unit,), factor=factor, score=1.0, stated=True)
    return replace(guess, doubt="is it the vertical speed? The height changes at another one")


def _look_at_roll(guess: Guess, values: Array, movement: Movement) -> Guess:
    """Give a roll the sign in which it turns the course: to the right counts positive."""
    north, east = movement.velocity
    turn = _rate(movement.time, np.unwrap(np.nan_to_num(np.arctan2(east, north))))
    return guess if _agreement(values, turn) > -_CLIMBING else replace(guess, factor=-guess.factor)


def _agreement(one: Array, other: Array) -> float:
    """Return the cosine of the angle between two series, (n,) each: 0 where one of them is zero."""
    one, other = np.nan_to_num(one), np.nan_to_num(other)
    power = float(np.sum(one**2) * np.sum(other**2))
    return float(np.sum(one * other)) / np.sqrt(power) if power else 0.0


def _look_at_warmth(guess: Guess, values: Array, movement: Movement) -> Guess:
    """Ask for a temperature that does not fall with height.

    Ask also for one of which neither height nor name tells whose it is: most are of a box.
    """
    rows = np.isfinite(values + movement.height)
    height = movement.height[rows]
    if _COUNTED.search(guess.theirs.lower()) and _counts(values[rows]):
        return replace(guess, doubt="is it the air's, or a number of satellites?")
    if len(height) < _FEWEST or np.subtract(*np.quantile(height, [0.95, 0.05])) < _HEIGHTS:
        of_air = _OF_AIR.search(guess.theirs.lower())
        return guess if of_air else replace(guess, doubt="is it the air's, or that of a box?")
    # A log that climbs alone cannot tell the height from the hour, so the hour counts for nothing.
    slope = float(np.polyfit(height, to_si(values[rows], guess.units[0]), 1)[0])
    if _LAPSES[0] < slope < _LAPSES[1]:
        return guess
    return replace(
        guess,
        doubt=f"is it the air's? It changes by {1e3 * slope:+.1f} K in 1,000 m, the air by about "
        "−6.5",
    )


def _counts(values: Array) -> bool:
    """Return whether values are whole numbers such as those of satellites in view."""
    whole = bool(np.all(values == np.round(values)))
    return whole and bool(np.all((values >= 0.0) & (values <= _MOST_SATELLITES)))


_LOOKS = {
    "ground_speed": _look_at_speed,
    "velocity_north": _look_at_speed,
    "velocity_east": _look_at_speed,
    "track": _look_at_direction,
    "magnetic_track": _look_at_direction,
    "heading": _look_at_direction,
    "magnetic_heading": _look_at_direction,
    "velocity_down": _look_at_climb,
    "roll": _look_at_roll,
    "air_temperature": _look_at_warmth,
}
