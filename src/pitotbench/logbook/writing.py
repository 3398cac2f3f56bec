"""FlightLog to a file."""

from pathlib import Path

from pitotbench.logbook.formats import format_of
from pitotbench.logbook.quantities import QUANTITIES
from pitotbench.logbook.table import atomic
from pitotbench.records.errors import BadInputError
from pitotbench.records.log import FlightLog


def write_log(log: FlightLog, path: Path | str) -> Path:
    """Write a log with canonical columns, in the format of the path's suffix; whole or not at all.

    Raises BadInputError for a suffix that is none of ours or a place that cannot be written.
    """
    target = Path(path)
    try:
        kind = format_of(target)
    except BadInputError as error:
        raise BadInputError(f"{target}: {error}") from error
    columns = {QUANTITIES[name].column: values for name, values in log.channels().items()}
    with atomic(target) as temporary:
        kind.write(temporary, columns, log.header)
    return target
