"""Find logs of one flight, so that it counts once: doubles, overlaps, or two recorders.

Doubles are the same rows under two names, overlaps those of two files, and the recorders are in one
airplane.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from itertools import combinations

import numpy as np

from pitotbench.airdata import NEEDED
from pitotbench.logbook.columns import START
from pitotbench.logbook.identity import airplane_of
from pitotbench.records.log import Caution, FlightLog
from pitotbench.timeline import interval, nearest

COUNTED_ONCE = "counted once"  # code of the notices of logs of one flight
# Of a channel's change from row to row (rms), and of its largest value: what writing a file again
# rounds. Two sensors, and two flights, differ by their noise, which is most of that change.
_ROUNDED = 0.01
_DIGITS = 1e-6
_SAME = 0.9  # of the rows in common that agree: a reader may drop or mend single rows
_FEWEST = 20  # rows in common that differ from the one before: a parked airplane's are all alike
_SIMULTANEOUS = 0.1  # of a row's interval, within which two rows are of one moment
_TOGETHER = 60.0  # s of overlap by clock: between two flights of one day clocks may be off by less


@dataclass(frozen=True, slots=True)
class DistinctLogs:
    """Logs of which no two hold the same rows.

    `places` (n,) are those of the logs that were given among `logs`; `notices` name the files that
    counted once.
    """

    logs: tuple[FlightLog, ...]
    places: tuple[int, ...]
    notices: tuple[Caution, ...]

    @property
    def first(self) -> tuple[int, ...]:
        """The place among the given logs of the first that each of `logs` stands for."""
        return tuple(self.places.index(place) for place in range(len(self.logs)))


def distinct(logs: Sequence[FlightLog], names: Sequence[str]) -> DistinctLogs:
    """Return each of the logs once, and logs that overlap as one.

    Rows are the same where their numbers are, whatever the file. The clocks of two logs are
    compared as they stand, from their first rows, and by date and time. A log that stands alone is
    returned as it is. `names` are those of the notices.
    """
    kept: list[tuple[list[int], FlightLog]] = []
    for place, each in enumerate(logs):
        own, log = [place], each
        while (same := _of_same_rows(log, [other for _, other in kept])) is not None:
            number, shift = same
            members, other = kept.pop(number)
            own, log = sorted([*members, *own]), _union(other, log, shift)
        kept.append((own, log))
    kept.sort(key=lambda item: item[0])
    at = {member: place for place, (own, _) in enumerate(kept) for member in own}
    notices = [
        f"the same rows are in {_listed([names[member] for member in own])}: the flight counts once"
        for own, _ in kept
        if len(own) > 1
    ]
    return DistinctLogs(
        tuple(log for _, log in kept),
        tuple(at[place] for place in range(len(logs))),
        tuple(Caution(words, COUNTED_ONCE) for words in notices),
    )


def recorders(logs: Sequence[FlightLog]) -> list[tuple[int, int]]:
    """Return the pairs of logs, by their places, that two recorders wrote in one flight.

    Their airplane is one, as far as their headers name it, and their clocks, with date and time,
    overlap. The logs are `distinct`. Seconds without a date are no clock.
    """
    return [
        (i, j)
        for i, j in combinations(range(len(logs)), 2)
        if overlap(logs[i], logs[j]) > _TOGETHER and _may_be_one_airplane(logs[i], logs[j])
    ]


def recorders_notices(
    logs: Sequence[FlightLog], names: Sequence[str], together: bool = True
) -> tuple[Caution, ...]:
    """Return what is said of `recorders`, whose logs are calibrated `together` or each alone."""
    wind = (
        "over the same minutes the wind of the one that knows it better"
        if together
        else "a wind of its own"
    )
    return tuple(
        Caution(
            f"two recorders wrote one flight, {names[i]} and {names[j]}: each has a curve of its "
            f"own and {wind}",
            COUNTED_ONCE,
        )
        for i, j in recorders(logs)
    )


def overlap(log: FlightLog, other: FlightLog) -> float:
    """Return for how long [s] both logs were recorded, by date and time; 0 without them."""
    here, there = moment_of(log), moment_of(other)
    if here is None or there is None:
        return 0.0
    begin = max(here + log.time[0], there + other.time[0])
    return max(float(min(here + log.time[-1], there + other.time[-1]) - begin), 0.0)


def moment_of(log: FlightLog) -> float | None:
    """Return the moment [s since 1970] at which a log's seconds begin, None without a full date.

    A full date has a time of day.
    """
    stated = str(log.header.get(START, ""))
    if ":" not in stated:
        return None
    try:
        moment = datetime.fromisoformat(stated)
    except ValueError:
        return None
    return (moment if moment.tzinfo else moment.replace(tzinfo=UTC)).timestamp()


def _listed(names: Sequence[str]) -> str:
    return f"{', '.join(names[:-1])} and {names[-1]}"


def _may_be_one_airplane(log: FlightLog, other: FlightLog) -> bool:
    named = {name.casefold() for each in (log, other) if (name := airplane_of(each))}
    return len(named) < 2


def _of_same_rows(log: FlightLog, others: Sequence[FlightLog]) -> tuple[int, float] | None:
    """Return the first of the others that holds the same rows, and its clock's lead [s].

    The lead is to be added to the log's time. Rows under the names of two airplanes are not those
    of one flight.
    """
    for number, other in enumerate(others):
        if not _may_be_one_airplane(log, other):
            continue
        here, there = moment_of(log), moment_of(other)
        shifts = [0.0, float(other.time[0] - log.time[0])]
        if here is not None and there is not None:
            shifts.append(here - there)
        for shift in dict.fromkeys(shifts):
            if _agree(log, other, shift):
                return number, shift
    return None


def _agree(log: FlightLog, other: FlightLog, shift: float) -> bool:
    """Whether the rows of one moment are the same in two logs."""
    here, there = log.time + shift, other.time
    few, many, coarse, fine = here, there, log, other
    if interval(here) < interval(there):
        few, many, coarse, fine = there, here, other, log
    place = nearest(few, many)
    near = np.abs(many[place] - few) < _SIMULTANEOUS * interval(many)
    inside = (few >= many[0]) & (few <= many[-1])
    count = int(np.count_nonzero(near))
    if count < max(_FEWEST, _SAME * np.count_nonzero(inside)):
        return False
    same, moves = np.ones(count, dtype=np.bool_), np.zeros(count - 1, dtype=np.bool_)
    for name in NEEDED[1:]:  # all but the time
        values, theirs = getattr(coarse, name)[near], getattr(fine, name)[place[near]]
        steps = np.diff(values)
        moves |= steps != 0.0
        change = float(np.sqrt(np.mean(np.square(steps))))
        rounded = max(_ROUNDED * change, _DIGITS * float(np.max(np.abs(values))))
        same &= np.abs(values - theirs) <= rounded
    return int(np.count_nonzero(moves)) >= _FEWEST and float(np.mean(same)) >= _SAME


def _union(other: FlightLog, log: FlightLog, shift: float) -> FlightLog:
    """Return one log of two that overlap: the longer, with the other's rows before and after it.

    Of logs of one length it is the one with more channels, or the first.
    """
    span = [float(each.time[-1] - each.time[0]) for each in (other, log)]
    later = (span[1], len(log.channels())) > (span[0], len(other.channels()))
    base, more = (log, other) if later else (other, log)
    time = more.time + (-shift if later else shift)
    near = 0.5 * interval(base.time)  # a clock with a digit less ends within a row of the other
    before, after = time < base.time[0] - near, time > base.time[-1] + near
    if not (before | after).any():
        return base
    moved = replace(more, time=time).channels()
    return FlightLog(
        **{
            name: np.concatenate([moved[name][before], values, moved[name][after]])
            for name, values in base.channels().items()
            if name in moved
        },
        header=base.header,
    )
