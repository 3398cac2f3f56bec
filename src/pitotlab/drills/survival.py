"""What a campaign survives: kills, a request to stop, bad flights, bad stores, a second driver,
full disks.
"""

import json
import os
import random
import signal
import subprocess
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from pitotbench.campaigns.campaign import Watch, fly_missing
from pitotbench.campaigns.fleet import Fleet, Limits, open_fleet
from pitotbench.campaigns.store import INDEX, OWNER, ResultStore
from pitotlab.drills import drivers

TABLE = "results.parquet"


def kill_drivers(folder: Path, flights: int, kills: int = 10) -> Iterator[str]:
    """Kill the driver at random moments, go on each time; compare with an undisturbed campaign."""
    plan = drivers.write_plan_file(folder, str(flights))
    drivers.fly_campaign(plan, folder / "whole", "--jobs", "2")
    out, lucky = folder / "killed", random.Random(15)
    moments = sorted(lucky.sample(range(1, flights), kills))
    left = lost = 0
    for number, moment in enumerate(moments):
        driver = drivers.start(plan, out, "--jobs", "2")
        # Every second moment is soon after the start, while the workers are still starting.
        if number % 2:
            time.sleep(lucky.uniform(2.0, 8.0))
        else:
            drivers.wait_for_parts(out, moment, driver)
        more_left, more_lost = drivers.kill(driver, out)
        left, lost = left + more_left, lost + (more_lost > 0)
    kept = drivers.stamps(out)
    last = drivers.fly_campaign(plan, out, "--jobs", "2")
    again = drivers.flown_again(out, kept)
    same = drivers.digest(out / TABLE) == drivers.digest(folder / "whole" / TABLE)
    yield f"driver killed with -9 {kills} times, {flights} flights; {len(kept)} were stored after the last"
    yield f"  table identical to the undisturbed one: {same}; exit code {last.code}"
    yield f"  stored flights flown again: {again}; stored flights lost: {lost}; processes left after 5 s: {left}"


def fly_long(folder: Path, flights: int, kills: int = 3) -> Iterator[str]:
    """Fly a long campaign with one worker, kill its driver on the way; say what was lost."""
    plan = drivers.write_plan_file(folder, str(flights))
    out, highest = folder / "long", 0.0
    for number in range(1, kills + 1):
        driver = drivers.start(plan, out, "--jobs", "1")
        while driver.poll() is None and drivers.parts(out) < number * flights // (kills + 1):
            highest = max(highest, drivers.memory(driver.pid))
            time.sleep(2.0)
        before = drivers.parts(out)
        left, lost = drivers.kill(driver, out)
        yield f"kill {number} at {before:,} flights: {left} processes left after 5 s, {lost} stored flights lost"
    kept = drivers.stamps(out)
    last = drivers.fly_campaign(plan, out, "--jobs", "1")
    again = drivers.flown_again(out, kept)
    documents = [json.loads(path.read_bytes()) for path in drivers.parts_of(out)]
    states = Counter(document["state"] for document in documents)
    reasons = Counter(
        text.partition(": ")[2] for document in documents for text in document["failures"]
    )
    yield f"{flights:,} flights: exit code {last.code}; {dict(states)}; stored flights flown again: {again}"
    yield from (f"  {count:,} × {reason}" for reason, count in reasons.most_common(5))
    spent = sum(document["made"]["cpu_s"] for document in documents)
    yield f"  {spent / 60.0:.0f} CPU min in flights; the driver's memory at most {highest:.0f} MB"


