"""A log being read: channels in SI with the columns they came from, the rows that are left, the warnings."""

from collections.abc import Iterable
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pitotbench.channels import Channel
from pitotbench.logbook.quantities import QUANTITIES, parse_column
from pitotbench.logbook.table import Column, Table, flags, numbers, texts
from pitotbench.records.errors import BadInputError
from pitotbench.units import Booleans, to_si

_NEEDED = ("time", "static_pressure", "velocity_north", "velocity_east")
_EITHER = ("impact_pressure", "total_pressure")
_SHOWN_RANGES = 5
_FEWEST_ROWS = 2


@dataclass(slots=True)
class Draft:
    """Channels by quantity (SI), the column and unit suffix each came from, row numbers from 1, and warnings."""

    channels: dict[str, NDArray[Any]]
    columns: dict[str, str]
    suffixes: dict[str, str]
    rows: NDArray[np.intp]
    warnings: list[str]

    def keep(self, good: Booleans) -> None:
        """Leave only these rows. Raises BadInputError, with the reason last given, where fewer than two remain."""
        if int(good.sum()) < _FEWEST_ROWS:
            raise BadInputError(f"{self.warnings[-1] if self.warnings else 'rows are dropped'}; no log remains")
        self.channels = {name: values[good] for name, values in self.channels.items()}
        self.rows = self.rows[good]

    def leave_out(self, name: str, reason: str) -> None:
        """Go on without a channel that is not needed."""
        del self.channels[name]
        self.warnings.append(f"column {self.columns[name]!r} is left out: {reason}")

    def numeric(self) -> list[Channel]:
        """The quantities present whose values are numbers."""
        return [QUANTITIES[name] for name in self.channels if QUANTITIES[name].kind == "number"]

    def named(self, bad: Booleans) -> str:
        """Rows in words: `rows 3–7, 12`."""
        return name_rows(self.rows[bad])


def draft_of(table: Table) -> Draft:
    """Recognize the columns of a table and convert them to SI.

    Raises BadInputError for a wrong unit, a quantity given twice, a missing column or a cell that is no number.
    Columns that are none of ours are named in a warning.
    """
    draft = Draft({}, {}, {}, np.arange(1, len(table) + 1), list(table.warnings))
    strangers = []
    _refuse_twins(table.names)
    for name, column in zip(table.names, table.columns, strict=True):
        parsed = parse_column(name)
        if parsed is None:
            strangers.append(name)
            continue
        quantity, suffix = parsed
        _refuse_second_unit(draft, quantity, name)
        draft.channels[quantity.name] = _values(quantity, suffix, name, column)
        draft.columns[quantity.name], draft.suffixes[quantity.name] = name, suffix
    _require(draft, strangers)
    if strangers:
        draft.warnings.append(f"columns not used (not quantities of a flight log): {', '.join(strangers)}")
    return draft


def _refuse_twins(names: Iterable[str]) -> None:
    seen: set[str] = set()
    for name in names:
        if name in seen:
            raise BadInputError(f"column {name!r} is given twice; keep one")
        seen.add(name)


def _refuse_second_unit(draft: Draft, quantity: Channel, name: str) -> None:
    if quantity.name in draft.columns:
        raise BadInputError(
            f"columns {draft.columns[quantity.name]!r} and {name!r} give one quantity in two units; keep one"
        )


def _values(quantity: Channel, suffix: str, name: str, column: Column) -> NDArray[Any]:
    if quantity.kind == "text":
        return texts(column)
    if quantity.kind == "flag":
        return flags(name, column)
    values = numbers(name, column)
    return to_si(values, suffix) if suffix else values


def _require(draft: Draft, strangers: list[str]) -> None:
    """Every needed quantity, all that is missing in one message."""
    missing = [QUANTITIES[name].column for name in _NEEDED if name not in draft.channels]
    if not any(name in draft.channels for name in _EITHER):
        missing.append(" or ".join(QUANTITIES[name].column for name in _EITHER))
    if not missing:
        return
    near = {m: get_close_matches(m.split(" or ")[0], strangers, n=1, cutoff=0.7) for m in missing}
    hints = "".join(f" Is {found[0]!r} meant for {wanted}?" for wanted, found in near.items() if found)
    raise BadInputError(
        f"missing column{'s' if len(missing) > 1 else ''} {', '.join(missing)} (or in another unit).{hints} "
        "A log with other names needs a mapping file: --mapping NAME or FILE.toml"
    )


def name_rows(rows: NDArray[np.intp]) -> str:
    """Row numbers in words, runs as ranges, at most five of them."""
    breaks = np.flatnonzero(np.diff(rows) != 1)
    first, last = rows[np.r_[0, breaks + 1]], rows[np.r_[breaks, len(rows) - 1]]
    ranges = [f"{a}" if a == b else f"{a}–{b}" for a, b in zip(first, last, strict=True)]
    more = f" and {len(ranges) - _SHOWN_RANGES} more places" if len(ranges) > _SHOWN_RANGES else ""
    return f"row{'s' if len(rows) > 1 else ''} {', '.join(ranges[:_SHOWN_RANGES])}{more}"
