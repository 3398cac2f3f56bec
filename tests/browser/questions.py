"""Questions to the children of the page: slow, large, and quick ones."""

from collections.abc import Iterator


def spin() -> Iterator[str]:
    """Compute for ever."""
    while True:
        pass


def grow() -> Iterator[str]:
    """Take all memory."""
    held = []
    while True:
        held.append(bytes(1 << 26))


def echo(text: str) -> Iterator[str]:
    """Say what was said."""
    yield text
