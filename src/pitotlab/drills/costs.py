"""What the engine of campaigns costs, and the table of all drills."""

import json
import os
import time
from argparse import ArgumentParser
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from statistics import mean
from tempfile import TemporaryDirectory

from pitotbench.campaigns.campaign import Watch, fly_missing
from pitotbench.campaigns.fleet import open_fleet
from pitotbench.campaigns.plan_file import read_plan
from pitotbench.campaigns.store import ResultStore, stored
from pitotbench.campaigns.task import perform_task
from pitotlab.drills import drivers, survival


def overhead(folder: Path, flights: int = 30) -> Iterator[str]:
    """Compare the CPU time of planning, keeping and finding a result with the shortest flight's."""
    plan = read_plan(drivers.write_plan_file(folder, str(flights)))
    store = ResultStore(folder / "store")
    with store:
        begun = time.process_time()
        tasks = [*plan.tasks(keep_logs="none")]
        planned = time.process_time()
        results = [perform_task(task) for task in tasks]
        flown = time.process_time()
        for task, result in zip(tasks, results, strict=True):
            store.put(task.key, *stored(task, result))
        kept = time.process_time()
        assert all(store.find(task.key) for task in tasks)
        found = time.process_time()
    flight = (flown - planned) / flights
    parts = {"plan and key": planned - begun, "keep": kept - flown, "find": found - kept}
    yield f"shortest flight: {flight * 1e3:.0f} ms of CPU"
    for name, seconds in parts.items():
        yield f"  {name}: {seconds / flights * 1e3:.2f} ms"
    yield f"overhead of store and index: {sum(parts.values()) / flights / flight:.2%} of the flight's CPU"
    sizes = [path.stat().st_size for path in (folder / "store").glob("flights/*/*.json")]
    yield f"bytes of a part: {mean(sizes):.0f}"


def efficiency(folder: Path, flights: int, dask: bool) -> Iterator[str]:
    """Compare the CPU time inside the flights with that of all processes of a campaign."""
    plan, where, before = drivers.write_plan_file(folder, str(flights)), "", drivers.children_cpu()
    kind = "dask" if dask else "local"
    if dask:
        with drivers.dask_cluster() as cluster:
            ended = drivers.fly_campaign(plan, folder / "dask", "--scheduler", cluster.address)
            scheduler = drivers.cpu_used(cluster.scheduler)
            workers = sum(
                map(drivers.cpu_used, [cluster.workers, *drivers.descendants(cluster.workers)])
            )
            where = (
                f"driver {ended.cpu:.1f} s, scheduler {scheduler:.1f} s, workers with their "
                f"nannies {workers:.1f} s"
            )
    else:
        ended = drivers.fly_campaign(plan, folder / "local", "--jobs", "2")
    cpu = drivers.children_cpu() - before
    inside = [
        json.loads(path.read_bytes())["made"]["cpu_s"] for path in drivers.parts_of(folder / kind)
    ]
    flown = sum(inside)
    yield f"{kind}, 2 workers, {len(inside)} flights: {flown:.1f} CPU s in flights, {cpu:.1f} in all processes"
    yield f"  CPU efficiency {flown / cpu:.3f}; {mean(inside) * 1e3:.0f} ms a flight; wall {ended.seconds:.0f} s"
    if where:
        yield f"  {where}"


def resume(folder: Path, flights: int) -> Iterator[str]:
    """Measure the time of the command for a plan whose flights are all stored."""
    path = drivers.write_plan_file(folder, str(flights))
    tasks = read_plan(path).tasks(keep_logs="none")
    store = ResultStore(folder / "out" / "store", sync=False)
    with store:
        first = next(tasks)
        result = perform_task(first)
        store.put(first.key, *stored(first, result))
        for task in tasks:  # the numbers of one flight for all: only their storage counts here
            store.put(task.key, *stored(task, result))
    for what in ("table and page made", "table and page there"):
        ended = drivers.fly_campaign(path, folder / "out", "--jobs", "2")
        times = f"{ended.seconds:.1f} s of wall time, {ended.cpu:.1f} s of CPU"
        yield f"resume with {flights:,} stored, {what}: {times}; exit code {ended.code}"


def driver_memory(folder: Path, tasks: int) -> Iterator[str]:
    """Measure the memory of a driver of tasks without flights in two processes."""
    store = ResultStore(folder / "stubs", sync=False)
    samples: list[tuple[int, float]] = []
    watch = Watch(tasks, "none")

    def sampled() -> Iterator[drivers.Stub]:
        for number, task in enumerate(drivers.stubs(tasks)):
            if number % max(tasks // 8, 1) == 0:
                samples.append((number, drivers.memory(os.getpid())))
            yield task

    begun, cpu = time.monotonic(), time.process_time()
    with open_fleet(2) as fleet, store:
        fly_missing(sampled(), drivers.act, drivers.stub_outcome, store, fleet, watch)
    samples.append((tasks, drivers.memory(os.getpid())))
    yield f"driver memory, {tasks:,} tasks: " + ", ".join(
        f"{size:.0f} MB at {n:,}" for n, size in samples
    )
    seconds, used = time.monotonic() - begun, time.process_time() - cpu
    yield f"  {used / tasks * 1e3:.2f} ms of the driver's CPU a task, {tasks / seconds:,.0f} tasks a second"


Measurement = Callable[[Path, int], Iterator[str]]


def _faults(folder: Path, _: int) -> Iterator[str]:
    yield from survival.bad_flights(folder / "flights")
    yield from survival.bad_stores(folder / "stores")
    yield from survival.second_driver(folder / "second")
    yield from survival.full_disks(folder / "full")


# Each measurement with its usual number of flights or tasks.
MEASUREMENTS: dict[str, tuple[Measurement, int]] = {
    "kills": (survival.kill_drivers, 60),
    "long": (survival.fly_long, 10_000),
    "workers": (survival.kill_workers, 30),
    "faults": (_faults, 0),
    "resume": (resume, 10_000),
    "memory": (driver_memory, 1_000_000),
    "efficiency": (lambda folder, flights: efficiency(folder, flights, dask=False), 1_000),
    "efficiency-dask": (lambda folder, flights: efficiency(folder, flights, dask=True), 1_000),
    "sigterm": (survival.stop_drivers, 60),
    "overhead": (overhead, 30),
}


def command(parser: ArgumentParser, words: Sequence[str]) -> None:
    """Measure what campaigns survive and cost. For Linux; `faults` needs the right to mount a disk.

    Without `--flights` a measurement has the usual number of them.
    """
    add = parser.add_argument
    add("what", choices=[*MEASUREMENTS], help="the measurement")
    add("--flights", type=int, help="number of flights or tasks")
    options = parser.parse_args(words)
    measure, usual = MEASUREMENTS[options.what]
    with TemporaryDirectory(prefix="pitotbench-") as scratch:
        for line in measure(Path(scratch), options.flights or usual):
            print(line, flush=True)
