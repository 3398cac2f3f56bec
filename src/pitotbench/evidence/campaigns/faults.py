"""What a campaign survives: bad flights, bad disks, bad clocks, and a second driver."""

import json
import os
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from pitotbench.bench.campaign.engine import fly_missing
from pitotbench.bench.campaign.watching import Watch
from pitotbench.bench.fleet import Fleet, Limits, open_fleet
from pitotbench.bench.store import INDEX, OWNER, ResultStore
from pitotbench.evidence.campaigns.drivers import (
    dask_cluster,
    digest,
    finish,
    fly_campaign,
    parts,
    start,
    wait_for_parts,
    write_plan_file,
)
from pitotbench.evidence.campaigns.stubs import Stub, act, stub_outcome, stubs

LIMITS = Limits(seconds=5.0, memory=2_000_000_000)
BAD = ("crash", "hang", "eat 6")


def bad_flights(folder: Path) -> Iterator[str]:
    """Perform good tasks around one that crashes, one that hangs and one that eats memory."""
    with open_fleet(2, limits=LIMITS) as fleet:
        yield from _bad("local", folder / "local", fleet)
    with dask_cluster() as cluster, open_fleet(scheduler=cluster.address, limits=LIMITS) as fleet:
        yield from _bad("dask", folder / "dask", fleet)


def _bad(kind: str, folder: Path, fleet: Fleet) -> Iterator[str]:
    good = [*stubs(40)]
    tasks = [*good[:20], *(Stub(f"ff{number}", deed) for number, deed in enumerate(BAD)), *good[20:]]
    with ResultStore(folder) as store:
        fly_missing(tasks, act, stub_outcome, store, fleet, Watch(len(tasks), "none"))
        done = sum((store.find(task.key) or {}).get("state") == "done" for task in good)
        yield f"bad flights, {kind}: {done} of {len(good)} others done"
        for task in tasks:
            document = store.find(task.key) or {}
            if task.deed:
                lines = len(document["trace"].splitlines())
                yield f"  {document['state']}: {document['failures'][0]} (log of {lines} lines)"


def bad_stores(folder: Path, flights: int = 12) -> Iterator[str]:
    """Cut, fill, lock and age a store, and give the same command again."""
    plan = write_plan_file(folder, str(flights))
    out = folder / "out"
    fly_campaign(plan, out, "--jobs", "2")
    whole = digest(out / "results.parquet")

    def again(what: str, *flags: str) -> str:
        before = _stamps(out)
        ended = fly_campaign(plan, out, "--jobs", "2", *flags)
        flown = len(set(_stamps(out).items()) - set(before.items()))
        same = digest(out / "results.parquet") == whole
        return f"{what}: exit code {ended.code}, {flown} flown again, {parts(out)} stored, table identical: {same}"

    first = next((out / "store/flights").glob("*/*.json"))
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
    (out / "store" / OWNER).write_text(json.dumps({"host": "old", "process": 1, "since": time.time() + 1e7}))
    yield again("clock set back by 400 days, lock of a dead owner")
    document = json.loads(first.read_bytes())
    first.write_text(json.dumps(document | {"made": document["made"] | {"code": "other"}, "key": "0" * 32}))
    first.rename(first.with_name("0" * 32 + ".json"))
    yield again("a part of other code")


def _stamps(out: Path) -> dict[Path, int]:
    """Return when each part was written, by the clock of the disk [ns]."""
    return {path: path.stat().st_mtime_ns for path in (out / "store/flights").glob("*/*.json")}


def second_driver(folder: Path) -> Iterator[str]:
    """Start a second driver on a store that another one writes."""
    plan = write_plan_file(folder, "60")
    driver = start(plan, folder / "out", "--jobs", "1")
    wait_for_parts(folder / "out", 1, driver)
    second = fly_campaign(plan, folder / "out", "--jobs", "1")
    yield f"second driver: exit code {second.code}: {second.said}"
    driver.terminate()
    finish(driver, 0.0)


def full_disks(folder: Path) -> Iterator[str]:
    """Fly into a disk that is full after some flights, then make room; fly into one that cannot be written."""
    plan = write_plan_file(folder, "30")
    with _disk(folder / "disk", "size=300k") as disk:
        ended = fly_campaign(plan, disk / "out", "--jobs", "2")
        yield f"disk full: exit code {ended.code}, {parts(disk / 'out')} stored: {ended.said[:150]}"
        kept = parts(disk / "out")
        _mount("-o", "remount,size=20m", str(disk))
        ended = fly_campaign(plan, disk / "out", "--jobs", "2")
        yield f"  after room was made: exit code {ended.code}, {parts(disk / 'out')} stored, {kept} of them before"
        _mount("-o", "remount,ro", str(disk))
        ended = fly_campaign(write_plan_file(folder, "31"), disk / "out", "--jobs", "2")
        yield f"read-only store: exit code {ended.code}, {parts(disk / 'out')} stored: {ended.said[:150]}"


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
    from pitotbench.bench.result_table import result_table

    return f"{len(result_table([out]))} rows listed from the parts"
