"""Read the topics of a PX4 ULog as tables. Needs pyulog, which the extra pitotbench[logs] installs."""

from pathlib import Path

import numpy as np

from pitotbench.logbook.table import Table
from pitotbench.records.errors import BadInputError


def read_topics(path: Path, topics: list[str]) -> list[Table]:
    """Return the tables of some topics. Names are those of `ulog2csv`: `sensor_gps_0` is the first `sensor_gps`.

    Raises BadInputError where pyulog is not installed, the file is not a ULog, or it lacks a topic.
    """
    try:
        from pyulog import ULog  # an extra: most users never read a ULog
    except ImportError as error:
        raise BadInputError("reading a ULog needs pyulog: pip install 'pitotbench[logs]'") from error
    wanted = [_split(topic) for topic in topics]
    try:
        log = ULog(str(path), message_name_filter_list=[name for name, _ in wanted])
    except Exception as error:  # pyulog lets struct, index and key errors out of a broken file
        raise BadInputError(f"not a complete ULog: {error or type(error).__name__}") from error
    found = {(data.name, data.multi_id): data.data for data in log.data_list}
    missing = [topic for topic, key in zip(topics, wanted, strict=True) if key not in found]
    if missing:
        known = ", ".join(f"{name}_{number}" for name, number in sorted(found)) or "none of those wanted"
        raise BadInputError(f"the ULog holds no topic {', '.join(missing)}; it holds {known}")
    return [_table(found[key]) for key in wanted]


def _split(topic: str) -> tuple[str, int]:
    name, _, number = topic.rpartition("_")
    return (name, int(number)) if number.isdigit() else (topic, 0)


def _table(fields: dict[str, np.ndarray]) -> Table:
    return Table(tuple(fields), tuple(np.asarray(values) for values in fields.values()))
