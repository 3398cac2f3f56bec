"""A simulation of a campaign's driver and workers in their own time, at sizes that are not flown."""

import random
from collections.abc import Iterator
from dataclasses import dataclass
from heapq import heappop, heappush
from pathlib import Path

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
