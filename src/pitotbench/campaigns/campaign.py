"""Run a campaign: plan its flights, fly those not stored, and make the folder of results."""

import json
import signal
import sys
import time
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from threading import current_thread, main_thread
from types import FrameType
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

from pitotbench.calibration.options import CalibrationOptions
from pitotbench.campaigns.digests import code_digest
from pitotbench.campaigns.fleet import (
    Failure,
    Fleet,
    FleetLostError,
    Limits,
    MachineError,
    open_fleet,
)
from pitotbench.campaigns.plan_file import CampaignPlan, plan_of_names, read_plan, seeds_of
from pitotbench.campaigns.progress import say, terminal_bar
from pitotbench.campaigns.result_table import (
    RESULTS,
    STORE,
    gather,
    page_of,
    publish_files,
    require_own_folder,
)
from pitotbench.campaigns.store import DONE, Document, ResultStore, satisfies, stored
from pitotbench.campaigns.task import Task, perform_task, sharded
from pitotbench.logbook.columns import write_text
from pitotbench.records import BadInputError, NoAnswerError
from pitotbench.records.case import Case
from pitotbench.show.calibration import ShortAnswer
from pitotbench.show.campaign import means_of
from pitotbench.show.columns import command_line
from pitotbench.show.reader_units import Units, reader_units

if TYPE_CHECKING:
    from pandas import DataFrame

_ASKED = tuple(
    number for name in ("SIGTERM", "SIGHUP") if (number := getattr(signal, name, None)) is not None
)


class StoppedError(KeyboardInterrupt):
    """A campaign was asked to stop. Its message says what is stored and how to go on."""


@contextmanager
def stoppable() -> Iterator[None]:
    """Let SIGTERM and SIGHUP raise KeyboardInterrupt as Ctrl-C does, to close all in order."""
    if current_thread() is not main_thread():  # only the main thread may set handlers
        yield
        return
    before = {number: signal.signal(number, _stop) for number in _ASKED}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _stop(number: int, _: FrameType | None) -> None:
    raise KeyboardInterrupt(signal.Signals(number).name)


STYLES = ("auto", "bar", "lines", "json", "none")
_EVERY = 60.0  # s between two lines
_RECENT = 600.0  # s over which the rate is measured


@dataclass(slots=True)
class Watch:
    """A count of a campaign's flights, reported by `style`: a bar on a terminal, or lines.

    A line comes each minute, in words or as JSON. `total` is the number of flights planned.
    """

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
        bar, line = terminal_bar("flying", self.total)
        self._advance = lambda done: bar.update(
            line, completed=done, description=self._failed() or "flying"
        )
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

    @property
    def left(self) -> int | None:
        """The time left [s]; None before the first flight."""
        flights = self.total - self.found - self.flown
        return round(flights / self.rate) if self.rate > 0 else None

    def state(self) -> dict[str, object]:
        """Return the counts, the rate and the time left [s], for a program that watches."""
        return {
            "planned": self.total,
            "found": self.found,
            "flown": self.flown,
            "failed": sum(self.reasons.values()),
            "reasons": dict(self.reasons),
            "flights_per_s": round(self.rate, 3),
            "left_s": self.left,
            "elapsed_s": round(self.clock() - self._begun, 1),
        }

    def line(self) -> str:
        """Return the state in words."""
        done, left = self.found + self.flown, self.left
        parts = [f"{done:,} of {self.total:,} flights"]
        parts += [f"{self.rate:.2f} a second"] if self.flown else []
        parts += [f"{left / 60.0:,.0f} min left"] if left else []
        return ", ".join([*parts, *([self._failed()] if self.reasons else [])])

    def finish(self) -> None:
        """Say the last state."""
        if self.style == "json":
            self._write()

    def _failed(self) -> str:
        counted = ", ".join(
            f"{count:,} × {reason}" for reason, count in self.reasons.most_common(4)
        )
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


class Keyed(Protocol):
    """A task with the key under which its result is kept."""

    @property
    def key(self) -> str:
        """The digest of all that decides the result."""
        ...


K = TypeVar("K", bound=Keyed)
R = TypeVar("R")
Stored = tuple[Mapping[str, Any], Mapping[str, bytes]]


