"""Check the rows of a log: pauses, stuck sensors, missing numbers.

A check drops rows with a warning, or raises.
"""

import re
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from pitotbench import air
from pitotbench.airdata import TAXI
from pitotbench.broken import BROKEN, Broken, find_early, find_late
from pitotbench.channels import Channel
from pitotbench.logbook.columns import (
    HEIGHT,
    KIND,
    PARAMETERS,
    QUANTITIES,
    SECONDS_A_DAY,
    START,
    impossible,
)
from pitotbench.logbook.draft import Draft, check_numbers, hold_fixes
from pitotbench.logbook.plausibility import SPEED_FACTOR, check_plausibility
from pitotbench.logbook.plausible_air import TEMPERATURES, at_ceiling, likely_temperatures
from pitotbench.records import BadInputError
from pitotbench.records.log import Caution, FlightLog
from pitotbench.timeline import PAUSE_SAMPLES, Indices, pauses, stretches
from pitotbench.units import KNOT, Array, Booleans, MetersPerSecond, Seconds, from_si, to_si

BETWEEN_FLIGHTS = 300.0  # s: in five minutes without a record an airplane lands and takes off, or the wind changes
_SHOWN = 3  # row numbers that a sentence names


# s: a pause or a stop on the ground, after which a wind that does not fit the rows before may be
# another one
STOP = 20.0


def flights_in(log: FlightLog) -> list[FlightLog]:
    """Return the log cut at every pause of more than five minutes.

    Where there is none, it is a list of the log alone.

    A part of a single row, which is no log, is left out.
    """
    return _cut(log, flight_breaks(log.time))


def flights_between_stops(log: FlightLog) -> list[FlightLog]:
    """Return the log cut at every pause and every stop on the ground of at least `STOP`.

    Such a stop is a taxi back to the runway. Else as `flights_in`.
    """
    after = pauses(log.time)
    slow = np.hypot(log.velocity_north, log.velocity_east) < TAXI
    begins = np.flatnonzero(slow & ~np.append(True, slow[:-1]))
    ends = np.flatnonzero(slow & ~np.append(slow[1:], True))[-len(begins) :]
    stops = [
        begin
        for begin, end in zip(begins, ends, strict=False)
        if log.time[end] - log.time[begin] >= STOP
    ]
    paused = after[np.diff(log.time)[after - 1] >= STOP]
    return _cut(log, np.union1d(paused, np.array(stops, dtype=np.intp)))


def _cut(log: FlightLog, breaks: Indices) -> list[FlightLog]:
    parts = stretches(log.time, breaks)
    if len(parts) == 1:
        return [log]
    return [log.part(np.arange(p.start, p.stop)) for p in parts if p.stop - p.start > 1]


# What names the airplane: entries of a header, and words in the first lines of a recorder.
_AIRPLANE = (
    "airframe_name",
    "aircraft_ident",
    "aircraft",
    "airplane",
    "glider",
    "registration",
    "tail",
)
_NAMED = re.compile(rf"\b({'|'.join(_AIRPLANE)})\s*[=:]\s*\"?([^\",]+)")


def _names_of(log: FlightLog) -> list[tuple[str, str]]:
    """What names the airplane of a log, with the entries that do."""
    case, lines = log.header.get("case"), log.header.get("comments", ())
    named = [(key, str(log.header[key])) for key in _AIRPLANE if key in log.header]
    named += _NAMED.findall("\n".join(map(str, lines if isinstance(lines, list) else ())))
    if isinstance(case, Mapping):  # an airplane with a patch is the same
        named.append(("case", str(case.get("aircraft", "")).partition("+")[0]))
    return [(key, name.strip()) for key, name in named if name.strip()]


def airplane_of(log: FlightLog) -> str:
    """Return the airplane as the header of a log names it; empty where it does not."""
    return next((name for _, name in _names_of(log)), "")


def day_of(log: FlightLog) -> str:
    """Return the day of the first row of a log, such as `2011-08-12`.

    Empty where only the time of the day is known.
    """
    day = str(log.header.get(START, "")).replace("T", " ").partition(" ")[0]
    return day if "-" in day else ""


_LIGHTEST = 115.0  # kg: 254 lb, the lightest vehicle that 14 CFR 103.1 knows with a person to it


