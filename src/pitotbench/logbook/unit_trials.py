"""Find the units of columns in which a log agrees with itself."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from itertools import islice, product

import numpy as np

from pitotbench import air
from pitotbench.logbook.assembly import log_of
from pitotbench.logbook.checks import check_broken, check_broken_in_sound_velocities
from pitotbench.logbook.column_guesses import EXACT, with_units
from pitotbench.logbook.columns import QUANTITIES, Table, almost_numbers, is_clock, parse_column
from pitotbench.logbook.draft import Draft
from pitotbench.logbook.guess import Guess, missing
from pitotbench.logbook.joining import rename
from pitotbench.logbook.mapping import MappedFile, Renamed
from pitotbench.records import BadInputError
from pitotbench.records.log import GUESSED, UNITS_BY
from pitotbench.units import Array

_AIRSPEED_AGREES = 0.05  # of the airspeed: a display shows the impact pressure of its own source
_HEIGHT_AGREES = 250.0  # m, more than a static source errs; a unit errs by kilometers
_PAIRS: tuple[tuple[str, tuple[str, ...], Callable[[Array], Array]], ...] = (
    (
        "impact_pressure",
        ("indicated_airspeed", "calibrated_airspeed"),
        lambda q: air.calibrated_airspeed(q),
    ),
    ("static_pressure", ("pressure_altitude",), lambda p: air.pressure_altitude(p)),
)


def agreed(table: Table, chosen: Sequence[Guess]) -> list[Guess]:
    """Return the guesses, with the units of pressures that agree with a display.

    A pressure that agrees in no unit is left out, because a raw or a smoothed count looks like one.

    An airspeed and an impact pressure, or a height and a static pressure, say the same in two ways.
    Where both are there, the one that needs no unit by guess tells the unit of the other.
    """
    by_quantity = {guess.quantity: guess for guess in chosen}
    result = list(chosen)
    for pressure, displays, converted in _PAIRS:
        shown = next((by_quantity[name] for name in displays if name in by_quantity), None)
        guess = by_quantity.get(pressure)
        if shown is None or guess is None:
            continue
        fits = [unit for unit in guess.units if _close(table, guess, unit, shown, converted)]
        result.remove(guess)
        result += [replace(guess, units=(unit,), stated=True) for unit in fits[:1]]
    return [guess for guess in result if guess.units]


def _close(
    table: Table, guess: Guess, unit: str, shown: Guess, converted: Callable[[Array], Array]
) -> bool:
    """Return whether a pressure in a unit agrees with a display in one of its possible units."""
    with np.errstate(all="ignore"):
        expected = converted(replace(guess, units=(unit,)).values(table))
    written = (replace(shown, units=(each,)).values(table) for each in shown.units)
    return any(_near(expected, each, guess.quantity) for each in written)


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


_ROWS = 2000  # of a long log that are tried
_MOST_TRIALS = 48  # of units on the whole log: a second or two


def mapped_file(chosen: Sequence[Guess]) -> MappedFile:
    return MappedFile(
        ("*",), "last", tuple(Renamed(g.theirs, g.target(), g.factor) for g in chosen)
    )


def fit_units(table: Table, chosen: list[Guess]) -> tuple[list[Guess], str]:
    """Return the guesses with the units that bring the log together best, and a refusal or ""."""
    step = max(1, len(table) // _ROWS)
    sample = replace(table, columns=tuple(column[::step] for column in table.columns), warnings=())
    # No unit breaks a pitot, and to look for a broken one takes most of the time of a reading.
    trials = [
        (
            units,
            *trial(
                sample, _trusted(sample, units), (check_broken, check_broken_in_sound_velocities)
            ),
        )
        for units in islice(_unit_choices(chosen), _MOST_TRIALS)
    ]
    best = min(trials, key=lambda trial: (bool(trial[1]), trial[2]))
    if best[1]:
        return best[0], best[1]
    as_good = [each for each, refusal, doubts in trials if not refusal and doubts == best[2]]
    possible = [
        dict.fromkeys(column)
        for column in zip(*([g.units[0] for g in each] for each in as_good), strict=True)
    ]
    return [replace(g, units=tuple(units)) for g, units in zip(best[0], possible, strict=True)], ""


def like_the_airspeed(table: Table, chosen: Sequence[Guess]) -> list[Guess]:
    """Return the guesses with a ground speed's units ordered by nearness to the airspeed.

    The unit of the airspeed is known.
    """
    known = [g for g in chosen if g.quantity.endswith("_airspeed") and len(g.units) == 1]
    if not known:
        return list(chosen)
    airspeed = float(np.nanmedian(known[0].values(table)))

    def apart(guess: Guess, unit: str) -> float:
        speed = float(np.nanmedian(np.abs(replace(guess, units=(unit,)).values(table))))
        return abs(float(np.log(max(speed, 1e-6) / max(airspeed, 1e-6))))

    return [
        replace(g, units=tuple(sorted(g.units, key=partial(apart, g))))
        if g.quantity == "ground_speed" and len(g.units) > 1
        else g
        for g in chosen
    ]


_TIED = {"velocity_east": "velocity_north", "longitude": "latitude"}


def _unit_choices(chosen: list[Guess]) -> Iterator[list[Guess]]:
    """Yield the guesses with each choice of units, the usual ones first.

    Both horizontal velocities have one unit, and so have latitude and longitude.
    """
    open_units = {
        g.quantity: g.units for g in chosen if len(g.units) > 1 and g.quantity not in _TIED
    }
    ranks = product(*(range(len(units)) for units in open_units.values()))
    for rank in sorted(ranks, key=sum):
        picked = dict(zip(open_units, rank, strict=True))
        picked |= {name: picked.get(other, 0) for name, other in _TIED.items()}
        places = [min(picked.get(guess.quantity, 0), len(guess.units) - 1) for guess in chosen]
        yield [
            replace(g, units=(g.units[k], *g.units[:k], *g.units[k + 1 :]))
            for g, k in zip(chosen, places, strict=True)
        ]


def _trusted(table: Table, chosen: list[Guess]) -> list[Guess]:
    """Return the guesses by which the units of the others are judged.

    What raises a question itself is none, where the log can be read without it.
    """
    trusted = [guess for guess in chosen if not guess.doubt]
    return chosen if missing(table, trusted) else trusted


def trial(
    sample: Table, chosen: list[Guess], unasked: Sequence[Callable[[Draft], None]] = ()
) -> tuple[str, int]:
    """Return why the log is refused with some guesses, and how many doubts it raises."""
    try:
        with np.errstate(all="ignore"):
            log = log_of(rename(sample, mapped_file(chosen)), unasked=unasked)
    except BadInputError as error:
        return str(error), 0
    return "", sum(
        not w.startswith(("the header", "the recording")) for w in log.header.get("warnings", [])
    )


def fill_units(table: Table) -> Table:
    """Return a table whose columns of our names without a unit have that which their values tell.

    Each is tried on the whole log, as by `draft_mapping`. A column whose values fit several units
    is left as it is, except one that the log needs: it gets the likeliest, and a remark says so.
    """
    chosen: list[Guess] = []
    for name, column in zip(table.names, table.columns, strict=True):
        quantity = QUANTITIES.get(name)
        if quantity is None:
            with suppress(BadInputError):
                if parsed := parse_column(name):
                    chosen.append(Guess(name, parsed[0].name, (parsed[1],), EXACT, True))
        elif name == "time" and is_clock(column):
            chosen.append(Guess(name, name, ("s",), EXACT, True))
        elif quantity.unit and (values := almost_numbers(column)) is not None:
            chosen += with_units(name, quantity, EXACT, 1.0, "", values)
    if any(len(guess.units) > 1 for guess in chosen) and not missing(table, chosen):
        chosen = fit_units(table, chosen)[0]
    named: dict[str, str] = {}
    notes = list(table.warnings)
    for guess in chosen:
        unit, *others = guess.units
        if (
            guess.theirs in QUANTITIES
            and unit
            and not (others and not QUANTITIES[guess.theirs].essential)
        ):
            named[guess.theirs] = guess.target()
            units = ", or else ".join(guess.units)
            notes.append(f"column {guess.theirs!r} states no unit: by its values {units}")
    names = tuple(named.get(name, name) for name in table.names)
    by = {UNITS_BY: GUESSED} if named else {}
    return replace(table, names=names, header={**table.header, **by}, warnings=tuple(notes))
