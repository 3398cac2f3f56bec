"""Reconcile a log: name the missing effects, judge the log again with them, fly its card again, and report."""

from collections.abc import Callable

Progress = Callable[[str], None]  # is called with a line about the step that begins
