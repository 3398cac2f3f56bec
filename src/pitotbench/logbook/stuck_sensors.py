"""Find the rows in which a sensor stands still, and drop them or explain them."""

import numpy as np
from numpy.typing import NDArray

from pitotbench import air
from pitotbench.logbook.columns import HEIGHT
from pitotbench.logbook.draft import Draft
from pitotbench.logbook.plausible_air import at_ceiling
from pitotbench.records import BadInputError
from pitotbench.records.log import Caution
from pitotbench.timeline import pauses
from pitotbench.units import Array, Booleans, MetersPerSecond, percent_text

_MOST_STUCK = 0.5  # share of rows that may be dropped for a stuck sensor
_STUCK_TIME = 10.0  # s
_STUCK_RUNS = 10.0  # times the median time for which a value repeats
_DISPLAYED = 30.0  # times longer may a reading in steps stand still before a pause or the end
_JUMP = 3.0  # usual steps: with more, a reading in steps comes free that was stuck
_TURNED = 0.5  # rad of heading, in which no ground velocity stands still
_RETURNS = 0.9  # of a channel with steps: most values a move
_ADJACENT = 0.95  # likewise: least share of moves by one step
_STEEPEST = 0.99  # quantile of the steps of a reading that its step down from the end of the range stays below
_MOVING = 2.0  # m/s, above which a velocity cannot stand still


def check_stuck(draft: Draft) -> None:
    """Drop rows in which the impact pressure, the static pressure or the GPS velocity is stuck.

    Raises BadInputError for a GPS velocity that never changes, and where more than half of the rows
    are bad.
    """
    speed = np.hypot(draft.channels["velocity_north"], draft.channels["velocity_east"])
    if (
        np.ptp(draft.channels["velocity_north"]) == 0.0
        and np.ptp(draft.channels["velocity_east"]) == 0.0
    ):
        shown = air.calibrated_airspeed(np.maximum(draft.channels["impact_pressure"], 0.0))
        raise BadInputError(
            "the GPS velocity is the same in every row: the receiver gave none, or is stuck. Give "
            "another log; of a tunnel or a bench write the known speed of each run beside the "
            f"airspeed that was shown, here {np.median(shown):.1f} m/s, and give that table "
            "to `pitotbench fixed-speed`"
        )
    velocity = ["velocity_north", "velocity_east"]
    # Each sensor is compared with another one that must change in flight: pressure with velocity,
    # and the reverse.
    still = {
        "impact_pressure": _stuck(draft, ["impact_pressure"], velocity) & (speed > _MOVING),
        "static_pressure": _stuck(draft, ["static_pressure"], ["impact_pressure"])
        & (speed > _MOVING),
        "velocity_north": _stuck(draft, velocity, ["impact_pressure"]) & (speed > _MOVING),
    }
    if np.ptp(draft.channels["static_pressure"]) == 0.0:
        if draft.columns["static_pressure"] != HEIGHT:  # which is one number
            words = (
                f"column {draft.columns['static_pressure']!r} never changes: is the sensor stuck?"
            )
            draft.warnings.append(Caution(words, "suspect"))
        still["static_pressure"][:] = False
    # At the end of its range a sensor stands still as well. Those rows stay, and show where the
    # range ends.
    still["impact_pressure"] &= ~at_range_end(draft, speed)
    bad = np.any(list(still.values()), axis=0)
    idle = still["impact_pressure"] & (draft.channels["impact_pressure"] == 0.0)
    column = draft.columns["impact_pressure"]
    sentences = (
        [f"column {column!r} reads 0 below its lowest speed ({draft.named(idle)})"]
        if idle.any()
        else []
    )
    sentences += [
        f"column {draft.columns[name]!r} stands still while others move: it seems stuck "
        f"({draft.named(rows)})"
        for name, found in still.items()
        if (rows := found & ~idle).any()
    ]
    words = "; ".join(sentences)
    if bad.mean() > _MOST_STUCK and keep_new_airspeeds(draft):
        return
    if bad.mean() > _MOST_STUCK:
        raise BadInputError(
            f"{words}: {percent_text(bad.mean())} of the log; repair the sensor and fly again"
        )
    if words:
        draft.warnings.append(f"{words}: those rows are dropped")
    draft.keep(~bad)


_LONGEST_HELD = 0.05  # share of the rows that one value may fill
_FEWEST_NEW = 30  # new values: a sensor that is stuck in most rows has few


