"""Read the topics of a PX4 ULog. Needs pyulog, of the extra pitotbench[logs]."""

import re
from collections.abc import Mapping, Sequence
from io import BufferedReader, FileIO
from pathlib import Path
from typing import Any

import numpy as np

from pitotbench.logbook.columns import Table
from pitotbench.logbook.damage import complete, damage, heard
from pitotbench.records import BadInputError

_MOST_STEPS = 1_000_000  # bytes that are searched for the next message: some seconds
_MOST_FIELDS = 1_000_000  # of all instances of a topic; one of PX4 has some hundred


def read_topics(path: Path, topics: Sequence[str]) -> tuple[dict[str, Table], dict[str, Any]]:
    """Return the tables of those topics that the log has, and its parameters.

    Names are those of `ulog2csv`: `sensor_gps_0` is the first `sensor_gps`. Raises BadInputError
    where pyulog is not installed, the file is not a ULog, or its topics have more fields than the
    memory holds.
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
        with heard([]), _Watched(FileIO(path)) as head:
            _require_few_fields(ULog(head, parse_header_only=True).message_formats, path, wanted)
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


def _require_few_fields(formats: Mapping[str, Any], path: Path, topics: Sequence[str]) -> None:
    """Raise BadInputError for a file that announces topics of very many fields.

    With formats within one another 200 bytes state billions, and pyulog keeps a record of each.
    """
    counts: dict[str, int] = {}

    def count(kind: str) -> int:
        if kind not in counts:
            fields = formats[kind].fields if kind in formats else ()
            counts[kind] = max(1, sum(max(1, length) * count(inner) for inner, length, _ in fields))
        return counts[kind]

    data = path.read_bytes()
    for name in formats:
        instances = data.count(name.encode()) if name in topics else 1  # or more: also in a text
        if count(name) * instances > _MOST_FIELDS:
            raise BadInputError(
                f"the ULog states more than {_MOST_FIELDS:,} fields of its topic {name[:60]!r}: no "
                "autopilot writes such a log; export the topics as tables (CSV)"
            )


class _Watched(BufferedReader):
    """A file that knows whether the last reading met its end inside a message.

    The head of a message is three bytes. pyulog goes on behind the first byte of a message that it
    does not know, and takes the stated size for what was read: at the end of the file it would read
    the same bytes without end.
    """

    broken = False
    _lacking = 0  # bytes, of the last reading
    _steps = 0  # back, in a search for the next message

    def read(self, size: int | None = -1, /) -> bytes:
        """Read as any file does."""
        data = super().read(size)
        self._lacking = max(0, (size or 0) - len(data))
        self.broken = self._lacking > 0 and (len(data) > 0 or size != 3)
        return data

    def seek(self, target: int, whence: int = 0, /) -> int:
        """Seek as any file does, back no further than was read.

        Raises EOFError for a file of which so much is damaged that the search takes minutes.
        """
        if whence == 1:
            self._steps += 1
            target, self._lacking = target + self._lacking, 0
        if self._steps > _MOST_STEPS:
            raise EOFError
        return super().seek(target, whence)
