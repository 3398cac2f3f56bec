"""Check the rows of a log: units, glitches, air data. A check drops rows with a warning, or raises.
Also the flights that a log holds, and the airplane that it names.
"""

import re
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from pitotbench.broken import BROKEN, TAXI, Broken, find_early, find_late
from pitotbench.channels import Channel
from pitotbench.logbook.clock_checks import check_clock, check_pauses, check_time, flight_breaks
from pitotbench.logbook.columns import impossible
from pitotbench.logbook.draft import Draft, check_numbers, hold_fixes
from pitotbench.logbook.plausibility import SPEED_FACTOR, check_plausibility
from pitotbench.logbook.plausible_air import TEMPERATURES, likely_temperatures
from pitotbench.logbook.stuck_sensors import at_range_end, check_stuck
from pitotbench.records import BadInputError
from pitotbench.records.log import Caution, FlightLog
from pitotbench.timeline import stretches
from pitotbench.units import KNOT, Array, from_si, to_si


def flights_in(log: FlightLog) -> list[FlightLog]:
    """The log cut at every pause of more than five minutes; a list of the log alone where there is
    none.

    A part of a single row, which is no log, is left out.
    """
    parts = stretches(log.time, flight_breaks(log.time))
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


# Check the rows of a log. Each check drops rows with a warning, or raises BadInputError.
# Rows are counted from 1, which is the first row below the line of column names.

_MOST_BLANK = 0.5  # share of rows for which a unit may start up
_MOST_NEGATIVE = 0.5  # share of rows that may be dropped for a negative impact pressure


def drop_blank_start(draft: Draft) -> None:
    """Drop the rows before the first in which each needed channel has given a number: a unit that
    starts up.
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


def check_units(draft: Draft) -> None:
    """Find channels outside their plausible range: in another unit than the column says, or from a
    dead sensor.

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
                "rows "
                f"({draft.named(bad)}): they are dropped",
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
    end = at_range_end(draft, np.hypot(channels["velocity_north"], channels["velocity_east"]))
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
    """Drop rows of negative impact pressure. Raise BadInputError for a stuck sensor, and where most
    are negative.

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
            f"{len(impact)} rows; "
            "total and static are exchanged, or the sign is: swap them"
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
# broken pitot is told before anything else is blamed for what it reads.
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
