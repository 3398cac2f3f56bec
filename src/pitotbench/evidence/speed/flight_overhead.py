"""Measure the CPU time of flying and recording a card, relative to JSBSim alone."""

from collections.abc import Callable, Collection
from dataclasses import dataclass
from os import devnull
from statistics import median
from time import process_time

from pitotbench.records.case import Case
from pitotbench.records.integration import USUAL_RATE
from pitotbench.simulate.atmosphere import Air
from pitotbench.simulate.attach.library import ENGINES, SYSTEMS, library
from pitotbench.simulate.fdm import load_fdm
from pitotbench.simulate.plant import Plant
from pitotbench.simulate.sortie import fly
from pitotbench.units import KNOT

LEVEL_SPEED = 130.0 * KNOT  # m/s, of the bare loop
SHIPPED, SHIPPED_SPEED = "c172x", 100.0  # JSBSim's own airplane, and its speed in the bare loop [KCAS]


@dataclass(frozen=True, slots=True)
class Ratio:
    """A ratio of CPU times measured in pairs: the least time over the least, and the ratios of the pairs."""

    least: float
    pairs: tuple[float, ...]

    def __str__(self) -> str:
        spread = f"{min(self.pairs):.2f} to {max(self.pairs):.2f}, median {median(self.pairs):.2f}"
        return f"{self.least:6.2f}   pairs {spread}"


def overhead_ratio(case: Case | None = None, pairs: int = 9, channels: Collection[str] | None = None) -> Ratio:
    """Return the CPU time of a flight over that of a bare `run()` loop of as many steps.

    The flight includes the loading, the settling, the card, the channels asked for (by default all) at 100 Hz, and
    the arrays at the end.
    """
    case = case or Case(maneuver="step_decrease")
    flown, bare = [], []
    for _ in range(pairs):
        begun = process_time()
        flight = fly(case, channels=channels)
        flown.append(process_time() - begun)
        bare.append(bare_time(case, round(float(flight["time"][-1]) * USUAL_RATE)))
    return Ratio(min(flown) / min(bare), tuple(a / b for a, b in zip(flown, bare, strict=True)))


def bare_time(case: Case, steps: int) -> float:
    """Return the CPU time [s] of JSBSim alone for some steps of the case's aircraft in level flight, in its air."""
    plant = Plant.load(case.aircraft)
    plant.start(case.altitude, LEVEL_SPEED, air=Air.of(case))
    return _loop(plant.fdm.run, steps)


def step_ratio(rounds: int = 9, steps: int = 4000) -> Ratio:
    """Return the CPU time of a bare step of our airplane in light air over that of one that JSBSim ships."""
    ours, theirs = [], []
    for _ in range(rounds):
        ours.append(bare_time(Case(), steps))
        theirs.append(_shipped_time(steps))
    return Ratio(min(ours) / min(theirs), tuple(a / b for a, b in zip(ours, theirs, strict=True)))


def _shipped_time(steps: int) -> float:
    """Return the CPU time [s] of steps of the airplane as JSBSim ships it, in the air with its engine running."""
    parts = (library() / ENGINES, library() / SYSTEMS)
    fdm, _ = load_fdm(SHIPPED, library() / "aircraft" / SHIPPED, USUAL_RATE, parts)
    for path, value in (("ic/h-sl-ft", 6000.0), ("ic/vc-kts", SHIPPED_SPEED), ("fcs/mixture-cmd-norm", 1.0)):
        fdm[path] = value
    fdm.set_output_filename(0, devnull)  # its file asks for a log of its own, in the folder where it flies
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
