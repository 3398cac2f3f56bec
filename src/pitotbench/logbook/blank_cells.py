"""Blank cells of a log: fixes that are held, rows that are dropped, a unit that starts up."""

import numpy as np
from numpy.typing import NDArray

from pitotbench.channels import numbers_from
from pitotbench.logbook.draft import Draft
from pitotbench.records import BadInputError
from pitotbench.units import Booleans, percent_text

_SLOWEST = 2.0  # times the median number of rows between fixes: a longer blank is a failure, not a slow GPS
_ODD = 0.05  # share of the intervals that may be longer or shorter: a failure now and then


def hold_fixes(draft: Draft) -> None:
    """Repeat the velocity where it is blank at regular intervals, and mark the fixes.

    Rows before the first fix are dropped. Irregular blanks stay; the check for numbers handles
    them.
    """
    fresh = np.isfinite(draft.channels["velocity_north"])
    steps = np.diff(np.flatnonzero(fresh))
    if fresh.all() or not _regular(steps):
        return
    interval = float(np.median(steps))
    # The latest row with a fix, for each row: a running maximum of row numbers.
    fix = np.maximum.accumulate(np.where(fresh, np.arange(len(fresh)), 0))
    held = np.arange(len(fresh)) - fix < _SLOWEST * interval  # in a failure nothing is held
    for name in numbers_from("gps"):
        values = draft.channels.get(name)
        if values is not None and np.array_equal(np.isfinite(values), fresh):
            draft.channels[name] = np.where(held, values[fix], np.nan)
    if "gps_fresh" not in draft.channels:
        draft.put("gps_fresh", fresh, draft.columns["velocity_north"])
    draft.drop(
        np.arange(len(fresh)) < int(np.argmax(fresh)),
        f"column {draft.columns['velocity_north']!r} is blank between fixes (one in {interval:.0f} "
        "rows): held from fix to fix",
    )


def _regular(steps: NDArray[np.intp]) -> bool:
    """Return whether fixes come every two rows or more, at nearly equal intervals.

    Few of the intervals may differ much from the median.
    """
    if len(steps) < 2:
        return False
    usual = float(np.median(steps))
    odd = (steps > _SLOWEST * usual) | (steps < usual / _SLOWEST)
    return usual >= 2.0 and float(odd.mean()) <= _ODD


# share of rows for which a channel that is not needed is given up no sooner than the rows
_FEW = 0.01
_MOST = 0.5  # share of rows that may be skipped: of less than half a log nobody knows whether it is the right half


def check_numbers(draft: Draft) -> None:
    """Skip rows where a needed channel is no number; leave out others that often are not.

    Raises BadInputError where more than half of the rows would be skipped, or where the clock often
    stands blank.
    """
    # rows skipped may be those of the others
    quantities = sorted(draft.numeric(), key=lambda q: not q.essential)
    for quantity in quantities:
        bad = ~np.isfinite(draft.channels[quantity.name])
        if not bad.any():
            continue
        share, column = float(bad.mean()), draft.columns[quantity.name]
        words = f"{int(bad.sum())} of {len(bad)} values are not numbers ({draft.named(bad)})"
        if share > _FEW and not quantity.essential:
            draft.leave_out(quantity.name, words)
            continue
        if share > (_FEW if quantity.name == "time" else _MOST):
            raise BadInputError(
                f"column {column!r}: {words}: too few rows remain; cut the log to a whole part"
            )
        extent = (
            ""
            if share <= _FEW
            else f", {percent_text(share)} of the log, {_seconds(draft, bad):.0f} s"
        )
        draft.drop(bad, f"column {column!r}: {words}{extent}: those rows are dropped")


def _seconds(draft: Draft, bad: Booleans) -> float:
    """The time that the rows cover [s], by the usual time between rows."""
    steps = np.diff(draft.channels["time"])
    known = steps[np.isfinite(steps)]
    return float(np.median(known)) * float(bad.sum()) if len(known) else 0.0


_MOST_BLANK = 0.9  # share of rows for which a unit may start up: what follows is a whole part


def drop_blank_start(draft: Draft) -> None:
    """Drop the rows before the first in which each needed channel has given a number.

    A unit has not started up in them.
    """
    first = {
        q.name: int(np.argmax(~np.isnan(draft.channels[q.name])))
        for q in draft.numeric()
        if q.essential
    }
    late = {name: row for name, row in first.items() if 0 < row <= _MOST_BLANK * len(draft.rows)}
    if not late:
        return
    count = max(late.values())
    columns = ", ".join(repr(name) for name in dict.fromkeys(draft.columns[name] for name in late))
    draft.drop(
        np.arange(len(draft.rows)) < count,
        f"the first {count} rows are dropped: the log begins blank in {columns}"
        if count > 1
        else f"the first row is dropped: it is blank in {columns}",
    )
