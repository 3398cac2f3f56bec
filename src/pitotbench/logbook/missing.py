"""Rows in which a needed channel is not a number: skipped as rows that were never recorded."""

import numpy as np

from pitotbench.logbook.draft import Draft
from pitotbench.records.errors import BadInputError
from pitotbench.units import Booleans

_FEW = 0.01  # share of rows for which a channel that is not needed is given up no sooner than the rows
_MOST = 0.5  # share of rows that may be skipped: of less than half a log nobody knows whether it is the right half


def check_numbers(draft: Draft) -> None:
    """Skip the rows where a needed channel is not a number; leave out other channels that often are not.

    Raises BadInputError where more than half of the rows would be skipped, or where the clock often stands blank.
    """
    quantities = sorted(draft.numeric(), key=lambda q: not q.essential)  # rows skipped may be those of the others
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
            raise BadInputError(f"column {column!r}: {words}: too few rows remain; cut the log to a whole part")
        extent = "" if share <= _FEW else f", {share:.0%} of the log, {_seconds(draft, bad):.0f} s"
        draft.warnings.append(f"column {column!r}: {words}{extent}: those rows are dropped")
        draft.keep(~bad)


def _seconds(draft: Draft, bad: Booleans) -> float:
    """The time that the rows cover [s], by the usual time between rows."""
    steps = np.diff(draft.channels["time"])
    known = steps[np.isfinite(steps)]
    return float(np.median(known)) * float(bad.sum()) if len(known) else 0.0
