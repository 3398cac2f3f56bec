"""Write the truth of a flight to a file next to its log, and read it. Only on request: a log holds no truth."""

from pathlib import Path

import numpy as np

from pitotbench.logbook import QUANTITIES, atomic
from pitotbench.records.case_file import read_case, write_case
from pitotbench.records.errors import BadInputError
from pitotbench.records.flight import Flight

_CASE = b"pitotbench case"
_TRUE = "true_"  # prefix of all columns, so that no reader takes a truth file for a log


def truth_path(log_path: Path | str) -> Path:
    """Return the path of the truth of a log: `<name>.truth.parquet` in the same folder."""
    path = Path(log_path)
    return path.with_name(f"{path.stem}.truth.parquet")


def write_truth(flight: Flight, log_path: Path | str) -> Path:
    """Write all channels [SI], labels and the whole case of a flight next to its log, and return the path.

    Columns have the prefix `true_` and, where a log has the quantity, the suffix of its unit. An error leaves no
    incomplete file.
    """
    import pyarrow as pa
    from pyarrow import parquet

    columns = {_column(name): values for name, values in flight.channels.items()}
    table = pa.table({**columns, "segment": flight.segment, "on_condition": flight.on_condition})
    target = truth_path(log_path)
    with atomic(target) as temporary:
        metadata = {_CASE: write_case(flight.case).encode()}
        parquet.write_table(table.replace_schema_metadata(metadata), temporary, compression="zstd")
    return target


def read_truth(path: Path | str) -> Flight:
    """Read the flight of a truth file. Raises BadInputError for any other file."""
    import pyarrow as pa
    from pyarrow import parquet

    try:
        table = parquet.ParquetFile(Path(path)).read()
    except (pa.ArrowInvalid, OSError) as error:
        raise BadInputError(f"{path}: not a truth file: {error}") from error
    text = (table.schema.metadata or {}).get(_CASE)
    if text is None:
        raise BadInputError(f"{path}: not a truth file; expected the file that was written next to a log")
    units = {_column(name): name for name in QUANTITIES}
    found = {name: table[name].to_numpy() for name in table.column_names if name.startswith(_TRUE)}
    return Flight(
        case=read_case(text.decode()),
        channels={units.get(name, name.removeprefix(_TRUE)): values for name, values in found.items()},
        segment=np.asarray(table["segment"].to_numpy(), dtype=np.str_),
        on_condition=table["on_condition"].to_numpy(),
    )


def _column(name: str) -> str:
    return _TRUE + (QUANTITIES[name].column if name in QUANTITIES else name)
