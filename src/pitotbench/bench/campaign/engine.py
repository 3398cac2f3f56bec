"""The engine of a campaign: perform the tasks that a store does not hold, and keep every result."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, Protocol, TypeVar

from pitotbench.bench.campaign.watching import Watch
from pitotbench.bench.fleet import Failure, Fleet, say
from pitotbench.bench.store import Document, ResultStore


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
) -> None:
    """Perform every task whose result the store lacks, and keep each result as soon as it is there.

    `tasks` is read one by one, so a plan may be longer than the memory. `stored` turns a result into the document
    and the files that the store keeps. `wanted` says whether a document that is found will do. The document of a
    failure has its reason in `failures`. A damaged part costs one flight. Raises StoreError and
    FleetLostError; what is stored by then stays.
    """

    def missing() -> Iterator[K]:
        for task in tasks:
            found = store.find(task.key)
            if found is not None and wanted(found, task):
                watch.skip()
            else:
                if found is None and store.part(task.key).exists():
                    say(f"{store.part(task.key)}: damaged or incomplete; this flight is flown again")
                yield task

    for task, result in fleet.stream(work, missing()):
        document, files = stored(task, result)
        store.put(task.key, document, files)
        watch.fly(_short(result, document))


def _short(result: object, document: Mapping[str, Any]) -> str:
    """Return the reason of a failure in a few words, so that equal reasons can be counted."""
    if isinstance(result, Failure):
        return result.reason.partition(":")[0][:60]
    failures = document.get("failures") or [""]
    return str(failures[0]).partition(": ")[2].partition(":")[0].partition(" (")[0][:60]
