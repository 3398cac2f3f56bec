"""Read the messages of an ArduPilot DataFlash log, binary or as text.

Needs pymavlink, of the extra pitotbench[logs].
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pitotbench.logbook.columns import Table
from pitotbench.logbook.damage import complete, damage, heard
from pitotbench.records import BadInputError

_MAGIC, _TEXT = b"\xa3\x95", b"FMT,"  # begins every message, and a log of messages as text


def is_dataflash(path: Path) -> bool:
    """Return whether a file begins as a DataFlash log does."""
    begin = _begin(path)
    return begin.startswith(_MAGIC) or begin == _TEXT


def _begin(path: Path) -> bytes:
    with path.open("rb") as file:
        return file.read(len(_TEXT))


def read_messages(path: Path, topics: Sequence[str]) -> tuple[dict[str, Table], dict[str, Any]]:
    """Return the tables of some kinds of message and the log's parameters.

    Kinds that the log lacks are left out. Values are in the units that the log states for its
    fields (a latitude in degrees, not in 1e-7 of them). Raises BadInputError where pymavlink is not
    installed or the file is not a DataFlash log.
    """
    try:
        # an extra: most users never read a DataFlash log
        from pymavlink.DFReader import DFReader_binary, DFReader_text
    except ImportError as error:
        raise BadInputError(
            "reading an ArduPilot DataFlash log needs pymavlink: pip install 'pitotbench[logs]'"
        ) from error
    if not is_dataflash(path):
        raise BadInputError(
            "not an ArduPilot DataFlash log: it does not begin with a message; copy it again, or "
            "export the log of another recorder as a table (CSV)"
        )
    rows: dict[str, list[Any]] = {}
    parameters: dict[str, Any] = {}
    said: list[str] = []
    # pymavlink lets struct, index and key errors out of a broken file.
    with complete("DataFlash log: a message does not fit its format", Exception):
        with heard(said):
            log = (DFReader_text if _begin(path) == _TEXT else DFReader_binary)(
                str(path), zero_time_base=True
            )
            while (message := log.recv_match(type=[*topics, "PARM"])) is not None:
                if message.get_type() == "PARM":
                    parameters[message.Name] = message.Value
                else:
                    rows.setdefault(message.get_type(), []).append(message)
        ends = [
            log.offsets[kind][-1] + form.len
            for kind, form in log.formats.items()
            if hasattr(log, "data_len") and log.offsets[kind]
        ]
        columns = {
            kind: {
                name: np.array([getattr(message, name) for message in messages])
                for name in messages[0].get_fieldnames()
            }
            for kind, messages in rows.items()
        }
    warnings = damage("pymavlink", said, max(ends, default=0) > log.data_len)
    tables = {
        kind: Table(tuple(found), tuple(found.values()), warnings=warnings)
        for kind, found in columns.items()
    }
    return tables, parameters