def kill_workers(folder: Path, flights: int) -> Iterator[str]:
    """Kill one worker in the middle of a campaign, of the local pool and of a dask cluster."""
    plan = drivers.write_plan_file(folder, str(flights))
    drivers.fly_campaign(plan, folder / "whole", "--jobs", "2")
    driver = drivers.start(plan, folder / "local", "--jobs", "2")
    begun = time.monotonic()
    drivers.wait_for_parts(folder / "local", flights // 3, driver)
    os.kill(_workers(driver.pid)[0], signal.SIGKILL)
    yield _compared("local", folder, drivers.finish(driver, begun).code)
    with drivers.dask_cluster() as cluster:
        driver = drivers.start(plan, folder / "dask", "--scheduler", cluster.address)
        begun = time.monotonic()
        drivers.wait_for_parts(folder / "dask", flights // 3, driver)
        os.kill(_workers(cluster.workers)[0], signal.SIGKILL)
        yield _compared("dask", folder, drivers.finish(driver, begun).code)


def stop_drivers(folder: Path, flights: int) -> Iterator[str]:
    """Send SIGTERM and SIGINT in a campaign; measure the time until the prompt is back."""
    plan = drivers.write_plan_file(folder, str(flights))
    # A shell has what it starts in the background ignore Ctrl-C, and drivers would inherit that.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    for name in ("SIGTERM", "SIGINT"):
        driver = drivers.start(plan, folder / name, "--jobs", "2")
        drivers.wait_for_parts(folder / name, 3, driver)
        begun = time.monotonic()
        driver.send_signal(getattr(signal, name))
        ended = drivers.finish(driver, begun)
        yield f"{name}: prompt after {ended.seconds:.1f} s, exit code {ended.code}: {ended.said}"


def _workers(pid: int) -> list[int]:
    """Return the processes below a process that are neither a tracker of resources nor a nanny."""
    return [
        p
        for p in drivers.descendants(pid)
        if b"spawn_main" in Path(f"/proc/{p}/cmdline").read_bytes()
    ]


def _compared(kind: str, folder: Path, code: int) -> str:
    same = drivers.digest(folder / kind / TABLE) == drivers.digest(folder / "whole" / TABLE)
    stored = drivers.parts(folder / kind)
    return (
        f"worker killed with -9, {kind}: exit code {code}, {stored} flights stored, table "
        f"identical: {same}"
    )


LIMITS = Limits(seconds=5.0, memory=2_000_000_000)
BAD = ("crash", "hang", "eat 6")


def bad_flights(folder: Path) -> Iterator[str]:
    """Perform good tasks around one that crashes, one that hangs and one that eats memory."""
    with open_fleet(2, limits=LIMITS) as fleet:
        yield from _bad("local", folder / "local", fleet)
    with (
        drivers.dask_cluster() as cluster,
        open_fleet(scheduler=cluster.address, limits=LIMITS) as fleet,
    ):
        yield from _bad("dask", folder / "dask", fleet)


def _bad(kind: str, folder: Path, fleet: Fleet) -> Iterator[str]:
    good = [*drivers.stubs(40)]
    tasks = [
        *good[:20],
        *(drivers.Stub(f"ff{number}", deed) for number, deed in enumerate(BAD)),
        *good[20:],
    ]
    with ResultStore(folder) as store:
        fly_missing(
            tasks, drivers.act, drivers.stub_outcome, store, fleet, Watch(len(tasks), "none")
        )
        done = sum((store.find(task.key) or {}).get("state") == "done" for task in good)
        yield f"bad flights, {kind}: {done} of {len(good)} others done"
        for task in tasks:
            document = store.find(task.key) or {}
            if task.deed:
                lines = len(document["trace"].splitlines())
                yield f"  {document['state']}: {document['failures'][0]} (log of {lines} lines)"


def bad_stores(folder: Path, flights: int = 12) -> Iterator[str]:
    """Cut, fill, lock and age a store, and give the same command again."""
    plan = drivers.write_plan_file(folder, str(flights))
    out = folder / "out"
    drivers.fly_campaign(plan, out, "--jobs", "2")
    whole = drivers.digest(out / "results.parquet")

    def again(what: str, *flags: str) -> str:
        before = drivers.stamps(out)
        ended = drivers.fly_campaign(plan, out, "--jobs", "2", *flags)
        flown = len(set(drivers.stamps(out).items()) - set(before.items()))
        same = drivers.digest(out / "results.parquet") == whole
        stored = drivers.parts(out)
        return (
            f"{what}: exit code {ended.code}, {flown} flown again, {stored} stored, table "
            f"identical: {same}"
        )

    first = drivers.parts_of(out)[0]
    first.write_bytes(first.read_bytes()[:100])
    yield again("cut part")
    first.write_bytes(first.read_bytes().replace(b'"minutes": ', b'"minutes": 1', 1))
    yield again("changed number")
    first.write_bytes(first.read_bytes().replace(b'"failures"', b'"other"', 1))
    yield again("part without a field")
    (out / "store" / INDEX).write_bytes(b"PAR1 cut")
    yield f"cut index: {_listed(out)}"
    for path in (out / "store").rglob("*"):
        os.utime(path, (time.time() + 86400.0 * 400, time.time() + 86400.0 * 400))
    (out / "store" / OWNER).write_text(
        json.dumps({"host": "old", "process": 1, "since": time.time() + 1e7})
    )
    yield again("clock set back by 400 days, lock of a dead owner")
    document = json.loads(first.read_bytes())
    first.write_text(
        json.dumps(document | {"made": document["made"] | {"code": "other"}, "key": "0" * 32})
    )
    first.rename(first.with_name("0" * 32 + ".json"))
    yield again("a part of other code")


def second_driver(folder: Path) -> Iterator[str]:
    """Start a second driver on a store that another one writes."""
    plan = drivers.write_plan_file(folder, "60")
    driver = drivers.start(plan, folder / "out", "--jobs", "1")
    drivers.wait_for_parts(folder / "out", 1, driver)
    second = drivers.fly_campaign(plan, folder / "out", "--jobs", "1")
    yield f"second driver: exit code {second.code}: {second.said}"
    driver.terminate()
    drivers.finish(driver, 0.0)


def full_disks(folder: Path) -> Iterator[str]:
    """Fly into a disk that is full, then make room; fly into one that cannot be written."""
    plan = drivers.write_plan_file(folder, "30")
    with _disk(folder / "disk", "size=100k") as disk:
        ended = drivers.fly_campaign(plan, disk / "out", "--jobs", "2")
        yield f"disk full: exit code {ended.code}, {drivers.parts(disk / 'out')} stored: {ended.said[:150]}"
        kept = drivers.parts(disk / "out")
        _mount("-o", "remount,size=20m", str(disk))
        ended = drivers.fly_campaign(plan, disk / "out", "--jobs", "2")
        now = drivers.parts(disk / "out")
        yield f"  after room was made: exit code {ended.code}, {now} stored, {kept} of them before"
        _mount("-o", "remount,ro", str(disk))
        ended = drivers.fly_campaign(
            drivers.write_plan_file(folder, "31"), disk / "out", "--jobs", "2"
        )
        yield f"read-only store: exit code {ended.code}, {drivers.parts(disk / 'out')} stored: {ended.said[:150]}"


@contextmanager
def _disk(place: Path, options: str) -> Iterator[Path]:
    place.mkdir(parents=True, exist_ok=True)
    _mount("-t", "tmpfs", "-o", options, "tmpfs", str(place))
    try:
        yield place
    finally:
        subprocess.run(["umount", str(place)], check=True)


def _mount(*arguments: str) -> None:
    subprocess.run(["mount", *arguments], check=True)  # needs the rights of an administrator


def _listed(out: Path) -> str:
    from pitotbench.campaigns.result_table import result_table

    return f"{len(result_table([out]))} rows listed from the parts"
