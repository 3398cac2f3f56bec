"""Measure the CPU time of whole commands in new processes, relative to JSBSim alone and to an older checkout."""

import os
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from resource import RUSAGE_CHILDREN, getrusage
from tempfile import TemporaryDirectory

from pitotbench.evidence.speed.flight_overhead import bare_time
from pitotbench.logbook import read_log
from pitotbench.records.case_file import read_case
from pitotbench.records.integration import USUAL_RATE

HERE = Path(__file__).resolve().parents[3]  # the folder on Python's path that holds this package
DEMO = ("campaign", "--maneuver", "step_decrease", "--das", "20/1")
EVERYTHING = ("campaign", "--maneuver", "all", "--das", "all", "--model", "all")
PLAN = (
    *("plan", "--das", "20/1", "--turbulence", "light", "--wind-kt", "15", "--speeds-kt", "100,160"),
    *("--minutes", "6", "--want-kt", "0.1", "--box-nm", "10"),
)
_GAP = 'maneuver = "step_decrease"\n[[effects]]\nname = "induced_drag"\nparameters = { factor = 0.01 }\n'
STARTS = {
    "import numpy": ("-c", "import numpy"),
    "import pitotbench": ("-c", "import pitotbench"),
    "pitotbench --help": ("-m", "pitotbench", "--help"),
    "pitotbench --version": ("-m", "pitotbench", "--version"),
}
_START = "import sys; from pitotbench.cli import main; sys.exit(main())"  # older code has no `python -m pitotbench`
_TRIES = 5


def cpu_seconds_of_command(arguments: Sequence[str], source: Path = HERE, cache: Path | None = None) -> float:
    """Return the CPU time [s] of a new Python process with these arguments and of its workers, on one thread.

    `source` is the folder of the package that it imports, `cache` the folder of its cache, if not the usual one.
    Raises CalledProcessError where the process fails.
    """
    before = getrusage(RUSAGE_CHILDREN)
    environment = {**os.environ, "PYTHONPATH": str(source), "OPENBLAS_NUM_THREADS": "1"}
    environment |= {"PITOTBENCH_CACHE": str(cache)} if cache else {}
    subprocess.run([sys.executable, *arguments], env=environment, check=True, capture_output=True)
    after = getrusage(RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def start_lines() -> Iterator[str]:
    """Measure what it costs to start; yield a line for each command."""
    for name, arguments in STARTS.items():
        least = min(cpu_seconds_of_command(arguments) for _ in range(_TRIES))
        yield f"{name:<54} {least:6.2f} s{'' if 'numpy' in name else ' (limit 0.30 s)'}"


def campaign_lines(older: Path | None = None, pairs: int = 1) -> Iterator[str]:
    """Measure the two campaigns of the README in one process each; yield a line for each.

    `older` is the folder of the package of an older checkout, flown in turn with this one.
    """
    for name, arguments, limit in (("demo", DEMO, 3.5), ("everything, one seed", EVERYTHING, 2.2)):
        with TemporaryDirectory() as folder:
            # A folder a run: a campaign does not fly again what its folder holds.
            command = ("-c", _START, *arguments, "--jobs", "1", "--out")
            now, before = [], []
            for pair in range(pairs):
                before += [cpu_seconds_of_command((*command, f"{folder}/older{pair}"), older)] if older else []
                now.append(cpu_seconds_of_command((*command, f"{folder}/out{pair}")))
            bare = bare_loops(Path(folder, "out0"))
        measured = f"{min(now):.1f} s / {bare:.2f} s"
        yield f"{name + ', CPU / bare loops':<54} {min(now) / bare:6.2f}   (limit {limit:.2f}; {measured})"
        if before:
            ratio, then = min(before) / min(now), f"{min(before):.1f} s / {bare:.2f} s"
            yield f"{name + ', CPU of the older checkout / this':<54} {ratio:6.2f}   ({then})"


def bare_loops(results: Path) -> float:
    """Return the CPU time [s] of bare JSBSim loops as long as the flights of a campaign's folder."""
    total = 0.0
    for file in sorted(results.glob("cases/*.toml")):
        log = read_log(next(results.glob(f"logs/{file.stem}-*.parquet")))
        case = replace(read_case(file), effects=())
        total += min(bare_time(case, round(float(log.time[-1]) * USUAL_RATE)) for _ in range(2))
    return total


def plan_lines(older: Path | None = None) -> Iterator[str]:
    """Measure the plan of the README; yield a line."""
    with TemporaryDirectory() as folder:
        for name, source in _sources(older):
            seconds = cpu_seconds_of_command(("-c", _START, *PLAN, "--out", f"{folder}/{name}"), source)
            yield f"{'plan, flags of the README, ' + name:<54} {seconds:6.1f} s"


def study_lines(older: Path | None = None) -> Iterator[str]:
    """Measure the study of the paper's claims with one seed; yield a line."""
    with TemporaryDirectory() as folder:
        for name, source in _sources(older):
            script = str(source.parent / "scripts" / "reproduce_study.py")
            command = (script, "--claims-only", "--jobs", "1", "--out", f"{folder}/{name}")
            yield f"{'study, claims only, ' + name:<54} {cpu_seconds_of_command(command, source):6.1f} s"


def reconcile_lines(older: Path | None = None) -> Iterator[str]:
    """Measure the reconciliation of one log with an empty cache and with a filled one; yield a line for each.

    The log has one wrong number of the model, which is found. The older checkout flies it: older code reads no
    header of this one.
    """
    with TemporaryDirectory() as folder:
        case, log = Path(folder, "case.toml"), str(Path(folder, "log.csv"))
        case.write_text(_GAP, encoding="utf-8")
        cpu_seconds_of_command(("-c", _START, "fly", str(case), "-o", log), older or HERE)
        for name, source in _sources(older):
            cache = Path(folder, f"cache-{name}")
            for state in ("cold", "warm"):
                command = ("-c", _START, "reconcile", log, "--out", f"{folder}/{name}-{state}")
                seconds = cpu_seconds_of_command(command, source, cache)
                yield f"{f'reconcile one log, {state}, {name}':<54} {seconds:6.1f} s"


def _sources(older: Path | None) -> Iterator[tuple[str, Path]]:
    if older:
        yield "older", older
    yield "this", HERE


COMPARED: dict[str, Callable[[Path | None], Iterator[str]]] = {
    "campaigns": campaign_lines,
    "reconcile": reconcile_lines,
    "plan": plan_lines,
    "study": study_lines,
}
