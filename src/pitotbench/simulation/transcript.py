"""Collect JSBSim's messages, so that an error of the bench can quote them."""

from typing import Any

import jsbsim


class Transcript(jsbsim.FGLogger):
    """Collect JSBSim's messages, which otherwise go to the console and not to the caller.

    JSBSim has one logger a thread. With several plants in a thread, the one loaded last gets the messages of all.
    """

    def __init__(self) -> None:
        super().__init__()
        self.lines: list[str] = []
        self._parts: list[str] = []
        self._level = 0

    # JSBSim calls the next five methods for each message: level, place, parts, colors, and the end.
    def set_level(self, level: Any) -> None:
        """Note the level of the message that begins."""
        self._level = int(level)

    def file_location(self, filename: str, line: int) -> None:
        """Add the file and the line of which the message speaks."""
        self._parts.append(f"{filename}:{line}: ")

    def message(self, message: str) -> None:
        """Add a part of the message."""
        self._parts.append(message)

    def format(self, format: Any) -> None:
        """Ignore colors, which mean nothing in an error message."""

    def flush(self) -> None:
        """End the message and keep it if it is a warning or an error."""
        text = " ".join("".join(self._parts).split())
        if text and int(jsbsim.LogLevel.WARN) <= self._level <= int(jsbsim.LogLevel.FATAL):
            self.lines.append(text)
        self._parts.clear()

    def said(self) -> str:
        """Return the last three messages as the end of an error message."""
        return f" JSBSim says: {' | '.join(self.lines[-3:])}" if self.lines else ""
