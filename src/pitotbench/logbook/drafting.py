"""Draft a mapping for a log whose columns have unknown names."""

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import tomli_w

from pitotbench.logbook.behavior import judged
from pitotbench.logbook.column_guesses import EXACT, guesses, name_and_unit
from pitotbench.logbook.columns import Column, Table, almost_numbers
from pitotbench.logbook.guess import HEIGHTS, Guess, missing
from pitotbench.logbook.joining import first_of_each, rename
from pitotbench.logbook.sensors import AIRSPEEDS
from pitotbench.logbook.unit_trials import agreed, fit_units, like_the_airspeed, mapped_file, trial
from pitotbench.records import BadInputError

_MOST_COLUMNS = 1000  # of a log that is drafted: more would take minutes
_SURE = 0.7  # score of a name above which it is the field's own
_SUPERSEDED = {  # a quantity that is not needed where others are there
    "indicated_airspeed": ("impact_pressure", "total_pressure"),
    "calibrated_airspeed": ("impact_pressure", "total_pressure", "indicated_airspeed"),
    "mach": AIRSPEEDS,
    "true_airspeed": (*AIRSPEEDS, "mach"),
    "pressure_altitude": ("static_pressure",),
    "indicated_altitude": ("static_pressure", "pressure_altitude"),
    "height_above_takeoff": ("static_pressure", "pressure_altitude", "indicated_altitude"),
    "altimeter_setting": ("static_pressure", "pressure_altitude"),
    "ground_speed": ("velocity_north",),
    "track": ("velocity_east",),
    "magnetic_track": ("velocity_east", "track"),
    "total_pressure": ("impact_pressure",),
    "air_temperature": ("total_temperature",),
}


@dataclass(frozen=True, slots=True)
class DraftedLine:
    """A line of the mapping: the guess, and the question to ask where it is not sure."""

    guess: Guess
    question: str = ""


@dataclass(frozen=True, slots=True)
class DraftedMapping:
    """The lines of a drafted mapping, and what it lacks.

    `missing` are the needed quantities for which no column was found, and `unused` the columns that
    are left over, with what each holds, its range and its step, in `ranges`. `refusal` is what the
    reader says of the log with it: empty, or a refusal.
    """

    lines: tuple[DraftedLine, ...]
    missing: tuple[str, ...]
    unused: tuple[str, ...]
    refusal: str
    ranges: tuple[str, ...] = ()

    @property
    def sure(self) -> bool:
        """Whether the mapping can be used as it is."""
        return not self.unusable and not any(line.question for line in self.lines)

    @property
    def unusable(self) -> bool:
        """Whether the mapping lacks something essential, or the log is refused with it."""
        return bool(self.missing or self.refusal)


def draft_mapping(table: Table) -> DraftedMapping:
    """Return a mapping for a table, as far as its columns can be recognized.

    Each column goes to the quantity that its name fits best. Where the file does not state a unit,
    the units in which the values are possible are tried on the whole log: airspeed and ground
    speed, height and pressure have to agree.

    Raises BadInputError for a table of more than 1,000 columns, which would take minutes.
    """
    if len(table.names) > _MOST_COLUMNS:
        raise BadInputError(
            f"the log has {len(table.names):,} columns; a mapping is drafted for at most "
            f"{_MOST_COLUMNS:,}: keep those of air data and GPS"
        )
    table = first_of_each(table)
    columns = (
        column if column.dtype.kind != "O" or (found := almost_numbers(column)) is None else found
        for column in table.columns
    )
    table = replace(table, columns=tuple(columns))
    stated = table.units or ("",) * len(table.names)
    turns = _quaternions(table)
    offered = [
        [Guess(name, turns[name], ("",), EXACT, True)]
        if name in turns
        else guesses(name, unit, column)
        for name, unit, column in zip(table.names, stated, table.columns, strict=True)
    ]
    chosen = _without_superseded(table, agreed(table, judged(table, _one_each(offered))))
    lacking = missing(table, chosen)
    chosen = like_the_airspeed(table, chosen)
    fitted, refusal = (chosen, "") if lacking else fit_units(table, chosen)
    fitted = judged(table, fitted)  # now that more units are known
    by_quantity = {guess.quantity: guess.theirs for guess in fitted}
    lines = (
        *(
            DraftedLine(guess, _question(guess, _rivals(guess, offered, fitted), by_quantity))
            for guess in fitted
        ),
        *_more_sensors(fitted, offered),
    )
    if not refusal and not lacking:
        refusal, _ = trial(table, fitted)
    used = {line.guess.theirs for line in lines}
    unused = tuple(name for name in table.names if name not in used)
    ranges = tuple(_range_of(table.column(name)) for name in unused)
    return DraftedMapping(lines, lacking, unused, refusal, ranges)


