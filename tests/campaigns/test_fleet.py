"""The fleet: results in the order of the tasks, failures in words; a worker that differs is refused
by name.
"""

import os
import subprocess
import sys
import time
from dataclasses import replace
from multiprocessing import current_process

import pytest

from pitotbench.campaigns.cluster import Host, check_hosts, open_cluster
from pitotbench.campaigns.fleet import Failure, open_fleet, require_all, run_tasks
from pitotbench.campaigns.progress import progress
from pitotbench.records import BadInputError, NoAnswerError


class StubbornError(Exception):
    """An error that cannot be rebuilt from its text in another process."""

    def __init__(self, one, other):
        super().__init__(f"{one} and {other}")


def later(seconds):
    time.sleep(seconds)
    return seconds


def half(number):
    if number == 2:
        raise BadInputError("two is not halved")
    if number == 3:
        raise StubbornError("one", "two")
    return number / 2


def after_a_while(number):
    """The first of the tasks ends last."""
    time.sleep(0.4 if number == 1 else 0.0)
    return half(number)


def threads(number):
    return os.environ.get("OPENBLAS_NUM_THREADS")


def process(number):
    return os.getpid()


@pytest.mark.parametrize("jobs", [1, 2])
def test_results_come_in_the_order_of_the_tasks_and_a_failed_one_is_a_failure_in_words(jobs):
    steps = []
    tasks = [1, 2, 3, 4]
    first, refused, stubborn, last = run_tasks(
        after_a_while, tasks, jobs, step=lambda: steps.append(None)
    )
    assert (first, last) == (0.5, 2.0)
    assert refused == Failure("two is not halved", BadInputError)
    assert stubborn.reason == "StubbornError: one and two"
    assert "in half" in stubborn.trace
    assert len(steps) == 4
    assert run_tasks(half, [], jobs) == []


def test_the_first_failure_is_raised_where_all_results_are_required():
    assert require_all([1, 2]) == [1, 2]
    with pytest.raises(NoAnswerError, match="too few"):
        require_all([1, Failure("too few", NoAnswerError), Failure("bad", BadInputError)])
    with pytest.raises(RuntimeError, match="ZeroDivisionError"):
        require_all([Failure.of(ZeroDivisionError("by zero"))])


def test_a_spawned_process_computes_with_one_thread(monkeypatch):
    monkeypatch.delenv("OPENBLAS_NUM_THREADS", raising=False)
    assert run_tasks(threads, [1, 2], jobs=2) == ["1", "1"]
    assert "OPENBLAS_NUM_THREADS" not in os.environ


def test_a_process_that_may_start_no_other_does_the_work_itself(monkeypatch):
    """A worker of a multiprocessing.Pool is such a process: a reconciliation in one waited for
    ever.
    """
    monkeypatch.setitem(current_process()._config, "daemon", True)
    assert run_tasks(process, [1, 2], jobs=2) == [os.getpid(), os.getpid()]


def test_an_interrupt_does_not_wait_for_the_tasks_that_have_not_begun():
    begun = time.monotonic()

    def interrupt():
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt), open_fleet(2) as two:
        two.perform(later, [0.0] + [2.0] * 40, interrupt)
    assert time.monotonic() - begun < 30.0  # all of them take 40 s


@pytest.mark.parametrize(
    ("label", "said"),
    [("flying", "pitotbench: flying: 2 of 1,200\npitotbench: flying: 4 of 1,200\n"), ("", "")],
)
def test_without_a_terminal_a_line_says_how_far_the_work_is(label, said, monkeypatch, capsys):
    """At most one line in 20 s: the tasks end 5, 21, 30 and 45 s after the begin."""
    clock = iter([0.0, 5.0, 21.0, 21.0, 30.0, 45.0, 45.0])
    monkeypatch.setattr("pitotbench.campaigns.progress.monotonic", lambda: next(clock))
    with progress(label, 1200) as advance:
        for _ in range(4):
            advance()
    assert capsys.readouterr().err == said


UNGUARDED = """
from pitotbench.campaigns.fleet import run_tasks
print(run_tasks(abs, [1, 2, 3], 2))
"""


def test_a_script_without_a_guard_ends_at_once_and_is_told_the_line_it_lacks(tmp_path):
    script = tmp_path / "script.py"
    command = [sys.executable, script]
    script.write_text(UNGUARDED, encoding="utf-8")
    ended = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert ended.returncode == 1
    lacked = 'if __name__ == "__main__":'
    assert ended.stderr.splitlines()[-1].endswith(lacked)
    script.write_text(UNGUARDED.replace("print", f"{lacked}\n    print"), encoding="utf-8")
    assert subprocess.check_output(command, text=True, timeout=60) == "[1, 2, 3]\n"


HERE = Host({"python": "3.11.7", "jsbsim": "1.3.3"}, "c0de")


@pytest.mark.parametrize(
    ("worker", "says"),
    [
        (
            replace(HERE, versions={"python": "3.11.7", "jsbsim": "1.2.0"}),
            "jsbsim 1.2.0, the driver has 1.3.3",
        ),
        (replace(HERE, code="other"), "worker b has other code"),
        (
            ModuleNotFoundError("No module named 'pitotbench'"),
            "worker b cannot fly: ModuleNotFoundError",
        ),
    ],
)
def test_a_worker_that_differs_is_refused_by_name(worker, says):
    check_hosts(HERE, {"a": HERE, "b": replace(HERE)})
    with pytest.raises(BadInputError, match=says):
        check_hosts(HERE, {"a": HERE, "b": worker})


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (None, "asks for certificates: give --security FILE"),
        ("ca = 1", "paths ca, cert and key"),
        ('ca = "a"\ncert = "b"\nkey = "c"', "No such file"),
    ],
)
def test_a_missing_or_wrong_security_file_is_refused_by_name(tmp_path, text, says):
    pytest.importorskip("distributed", reason="dask.distributed is an extra")
    file = tmp_path / "tls.toml"
    file.write_text(text or "")
    with (
        pytest.raises(BadInputError, match=says),
        open_cluster("tls://127.0.0.1:1", text and file),
    ):
        pass