def kind_of(log: FlightLog) -> str:
    """Return the kind of aircraft that a log is of, `drone` or `glider`.

    A recorder tells it, the parameters of an autopilot, or a mass that carries nobody. Empty where
    nothing shows it.
    """
    light = log.mass is not None and float(np.max(log.mass)) < _LIGHTEST
    return str(log.header.get(KIND, "drone" if light or PARAMETERS in log.header else ""))


def require_one_airplane(logs: Sequence[FlightLog]) -> None:
    """Raise BadInputError where the headers of logs that are to be joined name two airplanes."""
    known: dict[str, str] = {}
    for log in logs:
        for key, name in _names_of(log):
            other = known.setdefault(key, name)
            if other.casefold() != name.casefold():
                raise BadInputError(
                    f"the logs are of two airplanes, {other!r} and {name!r} ({key} of their "
                    "headers), which have nothing in common: give each alone, or calibrate with "
                    "--separately"
                )


def flight_breaks(time: Seconds) -> Indices:
    """The first row after each pause of more than `BETWEEN_FLIGHTS`."""
    after = pauses(time)
    return after[np.diff(time)[after - 1] > BETWEEN_FLIGHTS]


def check_pauses(draft: Draft) -> None:
    """Mention pauses of the recording; say it where they are long enough to part two flights.

    A pause at the end of a labeled segment is meant and not mentioned, nor is one that dropped rows
    made.
    """
    time = draft.channels["time"]
    breaks, after = flight_breaks(time), pauses(time)
    if len(breaks):
        draft.warnings.append(
            f"the log seems to hold {len(breaks) + 1} flights: the recording pauses for more than "
            f"{BETWEEN_FLIGHTS / 60.0:.0f} minutes {_before(draft, breaks)}; a calibration "
            "gives each its own wind"
        )
    short = after[_unmeant(draft, after) & ~np.isin(after, breaks)]
    if len(short):
        longest = float(np.max(np.diff(time)[short - 1]))
        draft.warnings.append(
            f"the recording pauses {'once' if len(short) == 1 else f'{len(short)} times'}, "
            f"for up to {longest:.0f} s, {_before(draft, short)}"
        )


def _before(draft: Draft, after: Indices) -> str:
    rows = ", ".join(str(draft.rows[i]) for i in after[:_SHOWN])
    return (
        f"before row{'s' if len(after) > 1 else ''} "
        f"{rows}{' and others' if len(after) > _SHOWN else ''}"
    )


def _unmeant(draft: Draft, after: Indices) -> Booleans:
    adjoining: Booleans = np.diff(draft.rows)[after - 1] == 1
    segment = draft.channels.get("segment")
    if segment is None:
        return adjoining
    same: Booleans = segment[after] == segment[after - 1]
    return adjoining & same


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