def fly_missing(
    tasks: Iterable[K],
    work: Callable[[K], R],
    stored: Callable[[K, R | Failure], Stored],
    store: ResultStore,
    fleet: Fleet,
    watch: Watch,
    wanted: Callable[[Document, K], bool] = lambda document, task: True,
) -> tuple[str, ...]:
    """Perform every task whose result the store lacks, and keep each result as soon as it is there.

    `tasks` is read one by one, so a plan may be longer than the memory. `stored` turns a result
    into the document and the files that the store keeps. `wanted` says whether a document that is
    found will do. The document of a failure has its reason in `failures`. A damaged part costs one
    flight. A failure of the machine is no result and is not stored: its sentence is returned.
    Raises StoreError and FleetLostError; what is stored by then stays.
    """

    def missing() -> Iterator[K]:
        for task in tasks:
            found = store.find(task.key)
            if found is not None and wanted(found, task):
                watch.skip()
            else:
                if found is None and store.part(task.key).exists():
                    say(
                        f"{store.part(task.key)}: damaged or incomplete; this flight is flown again"
                    )
                yield task

    open_ones: list[str] = []
    for task, result in fleet.stream(work, missing()):
        document, files = stored(task, result)
        if isinstance(result, Failure) and result.kind is MachineError:
            watch.reasons[_short(document)] += 1
            open_ones += [
                f"{each}; the same command flies it again" for each in document["failures"]
            ]
            continue
        store.put(task.key, document, files)
        watch.fly(_short(document))
    return tuple(open_ones)


def _short(document: Mapping[str, Any]) -> str:
    """Return the reason of a failure in a few words, so that equal reasons can be counted."""
    failures = document.get("failures") or [""]
    return str(failures[0]).partition(": ")[2].partition(":")[0].partition(" (")[0][:60]


GIGABYTE = 1_000_000_000
MEMORY = 2.0  # GB that a flight may use; 0.3 GB are usual
PAGE = "report.html"
_SAMPLED = 20  # stored flights, of which the code is compared
SECONDS = 900.0  # s that a flight may take; 1 to 10 s are usual


@dataclass(frozen=True, slots=True)
class CampaignRequest:
    """The request for a campaign, as the command line makes it. Names may be comma lists or `all`.

    `plan` is a file that says what is flown; without it the names do. `seeds` is a number, or a
    range such as `501-1000`. `shard` (k, n) flies the k-th of n parts. `time_limit` [s] and
    `memory_limit` [GB] are for a flight. `keep_logs` is `none`, `failed` or `all`. `retry_failed`
    flies failures again. `progress` is a style of `Watch`. Without `report` nothing is drawn and no
    page is written; it is in the `units` that words such as `km/h,m` ask for.
    """

    maneuvers: str = ""
    systems: str = ""
    models: str = "inverse+"
    seeds: int | str = 1
    base: Case = field(default_factory=Case)
    options: CalibrationOptions = field(default_factory=CalibrationOptions)
    out: Path = Path("out")
    jobs: int | None = None
    scheduler: str | None = None
    log_format: str = "parquet"
    plan: Path | None = None
    shard: tuple[int, int] | None = None
    security: Path | None = None
    time_limit: float | None = SECONDS
    memory_limit: float | None = MEMORY
    keep_logs: str = "all"
    retry_failed: bool = False
    progress: str = "none"
    report: bool = True
    units: str = ""

    def planned(self) -> CampaignPlan:
        """Return the plan. Raises BadInputError or UnknownNameError for a bad one."""
        try:
            if self.plan is not None:
                return read_plan(self.plan)
            seeds = seeds_of(str(self.seeds))
            plan = plan_of_names(
                self.base, self.maneuvers, self.systems, self.models, seeds, self.options
            )
            plan.check()
        except OverflowError as error:
            raise BadInputError(
                f"{self.plan or '--seeds'}: a whole number is too large for a plan; give one of "
                "fewer digits"
            ) from error
        return plan


@dataclass(frozen=True, slots=True)
class CampaignResult:
    """The table of results, the failures in words, and the folder of the files.

    `found` and `flown` count the flights that the store held and those of this run; `answers` are
    the first short answers, one a flight and data system. `drawn` are the fields of the plan with
    random values.
    """

    table: "DataFrame"
    failures: tuple[str, ...]
    folder: Path
    found: int = 0
    flown: int = 0
    answers: tuple[ShortAnswer, ...] = ()
    drawn: tuple[str, ...] = ()

    @property
    def means(self) -> "DataFrame":
        """The means over the seeds and over what is drawn.

        A row stands for each combination of all else that the plan varies: the table that the page
        and the command show.
        """
        return means_of(self.table, self.drawn)


