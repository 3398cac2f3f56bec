"""A log while it is read: channels in SI, their columns, the rows kept so far, the warnings."""

from collections import Counter
from dataclasses import dataclass, field
from difflib import get_close_matches
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pitotbench.airdata import Rest
from pitotbench.channels import Channel
from pitotbench.logbook.columns import (
    OPTIONAL,
    QUANTITIES,
    Column,
    Table,
    clock_seconds,
    flags,
    is_clock,
    numbers,
    parse_column,
    texts,
)
from pitotbench.records import BadInputError
from pitotbench.records.log import Caution
from pitotbench.timeline import minutes_text
from pitotbench.units import Booleans, to_si

_NEEDED = ("time", "static_pressure", "velocity_north", "velocity_east")
_EITHER = ("impact_pressure", "total_pressure")
_INSTEAD = {
    "static_pressure": " or pressure_altitude_ft",
    "impact_pressure": " or indicated_airspeed_kt",
    "velocity_north": " or ground_speed_kt with track_deg or latitude_deg with longitude_deg",
}
_HEIGHT_IS_ENOUGH = " A height that you know is enough: --height 2000 (ft) or 600m states it."
_NO_AIRSPEED = " No airspeed is logged: give the log of the box that shows it."
_SHOWN = 3  # single rows that a sentence names
_SHOWN_RANGES = 5  # ranges of rows, likewise
_FEWEST_ROWS = 2
_FEWEST_OURS = 3  # names of needed quantities that a log of ours has, whatever else it lacks


class MissingColumnsError(BadInputError):
    """The table lacks a needed quantity under any of its names."""


@dataclass(slots=True)
class Draft:
    """Channels by quantity [SI], (n,) each, with their columns, units, rows and warnings.

    `columns` and `suffixes` hold the column and the unit of each.

    `rows` holds the numbers, from 1, that the kept rows have in the file. `strangers` are columns
    that are no quantities, and `displayed` the channels that come from a display, in steps. `rests`
    is what the impact pressure reads before and after the flight.
    """

    channels: dict[str, NDArray[Any]]
    columns: dict[str, str]
    suffixes: dict[str, str]
    rows: NDArray[np.intp]
    warnings: list[str]
    strangers: list[str] = field(default_factory=list)
    displayed: set[str] = field(default_factory=set)
    misnamed: dict[str, str] = field(default_factory=dict)  # why a name of ours is not read
    clock: bool = False  # whether the time comes from clock times
    start: float | None = None  # s, the first row of the log of which a part is kept
    units_by: dict[str, str] = field(default_factory=dict)  # as `FlightLog.units_by`
    rests: list[Rest] = field(default_factory=list)

    def keep(self, good: Booleans) -> None:
        """Keep only the rows where `good` is true, (n,).

        Raises BadInputError, with the reason given last, where fewer than two rows remain.
        """
        if int(good.sum()) < _FEWEST_ROWS:
            raise BadInputError(
                f"{self.warnings[-1] if self.warnings else 'rows are dropped'}; no log remains: "
                "mend that column, or give another log"
            )
        if good.all():
            return
        for (
            name,
            values,
        ) in self.channels.items():  # one after the other: a long log is in memory once
            self.channels[name] = values[good]
        self.rows = self.rows[good]

    def drop(self, bad: Booleans, why: str) -> None:
        """Drop the rows where `bad` is true, (n,), with a warning. Raises as `keep` does."""
        self.warnings.append(why)
        self.keep(~bad)

    def put(self, name: str, values: NDArray[Any], column: str, suffix: str = "") -> None:
        """Store a channel with the column it came from, which messages name, and its unit."""
        self.channels[name], self.columns[name], self.suffixes[name] = values, column, suffix

    def keep_part(
        self, begin: float | None, end: float | None, *without: tuple[float, float]
    ) -> None:
        """Keep the rows from `begin` to `end` [s] after the first one, but those of `without`.

        None is the log's own begin or end; `without` are spans that are left out. Raises
        BadInputError where the log holds no such part.
        """
        self.start = float(self.channels["time"][0])
        since = self.channels["time"] - self.start
        low, high = begin or 0.0, float(since[-1]) if end is None else end
        rows = (since >= low) & (since <= high)
        for first, last in without:
            rows &= (since < first) | (since > last)
        if low >= high or rows.sum() < _FEWEST_ROWS:
            raise BadInputError(
                f"--from {minutes_text(low)} --to "
                f"{minutes_text(high)}{' and what is left out' if without else ''}: no rows "
                f"remain; the log runs from 0:00 to {minutes_text(float(since[-1]))} (minutes and "
                "seconds from its first row)"
            )
        self.keep(rows)

    def doubt(self, words: str, refused: bool, column: str = "", code: str = "suspect") -> None:
        """Warn with a code of what is hardly possible; raise BadInputError where `refused`."""
        if refused:
            raise BadInputError(words)
        self.warnings.append(Caution(words, code, column))

    def cautions(self, code: str) -> list[Caution]:
        """Return the warnings of a code."""
        return [w for w in self.warnings if isinstance(w, Caution) and w.code == code]

    def leave_out(self, name: str, reason: str) -> None:
        """Remove an optional channel, with a warning that gives the reason."""
        del self.channels[name]
        self.warnings.append(f"column {self.columns[name]!r} is left out: {reason}")

    def numeric(self) -> list[Channel]:
        """Return the quantities present whose values are numbers."""
        return [QUANTITIES[name] for name in self.channels if QUANTITIES[name].kind == "number"]

    def named(self, bad: Booleans) -> str:
        """Return the marked rows in words, for example `rows 3–7, 12`."""
        return name_rows(self.rows[bad])

    def before(self, after: NDArray[np.intp]) -> str:
        """Return in words the place before some rows: of many, the first three are named."""
        rows = ", ".join(str(self.rows[i]) for i in after[:_SHOWN])
        others = " and others" if len(after) > _SHOWN else ""
        return f"before row{'s' if len(after) > 1 else ''} {rows}{others}"


