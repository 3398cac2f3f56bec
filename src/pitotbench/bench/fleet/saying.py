"""Say a line to the user while a command works."""

import sys


def say(text: str) -> None:
    """Write a line to standard error."""
    from pitotbench.show.terminal import printable

    sys.stderr.write(f"pitotbench: {printable(text)}\n")
    sys.stderr.flush()
