"""Write a FlightLog to a file."""

from pathlib import Path

from pitotbench.logbook.formats import format_of
from pitotbench.logbook.quantities import QUANTITIES
from pitotbench.logbook.table import atomic
from pitotbench.records.errors import BadInputError
from pitotbench.records.log import FlightLog


def write_log(log: FlightLog, path: Path | str) -> Path:
    """Write a log with canonical columns, in the format of the path's suffix, and return the path.

    An error leaves no incomplete file. Raises BadInputError for an unknown suffix or an unwritable place.
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
