"""The closure: how much of the explainable gap an explanation closes."""

from collections.abc import Sequence

import numpy as np

from pitotbench.reconcile.decide.normal_equations import NormalEquations
from pitotbench.reconcile.decide.thresholds import THRESHOLDS
from pitotbench.records.verdict import Closure
from pitotbench.units import Array


def closure_of(
    equations: NormalEquations,
    columns: Sequence[int],
    sizes: Sequence[float],
    cells: Sequence[int],
    covariance: Array | None = None,
    beside: Sequence[int] = (),
) -> Closure:
    """Return the closure by effects of given sizes; the free parameters are fitted anew, the sizes are not.

    `covariance` is that of the sizes, (k, k), where they come from another log. The columns `beside` are fitted
    freely, before as well as after: an event of this log is no part of what another log can close.

    The sum of squares that noise leaves is that of a fit with free sizes and with every significant cell. So an
    explanation that leaves a gap elsewhere does not close all of it.
    """
    before = equations.remaining(beside)
    after, chance = before, 0.0
    if len(columns):
        inner, s = equations.inner, np.asarray(sizes)
        chosen, free = list(columns), list(beside)
        squares = inner[np.ix_(chosen, chosen)]
        left = inner[free, -1] - inner[np.ix_(free, chosen)] @ s
        taken = left @ np.linalg.lstsq(inner[np.ix_(free, free)], left, rcond=None)[0]
        after = float(equations.remaining(()) - 2.0 * s @ inner[chosen, -1] + s @ squares @ s - taken)
        chance = 0.0 if covariance is None else float(np.sum(squares * covariance))
    used = [*columns, *beside]
    for _ in range(THRESHOLDS.gap_cells_most if len(cells) else 0):
        scores = equations.scores(cells, used)
        worst = int(np.argmax(np.abs(scores)))
        if scores[worst] ** 2 < THRESHOLDS.gap_cell:
            break
        used.append(cells[worst])
    noise = equations.remaining(used) + len(used)
    return Closure(before, after, min(noise, before, after) if len(columns) else min(noise, before), chance)


def with_form_error(covariance: Array, sizes: Sequence[float]) -> Array:
    """Return the covariance of sizes, (k, k), with the error that another log's form and the method add to each."""
    share = np.hypot(THRESHOLDS.form_error, THRESHOLDS.size_error)
    return np.asarray(covariance + np.diag((share * np.asarray(sizes)) ** 2))
