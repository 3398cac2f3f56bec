"""The table of measurements of campaigns, by name."""

from collections.abc import Callable, Iterator
from pathlib import Path

from pitotbench.evidence.campaigns.costs import driver_memory, efficiency, overhead, resume
from pitotbench.evidence.campaigns.faults import bad_flights, bad_stores, full_disks, second_driver
from pitotbench.evidence.campaigns.kills import fly_long, kill_drivers, kill_workers, stop_drivers
from pitotbench.evidence.campaigns.scheduler import schedules

Measurement = Callable[[Path, int], Iterator[str]]


def _faults(folder: Path, _: int) -> Iterator[str]:
    yield from bad_flights(folder / "flights")
    yield from bad_stores(folder / "stores")
    yield from second_driver(folder / "second")
    yield from full_disks(folder / "full")


# Each measurement with its usual number of flights or tasks.
MEASUREMENTS: dict[str, tuple[Measurement, int]] = {
    "kills": (kill_drivers, 60),
    "long": (fly_long, 10_000),
    "workers": (kill_workers, 30),
    "faults": (_faults, 0),
    "resume": (resume, 10_000),
    "memory": (driver_memory, 1_000_000),
    "efficiency": (lambda folder, flights: efficiency(folder, flights, dask=False), 1_000),
    "efficiency-dask": (lambda folder, flights: efficiency(folder, flights, dask=True), 1_000),
    "sigterm": (stop_drivers, 60),
    "overhead": (overhead, 30),
    "scheduler": (schedules, 1_000_000),
}
