"""Say how a campaign goes on: a bar on a terminal, else a line a minute, in words or as JSON."""

import json
import sys
import time
from collections import Counter, deque
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field
from typing import Any

from pitotbench.bench.fleet import say

STYLES = ("auto", "bar", "lines", "json", "none")
_EVERY = 60.0  # s between two lines
_RECENT = 600.0  # s over which the rate is measured


@dataclass(slots=True)
class Watch:
    """Counts the flights of a campaign and reports them. `total` is the number of flights planned."""

    total: int
    style: str = "auto"
    clock: Callable[[], float] = time.monotonic
    found: int = 0
    flown: int = 0
    reasons: Counter[str] = field(default_factory=Counter)
    _begun: float = 0.0
    _said: float = 0.0
    _times: deque[tuple[float, int]] = field(default_factory=deque)
    _advance: Callable[[int], object] = lambda done: None

    def __post_init__(self) -> None:
        if self.style == "auto":
            self.style = "bar" if sys.stderr.isatty() else "lines"
        self._begun = self._said = self.clock()

    def shown(self) -> AbstractContextManager[object]:
        """Return the context within which the bar is shown."""
        if self.style != "bar":
            return nullcontext()
        from rich.console import Console  # slow to load, and only a terminal needs it
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

        columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
        bar = Progress(*columns, console=Console(stderr=True), transient=True)
        line = bar.add_task("flying", total=self.total)
        self._advance = lambda done: bar.update(line, completed=done, description=self._failed() or "flying")
        return bar

    def skip(self) -> None:
        """Count a flight that the store holds already."""
        self.found += 1
        self._report()

    def fly(self, reason: str = "") -> None:
        """Count a flight that has ended, with the reason in a few words where it failed."""
        self.flown += 1
        if reason:
            self.reasons[reason] += 1
        now = self.clock()
        self._times.append((now, self.flown))
        while now - self._times[0][0] > _RECENT or len(self._times) > 10_000:
            self._times.popleft()
        self._report()

    @property
    def rate(self) -> float:
        """Flights a second over the last ten minutes."""
        if not self._times:
            return 0.0
        first, before = (self._begun, 0) if len(self._times) == self.flown else self._times[0]
        return (self.flown - before) / max(self.clock() - first, 1e-9)

    def state(self) -> dict[str, Any]:
        """Return the counts, the rate and the time left [s], for a program that watches."""
        left = self.total - self.found - self.flown
        return {
            "planned": self.total,
            "found": self.found,
            "flown": self.flown,
            "failed": sum(self.reasons.values()),
            "reasons": dict(self.reasons),
            "flights_per_s": round(self.rate, 3),
            "left_s": round(left / self.rate) if self.rate > 0 else None,
            "elapsed_s": round(self.clock() - self._begun, 1),
        }

    def line(self) -> str:
        """Return the state in words."""
        done, left = self.found + self.flown, self.state()["left_s"]
        parts = [f"{done:,} of {self.total:,} flights"]
        parts += [f"{self.rate:.2f} a second"] if self.flown else []
        parts += [f"{left / 60.0:,.0f} min left"] if left else []
        return ", ".join([*parts, *([self._failed()] if self.reasons else [])])

    def finish(self) -> None:
        """Say the last state."""
        if self.style == "json":
            self._write()

    def _failed(self) -> str:
        counted = ", ".join(f"{count:,} × {reason}" for reason, count in self.reasons.most_common(4))
        return f"failed: {counted}" if counted else ""

    def _report(self) -> None:
        self._advance(self.found + self.flown)
        if self.style in ("lines", "json") and self.clock() - self._said >= _EVERY:
            self._said = self.clock()
            self._write()

    def _write(self) -> None:
        if self.style == "json":
            sys.stderr.write(json.dumps(self.state()) + "\n")
            sys.stderr.flush()
        else:
            say(self.line())
