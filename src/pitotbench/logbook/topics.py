"""Logs that hold topics, each with a clock of its own, by file suffix. A new one is one file and one line here."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from pitotbench.logbook.dataflash_format import read_messages
from pitotbench.logbook.mapping import MappedFile
from pitotbench.logbook.table import Table
from pitotbench.logbook.ulog_format import read_topics
from pitotbench.records.errors import BadInputError

ReadTopics = Callable[[Path, Sequence[str]], dict[str, Table]]


@dataclass(frozen=True, slots=True)
class TopicReader:
    """How the files of one suffix are read, and the shipped mapping that suits them.

    `read_named` returns those of the wanted topics that are there; with no names, all that are there.
    """

    kind: str
    mapping: str
    read_named: ReadTopics

    def read(self, path: Path, files: Sequence[MappedFile]) -> list[Table | None]:
        """Return the table of each file of a mapping; None for an optional one that is absent.

        Raises BadInputError for a missing topic, with those that are there.
        """
        wanted = [[_topic(pattern) for pattern in entry.patterns] for entry in files]
        found = self.read_named(path, [name for names in wanted for name in names])
        missing = [
            " or ".join(names)
            for names, entry in zip(wanted, files, strict=True)
            if not entry.optional and not found.keys() & set(names)
        ]
        if missing:
            known = ", ".join(sorted(found)) or "none of those wanted"
            raise BadInputError(f"the {self.kind} holds no topic {', '.join(missing)}; it holds {known}")
        return [next((found[name] for name in names if name in found), None) for names in wanted]


def _topic(pattern: str) -> str:
    """Return the topic of a file of the same log written as CSV."""
    return pattern.removeprefix("*").removesuffix(".csv")


TOPIC_READERS = {
    ".ulg": TopicReader("ULog", "px4", read_topics),
    ".bin": TopicReader("DataFlash log", "ardupilot", read_messages),
}
