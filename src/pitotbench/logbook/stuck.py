"""Find stuck sensors, whose values stay the same while those of others change."""

import numpy as np
from numpy.typing import NDArray

from pitotbench.logbook.ceiling import at_ceiling
from pitotbench.logbook.draft import Draft
from pitotbench.records.errors import BadInputError
from pitotbench.timeline import pauses
from pitotbench.units import Array, Booleans, MetersPerSecond

_MOST = 0.5  # share of rows that may be dropped for a stuck sensor
_STUCK_TIME = 10.0  # s
_STUCK_RUNS = 10.0  # times the median time for which a value repeats
_DISPLAYED = 30.0  # times longer may the value of a display stand still, which shows steps
_RETURNS, _ADJACENT = 0.9, 0.95  # of a channel with steps: most values a move, least share of moves by one step
_STEEPEST = 0.99  # quantile of the steps of a reading that its step down from the end of the range stays below
_MOVING = 2.0  # m/s, above which a velocity cannot stand still


def check_stuck(draft: Draft) -> None:
    """Drop rows in which the impact pressure, the static pressure or the GPS velocity is stuck.

    Raises BadInputError for a GPS velocity that never changes, and where more than half of the rows are bad.
    """
    speed = np.hypot(draft.channels["velocity_north"], draft.channels["velocity_east"])
    if np.ptp(draft.channels["velocity_north"]) == 0.0 and np.ptp(draft.channels["velocity_east"]) == 0.0:
        raise BadInputError("the GPS velocity is the same in every row: the receiver is stuck; use another log")
    velocity = ["velocity_north", "velocity_east"]
    # Each sensor is compared with another one that must change in flight: pressure with velocity, and the reverse.
    still = {
        "impact_pressure": _stuck(draft, ["impact_pressure"], velocity) & (speed > _MOVING),
        "static_pressure": _stuck(draft, ["static_pressure"], ["impact_pressure"]) & (speed > _MOVING),
        "velocity_north": _stuck(draft, velocity, ["impact_pressure"]) & (speed > _MOVING),
    }
    if np.ptp(draft.channels["static_pressure"]) == 0.0:
        draft.warnings.append(f"column {draft.columns['static_pressure']!r} never changes: is the sensor stuck?")
        still["static_pressure"][:] = False
    # At the end of its range a sensor stands still as well. Those rows stay, and show where the range ends.
    still["impact_pressure"] &= ~_at_range_end(draft, speed)
    bad = np.any(list(still.values()), axis=0)
    words = "; ".join(
        f"column {draft.columns[name]!r} stands still while others move: it seems stuck ({draft.named(rows)})"
        for name, rows in still.items()
        if rows.any()
    )
    if bad.mean() > _MOST:
        raise BadInputError(f"{words}: {bad.mean():.0%} of the log; repair the sensor and fly again")
    if words:
        draft.warnings.append(f"{words}: those rows are dropped")
    draft.keep(~bad)


def _at_range_end(draft: Draft, speed: MetersPerSecond) -> Booleans:
    """Return the rows, (n,), in which the impact pressure stands at the end of its sensor's range and is not stuck.

    Where a range ends, the reading comes back by steps as it makes them elsewhere. A stuck sensor jumps to what the
    pressure has become meanwhile. Where no recording shows the way back, the ground `speed` decides: the airplane
    is faster at the end of the range.
    """
    impact = draft.channels["impact_pressure"]
    rows = at_ceiling(impact)
    if not rows.any():
        return rows
    steps = np.abs(np.diff(impact))
    steps[pauses(draft.channels["time"]) - 1] = np.nan  # what happened meanwhile was not recorded
    back = steps[rows[:-1] & ~rows[1:] & np.isfinite(steps)]
    free = steps[~rows[:-1] & ~rows[1:] & (steps > 0.0)]
    if len(back) and len(free):
        found = np.median(back) <= np.quantile(free, _STEEPEST)
    else:
        found = np.mean(speed[rows] ** 2) > np.mean(speed[~rows] ** 2)
    return rows if found else np.zeros_like(rows)


def _stuck(draft: Draft, names: list[str], others: list[str]) -> Booleans:
    """Return the rows, (n,), in which values stay equal for very long while those of another sensor change.

    Short runs of equal values are normal: the fixes of a slow GPS repeat, and so do the steps of a coarse sensor.
    """
    changed, moved = _changes(draft, names), np.r_[0, np.cumsum(_changes(draft, others))]
    changed[pauses(draft.channels["time"]) - 1] = True  # what happened meanwhile was not recorded
    first = np.r_[0, np.flatnonzero(changed) + 1]
    last = np.r_[first[1:] - 1, len(draft.rows) - 1]
    lasting = draft.channels["time"][last] - draft.channels["time"][first]
    stepped = bool(draft.displayed & set(names)) or all(_shows_steps(draft.channels[name]) for name in names)
    patience = _DISPLAYED if stepped else 1.0
    limit = patience * max(_STUCK_TIME, _STUCK_RUNS * float(np.median(_run_times(draft.channels["time"], first))))
    bad = np.zeros(len(draft.rows), dtype=np.bool_)
    long = (lasting > limit) & (moved[last] > moved[first])
    for a, b in zip(first[long], last[long], strict=True):
        bad[a : b + 1] = True
    return bad


def _shows_steps(values: Array) -> bool:
    """Return whether a channel returns to few values and moves from each to the next above or below only.

    So does a coarse display in calm air, and it may stand still for a whole leg.
    """
    levels, place = np.unique(values, return_inverse=True)
    moves = np.diff(place)
    moves = np.abs(moves[moves != 0])
    return len(levels) < _RETURNS * len(moves) and bool(np.mean(moves == 1) > _ADJACENT)


def _changes(draft: Draft, names: list[str]) -> Booleans:
    """Return whether each row differs from the one before, from the second row on, (n − 1,)."""
    changed: Booleans = np.any([np.diff(draft.channels[name]) != 0.0 for name in names], axis=0)
    return changed


def _run_times(time: Array, first: NDArray[np.intp]) -> Array:
    return np.diff(time[first]) if len(first) > 1 else np.zeros(1)
