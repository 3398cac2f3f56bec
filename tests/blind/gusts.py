"""Gusts of the generator's own: von Karman's spectra as sums of sines along the way through the air.

The spectra are those of MIL-F-8785C, 3.7.1 (von Karman form), of 762 m above 2,000 ft. The gusts are frozen in the
air: the airplane flies through them. They have no rotation of their own.
"""

from dataclasses import dataclass

import numpy as np

from pitotbench.units import Array

LENGTH = 762.0  # m
LEAST, MOST, MODES = 2.0e-4, 0.5, 160  # rad/m: from 31 km to 13 m, or a fifth of a second
STEP = 1.0  # m


def longitudinal(number: Array) -> Array:
    """The one-sided spectrum of the gust along the flight at a wave number [rad/m], of unit variance."""
    return np.asarray(2.0 * LENGTH / np.pi / (1.0 + (1.339 * LENGTH * number) ** 2) ** (5.0 / 6.0))


def lateral(number: Array) -> Array:
    """The same for the gusts across the flight."""
    x = (1.339 * LENGTH * number) ** 2
    return np.asarray(LENGTH / np.pi * (1.0 + 8.0 / 3.0 * x) / (1.0 + x) ** (11.0 / 6.0))


@dataclass(frozen=True, slots=True)
class GustField:
    """Gusts along, across and down [m/s] at each `STEP` of the way, (m, 3)."""

    values: Array

    def at(self, way: float) -> Array:
        """Return the gusts after some way through the air [m], (3,); the field begins anew at its end."""
        place = way / STEP
        low = int(place)
        share, count = place - low, len(self.values)
        return np.asarray((1.0 - share) * self.values[low % count] + share * self.values[(low + 1) % count])


def gust_field(deviation: float, seed: int, way: float = 60_000.0) -> GustField:
    """Return gusts of a standard deviation [m/s] along a way [m]."""
    draw = np.random.default_rng([seed, 77])
    edges = np.geomspace(LEAST, MOST, MODES + 1)
    numbers = edges[:-1] + draw.random(MODES) * np.diff(edges)
    place = np.arange(0.0, way, STEP)
    columns = []
    for spectrum in (longitudinal, lateral, lateral):
        size = np.sqrt(2.0 * spectrum(numbers) * np.diff(edges))
        phase = draw.uniform(0.0, 2.0 * np.pi, MODES)
        column = np.zeros_like(place)
        for amplitude, number, start in zip(size, numbers, phase, strict=True):
            column += amplitude * np.sin(number * place + start)
        columns.append(column)
    return GustField(deviation * np.stack(columns, axis=1))
