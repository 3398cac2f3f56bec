"""Judge drafted columns by what they do: a ground speed moves the position, a track is its course,
an outside temperature falls with height.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pitotbench import air
from pitotbench.logbook.columns import Table, numbers
from pitotbench.logbook.guess import Guess
from pitotbench.units import DEGREE, STANDARD_GRAVITY, Array, Booleans, Radians, to_si

_EARTH = 6371e3  # m, mean radius: a speed within 1 % is enough to tell units apart
_BASE = 2.0  # s to either side over which positions and heights are differenced
_MOVING = 5.0  # m/s, above which a course is known
_FEWEST = 16  # rows that show what a column does
_SAME_SPEED = 0.07  # of the speed; units of speed differ by 9 % or more
_SAME_COURSE = 2.5  # degrees rms: whole degrees, and a receiver that smooths
_STEADY = 5.0  # degrees rms about a constant: the magnetic variation
_VARIATION = 3.0  # degrees that are a magnetic variation and no delay
_CLIMBING = 0.5  # correlation with the change of height above which a vertical speed is one
_SAME_CLIMB = 0.25  # of the vertical speed; its units differ by 3 and more
_HEIGHTS = 250.0  # m between the 5 % and 95 % quantiles of height, over which a lapse shows
_LAPSES = (-15e-3, -1.5e-3)  # K/m: superadiabatic air close to the ground, and an inversion


@dataclass(frozen=True, slots=True)
class Movement:
    """What the other columns say of the flight, (n,) each, NaN where unknown: the velocity over
    ground and the climb [m/s], the height [m]. `absolute`: the size of the velocity is known.
    """

    time: Array
    north: Array
    east: Array
    climb: Array
    height: Array
    absolute: bool

    @property
    def moving(self) -> Booleans:
        """The rows in which the course is known."""
        fast = np.hypot(self.north, self.east) > (_MOVING if self.absolute else 0.0)
        return np.asarray(fast & np.isfinite(self.north + self.east))


def judged(table: Table, chosen: Sequence[Guess]) -> list[Guess]:
    """Return the guesses after a look at what their columns do.

    Units that the movement contradicts go, a heading that is the course becomes the track, a
    vertical speed gets its sign. A guess that its column contradicts is left out; one that cannot
    be looked at, and that names a temperature, carries its question. Where the log holds neither
    position nor velocity, the guesses stay as they are.
    """
    found = {guess.quantity: guess for guess in chosen}
    movement = _movement(table, found)
    if movement is None:
        return list(chosen)
    kept = []
    for guess in chosen:
        look = _LOOKS.get(guess.quantity)
        seen = guess if look is None else look(guess, _values(table, guess), movement, found)
        if seen is not None:
            kept.append(seen)
    return kept


def _values(table: Table, guess: Guess) -> Array:
    """The numbers of a column as they are written, but for the factor of its guess, (n,)."""
    return numbers(guess.theirs, table.column(guess.theirs)) * guess.factor


def _first(table: Table, found: Mapping[str, Guess], *names: str) -> Array | None:
    """The values [SI] of the first quantity that has a column, in its likeliest unit."""
    guess = next((found[name] for name in names if name in found), None)
    return None if guess is None else guess.values(table)


def _movement(table: Table, found: Mapping[str, Guess]) -> Movement | None:
    time = _first(table, found, "time")
    if time is None or len(time) < _FEWEST:
        return None
    nothing = np.full(len(time), np.nan)
    height = _first(table, found, "pressure_altitude", "altitude", "indicated_altitude")
    static = _first(table, found, "static_pressure")
    if height is None and static is not None:
        height = np.asarray(air.pressure_altitude(np.maximum(static, 1.0)))
    latitude, longitude = (_first(table, found, name) for name in ("latitude", "longitude"))
    if latitude is not None and longitude is not None:
        north = _EARTH * _rate(time, latitude)
        east = _EARTH * _rate(time, np.unwrap(np.nan_to_num(longitude))) * np.cos(latitude)
    elif {"velocity_north", "velocity_east"} <= found.keys():
        north, east = (_values(table, found[f"velocity_{axis}"]) for axis in ("north", "east"))
    elif height is not None:
        north = east = nothing
    else:
        return None
    climb = nothing if height is None else _rate(time, height)
    return Movement(
        time, north, east, climb, nothing if height is None else height, latitude is not None
    )


def _rate(time: Array, values: Array) -> Array:
    """The change of values a second over twice `_BASE`, (n,); NaN where the clock stands."""
    after = np.minimum(np.searchsorted(time, time + _BASE), len(time) - 1)
    before = np.maximum(np.searchsorted(time, time - _BASE, side="right") - 1, 0)
    after, before = (
        np.maximum(after, np.minimum(np.arange(len(time)) + 1, len(time) - 1)),
        np.minimum(before, np.maximum(np.arange(len(time)) - 1, 0)),
    )
    with np.errstate(all="ignore"):
        rate = (values[after] - values[before]) / (time[after] - time[before])
    return np.where(np.isfinite(rate), rate, np.nan)


def _look_at_speed(
    guess: Guess, values: Array, movement: Movement, found: Mapping[str, Guess]
) -> Guess | None:
    """Keep the units in which a ground speed moves the position."""
    rows = movement.moving & np.isfinite(values)
    if not movement.absolute or rows.sum() < _FEWEST:
        return guess
    speed = np.hypot(movement.north, movement.east)[rows]
    fits = [
        unit
        for unit in guess.units
        if abs(float(np.median(to_si(values[rows], unit) / speed)) - 1.0) < _SAME_SPEED
    ]
    if fits:
        return replace(guess, units=(fits[0],), stated=True)
    return replace(guess, doubt="is it the ground speed? The position moves at another one")


def _look_at_direction(
    guess: Guess, values: Array, movement: Movement, found: Mapping[str, Guess]
) -> Guess | None:
    """Tell a course over ground, true or magnetic, from a heading."""
    angle: Radians = to_si(values, guess.units[0])
    rows = movement.moving & np.isfinite(angle)
    if rows.sum() < _FEWEST:
        return guess
    course = np.arctan2(movement.east, movement.north)[rows]
    apart = np.exp(1j * (angle[rows] - course))
    middle = float(np.angle(np.median(apart.real) + 1j * np.median(apart.imag))) / DEGREE
    about = np.abs(np.angle(apart * np.exp(-1j * middle * DEGREE))) / DEGREE
    scatter = float(np.median(about)) / 0.6745  # the median of |x| of a normal distribution
    is_course = scatter < _SAME_COURSE and abs(middle) < _VARIATION
    if guess.quantity.endswith("heading"):
        if not is_course:
            return guess
        return None if "track" in found else replace(guess, quantity="track", stated=True)
    if is_course or not movement.absolute:
        return replace(guess, quantity="track") if is_course else guess
    if scatter < _STEADY:
        return replace(guess, quantity="magnetic_track")
    return replace(guess, doubt="is it the track? The position moves on another course")


def _look_at_climb(
    guess: Guess, values: Array, movement: Movement, found: Mapping[str, Guess]
) -> Guess | None:
    """Give a vertical speed the sign and the unit in which it is the change of height."""
    rows = np.isfinite(values) & np.isfinite(movement.climb)
    climb, down = movement.climb[rows], values[rows]
    if len(climb) < _FEWEST or not np.ptp(climb) or not np.ptp(down):
        return guess
    agreement = -float(np.mean(climb * down) / np.sqrt(np.mean(climb**2) * np.mean(down**2)))
    if abs(agreement) < _CLIMBING:
        return guess
    size = float(np.sqrt(np.mean(climb**2) / np.mean(down**2)))
    fits = [unit for unit in guess.units if abs(size / float(to_si(1.0, unit)) - 1.0) < _SAME_CLIMB]
    if not fits:
        return None
    sign = float(np.sign(agreement))
    return replace(guess, units=(fits[0],), factor=guess.factor * sign, score=1.0, stated=True)


def _look_at_warmth(
    guess: Guess, values: Array, movement: Movement, found: Mapping[str, Guess]
) -> Guess | None:
    """Leave out a temperature that does not fall with height, and ask for one of a level flight."""
    rows = np.isfinite(values) & np.isfinite(movement.height)
    if rows.sum() < _FEWEST:
        return guess
    height, time = movement.height[rows], movement.time[rows]
    kelvin = to_si(values[rows], guess.units[0])
    low, high = np.quantile(height, [0.05, 0.95])
    if high - low < _HEIGHTS:
        return guess
    design = np.stack([height - height.mean(), time - time.mean(), np.ones_like(height)], axis=1)
    scale = np.maximum(np.std(design, axis=0), 1e-9)
    slope = np.linalg.lstsq(design / scale, kelvin, rcond=None)[0][0] / scale[0]
    if guess.quantity == "total_temperature" or _LAPSES[0] < slope < _LAPSES[1]:
        return guess
    words = (
        f"is it the air's? It changes by {1e3 * slope:+.1f} K in 1,000 m, where the air cools by "
        f"{1e3 * STANDARD_GRAVITY / 1005.0:.0f} K at most and by 6.5 usually"
    )
    return replace(guess, doubt=words)


_LOOKS = {
    "ground_speed": _look_at_speed,
    "track": _look_at_direction,
    "magnetic_track": _look_at_direction,
    "heading": _look_at_direction,
    "magnetic_heading": _look_at_direction,
    "velocity_down": _look_at_climb,
    "air_temperature": _look_at_warmth,
}
