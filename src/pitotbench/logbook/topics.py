"""Logs that hold topics, each with a clock of its own, by file suffix. A new one is one file and
one line here.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pitotbench.logbook.columns import Table, require_regular
from pitotbench.logbook.dataflash import is_dataflash, read_messages
from pitotbench.logbook.mapping import MappedFile
from pitotbench.logbook.ulog import read_topics
from pitotbench.records import BadInputError

# The tables of the wanted topics by name, and the parameters of the autopilot by name.
Topics = tuple[dict[str, Table], dict[str, Any]]
ReadTopics = Callable[[Path, Sequence[str]], Topics]


@dataclass(frozen=True, slots=True)
class TopicReader:
    """How the files of one suffix are read, and the shipped mapping that suits them.

    `read_named` returns those of the wanted topics that are there.
    """

    kind: str
    mapping: str
    read_named: ReadTopics

    def read(
        self, path: Path, files: Sequence[MappedFile]
    ) -> tuple[list[Table | None], dict[str, Any]]:
        """Return the table of each file of a mapping, None for an optional one that is absent, and
        the parameters of the log.

        Raises BadInputError for a missing topic, with those that are there.
        """
        wanted = [
            [pattern.removeprefix("*").removesuffix(".csv") for pattern in entry.patterns]
            for entry in files
        ]
        require_regular(path)
        found, held = self.read_named(path, [name for names in wanted for name in names])
        missing = [
            " or ".join(names)
            for names, entry in zip(wanted, files, strict=True)
            if not entry.optional and not found.keys() & set(names)
        ]
        if missing:
            known = ", ".join(sorted(found)) or "none of those wanted"
            raise BadInputError(
                f"the {self.kind} holds no topic {', '.join(missing)}; it holds {known}: set the "
                "autopilot to log the airspeed sensor, the barometer and the GPS, and fly again"
            )
        tables = [next((found[name] for name in names if name in found), None) for names in wanted]
        return tables, held


TOPIC_READERS = {
    ".ulg": TopicReader("ULog", "px4", read_topics),
    ".bin": TopicReader("DataFlash log", "ardupilot", read_messages),
    ".log": TopicReader("DataFlash log", "ardupilot", read_messages),
}


def topics_of(path: Path) -> TopicReader | None:
    """Return the reader of a log that holds topics; None for another, as a .log that is a table."""
    suffix = path.suffix.lower()
    if suffix == ".log" and path.is_file() and not is_dataflash(path):
        return None
    return TOPIC_READERS.get(suffix)
