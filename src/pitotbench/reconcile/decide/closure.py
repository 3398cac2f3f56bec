"""The closure: how much of the explainable gap an explanation closes."""

from collections.abc import Sequence

import numpy as np

from pitotbench.reconcile.decide.normal_equations import NormalEquations
from pitotbench.reconcile.decide.thresholds import THRESHOLDS
from pitotbench.records.verdict import Closure


def closure_of(
    equations: NormalEquations, columns: Sequence[int], sizes: Sequence[float], cells: Sequence[int]
) -> Closure:
    """Return the closure by effects of given sizes; the free parameters are fitted anew, the sizes are not.

    The sum of squares that noise leaves is that of a fit with free sizes and with every significant cell. So an
    explanation that leaves a gap elsewhere does not close all of it.
    """
    before = equations.remaining(())
    after = before
    if len(columns):
        inner, s = equations.inner, np.asarray(sizes)
        chosen = list(columns)
        after = float(before - 2.0 * s @ inner[chosen, -1] + s @ inner[np.ix_(chosen, chosen)] @ s)
    used = list(columns)
    for _ in range(THRESHOLDS.gap_cells_most):
        scores = equations.scores(cells, used)
        worst = int(np.argmax(np.abs(scores)))
        if scores[worst] ** 2 < THRESHOLDS.gap_cell:
            break
        used.append(cells[worst])
    noise = equations.remaining(used) + len(used)
    return Closure(before, after, min(noise, before, after) if len(columns) else min(noise, before))
