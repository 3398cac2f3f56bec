"""Measure the CPU time of flights and of whole commands, relative to JSBSim alone."""

import os
import subprocess
import sys
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from math import inf
from os import devnull
from pathlib import Path
from resource import RUSAGE_CHILDREN, getrusage
from statistics import median
from tempfile import TemporaryDirectory
from time import process_time

from pitotbench.logbook.reading import read_log
from pitotbench.records.case import USUAL_RATE, Case
from pitotbench.records.case_file import read_case
from pitotbench.simulation.aircraft_files import ENGINES, SYSTEMS, library, load_fdm
from pitotbench.simulation.plant import Air, Plant
from pitotbench.simulation.sortie import fly
from pitotbench.units import KNOT

LEVEL_SPEED = 130.0 * KNOT  # m/s, of the bare loop
SHIPPED, SHIPPED_SPEED = "c172x", 100.0  # JSBSim's own airplane, and its speed [KCAS]


@dataclass(frozen=True, slots=True)
class Line:
    """A measured number; `limit` is the most it should be, `figure` its name on the page."""

    name: str
    value: float
    unit: str = ""
    limit: float = inf
    note: str = ""
    figure: str = ""

    @property
    def is_exceeded(self) -> bool:
        """Whether the number is above its limit."""
        return self.value > self.limit

    def __str__(self) -> str:
        limit = f"limit {self.limit:.2f}{self.unit}" if self.limit < inf else ""
        notes = "; ".join(part for part in (limit, self.note) if part)
        exceeded = "   exceeded" if self.is_exceeded else ""
        end = f"   ({notes}){exceeded}" if notes else ""
        return f"{self.name:<54} {self.value:6.2f}{self.unit}{end}"


@dataclass(frozen=True, slots=True)
class Ratio:
    """A ratio of CPU times: the least time over the least, and the ratios of the pairs."""

    least: float
    pairs: tuple[float, ...]

    def line(self, name: str, limit: float = inf) -> Line:
        """Return the line of this ratio."""
        spread = f"{min(self.pairs):.2f} to {max(self.pairs):.2f}, median {median(self.pairs):.2f}"
        return Line(name, self.least, "", limit, f"pairs {spread}")


def overhead_ratio(
    case: Case | None = None, pairs: int = 9, channels: Collection[str] | None = None
) -> Ratio:
    """Return the CPU time of a flight over that of a bare `run()` loop of as many steps.

    The flight includes the loading, the settling, the card, the channels asked for (by default all)
    at 100 Hz, and the arrays at the end.
    """
    case = case or Case(maneuver="step_decrease")
    times = []
    for _ in range(pairs):
        begun = process_time()
        flight = fly(case, channels=channels)
        flown = process_time() - begun
        times.append((flown, bare_time(case, round(float(flight["time"][-1]) * USUAL_RATE))))
    return _ratio(times)


def bare_time(case: Case, steps: int) -> float:
    """Return the CPU time [s] of JSBSim alone for steps of the case's aircraft in level flight."""
    plant = Plant.load(case.aircraft)
    plant.start(case.altitude, LEVEL_SPEED, air=Air.of(case))
    return _loop(plant.fdm.run, steps)


def step_ratio(rounds: int = 9, steps: int = 4000) -> Ratio:
    """Return the CPU time of a bare step of our airplane over that of one that JSBSim ships."""
    return _ratio([(bare_time(Case(), steps), _shipped_time(steps)) for _ in range(rounds)])


def _ratio(pairs: Sequence[tuple[float, float]]) -> Ratio:
    least_ours, least_theirs = map(min, zip(*pairs, strict=True))
    return Ratio(least_ours / least_theirs, tuple(a / b for a, b in pairs))


def _shipped_time(steps: int) -> float:
    """Return the CPU time [s] of steps of the airplane as JSBSim ships it, engine running."""
    parts = (library() / ENGINES, library() / SYSTEMS)
    fdm, _ = load_fdm(SHIPPED, library() / "aircraft" / SHIPPED, USUAL_RATE, parts)
    fdm["ic/h-sl-ft"], fdm["ic/vc-kts"], fdm["fcs/mixture-cmd-norm"] = 6000.0, SHIPPED_SPEED, 1.0
    fdm.set_output_filename(0, devnull)  # its file asks for a log, in the folder where it flies
    fdm.disable_output()
    fdm.run_ic()
    fdm["propulsion/set-running"] = -1
    fdm["fcs/throttle-cmd-norm"] = 0.7
    return _loop(fdm.run, steps)


def _loop(run: Callable[[], bool], steps: int) -> float:
    begun = process_time()
    for _ in range(steps):
        run()
    return process_time() - begun


HERE = Path(__file__).resolve().parents[2]  # the folder on Python's path that holds the product
DEMO = ("campaign", "--maneuver", "step_decrease", "--das", "20/1")
EVERYTHING = ("campaign", "--maneuver", "all", "--das", "all", "--model", "all")
STARTS = {
    "import numpy": ("-c", "import numpy"),
    "import pitotbench": ("-c", "import pitotbench"),
    "pitotbench --help": ("-m", "pitotbench", "--help"),
    "pitotbench --version": ("-m", "pitotbench", "--version"),
}
_TRIES = 5


def cpu_seconds_of_command(arguments: Sequence[str]) -> float:
    """Return the CPU time [s] of a new Python process with these arguments and of its workers, on
    one thread.

    Raises CalledProcessError where the process fails.
    """
    before = getrusage(RUSAGE_CHILDREN)
    environment = {**os.environ, "PYTHONPATH": str(HERE), "OPENBLAS_NUM_THREADS": "1"}
    command = [sys.executable, *arguments]
    subprocess.run(command, env=environment, check=True, capture_output=True)
    after = getrusage(RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def start_lines() -> Iterator[Line]:
    """Measure what it costs to start; yield a line for each command."""
    for name, arguments in STARTS.items():
        least = min(cpu_seconds_of_command(arguments) for _ in range(_TRIES))
        yield Line(name, least, " s", inf if "numpy" in name else 0.30)


def campaign_lines() -> Iterator[Line]:
    """Measure the campaigns of the README in one process each; yield a line for each."""
    for name, arguments, limit in (
        ("demo", DEMO, 5.5),
        ("everything, one seed", EVERYTHING, 3.5),
        ("everything, no report", (*EVERYTHING, "--no-report"), 2.8),
    ):
        with TemporaryDirectory() as folder:
            command = ("-m", "pitotbench", *arguments, "--jobs", "1", "--out", f"{folder}/out")
            seconds = cpu_seconds_of_command(command)
            bare = bare_loops(Path(folder, "out"))
        measured = f"{seconds:.1f} s / {bare:.2f} s"
        yield Line(f"{name}, CPU / bare loops", seconds / bare, "", limit, measured)


def bare_loops(results: Path) -> float:
    """Return the CPU time [s] of bare JSBSim loops as long as the flights of a campaign's folder."""
    total = 0.0
    for file in sorted(results.glob("cases/*.toml")):
        log = read_log(next(results.glob(f"logs/{file.stem}-*.parquet")))
        case = replace(read_case(file), effects=())
        total += min(bare_time(case, round(float(log.time[-1]) * USUAL_RATE)) for _ in range(2))
    return total


def least(work: Callable[[], object], tries: int = _TRIES) -> float:
    """Return the CPU time [s] of the fastest of some tries."""
    times = []
    for _ in range(tries):
        begun = process_time()
        work()
        times.append(process_time() - begun)
    return min(times)
