"""Measure the CPU time of flying and recording a card, relative to JSBSim alone."""

from collections.abc import Collection
from dataclasses import dataclass
from statistics import median
from time import process_time

from pitotbench.records.case import Case
from pitotbench.simulate.atmosphere import Air
from pitotbench.simulate.plant import Plant
from pitotbench.simulate.sortie import fly
from pitotbench.units import KNOT

LEVEL_SPEED = 130.0 * KNOT  # m/s, of the bare loop
RATE = 100.0  # Hz


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
        bare.append(bare_time(case, round(float(flight["time"][-1]) * RATE)))
    return Ratio(min(flown) / min(bare), tuple(a / b for a, b in zip(flown, bare, strict=True)))


def bare_time(case: Case, steps: int) -> float:
    """Return the CPU time [s] of JSBSim alone for some steps of the case's aircraft in level flight, in its air."""
    plant = Plant.load(case.aircraft)
    plant.start(case.altitude, LEVEL_SPEED, air=Air.of(case))
    run = plant.fdm.run
    begun = process_time()
    for _ in range(steps):
        run()
    return process_time() - begun
