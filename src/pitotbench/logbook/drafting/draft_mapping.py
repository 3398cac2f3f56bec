"""Draft a mapping for a table of unknown names, and say how sure each line is.

Each column goes to the quantity that its name fits best. Where the file does not state a unit, the units in which the
values are possible are tried on the whole log: airspeed and ground speed, height and pressure have to agree.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice, product

import numpy as np

from pitotbench.logbook.drafting.agreement import agreed
from pitotbench.logbook.drafting.guess import Guess, guesses
from pitotbench.logbook.mapping import MappedFile, Renamed
from pitotbench.logbook.joining import rename
from pitotbench.logbook.reading import log_of
from pitotbench.logbook.table import Table
from pitotbench.records.errors import BadInputError

_ROWS = 2000  # of a long log that are tried
_MOST_TRIALS = 48
_SURE = 0.7  # score of a name above which it is the field's own
_NEEDED = (
    ("time",),
    ("impact_pressure", "total_pressure", "indicated_airspeed", "calibrated_airspeed"),
    ("static_pressure", "pressure_altitude", "indicated_altitude"),
    ("velocity_north", "ground_speed"),
    ("velocity_east", "track", "magnetic_track"),
)
_SUPERSEDED = {  # a quantity that is not needed beside others
    "indicated_airspeed": ("impact_pressure", "total_pressure"),
    "calibrated_airspeed": ("impact_pressure", "total_pressure", "indicated_airspeed"),
    "pressure_altitude": ("static_pressure",),
    "indicated_altitude": ("static_pressure", "pressure_altitude"),
    "altimeter_setting": ("static_pressure", "pressure_altitude"),
    "ground_speed": ("velocity_north",),
    "track": ("velocity_east",),
    "magnetic_track": ("velocity_east", "track"),
    "total_pressure": ("impact_pressure",),
    "air_temperature": ("total_temperature",),
}


@dataclass(frozen=True, slots=True)
class DraftedLine:
    """A line of the mapping: the guess with its unit, whether it is sure, and the question to ask where it is not."""

    guess: Guess
    unit: str
    question: str = ""


@dataclass(frozen=True, slots=True)
class DraftedMapping:
    """The lines of a drafted mapping, the needed quantities for which no column was found, the columns that are left
    over, and what the reader says of the log with it: empty, or a refusal."""

    lines: tuple[DraftedLine, ...]
    missing: tuple[str, ...]
    unused: tuple[str, ...]
    refusal: str

    @property
    def sure(self) -> bool:
        """Whether the mapping can be used as it is."""
        return not self.missing and not self.refusal and not any(line.question for line in self.lines)


def draft_mapping(table: Table) -> DraftedMapping:
    """Return a mapping for a table, as far as its columns can be recognized."""
    units = table.units or ("",) * len(table.names)
    offered = [guesses(n, u, c) for n, u, c in zip(table.names, units, table.columns, strict=True)]
    chosen = _without_superseded(agreed(table, _one_each(offered)))
    fitted, refusal = _fit_units(table, chosen) if not _missing(chosen) else (chosen, "")
    others = {guess.theirs: rest for guess in fitted for rest in [_rivals(guess, offered)] if rest}
    lines = tuple(DraftedLine(guess, guess.units[0], _question(guess, others.get(guess.theirs, []))) for guess in fitted)
    unused = tuple(name for name in table.names if name not in {guess.theirs for guess in fitted})
    return DraftedMapping(lines, _missing(chosen), unused, refusal)


def _one_each(offered: Sequence[list[Guess]]) -> list[Guess]:
    """Give each quantity to one column and each column one quantity, the best fit first."""
    ranked = sorted((guess for options in offered for guess in options), key=lambda g: (-g.score, not g.stated))
    chosen: dict[str, Guess] = {}
    used: set[str] = set()
    for guess in ranked:
        if guess.quantity not in chosen and guess.theirs not in used:
            chosen[guess.quantity] = guess
            used.add(guess.theirs)
    order = [guess.theirs for options in offered for guess in options[:1]]
    return sorted(chosen.values(), key=lambda guess: order.index(guess.theirs) if guess.theirs in order else len(order))


def _without_superseded(chosen: list[Guess]) -> list[Guess]:
    here = {guess.quantity for guess in chosen if guess.score >= _SURE}
    if "velocity_north" not in here or "velocity_east" not in here:
        here -= {"velocity_north", "velocity_east"}
        if {"ground_speed"} & here:
            chosen = [g for g in chosen if not g.quantity.startswith("velocity_")]
    kept = [g for g in chosen if not set(_SUPERSEDED.get(g.quantity, ())) & here]
    if "indicated_altitude" in here and not any(g.quantity == "altimeter_setting" for g in kept):
        kept = [g for g in kept if g.quantity != "indicated_altitude"]
    return kept


def _missing(chosen: Sequence[Guess]) -> tuple[str, ...]:
    here = {guess.quantity for guess in chosen}
    return tuple(" or ".join(names) for names in _NEEDED if not here & set(names))


def _fit_units(table: Table, chosen: list[Guess]) -> tuple[list[Guess], str]:
    """Return the guesses with the units that bring the log together best, and why the log is refused with them."""
    step = max(1, len(table) // _ROWS)
    sample = replace(table, columns=tuple(column[::step] for column in table.columns), warnings=())
    trials = [_trial(sample, units) for units in islice(_unit_choices(chosen), _MOST_TRIALS)]
    best = min(trials, key=lambda trial: (bool(trial[1]), trial[2]))
    if best[1]:
        return best[0], best[1]
    as_good = [each for each, refusal, doubts in trials if not refusal and doubts == best[2]]
    possible = [dict.fromkeys(column) for column in zip(*([g.units[0] for g in each] for each in as_good), strict=True)]
    return [replace(g, units=tuple(units)) for g, units in zip(best[0], possible, strict=True)], ""


def _unit_choices(chosen: list[Guess]) -> Iterator[list[Guess]]:
    """Yield the guesses with each choice of units, the usual ones first; both horizontal velocities have one unit."""
    open_units = {g.quantity: g.units for g in chosen if len(g.units) > 1 and g.quantity != "velocity_east"}
    ranks = product(*(range(len(units)) for units in open_units.values()))
    for rank in sorted(ranks, key=sum):
        picked = dict(zip(open_units, rank, strict=True))
        picked["velocity_east"] = picked.get("velocity_north", 0)
        yield [_first(guess, picked.get(guess.quantity, 0)) for guess in chosen]


def _first(guess: Guess, number: int) -> Guess:
    number = min(number, len(guess.units) - 1)
    return replace(guess, units=(guess.units[number], *guess.units[:number], *guess.units[number + 1 :]))


def _trial(sample: Table, chosen: list[Guess]) -> tuple[list[Guess], str, int]:
    """Return the guesses, why the log is refused with them, and how many doubts it raises."""
    try:
        with np.errstate(all="ignore"):
            log = log_of(rename(sample, entry_of(chosen)))
    except BadInputError as error:
        return chosen, str(error), 0
    doubts = [w for w in log.header.get("warnings", []) if not w.startswith(("the header", "the recording"))]
    return chosen, "", len(doubts)


def entry_of(chosen: Sequence[Guess]) -> MappedFile:
    """Return the guesses as the entry of a mapping."""
    renamed = tuple(Renamed(g.theirs, g.target(), g.factor) for g in chosen)
    return MappedFile(("*",), "last", renamed)


def _rivals(guess: Guess, offered: Sequence[list[Guess]]) -> list[str]:
    """Return other columns that fit the same quantity as well."""
    return [
        other.theirs
        for options in offered
        for other in options
        if other.quantity == guess.quantity and other.theirs != guess.theirs and other.score > guess.score - 0.15
    ]


def _question(guess: Guess, rivals: Sequence[str]) -> str:
    """Return what to ask about a line; empty for one that is sure."""
    if guess.score < _SURE:
        return f"is this the {guess.quantity.replace('_', ' ')}?"
    if rivals:
        return f"or is it {' or '.join(map(repr, rivals[:3]))}?"
    if not guess.stated and len(guess.units) > 1:
        return f"the file states no unit: is it {guess.units[0]}, or {' or '.join(guess.units[1:])}?"
    return ""
