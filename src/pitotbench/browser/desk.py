"""What lies on the desk: the logs, what is asked of them, and the latest answer.

The desk outlives the tabs that show it.
"""

import asyncio
from collections.abc import Callable, Sequence
from dataclasses import replace
from filecmp import cmp
from pathlib import Path
from typing import Any

from pitotbench.browser.uploads import Store
from pitotbench.browser.work import (
    EXAMPLE,
    Answer,
    DraftRow,
    Found,
    Look,
    Plain,
    Request,
    answer,
    draft,
    find_flights,
    fly_example,
    mapping_of,
    reduce_legs,
    take,
)
from pitotbench.browser.workers import Workers
from pitotbench.logbook.bundle import ZIP
from pitotbench.records.calibration_request import NamedFile
from pitotbench.records.log import FlightSummary
from pitotbench.records.over_dates import OverDates
from pitotbench.show.reader_units import reader_units

_SETTLE = 0.05  # s that a choice must stand before it is computed


class Desk:
    """The state of the page, and what changes it. `listeners` are called after each change."""

    def __init__(self, store: Store, workers: Workers) -> None:
        self.store, self.workers = store, workers
        self.listeners: set[Callable[[], None]] = set()
        self.found: list[Found] = []
        self.handbook: NamedFile | None = None  # its table, with which the curve is compared
        self.units = reader_units()
        self.leave_out = False  # what is brushed
        self.legs: Plain | None = None
        self._card: NamedFile | None = None
        self._drops = 0
        self._shown = (0, False)  # the drop whose file is chosen, and whether that was read
        self._tasks: dict[asyncio.Task[None], str] = {}  # what runs, in words
        self._answering: asyncio.Task[None] | None = None
        self._clear()

    def _clear(self) -> None:
        """Ask nothing, and show no answer."""
        self.chosen: tuple[int, ...] = ()
        self.request: Request | None = None
        self.refusal = ""
        self.look: tuple[Request, Look] | None = None  # how the log was read for it, and itself
        self.answer: Answer | None = None
        self.course: OverDates | None = None  # of the correction over dates, of several logs
        self.draft: list[DraftRow] = []

    @property
    def status(self) -> str:
        """What is computed, in words; empty where nothing is."""
        return next(reversed(self._tasks.values()), "")

    def tell(self) -> None:
        """Call the listeners."""
        for listener in tuple(self.listeners):
            listener()

    def _ask(
        self, status: str, then: Callable[[str, Any], None], *question: Any, wait: float = 0.0
    ) -> asyncio.Task[None]:
        """Ask the children a question, and call `then` with the name of each reply and itself."""

        async def work() -> None:
            await asyncio.sleep(wait)
            async for name, reply in self.workers.ask(*question):
                if name == "status":
                    self._tasks[task] = reply
                else:
                    then(name, self.store.named(reply) if name == "refusal" else reply)
                self.tell()

        def over(task: asyncio.Task[None]) -> None:
            del self._tasks[task]
            self.tell()

        task = asyncio.ensure_future(work())
        self._tasks[task] = status
        task.add_done_callback(over)
        self.tell()
        return task

    def add_drop(self, drop: str) -> None:
        """Look into the files of a drop that has arrived."""
        self._drops += 1
        names = self.store.names(drop)
        alone = {path for path in names if path.suffix == ZIP or len(names) == 1}
        for place in sorted({path if path in alone else path.parent for path in names}):
            self.add(place, {path.name: name for path, name in names.items()})

    def add_example(self) -> None:
        """Fly an example on the bench, and look into its log."""
        place = self.store.new_folder() / EXAMPLE
        self.add(place, {place.name: place.name}, fly_example)

    def remove(self, place: int) -> None:
        """Take a flight out of the list; the answer of others stays."""
        gone = self.found[place]
        del self.found[place]
        if self.handbook == gone.log:
            self.handbook = None
            self.change(handbook=None)
        if place in self.chosen:
            self._stop()
            self._clear()
        self.chosen = tuple(i - (i > place) for i in self.chosen)
        self.tell()

    def add(
        self, place: Path, names: dict[str, str], question: Callable[..., None] = find_flights
    ) -> None:
        """Look for flights in a file, a folder or a .zip file, or where another question puts them.

        `names` as for `find_flights`.

        What came last is chosen, be it read or refused; of one drop a log that is read.
        """
        drop = self._drops
        shown = names.get(place.name) or names.get("") or f"{len(names)} files"
        self.store.known.append(NamedFile(place, shown))

        def then(name: str, reply: Any) -> None:
            if name == "refusal":
                reply = (Found(NamedFile(place, shown), FlightSummary(shown, reply)),)
            if len(reply) == 1 and (copies := self._copies(reply[0].log)):
                self.choose(copies[:1])
                return
            places = range(len(self.found), len(self.found) + len(reply))
            self.found += reply
            self.store.known += [each.log for each in reply]
            for each in [i for i in places if self.found[i].handbook]:
                self.compare(each)
            logs = [i for i in places if not self.found[i].handbook]
            read = [i for i in logs if not self.found[i].flight.refusal]
            strange = [i for i in logs if self.found[i].flight.strange]
            if logs and (drop, bool(read)) >= self._shown:
                self._shown = (drop, bool(read))
                self.choose((read or strange or logs)[:1])

        self._ask(f"reading {shown}", then, question, place, names, self.store.new_folder())

    def _copies(self, log: NamedFile) -> list[int]:
        """The places of files with the same content: a flight is listed once."""
        return [
            place
            for place, each in enumerate(self.found)
            if each.log.path.is_file()
            and log.path.is_file()
            and cmp(each.log.path, log.path, False)
        ]

    def choose(self, places: Sequence[int]) -> None:
        """Choose the logs that are asked, by their places in the list."""
        chosen = [self.found[i] for i in dict.fromkeys(places)]
        old = self.request or Request()
        self._stop()
        self._clear()
        self.chosen = tuple(dict.fromkeys(places))
        refused = [each for each in chosen if each.flight.refusal]
        if chosen and not refused:
            # The part, the sensor and the parameters are of one log; the rest is for another too.
            self._answer(
                Request(
                    logs=tuple(dict.fromkeys(each.log for each in chosen)),
                    handbook=self.handbook,
                    options=old.options,
                    **old.facts(),
                    parameters=chosen[0].autopilot,
                )
            )
        for each in refused[:1]:
            self.refusal = str(each.flight)
            if each.flight.strange:
                self._answering = self._ask("drafting a mapping", self._heard, draft, each.log)
        self.tell()

    def compare(self, place: int) -> None:
        """Compare the curve with the handbook at a place of the list, or with it no more."""
        log = self.found[place].log
        self.handbook = None if self.handbook == log else log
        self.change(handbook=self.handbook)
        self.tell()

    def _heard(self, name: str, reply: Any) -> None:
        """Hold a reply under its name."""
        setattr(self, name, reply)

    def read_with(self, edited: Sequence[tuple[str, str]]) -> None:
        """Read the chosen log by the draft, of whose rows our name and unit were edited."""
        self.draft = [
            (row[0], chosen, *row[2:]) for row, chosen in zip(self.draft, edited, strict=True)
        ]
        log = self.found[self.chosen[0]].log
        text = mapping_of(self.draft, f"drafted from {log.name}")
        mapping = self.store.write("mapping.toml", text)
        self._answer(Request(mapping, handbook=self.handbook, logs=(log,)))

    def change(self, **flags: Any) -> None:
        """Change flags of the request, such as `begin`, and ask again."""
        if self.request is not None:
            self._answer(replace(self.request, **flags))

    def brush(self, begin: str, end: str) -> None:
        """Use the minutes between two moments alone, or leave them out, as was chosen."""
        if self.request is not None and self.leave_out:
            self.change(without=(*self.request.without, f"{begin}-{end}"))
        else:
            self.change(begin=begin, end=end)

    def _stop(self) -> None:
        if self._answering is not None:
            self._answering.cancel()

    def _answer(self, request: Request) -> None:
        """Ask for an answer; an older question is given up."""
        self._stop()
        if self.refusal:
            self.answer = None
        self.course = None
        self.request, self.refusal = request, ""
        look = self.look is None or self.look[0] != request.whole
        self._answering = self._ask("reading", self._heard, answer, request, look, wait=_SETTLE)

    def reduce(self, text: str) -> None:
        """Reduce typed legs: a card of legs (CSV), or their ground speeds and tracks alone."""
        self._card = self.store.write("legs.csv", text)
        self._ask(
            "reducing the legs",
            self._heard_of_legs,
            reduce_legs,
            self._card.path,
            (self.request or Request()).setting("accuracies"),
        )

    def _heard_of_legs(self, name: str, reply: Any) -> None:
        self.legs = {name: reply} if name == "refusal" else reply

    async def take(self, kind: str) -> tuple[str, str] | None:
        """Return name and text of a file to take away; None where there is none of the kind."""
        own = {"legs": self._card, "mapping": getattr(self.request, "mapping", None)}.get(kind)
        if own is not None:
            return own.name, own.path.read_text(encoding="utf-8")
        if self.request is None or self.answer is None:
            return None
        replies = self.workers.ask(take, self.request, kind, self.units)
        return {name: reply async for name, reply in replies}.get("file")

    def close(self) -> None:
        """End the children, and delete the files."""
        for task in tuple(self._tasks):
            task.cancel()
        self.workers.close()
        self.store.close()
