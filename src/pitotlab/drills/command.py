"""The table of measurements of campaigns, by name."""

from argparse import ArgumentParser
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

from pitotlab.drills.costs import driver_memory, efficiency, overhead, resume, schedules
from pitotlab.drills.survival import (
    bad_flights,
    bad_stores,
    fly_long,
    full_disks,
    kill_drivers,
    kill_workers,
    second_driver,
    stop_drivers,
)

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


def command(parser: ArgumentParser, words: Sequence[str]) -> None:
    """Measure what campaigns survive and cost. For Linux; `faults` needs the right to mount a disk.

    Without `--flights` a measurement has the usual number of them.
    """
    parser.add_argument("what", choices=[*MEASUREMENTS], help="the measurement")
    parser.add_argument("--flights", type=int, help="number of flights or tasks")
    parser.add_argument("--folder", type=Path, help="folder for the stores, which stay (default: a temporary one)")
    options = parser.parse_args(words)
    measure, usual = MEASUREMENTS[options.what]
    with TemporaryDirectory(prefix="pitotbench-") as scratch:
        for line in measure(options.folder or Path(scratch), options.flights or usual):
            print(line, flush=True)
