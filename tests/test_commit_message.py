"""The hook on a commit's message, as git runs it."""

import subprocess
import sys
from pathlib import Path

import pytest

HOOK = Path(__file__).parents[1] / ".githooks" / "commit-msg"


@pytest.mark.skipif(sys.platform == "win32", reason="git runs the hook in its own shell there")
@pytest.mark.parametrize(
    ("message", "refused"),
    [
        ("x" * 72 + "\n\nThe why.\n", ""),
        ("°" * 72 + "\n", ""),
        ("x\n# a comment of git\n", ""),
        ("x" * 73 + "\n", "73 characters, 72 at most"),
        ("Subject\nbody at once\n", "leave the second line"),
    ],
)
def test_a_subject_has_72_characters_at_most_and_stands_alone(tmp_path, message, refused):
    file = tmp_path / "message"
    file.write_text(message, encoding="utf-8")
    done = subprocess.run(
        ["sh", HOOK, file], capture_output=True, text=True, env={"LC_ALL": "C.UTF-8"}
    )
    assert refused in done.stderr
    assert (done.returncode != 0) == bool(refused)
