"""Measure the CPU time of flying and recording a card, relative to JSBSim alone."""

from time import process_time

from pitotbench.records.case import Case
from pitotbench.simulate.atmosphere import Air
from pitotbench.simulate.plant import Plant
from pitotbench.simulate.sortie import fly
from pitotbench.units import KNOT

LEVEL_SPEED = 130.0 * KNOT  # m/s, of the bare loop
RATE = 100.0  # Hz


def overhead_ratio(case: Case | None = None, repeats: int = 5) -> float:
    """Return the CPU time of a flight over that of a bare `run()` loop of as many steps, each the least of several.

    The flight includes the loading, the settling, the card, every channel at 100 Hz, and the arrays at the end.
    """
    case = case or Case(maneuver="step_decrease")
    flown, bare = [], []
    for _ in range(repeats):
        begun = process_time()
        flight = fly(case)
        flown.append(process_time() - begun)
        bare.append(bare_time(case, round(float(flight["time"][-1]) * RATE)))
    return min(flown) / min(bare)


def bare_time(case: Case, steps: int) -> float:
    """Return the CPU time [s] of JSBSim alone for some steps of the case's aircraft in level flight, in its air."""
    plant = Plant.load(case.aircraft)
    plant.start(case.altitude, LEVEL_SPEED, air=Air.of(case))
    run = plant.fdm.run
    begun = process_time()
    for _ in range(steps):
        run()
    return process_time() - begun
