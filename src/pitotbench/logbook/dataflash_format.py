"""Read the messages of an ArduPilot DataFlash log as tables. Needs pymavlink, of the extra pitotbench[logs]."""

from collections.abc import Sequence
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

from pitotbench.logbook.table import Table
from pitotbench.records.errors import BadInputError

_INSTANCE = "I"  # the field that numbers sensors of one kind
_MAGIC = b"\xa3\x95"  # begins every message


def read_messages(path: Path, topics: Sequence[str]) -> dict[str, Table]:
    """Return the tables of some kinds of message, or of all for none; those that the log lacks are left out.

    Of a message that several sensors send, only the first sensor's are kept. Values are in the units that the log
    states for its fields (a latitude in degrees, not in 1e-7 of them).
    Raises BadInputError where pymavlink is not installed or the file is not a DataFlash log.
    """
    try:
        from pymavlink.DFReader import DFReader_binary  # an extra: most users never read a DataFlash log
    except ImportError as error:
        raise BadInputError(
            "reading an ArduPilot DataFlash log needs pymavlink: pip install 'pitotbench[logs]'"
        ) from error
    with path.open("rb") as file:
        if file.read(2) != _MAGIC:
            raise BadInputError("not an ArduPilot DataFlash log: it does not begin with a message")
    rows: dict[str, list[Any]] = {}
    try:
        with redirect_stdout(StringIO()):  # it prints what it skips
            log = DFReader_binary(str(path), zero_time_base=True)
            while (message := log.recv_match(type=list(topics) or None)) is not None:
                if getattr(message, _INSTANCE, 0) == 0:
                    rows.setdefault(message.get_type(), []).append(message)
    except Exception as error:  # pymavlink lets struct, index and key errors out of a broken file
        raise BadInputError(f"not a complete DataFlash log: {error or type(error).__name__}") from error
    return {kind: _table(messages) for kind, messages in rows.items()}


def _table(messages: list[Any]) -> Table:
    names = tuple(messages[0].get_fieldnames())
    return Table(names, tuple(np.array([getattr(message, name) for message in messages]) for name in names))
