"""A measure of a log against the same measure of null flights."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, slots=True)
class Measure:
    """Mean and standard deviation of a measure over null flights."""

    mean: float
    deviation: float

    def standardized(self, value: float) -> float:
        """Return a value less the mean, in standard deviations."""
        return (value - self.mean) / self.deviation


def measures_over(flights: Sequence[Mapping[str, float]], lowest: float) -> dict[str, Measure]:
    """Return mean and deviation over null flights of each measure; no deviation is below `lowest`."""
    values = {name: [each[name] for each in flights] for name in flights[0]}
    return {n: Measure(float(np.mean(v)), max(lowest, float(np.std(v, ddof=1)))) for n, v in values.items()}
