"""The whole workflow: reconcile a log, judge it again with the named effects, fly its card again, write it down."""

from collections.abc import Callable

Progress = Callable[[str], None]  # takes a line about the step that begins
