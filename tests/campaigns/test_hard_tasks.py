"""A task that crashes, hangs or eats memory is put in quarantine, and takes no other task with it."""

import os
import signal
import subprocess
import sys
import time
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

import pytest
from tests.campaigns.hard_tasks import Stub, act

from pitotbench.campaigns import fleet as fleet_module
from pitotbench.campaigns.fleet import Fleet, FleetLostError, Limits, open_fleet

LIMITS = Limits(seconds=1.0, memory=1_000_000_000)


def keys(count):
    return [Stub(f"{number:02d}") for number in range(count)]


QUARANTINED = {  # its reason, and what its trace holds
    "crash": ("its process ended (signal 6), twice", "the simulator fell over"),
    "exit": ("its process ended (exit code 1), twice", ""),
    "hang": ("it took longer than its limit of 1 s, twice", "in act"),
    "eat": ("it needs more than its limit of 1 GB of memory", ""),
}


@pytest.fixture(scope="module")
def performed(tmp_path_factory):
    """Good tasks around one of every bad kind, performed by two processes."""
    notes = str(tmp_path_factory.mktemp("notes"))
    bad = [
        *(Stub(deed, "eat 3" if deed == "eat" else deed) for deed in QUARANTINED),
        Stub("once", "crash-once", notes),
    ]
    tasks = [*keys(6), *bad, *keys(12)[6:]]
    with open_fleet(2, limits=LIMITS) as fleet:
        return dict(zip([task.key for task in tasks], fleet.perform(act, tasks), strict=True))


@pytest.mark.parametrize("deed", list(QUARANTINED))
def test_a_bad_task_is_in_quarantine_with_its_reason_and_its_trace_and_all_others_are_done(
    performed, deed
):
    if deed == "eat" and sys.platform != "linux":
        pytest.skip("the limit of data is enforced on Linux")
    assert_quarantined(performed[deed], deed)
    assert {key for key in performed if performed[key] == key} == {
        *(stub.key for stub in keys(12)),
        "once",
    }


def assert_quarantined(failure, deed):
    reason, trace = QUARANTINED[deed]
    assert failure.quarantined
    assert failure.reason.startswith(reason)
    assert trace in failure.trace
    if deed == "crash":
        assert "hard_tasks.py" in failure.trace  # where it was, from the handler of faults


class KilledWorker(Exception):  # noqa: N818 (the name is the interface)
    """As dask's: it says neither why the worker died nor what it wrote."""


class ClusterOfThreads(ThreadPoolExecutor):
    """An executor whose workers die of every task with a deed, as those of a cluster do."""

    def submit(self, each, how, work, limits, tasks):
        if how is not fleet_module.attempt or not any(task[1].deed for task in tasks):
            return super().submit(each, how, work, limits, tasks)
        future = Future()
        future.set_exception(KilledWorker("died"))
        return future


def test_a_cluster_that_does_not_say_why_a_worker_died_is_asked_again_in_a_process_of_its_own():
    bad = [Stub("crash", "crash"), Stub("hang", "hang")]
    with ClusterOfThreads(2) as cluster:
        fleet = Fleet(cluster, LIMITS, own_process=True)
        first, *failures, last = fleet.perform(act, [Stub("1"), *bad, Stub("2")])
    assert (first, last) == ("1", "2")
    for failure, stub in zip(failures, bad, strict=True):
        assert_quarantined(failure, stub.deed)


def test_what_shared_a_call_with_a_task_that_crashes_is_performed_alone_and_is_no_failure():
    tasks = [Stub("1"), Stub("2"), Stub("3"), Stub("crash", "crash"), Stub("4")]
    with ClusterOfThreads(2) as cluster:
        fleet = Fleet(cluster, LIMITS, window=1, own_process=True, bundle=1e3)
        *done, crash, last = fleet.perform(act, tasks)
    assert [*done, last] == ["1", "2", "3", "4"]
    assert_quarantined(crash, "crash")


def test_the_limits_do_not_hold_in_the_process_of_the_driver():
    with open_fleet(1, limits=Limits(seconds=0.05)) as fleet:
        assert fleet.perform(act, [Stub("slow", "sleep 0.2")]) == ["slow"]


def test_a_plan_is_read_only_as_far_as_it_is_flown():
    read = []

    def endless():
        for number in range(10**9):
            read.append(number)
            yield Stub(str(number))

    with ThreadPoolExecutor(2) as pool:
        stream = Fleet(pool, window=4).stream(act, endless())
        assert [next(stream)[1] for _ in range(5)]
        assert len(read) <= 5 + 4
        stream.close()


def test_workers_that_cannot_work_at_all_stop_the_fleet(monkeypatch):
    monkeypatch.setattr(fleet_module, "MOST_LOST_AT_FIRST", 2)
    with open_fleet(2) as fleet, pytest.raises(FleetLostError, match="no worker can work"):
        fleet.perform(os._exit, [3] * 30)


DRIVER = """
import sys, time
from pitotbench.campaigns.fleet import open_fleet
from tests.campaigns.hard_tasks import Stub, act
if __name__ == "__main__":
    with open_fleet(2) as fleet:
        workers = fleet.executor._workers
        pids = lambda step=0: print(*(w.process.pid for w in workers), flush=True)
        fleet.perform(act, [Stub("a"), Stub("b"), Stub("c", "hang"), Stub("d", "hang")], pids)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGKILL")
def test_no_process_is_left_when_the_driver_is_killed(tmp_path):
    script = tmp_path / "driver.py"
    script.write_text(DRIVER)
    root = Path(__file__).parents[2]
    path = os.pathsep.join([str(root), str(root / "src")])
    with subprocess.Popen(
        [sys.executable, str(script)],
        stdout=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONPATH": path},
    ) as driver:
        driver.stdout.readline()
        workers = [int(pid) for pid in driver.stdout.readline().split()]
        assert len(workers) == 2
        driver.kill()
    limit = time.monotonic() + 5.0
    while any(map(alive, workers)) and time.monotonic() < limit:
        time.sleep(0.05)
    assert not [pid for pid in workers if alive(pid)]


def alive(pid):
    """Whether a process still runs; one that has ended and was not yet collected does not."""
    try:
        os.kill(pid, 0)
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except (ProcessLookupError, FileNotFoundError):
        return False


def test_a_killed_worker_costs_no_result():
    with open_fleet(2) as fleet:
        done = []

        def kill_one():
            if not done:
                os.kill(fleet.executor._workers[-1].process.pid, signal.SIGKILL)
            done.append(1)

        results = fleet.perform(act, [Stub(f"{n}", "sleep 0.1") for n in range(8)], kill_one)
    assert results == [f"{n}" for n in range(8)]


class CountingThreads(ThreadPoolExecutor):
    """An executor that counts its calls."""

    calls = 0

    def submit(self, *call):
        self.calls += 1
        return super().submit(*call)


def test_short_tasks_share_a_call_and_long_ones_have_one_each():
    tasks = [Stub(f"{number:03d}", "sleep 0.01") for number in range(120)]
    with CountingThreads(2) as cluster:
        done = [task.key for task, _ in Fleet(cluster, window=4, bundle=0.1).stream(act, tasks)]
        assert cluster.calls < 60
    assert sorted(done) == [task.key for task in tasks]
    with CountingThreads(2) as cluster:
        Fleet(cluster, window=4, bundle=0.1).perform(
            act, [Stub(str(number), "sleep 0.11") for number in range(8)]
        )
        assert cluster.calls == 8
