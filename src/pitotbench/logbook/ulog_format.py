"""Read the topics of a PX4 ULog as tables. Needs pyulog, which the extra pitotbench[logs] installs."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from pitotbench.logbook.table import Table
from pitotbench.records.errors import BadInputError


def read_topics(path: Path, topics: Sequence[str]) -> dict[str, Table]:
    """Return the tables of some topics, or of all for none; those that the log lacks are left out.

    Names are those of `ulog2csv`: `sensor_gps_0` is the first `sensor_gps`.
    Raises BadInputError where pyulog is not installed or the file is not a ULog.
    """
    try:
        from pyulog import ULog  # an extra: most users never read a ULog
    except ImportError as error:
        raise BadInputError("reading a ULog needs pyulog: pip install 'pitotbench[logs]'") from error
    wanted = [_without_number(topic) for topic in topics] or None
    try:
        log = ULog(str(path), message_name_filter_list=wanted)
    except Exception as error:  # pyulog lets struct, index and key errors out of a broken file
        raise BadInputError(f"not a complete ULog: {error or type(error).__name__}") from error
    return {f"{data.name}_{data.multi_id}": _table(data.data) for data in log.data_list}


def _without_number(topic: str) -> str:
    name, _, number = topic.rpartition("_")
    return name if number.isdigit() else topic


def _table(fields: dict[str, np.ndarray]) -> Table:
    return Table(tuple(fields), tuple(np.asarray(values) for values in fields.values()))