def read_by_draft(table: Table, drafted: DraftedMapping) -> Table | None:
    """Return a table under our names by the draft of its columns.

    A remark says how each was read; what raises a question is left out. None where something that a
    log needs is not sure.
    """
    sure = [line.guess for line in drafted.lines if not line.question]
    if drafted.unusable or missing(table, sure):
        return None
    asked = [line.guess.theirs for line in drafted.lines if line.question]
    lines = ", ".join(f"{guess.theirs} → {guess.target()}" for guess in sure)
    left = f"; left out, since `pitotbench map` has a question: {', '.join(asked)}" if asked else ""
    note = f"columns as their names, units and values tell: {lines}{left}"
    found = rename(table, mapped_file(sure))
    return replace(found, warnings=(*found.warnings, note))


def _range_of(column: Column) -> str:
    """Return in words what a column holds: its range and the smallest step of its numbers."""
    values = almost_numbers(column)
    if values is None:
        return "no numbers"
    different = np.unique(values[np.isfinite(values)])
    if len(different) < 2:
        return f"always {different[0]:g}" if len(different) else "blank"
    step = float(np.min(np.diff(different)))
    return f"{different[0]:g} to {different[-1]:g} in steps of {step:.2g}"


_PART_OF_FOUR = re.compile(r"(.*?)[\[(_.]?([0-3]|[wxyz])[\])]?")
_UNIT_LENGTH = 0.01  # by which the sum of the squares of a quaternion differs from one


def _quaternions(table: Table) -> dict[str, str]:
    """Return our names of the columns that are the four parts of a quaternion.

    Such columns have one name with four numbers or letters, and their squares add up to one.
    """
    stems: dict[str, dict[int, str]] = {}
    for name in table.names:
        if found := _PART_OF_FOUR.fullmatch(name.lower()):
            place = "0123".find(found[2]) if found[2].isdigit() else "wxyz".find(found[2])
            stems.setdefault(found[1], {})[place] = name
    turns: dict[str, str] = {}
    for parts in (each for each in stems.values() if len(each) == 4):
        columns = [table.column(parts[place]) for place in range(4)]
        if all(column.dtype.kind == "f" for column in columns):
            length = np.nanmedian(np.abs(np.sum(np.square(columns), axis=0) - 1.0))
            close = bool(length < _UNIT_LENGTH)
            turns |= {parts[p]: f"attitude_q{p}" for p in range(4)} if close else {}
    return turns


def _one_each(offered: Sequence[list[Guess]]) -> list[Guess]:
    """Give each quantity to one column and each column one quantity, the best fit first."""
    ranked = sorted(
        (guess for options in offered for guess in options), key=lambda g: (-g.score, not g.stated)
    )
    chosen: dict[str, Guess] = {}
    for guess in ranked:
        if guess.quantity not in chosen and all(guess.theirs != g.theirs for g in chosen.values()):
            chosen[guess.quantity] = guess
    order = [guess.theirs for options in offered for guess in options[:1]]
    places = {name: place for place, name in enumerate(order)}
    return sorted(chosen.values(), key=lambda guess: places.get(guess.theirs, len(order)))


_COMPONENTS = ("velocity_north", "velocity_east", "velocity_down")
_DIRECTED = ("ground_speed", "track", "magnetic_track")
_POSITIONS = ("latitude", "longitude")


def _without_superseded(table: Table, chosen: list[Guess]) -> list[Guess]:
    here = {guess.quantity for guess in chosen if guess.score >= _SURE}
    dropped: tuple[str, ...] = _POSITIONS  # where the velocity has both components
    if not here.issuperset(_COMPONENTS[:2]):
        here -= set(_COMPONENTS)
        directed = "ground_speed" in here and not here.isdisjoint(_DIRECTED[1:])
        others = _DIRECTED if here.issuperset(_POSITIONS) else ()
        dropped = (*_COMPONENTS, *(_POSITIONS if directed else others))
        dropped = dropped if directed or others else ()
    unneeded = {name for name, better in _SUPERSEDED.items() if not here.isdisjoint(better)}
    return _with_a_height(table, [g for g in chosen if g.quantity not in unneeded.union(dropped)])


def _with_a_height(table: Table, chosen: list[Guess]) -> list[Guess]:
    """Return the guesses with the altitude as the height for a static pressure that is missing.

    The reference of that height is as good as unknown.
    """
    lifted = [
        replace(g, quantity="indicated_altitude") if g.quantity == "altitude" else g for g in chosen
    ]
    return lifted if missing(table, chosen) and not missing(table, lifted) else chosen


