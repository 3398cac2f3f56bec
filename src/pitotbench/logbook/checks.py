"""Check the rows of a log. Each check drops rows with a warning, or raises BadInputError.

Rows are counted from 1, which is the first row below the line of column names.
"""

import numpy as np

from pitotbench.channels import Channel
from pitotbench.logbook.draft import Draft
from pitotbench.logbook.holding import hold_fixes
from pitotbench.logbook.missing import check_numbers
from pitotbench.logbook.plausibility import check_plausibility
from pitotbench.logbook.plausibility.weather import TEMPERATURES, likely_temperatures
from pitotbench.logbook.quantities import QUANTITIES
from pitotbench.logbook.recording_pauses import check_pauses
from pitotbench.logbook.stuck import check_stuck
from pitotbench.records.errors import BadInputError
from pitotbench.units import from_si, to_si

_FEW = 0.01  # share of time stamps that may repeat
_MOST = 0.5  # share of rows that may be dropped for a negative impact pressure
_BEYOND = 2.0  # times the plausible range: a single value outside it is a glitch
_LONGEST_STEP = 10.0  # s, median time between rows: 0.1 Hz is ten times slower than the slowest receiver
_SHORTEST_STEP = 1.0 / 5000.0  # s: no air data are recorded faster
_LONGEST_GAP = 86400.0  # s, between two rows of one log: the blocks of a log are counted by the second


def check_time(draft: Draft) -> None:
    """Drop a few rows with a repeated time stamp. Raise BadInputError for many, and for time that runs back."""
    if len(draft.rows) < 2:
        raise BadInputError(f"the log holds {len(draft.rows)} rows; at least 2 are needed")
    column, time = draft.columns["time"], draft.channels["time"]
    step = np.diff(time, prepend=-np.inf)
    if np.any(step < 0.0):
        i = int(np.argmax(step < 0.0))
        raise BadInputError(
            f"column {column!r}, row {draft.rows[i]}: time runs back from {time[i - 1]:g} to {time[i]:g} s; "
            "time must increase: sort the rows, or cut the log where its clock was set"
        )
    repeated = step == 0.0
    if repeated.mean() > _FEW:
        raise BadInputError(
            f"column {column!r}: {int(repeated.sum())} of {len(time)} time stamps repeat the one before "
            f"({draft.named(repeated)}); time must increase: write it with more digits"
        )
    if repeated.any():
        draft.warnings.append(
            f"column {column!r}: time stamps repeat ({draft.named(repeated)}): those rows are dropped"
        )
        draft.keep(~repeated)


def check_clock(draft: Draft) -> None:
    """Raise BadInputError for rows much too far apart or too close, and for a jump of more than a day.

    The first means a clock in another unit, the second a clock that was set during the log.
    """
    column, time = draft.columns["time"], draft.channels["time"]
    steps = np.diff(time)
    usual, longest = float(np.median(steps)), int(np.argmax(steps))
    if not _SHORTEST_STEP <= usual <= _LONGEST_STEP:
        raise BadInputError(
            f"column {column!r}: the rows are {usual:.3g} s apart, where {_SHORTEST_STEP:g} to {_LONGEST_STEP:g} s "
            f"are usual{_better_clock(draft, usual)}"
        )
    if steps[longest] > _LONGEST_GAP:
        raise BadInputError(
            f"column {column!r}, row {draft.rows[longest + 1]}: time jumps from {time[longest]:g} to "
            f"{time[longest + 1]:g} s; cut the log there"
        )


def _better_clock(draft: Draft, usual: float) -> str:
    """Return as a hint the unit of time in which the rows would come at the rate of a flight log."""
    written = float(from_si(usual, draft.suffixes["time"]))
    for suffix in QUANTITIES["time"].suffixes:
        if _SHORTEST_STEP <= float(to_si(written, suffix)) <= 1.0:
            return f": {written:.3g} between rows would fit a column named time_{suffix}"
    return ": check the unit of the clock"


def check_units(draft: Draft) -> None:
    """Find channels outside their plausible range: in another unit than the column says, or from a dead sensor.

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
        s for s in quantity.suffixes if quantity.low <= float(to_si(written, s)) <= quantity.high and s != suffix
    ]
    named = [f"{quantity.name}_{s}" for s in fits]
    if quantity.name in TEMPERATURES and "static_pressure" in draft.channels:
        named = likely_temperatures(draft, quantity.name) or named
    columns = " or ".join(named)
    way_out = f"; they would fit {columns}: correct the unit" if fits else ""
    if not quantity.unit:
        way_out = "; write it as a number from 0 to 1"
    return f"typical values of {written:.4g} {suffix} are not those of an airplane{way_out}"


def check_spikes(draft: Draft) -> None:
    """Drop rows in which an essential channel has an impossible value: a glitch of the recorder."""
    for quantity in draft.numeric():
        if not quantity.essential or quantity.name == "time":
            continue
        values = draft.channels[quantity.name]
        bad = np.abs(values) > _BEYOND * quantity.high
        if quantity.low > 0.0:
            bad |= values < quantity.low / _BEYOND
        if bad.any():
            draft.warnings.append(
                f"column {draft.columns[quantity.name]!r}: impossible values in {int(bad.sum())} rows "
                f"({draft.named(bad)}): they are dropped"
            )
            draft.keep(~bad)


def form_impact_pressure(draft: Draft) -> None:
    """Compute the impact pressure from total and static pressure where the log does not hold it."""
    total = draft.channels.pop("total_pressure", None)
    if total is None:
        return
    if "impact_pressure" in draft.channels:
        draft.warnings.append("both impact and total pressure are given: the impact pressure is used")
        return
    draft.channels["impact_pressure"] = total - draft.channels["static_pressure"]
    draft.columns["impact_pressure"] = draft.columns["total_pressure"]
    draft.suffixes["impact_pressure"] = draft.suffixes["total_pressure"]


def check_impact_pressure(draft: Draft) -> None:
    """Drop rows of negative impact pressure. Raise BadInputError for a stuck sensor, and where most are negative.

    Mostly negative values mean that total and static are exchanged, or that the sign is.
    """
    impact, column = draft.channels["impact_pressure"], draft.columns["impact_pressure"]
    if np.ptp(impact) == 0.0:
        or_range = ", or its range ends there: use a sensor with more range" if impact[0] > 0.0 else ""
        raise BadInputError(f"column {column!r}: the sensor is stuck at {impact[0]:g} Pa in every row{or_range}")
    negative = impact < 0.0
    if negative.mean() > _MOST:
        raise BadInputError(
            f"column {column!r}: the impact pressure is negative in {int(negative.sum())} of {len(impact)} rows; "
            "total and static are exchanged, or the sign is: swap them"
        )
    if negative.any():
        draft.warnings.append(
            f"column {column!r}: the impact pressure is negative in {int(negative.sum())} rows "
            f"({draft.named(negative)}): they are dropped"
        )
        draft.keep(~negative)


# The order matters: fixes are held before blanks count as missing numbers, the clock is right before units are
# judged, and the impact pressure exists before it is checked.
CHECKS = (
    hold_fixes,
    check_numbers,
    check_time,
    check_clock,
    check_pauses,
    check_units,
    check_spikes,
    form_impact_pressure,
    check_impact_pressure,
    check_stuck,
    check_plausibility,
)