def keep_new_airspeeds(draft: Draft) -> bool:
    """Drop the rows that repeat an airspeed which comes at long intervals.

    Mode S and slow buses give such an airspeed, while the GPS velocity beside it is of the row.
    Return whether it is so.
    """
    repeated = np.diff(draft.channels["impact_pressure"], prepend=np.nan) == 0.0
    count = int(np.count_nonzero(~repeated))
    longest = int(np.max(np.diff(np.flatnonzero(np.append(~repeated, True)))))
    sparse = _FEWEST_NEW <= count <= _MOST_STUCK * len(repeated)
    if not sparse or longest > _LONGEST_HELD * len(repeated):
        return False
    draft.drop(
        repeated,
        f"column {draft.columns['impact_pressure']!r} repeats each value until the next answer "
        f"comes: the {count} of {len(repeated)} rows with a new one are used",
    )
    return True


def at_range_end(draft: Draft, speed: MetersPerSecond) -> Booleans:
    """Return the rows, (n,), with impact pressure at the end of its range, but not stuck.

    Where a range ends, the reading comes back by steps as it makes them elsewhere. A stuck sensor
    jumps to what the pressure has become meanwhile. Where no recording shows the way back, the
    ground `speed` decides: the airplane is faster at the end of the range.
    """
    rows = at_ceiling(draft.channels["impact_pressure"])
    if not rows.any():
        return rows
    steps = _steps_out(draft, ["impact_pressure"])[:-1]
    back = steps[rows[:-1] & ~rows[1:] & np.isfinite(steps)]
    free = steps[~rows[:-1] & ~rows[1:] & (steps > 0.0)]
    if len(back) and len(free):
        found = np.median(back) <= np.quantile(free, _STEEPEST)
    else:
        found = np.mean(speed[rows] ** 2) > np.mean(speed[~rows] ** 2)
    return rows if found else np.zeros_like(rows)


def _stuck(draft: Draft, names: list[str], others: list[str]) -> Booleans:
    """Return the rows, (n,), in which values stay equal while those of another sensor change.

    Short runs of equal values are normal: the fixes of a slow GPS repeat. A reading in steps may
    stand still for a whole leg; then it moves on by a step, where one that was stuck jumps.
    """
    changed, moved = _changes(draft, names), np.r_[0, np.cumsum(_changes(draft, others))]
    changed[pauses(draft.channels["time"]) - 1] = True  # what happened meanwhile was not recorded
    first = np.r_[0, np.flatnonzero(changed) + 1]
    last = np.r_[first[1:] - 1, len(draft.rows) - 1]
    lasting = draft.channels["time"][last] - draft.channels["time"][first]
    usual_run = float(np.median(np.diff(draft.channels["time"][first]))) if len(first) > 1 else 0.0
    limit = max(_STUCK_TIME, _STUCK_RUNS * usual_run)
    long = (lasting > limit) & (moved[last] > moved[first])
    if draft.displayed & set(names) or all(_shows_steps(draft.channels[name]) for name in names):
        out = _steps_out(draft, names)[last]
        known = np.isfinite(out)
        usual = max(
            _JUMP * float(np.median(out[known])) if known.any() else 0.0,
            float(np.quantile(out[known & ~long], _STEEPEST)) if (known & ~long).any() else 0.0,
        )
        jumped = np.where(known, out > usual, lasting > _DISPLAYED * limit)
        long &= jumped | _turned(draft, names, first, last)
    bad = np.zeros(len(draft.rows), dtype=np.bool_)
    for a, b in zip(first[long], last[long], strict=True):
        bad[a : b + 1] = True
    return bad


def _steps_out(draft: Draft, names: list[str]) -> Array:
    """Return by how much values move from row to row, (n,), NaN where no record shows it."""
    moves = [np.diff(draft.channels[name], append=np.nan) for name in names]
    steps = np.sqrt(np.sum(np.square(moves), axis=0))
    steps[pauses(draft.channels["time"]) - 1] = np.nan
    return np.asarray(steps)


def _turned(
    draft: Draft, names: list[str], first: NDArray[np.intp], last: NDArray[np.intp]
) -> Booleans:
    """Return whether the airplane turned between first and last rows of a velocity, (k,)."""
    heading = draft.channels.get("heading")
    if heading is None or "velocity_north" not in names:
        return np.zeros(len(first), dtype=np.bool_)
    turned = np.unwrap(heading)
    swings = [np.ptp(turned[a : b + 1]) for a, b in zip(first, last, strict=True)]
    return np.asarray(swings) > _TURNED


def _shows_steps(values: Array) -> bool:
    """Return whether a channel comes in few values, from each to the next above or below.

    So does a coarse display in calm air, and it may stand still for a whole leg.
    """
    levels, place = np.unique(values, return_inverse=True)
    moves = np.diff(place)
    moves = np.abs(moves[moves != 0])
    return len(levels) < _RETURNS * len(moves) and bool(np.mean(moves == 1) > _ADJACENT)


def _changes(draft: Draft, names: list[str]) -> Booleans:
    """Return whether each row differs from the one before, from the second row on, (n − 1,)."""
    return np.asarray(np.any([np.diff(draft.channels[name]) != 0.0 for name in names], axis=0))