def _rivals(guess: Guess, offered: Sequence[list[Guess]], fitted: Sequence[Guess]) -> list[str]:
    """Return other columns that fit the same quantity as well, and none better."""
    taken = {each.theirs for each in fitted if each.score >= _SURE}
    return [
        other.theirs
        for options in offered
        for other in options
        if other.quantity == guess.quantity
        and other.theirs not in taken
        and other.score > guess.score - 0.15
    ]


def _more_sensors(fitted: Sequence[Guess], offered: Sequence[list[Guess]]) -> Iterator[DraftedLine]:
    """Yield a line for each column that seems to be another sensor's airspeed or pressure."""
    used, count = {guess.theirs for guess in fitted}, 1
    for first in fitted:
        for other in (guess for options in offered for guess in options):
            wanted = first.quantity in AIRSPEEDS and other.quantity == first.quantity
            if wanted and other.theirs not in used and other.score >= _SURE:
                used.add(other.theirs)
                count += 1
                unit = first.units[0] if first.units[0] in other.units else other.units[0]
                numbered = replace(other, quantity=f"{first.quantity}_{count}", units=(unit,))
                yield DraftedLine(numbered, f"is this a sensor beside {first.theirs!r}?")


def _question(guess: Guess, rivals: Sequence[str], by_quantity: Mapping[str, str]) -> str:
    """Return what to ask about a line; empty for one that is sure.

    `by_quantity` holds the columns by quantity.
    """
    variation = by_quantity.get("magnetic_variation", by_quantity.get("magnetic_track"))
    if (
        variation
        and guess.quantity in ("track", "heading")
        and "true" not in name_and_unit(guess.theirs, "")[0]
    ):
        return (
            f"is it true, or magnetic as {variation!r} beside it suggests "
            f"(magnetic_{guess.quantity}_deg)?"
        )
    if (guess.quantity == "indicated_altitude" and "altimeter_setting" not in by_quantity) or (
        guess.quantity == "altitude" and not set(HEIGHTS) & set(by_quantity)
    ):
        return (
            "is it the height by GPS, or a pressure altitude "
            f"(pressure_altitude_{guess.units[0]}), or one above the place of take-off "
            f"(height_above_takeoff_{guess.units[0]})? {_unit_question(guess)}"
        ).rstrip()
    if guess.doubt:
        return guess.doubt
    if guess.score < _SURE or (
        len(guess.theirs) == 1 and guess.quantity != "time" and not guess.stated
    ):
        return f"is this the {guess.quantity.replace('_', ' ')}?"
    if rivals:
        return f"or is it {' or '.join(map(repr, rivals[:3]))}?"
    return _unit_question(guess)


def _unit_question(guess: Guess) -> str:
    if guess.stated or len(guess.units) < 2:
        return ""
    return f"the file states no unit: is it {guess.units[0]}, or {' or '.join(guess.units[1:])}?"


_SHOWN = 40  # columns left over that are listed


def mapping_text(drafted: DraftedMapping, log: str) -> str:
    """Return the TOML text of a mapping for the log of a name."""
    open_lines = sum(bool(line.question) for line in drafted.lines)
    log = " ".join(log.split())
    above = [
        f"# Drafted from {log}: {len(drafted.lines)} columns recognized, {open_lines} to be "
        "checked."
    ]
    above += [f"# No column was found for {name}: add a line." for name in drafted.missing]
    if drafted.refusal:
        above.append(f"# With these lines the log is refused: {' '.join(drafted.refusal.split())}")
    body = [_line(line) for line in drafted.lines]
    # A line break would end the comment.
    unused = [
        f"# Not used: {' '.join(name.split())}: {values}"
        for name, values in zip(drafted.unused, drafted.ranges, strict=True)
        if name
    ]
    more = len(unused) - _SHOWN
    below = unused[:_SHOWN] + ([f"# Not used: {more} more columns"] if more > 0 else [])
    title = tomli_w.dumps({"title": f"drafted from {log}"}).strip()
    return "\n".join([*above, title, "", "[columns]", *body, "", *below]).rstrip() + "\n"


def _line(line: DraftedLine) -> str:
    guess = line.guess
    target = guess.target()
    value = (
        json.dumps(target)
        if guess.factor == 1.0
        else f'{{ name = "{target}", factor = {guess.factor!r} }}'
    )
    return f"{json.dumps(guess.theirs, ensure_ascii=False)} = {value}  # {line.question or 'sure'}"
