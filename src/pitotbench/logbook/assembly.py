"""Make a checked log of a table under our column names."""

from collections.abc import Callable, Sequence

from pitotbench.logbook.checks import CHECKS, CLOCK_CHECKS
from pitotbench.logbook.columns import WARNINGS, Table, earlier_warnings
from pitotbench.logbook.derived import derive
from pitotbench.logbook.draft import Draft, draft_of, require
from pitotbench.records.log import START as FIRST_ROW
from pitotbench.records.log import FlightLog

Part = tuple[float | None, float | None]  # s after the first row, from and to
WHOLE: Part = (None, None)


def log_of(
    table: Table, part: Part = WHOLE, unasked: Sequence[Callable[[Draft], None]] = ()
) -> FlightLog:
    """Return the checked log of a table, or of its `part`, as in `reading.read_log`, without the
    checks that are not asked. Raises BadInputError where it cannot be used.
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
    warnings = [*earlier_warnings(header), *draft.warnings]
    header.pop(WARNINGS, None)
    if warnings:
        # Each once: a log written and read again repeats them. The last of equal texts has the
        # finding beside it.
        header[WARNINGS] = list({text: text for text in warnings}.values())
    return FlightLog(**draft.channels, header=header)
