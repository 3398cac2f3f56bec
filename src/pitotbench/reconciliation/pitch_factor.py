"""All terms of the pitching moment times one factor, which trimmed flight hardly shows.

At every airspeed the pilot trims the terms of the pitching moment to nothing, whatever factor they
have in common; the inertia alone, in quick motion, tells it. There the measured angles are noisy
and gusts act as well, which pulls the factor toward zero (regression dilution: Carroll and others,
Measurement Error in Nonlinear Models, 2006, ch. 3), and by how much changes from flight to flight.
So the factor has a column, the sum of the terms, and as much of it as null flights seem to have is
unknown.
"""

from collections.abc import Iterable, Sequence

import numpy as np

from pitotbench.estimation.information import Information
from pitotbench.units import Array

# Sizes that are a share of a whole term, and the constant of the moment.
TERMS = ("pitch_stiffness|change", "pitch_damping|change", "control_moments|elevator_change")
CONSTANT = "trim_offset|pitch_coefficient"


def factor_deviation(labels: Sequence[str], flights: Iterable[Information]) -> float:
    """Return the standard deviation of the factor over null flights, beyond what their noise gives
    it. `labels` are those of the sizes of which each flight is the evidence.
    """
    surplus = list[float]()
    for evidence in flights:
        column = _sum_of_terms(labels, evidence)
        power = float(column @ evidence.inner @ column)
        if power > 0.0:
            size = float(column @ evidence.inner[:, -1]) / power
            surplus.append(size**2 - 1.0 / power)
    return max(0.0, float(np.mean(surplus))) ** 0.5 if surplus else 0.0


def without_factor(evidence: Information, labels: Sequence[str], deviation: float) -> Information:
    """Return the evidence with the factor integrated out, by its prior deviation."""
    return evidence.without(_sum_of_terms(labels, evidence), deviation)


def _sum_of_terms(labels: Sequence[str], evidence: Information) -> Array:
    """The sum of the terms as a combination of the columns, (m + 1,), with the constant that takes
    most of it, as the trim does; 0 where a term is missing.
    """
    combination = np.zeros(len(evidence.inner))
    if {*TERMS, CONSTANT} <= {*labels}:
        own, trim = [labels.index(term) for term in TERMS], labels.index(CONSTANT)
        power = float(evidence.inner[trim, trim])
        if power > 0.0:
            combination[own] = 1.0
            combination[trim] = -float(evidence.inner[trim, own].sum()) / power
    return combination