def run_campaign(request: CampaignRequest) -> CampaignResult:
    """Fly, sense, calibrate, score and show a campaign.

    A flight that the folder's store holds is not flown again.

    The same request therefore goes on where an earlier run was stopped, however that was. Raises
    BadInputError or UnknownNameError for a bad request, before anything is flown; NoAnswerError
    where no flight gave a result; StoppedError, a KeyboardInterrupt, where it is asked to stop.
    """
    campaign = _Campaign(request, request.planned(), reader_units(request.units))
    require_own_folder(request.out)
    memory = None if request.memory_limit is None else round(request.memory_limit * GIGABYTE)
    limits = Limits(request.time_limit, memory)
    with (
        stoppable(),
        open_fleet(
            request.jobs, request.scheduler, campaign.count, limits, request.security, isolated=True
        ) as fleet,
        ResultStore(request.out / STORE) as store,
    ):
        watch = Watch(campaign.count, request.progress)
        campaign.say_what_is_stored(store)
        try:
            with watch.shown():
                not_stored = fly_missing(
                    campaign.tasks(),
                    perform_task,
                    stored,
                    store,
                    fleet,
                    watch,
                    partial(campaign.wanted, store),
                )
        except KeyboardInterrupt as error:
            raise StoppedError(
                f"stopped ({str(error) or 'Ctrl-C'}); {campaign.how_to_go_on(watch)}"
            ) from error
        except FleetLostError as error:
            raise NoAnswerError(f"{error}; {campaign.how_to_go_on(watch)}") from error
        watch.finish()
        return campaign.result(store, watch, not_stored)


@dataclass(frozen=True, slots=True)
class _Campaign:
    request: CampaignRequest
    plan: CampaignPlan
    units: Units

    @property
    def count(self) -> int:
        """The number of flights of this shard."""
        if self.request.shard is None:
            return self.plan.count
        part, parts = self.request.shard
        return len(range(part - 1, self.plan.count, parts))

    def tasks(self) -> Iterator[Task]:
        """Give the tasks of this shard one by one."""
        request, draw = self.request, self.units.words if self.request.report else ""
        tasks = self.plan.tasks(request.log_format, request.keep_logs, draw)
        return sharded(tasks, self.request.shard) if self.request.shard else tasks

    def wanted(self, store: ResultStore, document: Document, task: Task) -> bool:
        """Return whether a stored result will do."""
        again = self.request.retry_failed and document["state"] != DONE
        if task.keep_logs != "none" and not store.has_logs(document):
            say(f"{store.part(task.key)}: its log is lost; this flight is flown again")
            return False
        return satisfies(document, task) and not again

    def say_what_is_stored(self, store: ResultStore) -> None:
        """Say how many flights the store holds, and how many of them are of other code."""
        if self.request.progress == "none":
            return
        keys = [*store.keys()]
        if not keys:
            return
        say(
            f"{self.request.out}: {len(keys):,} flights are stored; those of this plan are not "
            "flown again"
        )
        sampled = (store.find(key) for key in keys[:: max(len(keys) // _SAMPLED, 1)])
        if {document["made"]["code"] for document in sampled if document} - {code_digest()}:
            say("the stored flights are of other code: they stay, and are flown again by this code")

    def how_to_go_on(self, watch: Watch) -> str:
        """Return what is stored and the command that goes on."""
        program = (
            "pitotbench" if Path(sys.argv[0]).name in ("pitotbench", "__main__.py") else sys.argv[0]
        )
        command = command_line([program, *sys.argv[1:]])
        done = watch.found + watch.flown
        return (
            f"{done:,} of {watch.total:,} flights are stored in {self.request.out}; to go on: "
            f"{command}"
        )

    def result(
        self, store: ResultStore, watch: Watch, not_stored: tuple[str, ...]
    ) -> CampaignResult:
        """Make the files of the folder, and return the result."""
        from pandas import read_parquet  # large: a driver that flies does without

        folder = self.request.out
        found = gather(folder, store, self.tasks(), self.plan.varied)
        failures = (*not_stored, *found.failures)
        if (more := found.failed - len(found.failures)) > 0:
            failures += (f"and {more:,} more: pitotbench results {folder} --state failed",)
        if not found.rows:
            raise NoAnswerError("no flight gave a result: " + "; ".join(failures[:3]))
        if self.request.keep_logs != "none":
            publish_files(folder, store, self.tasks())
        table = read_parquet(folder / RESULTS)
        if self.request.report:
            case = next(self.tasks()).case
            page = page_of(case, table, found.sections, failures, self.units, self.plan.drawn)
            write_text(folder / PAGE, page)
        else:
            # The page of an earlier run shows another table.
            (folder / PAGE).unlink(missing_ok=True)
        answers = tuple(section.answer for section in found.sections)
        counts = watch.found, watch.flown
        return CampaignResult(table, failures, folder, *counts, answers, self.plan.drawn)
