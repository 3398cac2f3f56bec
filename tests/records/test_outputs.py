"""A file is written whole or not at all; what is no file is written into, and stays."""

import os
import stat
from threading import Thread

import pytest

from pitotbench.records.outputs import write_text


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
def test_a_pipe_is_written_into_and_stays_a_pipe(tmp_path):
    """An administrator who wrote to /dev/null had a file in its place."""
    pipe, read = tmp_path / "pipe", list[str]()
    os.mkfifo(pipe)
    reader = Thread(target=lambda: read.append(pipe.read_text("utf-8")), daemon=True)
    reader.start()
    write_text(pipe, "a line\n")
    assert stat.S_ISFIFO(pipe.stat().st_mode)
    reader.join(10.0)
    assert read == ["a line\n"]
    assert list(tmp_path.iterdir()) == [pipe]


def test_a_file_is_replaced_whole(tmp_path):
    target = tmp_path / "a.txt"
    target.write_text("before", "utf-8")
    write_text(target, "after")
    assert target.read_text("utf-8") == "after"
    assert list(tmp_path.iterdir()) == [target]
