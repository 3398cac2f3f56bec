"""Columns that say the same in two ways: an airspeed and an impact pressure, a height and a static pressure.

Where both are there, the one that needs no unit by guess tells the unit of the other.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from pitotbench import air
from pitotbench.logbook.drafting.guess import Guess
from pitotbench.logbook.table import Table, numbers
from pitotbench.units import Array, to_si

_AIRSPEED_AGREES = 0.05  # of the airspeed: a display shows the impact pressure of its own source
_HEIGHT_AGREES = 250.0  # m, more than a static source errs; a unit errs by kilometers
_PAIRS: tuple[tuple[str, tuple[str, ...], Callable[[Array], Array]], ...] = (
    ("impact_pressure", ("indicated_airspeed", "calibrated_airspeed"), lambda q: air.calibrated_airspeed(q)),
    ("static_pressure", ("pressure_altitude",), lambda p: air.pressure_altitude(p)),
)


def agreed(table: Table, chosen: Sequence[Guess]) -> list[Guess]:
    """Return the guesses, with the units of pressures that agree with a display; a pressure that agrees in no unit
    is left out, because a raw or a smoothed count looks like one."""
    by_quantity = {guess.quantity: guess for guess in chosen}
    result = list(chosen)
    for pressure, displays, converted in _PAIRS:
        shown = next((by_quantity[name] for name in displays if name in by_quantity), None)
        guess = by_quantity.get(pressure)
        if shown is None or guess is None:
            continue
        fits = [unit for unit in guess.units if _close(table, guess, unit, shown, converted)]
        result.remove(guess)
        if fits:
            result.append(replace(guess, units=(fits[0],), stated=True))
    return [guess for guess in result if guess.units]


def _close(table: Table, guess: Guess, unit: str, shown: Guess, converted: Callable[[Array], Array]) -> bool:
    """Return whether a pressure in a unit agrees with a display in one of its possible units."""
    pressure = to_si(numbers(guess.theirs, table.column(guess.theirs)) * guess.factor, unit)
    with np.errstate(all="ignore"):
        expected = converted(pressure)
    written = numbers(shown.theirs, table.column(shown.theirs)) * shown.factor
    return any(_near(expected, to_si(written, suffix), guess.quantity) for suffix in shown.units)


def _near(one: Array, other: Array, pressure: str) -> bool:
    known = np.isfinite(one) & np.isfinite(other)
    if pressure == "impact_pressure":
        known &= other > 0.5 * float(np.nanmax(other, initial=0.0))
    if not known.any():
        return False
    difference = float(np.median(np.abs(one[known] - other[known])))
    if pressure == "impact_pressure":
        return difference < _AIRSPEED_AGREES * float(np.median(other[known]))
    return difference < _HEIGHT_AGREES