def _usual_airspeed(draft: Draft) -> float:
    """The median airspeed that the impact pressure shows [m/s]."""
    shown = air.calibrated_airspeed(np.maximum(draft.channels["impact_pressure"], 0.0))
    return float(np.median(shown))


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
        raise BadInputError(
            "the GPS velocity is the same in every row: the receiver gave none, or is stuck. Give "
            "another log; of a tunnel or a bench write the known speed of each run beside the "
            f"airspeed that was shown, here {_usual_airspeed(draft):.1f} m/s, and give that table "
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
    still["impact_pressure"] &= ~_at_range_end(draft, speed)
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
            f"{words}: {bad.mean():.0%} of the log; repair the sensor and fly again"
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


def _at_range_end(draft: Draft, speed: MetersPerSecond) -> Booleans:
    """Return the rows, (n,), in which the impact pressure stands at the end of its range.

    Rows in which it is stuck are none of them.

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
    """Return by how much the values move from each row to the next, (n,).

    NaN where no record shows it.
    """
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


_FEW = 0.01  # share of time stamps that may repeat
# steps of a coarse clock: for longer it stands still, and a longer step is a pause
_STANDS_STILL = 4.0
_MOST_BLANK = 0.5  # share of rows for which a unit may start up
# times the most rows of one stamp, to either side, over which the moments are averaged
_NEIGHBORS = 4

_FEWEST_RECORDED = 30  # rows of a recording: a clock that falls for fewer was disturbed

_MOST_NEGATIVE = 0.5  # share of rows that may be dropped for a negative impact pressure

# s, median time between rows: 0.1 Hz is ten times slower than the slowest receiver
_LONGEST_STEP = 10.0
_SHORTEST_STEP = 1.0 / 5000.0  # s: no air data are recorded faster


def drop_blank_start(draft: Draft) -> None:
    """Drop the rows before a unit has started up.

    They end with the first row in which each needed channel has given a number.
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


def check_time(draft: Draft) -> None:
    """Drop a few rows with a repeated time stamp, and spread those of a coarse clock.

    The rows of a coarse clock are spread between its stamps.

    Raises BadInputError for a clock that stands still, and for time that runs back.
    """
    if len(draft.rows) < 2:
        raise BadInputError(
            f"the log holds {len(draft.rows)} rows; at least 2 are needed: give the log of a flight"
        )
    column = draft.columns["time"]
    time = draft.channels["time"] = _after_restarts(draft, draft.channels["time"])
    step = np.diff(time, prepend=-np.inf)
    if np.any(step < 0.0):
        i = int(np.argmax(step < 0.0))
        raise BadInputError(
            f"column {column!r}, row {draft.rows[i]}: time runs back from {time[i - 1]:g} to "
            f"{time[i]:g} s; time must increase: sort the rows, or cut the log where its clock was "
            "set"
        )
    repeated = step == 0.0
    if repeated.mean() > _FEW:
        words = (
            f"column {column!r}: {int(repeated.sum())} of {len(time)} time stamps repeat the "
            "one before"
        )
        stamp = float(np.min(step[step > 0.0][1:], initial=np.inf))
        spread = _spread(time, stamp)
        if spread is None:
            raise BadInputError(
                f"{words} ({draft.named(repeated)}); time must increase: write it with more digits"
            )
        draft.channels["time"] = spread
        draft.warnings.append(
            f"{words}: the rows are spread evenly over its steps of {stamp:.3g} s"
        )
    elif repeated.any():
        draft.drop(
            repeated,
            f"column {column!r}: time stamps repeat ({draft.named(repeated)}): those rows are "
            "dropped",
        )


_RESTART = 5.0  # s after the first moment of the file at which a recorder's clock begins again


def _after_restarts(draft: Draft, time: Seconds) -> Seconds:
    """Return the moments of rows whose clock begins anew with each recording, one after another.

    Between two recordings lie twice `BETWEEN_FLIGHTS`: what really passed is not known. A clock
    that falls to another moment than that of its beginning was set, and stays as it is.
    """
    starts = np.flatnonzero(np.diff(time, prepend=-np.inf) < 0.0)
    lengths = np.diff(starts, append=len(time))
    if not len(starts) or np.any(lengths < _FEWEST_RECORDED):
        return time
    # After a single stamp that is wrong the clock jumps back.
    if np.any(np.diff(time)[starts] >= _RESTART) or np.any(
        np.abs(time[starts] - time[0]) > _RESTART
    ):
        return time
    draft.warnings.append(
        f"column {draft.columns['time']!r} begins anew {_before(draft, starts)}: the file holds "
        f"{len(starts) + 1} recordings, which are read as flights of their own"
    )
    found = time.copy()
    for start in starts:
        found[start:] += found[start - 1] - found[start] + 2.0 * BETWEEN_FLIGHTS
    return found


def _spread(time: Seconds, stamp: float) -> Seconds | None:
    """Return the moments of rows whose clock counts in steps of `stamp` [s], (n,).

    Each is the mean of its neighbors'.

    They stay within a step of the clock, but for what a real recorder lets its stamps tremble, and
    increase strictly. None where the clock stands still for so long that it is no coarse clock.
    """
    first = np.flatnonzero(np.diff(time, prepend=-np.inf))
    longest = int(np.max(np.diff(first, append=len(time))))
    usual = float(np.median(np.diff(time[first]))) * len(first) / len(time)
    if not np.isfinite(stamp) or longest * usual > _STANDS_STILL * stamp:
        return None
    found, reach = time.copy(), longest * _NEIGHBORS
    after = np.flatnonzero(np.diff(time) > max(_STANDS_STILL * stamp, PAUSE_SAMPLES * usual)) + 1
    for rows in stretches(time, after):
        part = time[rows]
        count = min(reach, len(part) - 1)
        # Turned about its ends, the part goes on as it came: a mean at an end is as even as one
        # inside.
        turned = np.r_[
            2.0 * part[0] - part[count:0:-1], part, 2.0 * part[-1] - part[-2 : -count - 2 : -1]
        ]
        sums = np.cumsum(np.r_[0.0, turned - part[0]])
        found[rows] = part[0] + (sums[2 * count + 1 :] - sums[: len(part)]) / (2 * count + 1)
    return found if np.all(np.diff(found) > 0.0) else None


def check_clock(draft: Draft) -> None:
    """Part recordings of several days; their clock goes on some minutes after the last row of each.

    A jump of more than a day is another day, or a clock that was set. Raises BadInputError for rows
    much too far apart or too close, which mean a clock in another unit.
    """
    column, time = draft.columns["time"], draft.channels["time"]
    steps = np.diff(time)
    usual = float(np.median(steps))
    if not _SHORTEST_STEP <= usual <= _LONGEST_STEP:
        raise BadInputError(
            f"column {column!r}: the rows are {usual:.3g} s apart, where {_SHORTEST_STEP:g} to "
            f"{_LONGEST_STEP:g} s are usual{_better_clock(draft, usual)}"
        )
    later = np.flatnonzero(steps > SECONDS_A_DAY) + 1
    if len(later):  # what works on a log counts its clock by the second
        draft.warnings.append(
            f"column {column!r} jumps by more than a day {_before(draft, later)}: the file holds "
            f"{len(later) + 1} recordings, which are read as flights of their own"
        )
        excess = np.zeros(len(time))
        excess[later] = steps[later - 1] - 2.0 * BETWEEN_FLIGHTS
        draft.channels["time"] = time - np.cumsum(excess)


def _better_clock(draft: Draft, usual: float) -> str:
    """Return as a hint the unit of time in which the rows would come at the rate of a flight log."""
    written = float(from_si(usual, draft.suffixes["time"]))
    for suffix in QUANTITIES["time"].suffixes:
        if _SHORTEST_STEP <= float(to_si(written, suffix)) <= 1.0:
            return (
                f": {written:.3g} between rows would fit a column named time_{suffix}: name it so"
            )
    return ": check the unit of the clock"


def check_units(draft: Draft) -> None:
    """Find channels outside their plausible range.

    They are in another unit than the column says, or from a dead sensor.

    Raises BadInputError for an essential channel; any other is ignored with a warning.
    """
    for quantity in draft.numeric():
        size = np.abs(draft.channels[quantity.name])
        if quantity.low <= size.min() and size.max() <= quantity.high:
            continue  # then so are the median and the quantile, which take longer to find
        typical, high = float(np.median(size)), float(np.quantile(size, 0.95))
        if quantity.low <= typical and high <= quantity.high:
            continue
        words = _implausible(draft, quantity, typical)
        if quantity.essential:
            raise BadInputError(f"column {draft.columns[quantity.name]!r}: {words}")
        draft.leave_out(quantity.name, words)


def _implausible(draft: Draft, quantity: Channel, typical: float) -> str:
    suffix = draft.suffixes[quantity.name]
    written = float(from_si(typical, suffix)) if suffix else typical
    # The hint lists the units in which the same numbers would be plausible.
    fits = [
        s
        for s in quantity.suffixes
        if quantity.low <= float(to_si(written, s)) <= quantity.high and s != suffix
    ]
    named = [f"{quantity.name}_{s}" for s in fits]
    if quantity.name in TEMPERATURES and "static_pressure" in draft.channels:
        named = likely_temperatures(draft, quantity.name) or named
    columns = " or ".join(named)
    way_out = f"; they would fit {columns}: correct the unit" if fits else ": check its scale"
    if not quantity.unit:
        way_out = "; write it as a number from 0 to 1"
    return f"typical values of {written:.4g} {suffix} are not those of an airplane{way_out}"


def check_spikes(draft: Draft) -> None:
    """Drop rows in which an essential channel has an impossible value: a glitch of the recorder."""
    for quantity in draft.numeric():
        if not quantity.essential or quantity.name == "time":
            continue
        bad = impossible(quantity, draft.channels[quantity.name])
        if bad.any():
            draft.drop(
                bad,
                f"column {draft.columns[quantity.name]!r}: impossible values in {int(bad.sum())} "
                f"rows ({draft.named(bad)}): they are dropped",
            )


def form_impact_pressure(draft: Draft) -> None:
    """Compute the impact pressure from total and static pressure where the log does not hold it."""
    total = draft.channels.pop("total_pressure", None)
    if total is None:
        return
    if "impact_pressure" in draft.channels:
        draft.warnings.append(
            "both impact and total pressure are given: the impact pressure is used"
        )
        return
    impact = total - draft.channels["static_pressure"]
    column, suffix = draft.columns["total_pressure"], draft.suffixes["total_pressure"]
    draft.put("impact_pressure", impact, column, suffix)


_COARSE = 0.04  # of the usual impact pressure: a whole knot at 50 kt
_FEWEST_LEVELS = 4  # that tell a step


def check_broken(draft: Draft) -> None:
    """Warn of a broken pitot. Raise BadInputError where its air data hold no answer."""
    _tell_broken(draft, find_early)


def check_broken_in_sound_velocities(draft: Draft) -> None:
    """The same for the kinds that a mistake of the velocities looks like as well."""
    _tell_broken(draft, find_late)


def _tell_broken(draft: Draft, find: Callable[[Mapping[str, Array]], Broken | None]) -> None:
    channels, column = draft.channels, draft.columns["impact_pressure"]
    if draft.cautions(BROKEN) or (found := find(channels)) is None:
        return
    # At the end of its range a sensor stands still and is sound.
    end = _at_range_end(draft, np.hypot(channels["velocity_north"], channels["velocity_east"]))
    if end.any():
        found = find({name: values[~end] for name, values in channels.items()})
    if found is None:
        return
    words = f"column {column!r}: {found.words}"
    if found.refused:
        raise BadInputError(words)
    for other in draft.cautions(SPEED_FACTOR):  # one cause, one story
        draft.warnings.remove(other)
    draft.warnings.append(Caution(words, BROKEN, column))


def check_impact_pressure(draft: Draft) -> None:
    """Drop rows of negative impact pressure.

    Raise BadInputError for a stuck sensor, and where most are negative.

    Mostly negative values mean that total and static are exchanged, or that the sign is. Warn of
    coarse steps.
    """
    impact, column = draft.channels["impact_pressure"], draft.columns["impact_pressure"]
    if np.ptp(impact) == 0.0:
        or_range = (
            ", or its range ends there: use a sensor with more range" if impact[0] > 0.0 else ""
        )
        speed = np.hypot(draft.channels["velocity_north"], draft.channels["velocity_east"])
        if impact[0] <= 0.0 and float(np.max(speed)) < TAXI:
            raise BadInputError(
                f"no level flight in this log: column {column!r} reads 0 throughout and the ground "
                f"speed stays below {TAXI / KNOT:.0f} kt, as on the ramp and in taxi; give the "
                "log of a flight"
            )
        raise BadInputError(
            f"column {column!r}: the sensor is stuck at {impact[0]:g} Pa in every row{or_range}; "
            "repair its line or its wiring, and fly again"
        )
    negative = impact < 0.0
    if negative.mean() > _MOST_NEGATIVE:
        raise BadInputError(
            f"column {column!r}: the impact pressure is negative in {int(negative.sum())} of "
            f"{len(impact)} rows; total and static are exchanged, or the sign is: swap them"
        )
    if negative.any():
        draft.drop(
            negative,
            f"column {column!r}: the impact pressure is negative in {int(negative.sum())} rows "
            f"({draft.named(negative)}): they are dropped",
        )
    levels = np.unique(draft.channels["impact_pressure"])
    step = float(np.median(np.diff(levels))) if len(levels) > _FEWEST_LEVELS else 0.0
    usual = float(np.median(impact[impact > 0.0]))
    if step > _COARSE * usual:
        draft.warnings.append(
            Caution(
                f"column {column!r} comes in steps of {step:.0f} Pa, {step / usual:.0%} of what it "
                "usually reads: the curve may be off by as much; record more digits",
                "suspect",
            )
        )


# The order matters: fixes are held before blanks count as a start-up or as missing numbers, the
# clock is right before units are judged, and the impact pressure exists before it is checked. A
# broken pitot is reported before anything else is blamed for what it reads.
CLOCK_CHECKS = (hold_fixes, drop_blank_start, check_numbers, check_time, check_clock)
CHECKS = (
    check_pauses,
    check_units,
    check_spikes,
    form_impact_pressure,
    check_broken,
    check_impact_pressure,
    check_stuck,
    check_plausibility,
    check_broken_in_sound_velocities,
)
