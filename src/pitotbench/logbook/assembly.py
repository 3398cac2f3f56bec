"""Make a checked log of a table under our column names."""

from pitotbench.logbook.checks import CHECKS
from pitotbench.logbook.columns import WARNINGS, Table, earlier_warnings
from pitotbench.logbook.derived import derive
from pitotbench.logbook.draft import draft_of, require
from pitotbench.records.log import FlightLog


def log_of(table: Table) -> FlightLog:
    """Return the checked log of a table. Raises BadInputError where it cannot be used."""
    draft, header = draft_of(table), dict(table.header)
    derive(draft, header)
    require(draft)
    del table  # or its columns would stay in memory beside those of which a check drops rows
    for check in CHECKS:
        check(draft)
    warnings = [*earlier_warnings(header), *draft.warnings]
    header.pop(WARNINGS, None)
    if warnings:
        # Each once: a log written and read again repeats them. The last of equal texts has the
        # finding beside it.
        header[WARNINGS] = list({text: text for text in warnings}.values())
    return FlightLog(**draft.channels, header=header)
