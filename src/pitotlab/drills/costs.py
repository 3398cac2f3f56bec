"""What the engine of campaigns costs, and a simulation of a driver and its workers at sizes that are not flown."""

import json
import os
import random
import time
from collections.abc import Iterator
from dataclasses import dataclass
from heapq import heappop, heappush
from pathlib import Path
from statistics import mean

from pitotbench.bench.campaign.engine import fly_missing
from pitotbench.bench.campaign.perform import perform_task
from pitotbench.bench.campaign.plan_file import read_plan
from pitotbench.bench.campaign.result_store import ResultStore
from pitotbench.bench.campaign.stored_result import stored
from pitotbench.bench.campaign.watching import Watch
from pitotbench.bench.fleet import open_fleet
from pitotlab.drills.drivers import (
    Stub,
    act,
    cpu_used,
    dask_cluster,
    descendants,
    fly_campaign,
    memory,
    stub_outcome,
    stubs,
    write_plan_file,
)


def overhead(folder: Path, flights: int = 30) -> Iterator[str]:
    """Compare the CPU time of planning, keeping and finding a result with that of the shortest flight."""
    plan = read_plan(write_plan_file(folder, str(flights)))
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
    plan = write_plan_file(folder, str(flights))
    where = ""
    if dask:
        before = os.times()
        with dask_cluster() as cluster:
            ended = fly_campaign(plan, folder / "dask", "--scheduler", cluster.address)
            scheduler = cpu_used(cluster.scheduler)
            workers = sum(map(cpu_used, [cluster.workers, *descendants(cluster.workers)]))
            where = (
                f"driver {ended.cpu:.1f} s, scheduler {scheduler:.1f} s, workers with their nannies {workers:.1f} s"
            )
        after = os.times()
        cpu = after.children_user + after.children_system - before.children_user - before.children_system
    else:
        ended = fly_campaign(plan, folder / "local", "--jobs", "2")
        cpu = ended.cpu
    parts = (folder / ("dask" if dask else "local")).glob("store/flights/*/*.json")
    inside = [json.loads(path.read_bytes())["made"]["cpu_s"] for path in parts]
    kind, flown = "dask" if dask else "local", sum(inside)
    yield f"{kind}, 2 workers, {len(inside)} flights: {flown:.1f} CPU s in flights, {cpu:.1f} in all processes"
    yield f"  CPU efficiency {flown / cpu:.3f}; {mean(inside) * 1e3:.0f} ms a flight; wall {ended.seconds:.0f} s"
    if where:
        yield f"  {where}"


def resume(folder: Path, flights: int) -> Iterator[str]:
    """Measure the time of the command for a plan whose flights are all stored."""
    path = write_plan_file(folder, str(flights))
    tasks = read_plan(path).tasks(keep_logs="none")
    store = ResultStore(folder / "out" / "store", sync=False)
    with store:
        first = next(tasks)
        result = perform_task(first)
        store.put(first.key, *stored(first, result))
        for task in tasks:  # the numbers of one flight for all: only their storage counts here
            store.put(task.key, *stored(task, result))
    for what in ("table and page made", "table and page there"):
        ended = fly_campaign(path, folder / "out", "--jobs", "2")
        times = f"{ended.seconds:.1f} s of wall time, {ended.cpu:.1f} s of CPU"
        yield f"resume with {flights:,} stored, {what}: {times}; exit code {ended.code}"


def driver_memory(folder: Path, tasks: int) -> Iterator[str]:
    """Measure the memory of a driver while it performs tasks without flights in two processes and keeps them."""
    store = ResultStore(folder / "stubs", sync=False)
    samples: list[tuple[int, float]] = []
    watch = Watch(tasks, "none")

    def sampled() -> Iterator[Stub]:
        for number, task in enumerate(stubs(tasks)):
            if number % max(tasks // 8, 1) == 0:
                samples.append((number, memory(os.getpid())))
            yield task

    begun, cpu = time.monotonic(), time.process_time()
    with open_fleet(2) as fleet, store:
        fly_missing(sampled(), act, stub_outcome, store, fleet, watch)
    samples.append((tasks, memory(os.getpid())))
    yield f"driver memory, {tasks:,} tasks: " + ", ".join(f"{size:.0f} MB at {n:,}" for n, size in samples)
    seconds, used = time.monotonic() - begun, time.process_time() - cpu
    yield f"  {used / tasks * 1e3:.2f} ms of the driver's CPU a task, {tasks / seconds:,.0f} tasks a second"


# Measured (docs/scale.md): the driver's time for a flight, most of which it waits for the disk, and the flights.
DRIVER_SECONDS = 0.0085
FLIGHT_SECONDS = 1.0
_AHEAD = 3  # tasks submitted for each worker, as on a cluster


@dataclass(frozen=True, slots=True)
class Simulated:
    """The hours of a campaign, the share of the workers' time that they fly, and the most tasks in memory."""

    hours: float
    busy: float
    most_in_memory: int


def simulate_campaign(flights: int, workers: int, driver_seconds: float, flight_seconds: float) -> Simulated:
    """Simulate one driver that submits, takes and keeps results one by one, and its workers.

    Flights last 0.5 to 1.5 times the mean, uniformly. The window of tasks is that of the fleet on a cluster.
    """
    draw = random.Random(1).random
    window = _AHEAD * workers
    ended: list[float] = []  # of flights that the driver has not taken, in time
    free = [0.0] * workers
    flown = driver = total = 0.0
    submitted = taken = most = 0
    while taken < flights:
        while submitted < flights and submitted - taken < window:
            seconds = flight_seconds * (0.5 + draw())
            begun = max(heappop(free), driver)
            heappush(free, begun + seconds)
            heappush(ended, begun + seconds)
            flown += seconds
            submitted += 1
            most = max(most, submitted - taken)
        driver = max(driver, heappop(ended)) + driver_seconds
        taken += 1
    total = max(driver, max(free))
    return Simulated(total / 3600.0, flown / (workers * total), most)


def schedules(_: Path, flights: int) -> Iterator[str]:
    """Simulate one driver with more and more workers, and the shards that a hundred million flights need."""
    yield f"{DRIVER_SECONDS * 1e3:g} ms of the driver a flight, {FLIGHT_SECONDS:g} s a flight"
    for workers in (2, 16, 64, 100, 128, 256):
        found = simulate_campaign(flights, workers, DRIVER_SECONDS, FLIGHT_SECONDS)
        yield (
            f"  {flights:,} flights, {workers} workers: {found.hours:,.1f} h, workers busy {found.busy:.1%}, "
            f"{found.most_in_memory} tasks in memory"
        )
    # The shards of a campaign do not meet, so that one of them shows what each of them does.
    part = simulate_campaign(1_000_000, 100, DRIVER_SECONDS, FLIGHT_SECONDS)
    yield f"  100,000,000 flights, 100 shards of 100 workers: {part.hours:,.1f} h, workers busy {part.busy:.1%}"
