"""Reading a table of columns as a log."""

from collections.abc import Callable
from pathlib import Path

import pytest
from numpy.typing import NDArray
from tests.logbook import sample_log as sample

from pitotbench import FlightLog, read_log


@pytest.fixture
def read(tmp_path: Path) -> Callable[..., FlightLog]:
    """Writes columns, by default those of the sample log, as CSV below some lines, and reads the
    file.
    """

    def written(table: dict[str, NDArray] | None = None, above: str = "") -> FlightLog:
        return read_log(
            sample.write(tmp_path / "log.csv", sample.columns() if table is None else table, above)
        )

    return written
