"""What lies on the desk: the logs, what is asked of them, and the latest answer. It outlives the tabs
that show it.
"""

import asyncio
from collections.abc import Callable, Coroutine, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from pitotbench.browser.uploads import Store
from pitotbench.browser.work import (
    Answer,
    Download,
    DraftRow,
    Found,
    LegAnswer,
    LogFile,
    Look,
    Refusal,
    Request,
    answer,
    draft,
    find_flights,
    mapping_of,
    reduce_legs,
    take,
)
from pitotbench.browser.workers import Workers
from pitotbench.logbook.bundle import ZIP
from pitotbench.logbook.points_table import COLUMNS
from pitotbench.records.log import HeldFlight

_SETTLE = 0.15  # s that a choice must stand before it is computed
FLAGS = ("begin", "end", "model", "accuracy", "temperature", "autopilot")


class Desk:
    """The state of the page, and what changes it. `listeners` are called after each change."""

    def __init__(self, store: Store, workers: Workers) -> None:
        self.store = store
        self.workers = workers
        self.listeners: set[Callable[[], None]] = set()
        self.found: list[Found] = []
        self.chosen: tuple[int, ...] = ()
        self.request: Request | None = None
        self.unit = "kt"
        self.leave_out = False  # what is brushed
        self.status = ""
        self.refusal = ""
        self.look: Look | None = None
        self.answer: Answer | None = None
        self.draft: tuple[DraftRow, ...] = ()
        self.legs: LegAnswer | Refusal | None = None
        self._looked_at: Request | None = None
        self._card: LogFile | None = None
        self._answering: asyncio.Task[None] | None = None
        self._tasks: set[asyncio.Task[None]] = set()

    def tell(self) -> None:
        """Call the listeners."""
        for listener in tuple(self.listeners):
            listener()

    def _spawn(self, work: Coroutine[Any, Any, None]) -> asyncio.Task[None]:
        task = asyncio.ensure_future(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        return task

    def add_drop(self, drop: str) -> None:
        """Look into the files of a drop that has arrived."""
        names = self.store.names(drop)
        places = [path for path in names if path.suffix == ZIP]
        folders = {path.parent for path in names if path.suffix != ZIP}
        known = {path.name: name for path, name in names.items()}
        if len(names) == 1:  # alone, also its refusal is of the file and not of its folder
            places, folders = list(names), set()
        for place in (*places, *folders):
            self.add(place, known)

    def add(self, place: Path, names: dict[str, str] | None = None) -> None:
        """Look for flights in a file, a folder or a .zip file."""
        self._spawn(self._find(place, names or {}))

    async def _find(self, place: Path, names: dict[str, str]) -> None:
        shown = names.get(place.name, place.name)
        self.status = f"reading {shown}"
        self.tell()
        asked = self.workers.ask(find_flights, place, names, self.store.new_folder())
        reply = [each async for each in asked][-1]
        self.status = ""
        first = len(self.found)
        if isinstance(reply, Refusal):
            words = reply.words.replace(str(place), shown)
            reply = (Found(LogFile(place, shown), HeldFlight(shown, words)),)
        self.found += reply
        read = [i for i, each in enumerate(reply, first) if not each.flight.refusal]
        strange = [i for i, each in enumerate(reply, first) if each.strange]
        if read or (strange and self.answer is None):
            self.choose((read or strange)[:1])
        self.tell()

    def choose(self, places: Sequence[int]) -> None:
        """Choose the logs that are asked, by their places in the list."""
        chosen = tuple(i for i in dict.fromkeys(places) if 0 <= i < len(self.found))
        logs = tuple(dict.fromkeys(self.found[i].log for i in chosen))
        self.chosen, self.look, self.answer, self.draft, self.refusal = chosen, None, None, (), ""
        self._looked_at = None
        refused = next((self.found[i] for i in chosen if self.found[i].flight.refusal), None)
        if refused is not None or not logs:
            self._stop()
            self.request = None
            self.refusal = "" if refused is None else str(refused.flight)
            if refused is not None and refused.strange:
                self._spawn(self._draft(refused.log))
            self.tell()
            return
        old = self.request
        kept = {} if old is None else {name: getattr(old, name) for name in FLAGS[2:]}
        self.request = Request(logs, **kept)
        self._ask()

    async def _draft(self, log: LogFile) -> None:
        async for reply in self.workers.ask(draft, log):
            if isinstance(reply, Refusal):
                self.refusal = f"{log.name}: not read: {reply.words}"
            elif self.chosen and self.found[self.chosen[0]].log == log:
                self.draft = reply
        self.tell()

    def read_with(self, rows: Sequence[tuple[str, str, str]]) -> None:
        """Read the chosen log by the draft, in which rows (their name, ours, unit) were edited."""
        edited = {theirs: (ours.strip(), unit.strip()) for theirs, ours, unit in rows}
        self.draft = tuple(
            replace(row, ours=edited[row.theirs][0], unit=edited[row.theirs][1])
            if row.theirs in edited
            else row
            for row in self.draft
        )
        log = self.found[self.chosen[0]].log
        text = mapping_of(self.draft, f"drafted from {log.name}")
        self.request = Request((log,), self.store.write("mapping.toml", text))
        self._ask()

    def change(self, **flags: Any) -> None:
        """Change flags of the request, such as `begin`, and ask again."""
        if self.request is not None:
            self.request = replace(self.request, **flags)
            self._ask()

    def brush(self, begin: str, end: str) -> None:
        """Use the minutes between two moments alone, or leave them out, as was chosen."""
        if self.request is None:
            return
        if self.leave_out:
            self.change(without=(*self.request.without, f"{begin}-{end}"))
        else:
            self.change(begin=begin, end=end)

    def show_in(self, unit: str) -> None:
        """Show speeds in another unit."""
        self.unit = unit
        self.tell()

    def _stop(self) -> None:
        if self._answering is not None:
            self._answering.cancel()

    def _ask(self) -> None:
        self._stop()
        self.status, self.refusal = "computing", ""
        self._answering = self._spawn(self._answer(self.request))
        self.tell()

    async def _answer(self, request: Request | None) -> None:
        assert request is not None
        await asyncio.sleep(_SETTLE)
        whole = replace(request, begin="", end="", without=(), model="", accuracy="")
        async for reply in self.workers.ask(answer, request, whole != self._looked_at):
            if isinstance(reply, Look):
                self.look, self._looked_at = reply, whole
            elif isinstance(reply, Refusal):
                self.answer, self.refusal = None, self._plain(reply.words, request)
            else:
                self.answer = reply
            self.tell()
        self.status = ""
        self.tell()

    @staticmethod
    def _plain(words: str, request: Request) -> str:
        for log in (*request.logs, *filter(None, (request.mapping,))):
            words = words.replace(str(log.path), log.name)
        return words

    def reduce(self, rows: Sequence[Sequence[str]], by_heading: bool) -> None:
        """Reduce typed legs: a row has the point, and the columns of a points table; blank rows do
        not count. Where no airspeed is typed, ground speeds and tracks alone are asked.
        """
        typed = [[" ".join(cell.split()).replace(",", ".") for cell in row] for row in rows]
        typed = [row for row in typed if any(row[1:])]
        names = [COLUMNS[0], *COLUMNS[2:]]
        if by_heading:
            names[-1] = "heading_deg"
        if not any(cell for row in typed for cell in row[1:4]):
            names, typed = names[-2:], [row[-2:] for row in typed]
        elif not any(row[0] for row in typed):  # the points follow from the airspeeds
            names, typed = names[1:], [row[1:] for row in typed]
        lines = [",".join(names), *(",".join(row) for row in typed)]
        self._card = file = self.store.write("legs.csv", "\n".join([*lines, ""]))
        accuracy = "" if self.request is None else self.request.accuracy
        self._spawn(self._reduce(file, accuracy))

    async def _reduce(self, file: LogFile, accuracy: str) -> None:
        async for reply in self.workers.ask(reduce_legs, file.path, accuracy):
            refused = isinstance(reply, Refusal)
            self.legs = (
                Refusal(reply.words.replace(str(file.path), file.name)) if refused else reply
            )
        self.tell()

    async def take(self, kind: str) -> Download | Refusal:
        """Return the file of a kind to take away."""
        request = self.request
        if kind == "legs" and self._card is not None:
            return Download(self._card.name, self._card.path.read_text(encoding="utf-8"))
        if request is None or self.answer is None:
            return Refusal("there is no answer yet")
        if kind == "mapping" and request.mapping is not None:
            return Download("mapping.toml", request.mapping.path.read_text(encoding="utf-8"))
        found: Download | Refusal = Refusal(f"this answer has no {kind}")
        async for reply in self.workers.ask(take, request, kind):
            found = reply
        return found

    def close(self) -> None:
        """End the children, and delete the files."""
        for task in tuple(self._tasks):
            task.cancel()
        self.workers.close()
        self.store.close()
