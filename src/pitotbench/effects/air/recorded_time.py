"""Time since the first recorded sample, as a log knows it and as JSBSim computes it."""

import numpy as np

from pitotbench.effects.expression import Term, difference, operation
from pitotbench.effects.signals import Signals
from pitotbench.units import Seconds

RECORDING_START = "bench/recording-start-s"  # simulator's time of the first recorded sample; far ahead until then
ELAPSED = operation("max", 0.0, difference("simulation/sim-time-sec", RECORDING_START))


def elapsed(signals: Signals) -> Seconds:
    """Time since the first sample [s]."""
    return np.asarray(signals.time - signals.time[0])


def clipped(term: Term) -> str:
    """A term held within 0 and 1."""
    return operation("max", 0.0, operation("min", 1.0, term))
