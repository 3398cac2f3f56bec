"""Read the topics of a PX4 ULog. Needs pyulog, of the extra pitotbench[logs]."""

import re
from collections.abc import Sequence
from io import BufferedReader, FileIO
from pathlib import Path
from typing import Any

import numpy as np

from pitotbench.logbook.columns import Table
from pitotbench.logbook.damage import complete, damage, heard
from pitotbench.records import BadInputError


def read_topics(path: Path, topics: Sequence[str]) -> tuple[dict[str, Table], dict[str, Any]]:
    """Return the tables of some topics and the log's parameters; topics that the log lacks are left
    out.

    Names are those of `ulog2csv`: `sensor_gps_0` is the first `sensor_gps`.
    Raises BadInputError where pyulog is not installed or the file is not a ULog.
    """
    try:
        from pyulog import ULog  # an extra: most users never read a ULog
    except ImportError as error:
        raise BadInputError(
            "reading a ULog needs pyulog: pip install 'pitotbench[logs]'"
        ) from error
    wanted = [re.sub(r"_\d+$", "", topic) for topic in topics]
    said: list[str] = []
    # pyulog lets struct, index and key errors out of a broken file.
    with complete("ULog", Exception), _Watched(FileIO(path)) as file, heard(said):
        log = ULog(file, message_name_filter_list=wanted)
    if log.file_corruption and not said:
        said.append("a message of the wrong length")
    warnings = damage("pyulog", said, file.broken)
    tables = {
        f"{each.name}_{each.multi_id}": Table(
            tuple(each.data), tuple(map(np.asarray, each.data.values())), {}, warnings
        )
        for each in log.data_list
    }
    changed = {name: value for _, name, value in log.changed_parameters}
    return tables, {**log.initial_parameters, **changed}


class _Watched(BufferedReader):
    """A file that knows whether the last reading met its end inside a message: the head of one is
    three bytes.
    """

    broken = False

    def read(self, size: int | None = -1, /) -> bytes:
        """Read as any file does."""
        data = super().read(size)
        self.broken = size is not None and len(data) < size and (len(data) > 0 or size != 3)
        return data
