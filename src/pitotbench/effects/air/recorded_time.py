"""Time since the first recorded sample, in a log and as an expression of JSBSim."""

import numpy as np

from pitotbench.effects.expression import Term, difference, operation
from pitotbench.effects.signals import Signals
from pitotbench.units import Seconds

RECORDING_START = "bench/recording-start-s"  # simulator's time of the first recorded sample; far ahead until then
ELAPSED = operation("max", 0.0, difference("simulation/sim-time-sec", RECORDING_START))


def elapsed(signals: Signals) -> Seconds:
    """Return the time since the first sample [s], (n,)."""
    return np.asarray(signals.time - signals.time[0])


def clipped(term: Term) -> str:
    """Return an expression that limits a term to 0 … 1."""
    return operation("max", 0.0, operation("min", 1.0, term))