def draft_of(table: Table) -> Draft:
    """Recognize the columns of a table and convert them to SI.

    A name of ours with a wrong unit is kept for `require`, which knows whether it is needed. Raises
    BadInputError for a quantity given twice or a cell that is not a number.
    """
    draft = Draft({}, {}, {}, np.arange(1, len(table) + 1), list(table.warnings))
    counts = Counter(table.names)
    for name, column in zip(table.names, table.columns, strict=True):
        try:
            parsed = parse_column(name)
        except BadInputError as error:
            draft.misnamed[name] = str(error)
            continue
        if parsed is not None and counts[name] > 1:
            raise BadInputError(f"column {name!r} is given twice; keep one")
        # Texts in a column that most logs do not need are another way to write it than ours.
        optional = parsed and parsed[0].name in OPTIONAL and parsed[0].kind == "number"
        if parsed is None or (optional and column.dtype.kind not in "fiub"):
            draft.strangers.append(name)
            continue
        quantity, suffix = parsed
        if quantity.name in draft.columns:
            raise BadInputError(
                f"columns {draft.columns[quantity.name]!r} and {name!r} give one quantity in two "
                "units; keep one"
            )
        draft.put(quantity.name, _values(quantity, suffix, name, column), name, suffix)
        draft.clock |= quantity.name == "time" and is_clock(column)
    return draft


def _values(quantity: Channel, suffix: str, name: str, column: Column) -> NDArray[Any]:
    # Numbers are seconds of the day.
    if quantity.name == "clock_time" and column.dtype.kind in "mMfiu":
        return column
    if quantity.kind == "text":
        return texts(name, column)
    if quantity.name == "time" and is_clock(column):
        return clock_seconds(name, column)
    if quantity.kind == "flag":
        return flags(name, column)
    values = numbers(name, column)
    # A column in SI stays the array that it is: a long log is in memory once.
    return to_si(values, suffix) if suffix not in ("", quantity.unit) else values


def require(draft: Draft) -> None:
    """Warn of the columns that are no quantities of a flight log.

    Raises MissingColumnsError that lists every missing quantity, with the columns that may be meant
    for them; BadInputError for a wrong unit in a log that holds all else.
    """
    missing = [
        f"{QUANTITIES[name].column}{_INSTEAD.get(name, '')}"
        for name in _NEEDED
        if name not in draft.channels
    ]
    air_data = (
        " or ".join(QUANTITIES[name].column for name in _EITHER) + _INSTEAD["impact_pressure"]
    )
    if not any(name in draft.channels for name in _EITHER):
        missing.append(air_data)
    # A log of ours is to be corrected; that of another recorder has names of its own.
    needed = [name for name in draft.misnamed if name.startswith(_NEEDED + _EITHER)]
    if missing and len(missing) <= len(needed):
        raise BadInputError(draft.misnamed[needed[0]])
    if missing:
        # The cutoff is strict: a wrong guess here sends the user to the wrong column.
        near = {
            m: get_close_matches(m.split()[0], draft.strangers, n=1, cutoff=0.7) for m in missing
        }
        hints = "".join(
            f" Is {found[0]!r} meant for {m.split()[0]}?" for m, found in near.items() if found
        )
        if missing == [f"{QUANTITIES['static_pressure'].column}{_INSTEAD['static_pressure']}"]:
            hints += _HEIGHT_IS_ENOUGH
        elif missing == [air_data]:
            hints += _NO_AIRSPEED
        raise MissingColumnsError(
            f"missing column{'s' if len(missing) > 1 else ''} {', '.join(missing)} (or in another "
            f"unit).{hints} A log with other names needs a mapping file: `pitotbench map LOG -o "
            "FILE.toml` drafts one, --mapping FILE.toml reads by it"
        )
    for name, words in draft.misnamed.items():
        if name not in QUANTITIES:
            raise BadInputError(words)
        draft.warnings.append(f"not used: {words}")
    if draft.strangers:
        draft.warnings.append(
            "columns not used (not quantities of a flight log): "
            f"{', '.join(dict.fromkeys(filter(None, draft.strangers)))}"
        )


_BEGIN = tuple(f"{each.name}_" for each in QUANTITIES.values() if each.essential)


def has_our_names(table: Table) -> bool:
    """Return whether several needed quantities are among a table's names, with a unit.

    The names are then those of a flight log.
    """
    return len(names_of_ours(table)) >= _FEWEST_OURS


def names_of_ours(table: Table) -> set[str]:
    """Return the quantities that a log needs and that columns of a table name as we do."""
    found = set[str]()
    for name in table.names:
        try:
            parsed = parse_column(name)
        except BadInputError:  # another unit than is known
            found |= {name} if name.startswith(_BEGIN) else set()
        else:
            found |= {parsed[0].name} if parsed and parsed[0].essential else set()
    return found


def name_rows(rows: NDArray[np.intp]) -> str:
    """Return row numbers in words: runs as ranges, at most five ranges."""
    breaks = np.flatnonzero(np.diff(rows) != 1)
    first, last = rows[np.r_[0, breaks + 1]], rows[np.r_[breaks, len(rows) - 1]]
    ranges = [f"{a}" if a == b else f"{a}–{b}" for a, b in zip(first, last, strict=True)]
    more = f" and {len(ranges) - _SHOWN_RANGES} more places" if len(ranges) > _SHOWN_RANGES else ""
    return f"row{'s' if len(rows) > 1 else ''} {', '.join(ranges[:_SHOWN_RANGES])}{more}"
