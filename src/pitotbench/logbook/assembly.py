"""Make a checked log of a table under our column names."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, fields

import numpy as np

from pitotbench.airdata import Rest
from pitotbench.logbook.checks import CHECKS, CLOCK_CHECKS
from pitotbench.logbook.columns import MAPPING, WARNINGS, Table, earlier_warnings
from pitotbench.logbook.derived import derive
from pitotbench.logbook.draft import Draft, draft_of, require
from pitotbench.logbook.stuck_sensors import keep_new_airspeeds
from pitotbench.records import BadInputError
from pitotbench.records.log import AT_REST, FlightLog
from pitotbench.records.log import START as FIRST_ROW

Span = tuple[float, float]  # s after the first row
# From and to, None for an end of the log, and the spans between them that are left out.
Part = tuple[float | None, float | None, *tuple[Span, ...]]
WHOLE: Part = (None, None)


def part_of(
    begin: str | None,
    end: str | None,
    without: Iterable[str] = (),
    names: tuple[str, str] = ("--from", "--to"),
) -> Part:
    """Return the part of a log that texts state: two moments, and spans to leave out.

    A moment is as `12:30`, a span as `14:00-15:30`. Raises BadInputError, with the name of the
    moment, for what is none.
    """
    first, last = (
        None if text in (None, "") else _moment(name, text)
        for name, text in zip(names, (begin, end), strict=True)
    )
    spans = []
    for text in without:
        low, dash, high = text.partition("-")
        if not dash:
            raise BadInputError(f"--without {text!r}: give two moments, such as 14:00-15:30")
        spans.append((_moment("--without", low), _moment("--without", high)))
    return first, last, *spans


def _moment(flag: str, text: str) -> float:
    """Return the seconds of a moment such as 12:30, 1:02:03 or 750 (seconds)."""
    try:
        parts = [float(part) for part in text.split(":")]
    except (ValueError, AttributeError):  # a number: nothing says whether it counts minutes
        parts = []
    if not 1 <= len(parts) <= 3 or any(not 0.0 <= part < 1e6 for part in parts):
        raise BadInputError(
            f"{flag} {text!r}: give minutes and seconds of the log as text, such as 12:30"
        )
    return sum(part * 60.0**power for power, part in enumerate(reversed(parts)))


_HOLDS = "mode_s"  # the mapping of tables that repeat each value until the next answer


def log_of(
    table: Table, part: Part = WHOLE, unasked: Sequence[Callable[[Draft], None]] = ()
) -> FlightLog:
    """Return the checked log of a table or of its `part`, without the checks that are not asked.

    `part` is as in `reading.read_log`. Raises BadInputError where the log cannot be used.
    """
    draft, header = draft_of(table), dict(table.header)
    derive(draft, header)
    require(draft)
    del table  # or its columns would stay in memory beside those of which a check drops rows
    for check in CLOCK_CHECKS:
        check(draft)
    if part != WHOLE:
        draft.keep_part(*part)
        header[FIRST_ROW] = draft.start
    for check in (each for each in CHECKS if each not in unasked):
        check(draft)
    if header.get(MAPPING) == _HOLDS:
        keep_new_airspeeds(draft)
    if rests := _rests(header.pop(AT_REST, None), draft):
        header[AT_REST] = rests
    warnings = [*earlier_warnings(header), *draft.warnings]
    if warnings:
        # Each once: a log written and read again repeats them. The last of equal texts has the
        # finding beside it.
        header[WARNINGS] = list({text: text for text in warnings}.values())
    return FlightLog(**draft.channels, header=header)


_OF_REST = {each.name for each in fields(Rest)}


def _rests(written: object, draft: Draft) -> list[dict[str, float]]:
    """Return what the gauge reads at rest: as a log of ours was written with it, else as shown.

    The rows that were read when it was written may have been negative, and are then dropped.
    """
    most = float(np.max(draft.channels["impact_pressure"]))
    stated = [
        each
        for each in (written if isinstance(written, list) else [])
        if isinstance(each, dict)
        and each.keys() == _OF_REST
        and all(isinstance(value, float) and abs(value) < most for value in each.values())
    ]
    return stated or [asdict(each) for each in draft.rests]
