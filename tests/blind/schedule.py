"""Factors of an effect's size over the recorded time: a part of the flight, or a cycle."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pitotbench.units import Array

Schedule = Callable[[Array], Array]  # of seconds since the first sample; below 0 before it
EDGE = 3.0  # s, in which a part of a flight begins and ends


@dataclass(frozen=True, slots=True)
class Part:
    """A part of the flight, in seconds since the first sample."""

    begin: float
    end: float

    def __call__(self, time: Array) -> Array:
        """Return the share of the effect that acts: 1 within the part, 0 outside, with edges of 3 s."""
        inside = np.minimum((time - self.begin) / EDGE, (self.end - time) / EDGE)
        return np.asarray(np.clip(inside, 0.0, 1.0))


def always(time: Array) -> Array:
    """Act through the whole flight."""
    return np.ones_like(np.asarray(time, dtype=np.float64))


def square(period: float) -> Schedule:
    """Act half of each period [s], with edges of a tenth of it."""
    return lambda time: np.clip(5.0 * np.sin(2.0 * np.pi * np.asarray(time) / period), -0.5, 0.5) + 0.5


def wave(period: float) -> Schedule:
    """Go to and fro with a period [s]."""
    return lambda time: np.sin(2.0 * np.pi * np.asarray(time) / period)


def growing(seconds: float) -> Schedule:
    """Grow from nothing to all within some time [s], and on."""
    return lambda time: np.maximum(0.0, np.asarray(time)) / seconds


def pulses(period: float, last: float) -> Schedule:
    """Act for `last` seconds in each period [s], with smooth edges."""
    return lambda time: np.exp(-0.5 * ((np.mod(np.asarray(time), period) - 0.5 * period) / last) ** 2)
