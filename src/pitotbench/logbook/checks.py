"""Check the rows of a log. A check drops rows with a warning, or raises."""

from collections.abc import Callable, Mapping

import numpy as np

from pitotbench.airdata import TAXI, rests_of
from pitotbench.broken import BROKEN, Broken, find_early, find_late, zero_moved
from pitotbench.channels import Channel
from pitotbench.logbook.blank_cells import check_numbers, drop_blank_start, hold_fixes
from pitotbench.logbook.clock_checks import check_clock, check_time
from pitotbench.logbook.columns import impossible
from pitotbench.logbook.draft import Draft
from pitotbench.logbook.flight_parts import BETWEEN_FLIGHTS, flight_breaks
from pitotbench.logbook.plausibility import SPEED_FACTOR, check_plausibility
from pitotbench.logbook.plausible_air import TEMPERATURES, likely_temperatures
from pitotbench.logbook.stuck_sensors import at_range_end, check_stuck
from pitotbench.records import BadInputError
from pitotbench.records.log import Caution
from pitotbench.timeline import Indices, pauses
from pitotbench.units import KNOT, Array, Booleans, from_si, percent_text, to_si


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
            f"{BETWEEN_FLIGHTS / 60.0:.0f} minutes {draft.before(breaks)}; a calibration "
            "gives each its own wind"
        )
    short = after[_unmeant(draft, after) & ~np.isin(after, breaks)]
    if len(short):
        longest = float(np.max(np.diff(time)[short - 1]))
        draft.warnings.append(
            f"the recording pauses {'once' if len(short) == 1 else f'{len(short)} times'}, "
            f"for up to {longest:.0f} s, {draft.before(short)}"
        )


def _unmeant(draft: Draft, after: Indices) -> Booleans:
    segment = draft.channels.get("segment", np.zeros(len(draft.rows)))
    same = segment[after] == segment[after - 1]
    return np.asarray(same & (np.diff(draft.rows)[after - 1] == 1))


_MOST_NEGATIVE = 0.5  # share of rows that may be dropped for a negative impact pressure


def check_units(draft: Draft) -> None:
    """Find channels outside their plausible range, by a wrong unit or a dead sensor.

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
    """Keep what is read at rest, and warn of a broken pitot.

    Raises BadInputError where its air data hold no answer.
    """
    draft.rests = rests_of(draft.channels)
    _tell_broken(draft, lambda channels: find_early(channels) or zero_moved(channels, draft.rests))


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
    """Drop rows of negative impact pressure.

    Raises BadInputError for a stuck sensor, and where most are negative.

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
                f"column {column!r} comes in steps of {step:.0f} Pa, {percent_text(step / usual)} "
                "of what it usually reads: the curve may be off by as much; record more digits",
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
