"""Fill GPS columns that are blank between fixes: each fix is repeated until the next one.

A logger with one rate writes its file in this way.
"""

import numpy as np
from numpy.typing import NDArray

from pitotbench.channels import numbers_from
from pitotbench.logbook.draft import Draft
from pitotbench.units import Booleans

_SLOWEST = 2.0  # times the median number of rows between fixes: a longer blank is a failure, not a slow GPS
_ODD = 0.05  # share of the intervals that may be longer or shorter: a failure now and then


def hold_fixes(draft: Draft) -> None:
    """Repeat the velocity where it is blank at regular intervals, and mark the rows that hold a fix.

    Rows before the first fix are dropped. Irregular blanks stay; the check for numbers handles them.
    """
    fresh = np.isfinite(draft.channels["velocity_north"])
    if fresh.all() or not _regular(fresh):
        return
    # The latest row with a fix, for each row: a running maximum of row numbers.
    fix = np.maximum.accumulate(np.where(fresh, np.arange(len(fresh)), 0))
    held = np.arange(len(fresh)) - fix < _SLOWEST * _interval(fresh)  # in a failure nothing is held
    for name in numbers_from("gps"):
        values = draft.channels.get(name)
        if values is not None and np.array_equal(np.isfinite(values), fresh):
            draft.channels[name] = np.where(held, values[fix], np.nan)
    if "gps_fresh" not in draft.channels:
        draft.channels["gps_fresh"], draft.columns["gps_fresh"] = fresh, draft.columns["velocity_north"]
    draft.warnings.append(
        f"column {draft.columns['velocity_north']!r} is blank between fixes (one in {_interval(fresh):.0f} rows): "
        "held from fix to fix"
    )
    draft.keep(np.arange(len(fresh)) >= int(np.argmax(fresh)))


def _steps(fresh: Booleans) -> NDArray[np.intp]:
    return np.diff(np.flatnonzero(fresh))


def _interval(fresh: Booleans) -> float:
    return float(np.median(_steps(fresh)))


def _regular(fresh: Booleans) -> bool:
    """Return whether fixes come every two rows or more, at intervals few of which differ much from the median."""
    if int(fresh.sum()) < 3:
        return False
    usual, steps = _interval(fresh), _steps(fresh)
    odd = (steps > _SLOWEST * usual) | (steps < usual / _SLOWEST)
    return usual >= 2.0 and float(odd.mean()) <= _ODD
