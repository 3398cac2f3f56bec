"""Questions to the children of the page: slow, large, and quick ones."""

from pitotbench.browser.work import Tell


def spin(_tell: Tell) -> None:
    """Compute for ever."""
    while True:
        pass


def grow(_tell: Tell) -> None:
    """Take all memory."""
    held = []
    while True:
        held.append(bytes(1 << 26))


def echo(tell: Tell, text: str) -> None:
    """Say what was said."""
    tell("text", text)
