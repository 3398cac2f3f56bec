"""All terms of the pitching moment times one factor, which trimmed flight hardly shows.

At every airspeed the pilot trims the terms of the pitching moment to nothing, whatever factor they
have in common; the inertia alone, in quick motion, tells it. There the measured angles are noisy
and gusts act as well, which pulls the factor toward zero (regression dilution: Carroll and others,
Measurement Error in Nonlinear Models, 2006, ch. 3), and by how much changes from flight to flight.
So the factor has a column, the sum of the terms, and as much of it as null flights seem to have is
unknown. It multiplies what is changed of a term as well: a stiffness that is a quarter too small
seems to be a sixth where the factor is .65.
"""

from collections.abc import Iterable, Sequence

import numpy as np

from pitotbench.estimation.information import Information
from pitotbench.units import Array

# Sizes that are a share of a whole term, and the constant of the moment.
TERMS = ("pitch_stiffness|change", "pitch_damping|change", "control_moments|elevator_change")
CONSTANT = "trim_offset|pitch_coefficient"


def factor_deviation(labels: Sequence[str], flights: Iterable[Information]) -> float:
    """Return the standard deviation of the factor over null flights, beyond that by noise.

    `labels` are those of the sizes of which each flight is the evidence.
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


def around_sizes(
    evidence: Information,
    labels: Sequence[str],
    deviation: float,
    pitching: Sequence[int],
    shown: Array,
) -> Information:
    """Return the evidence of the sizes themselves, where a log alone shows them with the factor.

    `shown` are the sizes of all columns, (m,), those of the `pitching` columns times the factor.

    The evidence is linearized in both, because the factor multiplies what is changed of a term as
    well.
    """
    column = _sum_of_terms(labels, evidence)
    left = evidence.without(column, deviation).inner
    factor = deviation**2 * float(left @ column @ np.append(-shown, 1.0))
    extra, sizes = np.zeros(len(column)), np.zeros(len(column))
    extra[pitching] = factor
    sizes[pitching] = shown[pitching] / (1.0 + factor)
    turn = np.eye(len(column)) + np.diag(extra)
    turn[:, -1] += extra * sizes
    left = evidence.without(_sum_of_terms(labels, evidence, sizes), deviation).inner
    return Information(turn.T @ left @ turn)


def _sum_of_terms(labels: Sequence[str], evidence: Information, sizes: Array | float = 0) -> Array:
    """The sum of the terms as a combination of the columns, (m + 1,).

    The columns are changed by `sizes`. The constant takes most of the sum, as the trim does. The
    combination is 0 where a term is missing.
    """
    combination = np.zeros(len(evidence.inner))
    if {*TERMS, CONSTANT} <= {*labels}:
        trim = labels.index(CONSTANT)
        power = float(evidence.inner[trim, trim])
        if power > 0.0:
            combination[[labels.index(term) for term in TERMS]] = 1.0
            combination += sizes
            combination[trim] -= float(evidence.inner[trim] @ combination) / power
    return combination
