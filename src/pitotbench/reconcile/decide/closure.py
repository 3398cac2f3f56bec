"""How much of the gap an explanation closes: the explainable part of it, not what noise would leave in any case."""

from collections.abc import Sequence

import numpy as np

from pitotbench.reconcile.decide.normal_equations import NormalEquations
from pitotbench.records.verdict import Closure

WORTH = 16.0  # fall of the sum of squares (4σ) from which a cell without physics counts as part of the gap
MOST = 20  # such cells


def closure_of(
    weighed: NormalEquations, columns: Sequence[int], sizes: Sequence[float], cells: Sequence[int]
) -> Closure:
    """The closure by effects of given sizes: nuisances are fitted anew, the sizes are not.

    What noise leaves is what is left once the sizes are free and every cell that still shows something is fitted:
    so an explanation that leaves a gap elsewhere does not count as closing all of it.
    """
    before = weighed.left(())
    after = before
    if len(columns):
        inner, s = weighed.inner, np.asarray(sizes)
        chosen = list(columns)
        after = float(before - 2.0 * s @ inner[chosen, -1] + s @ inner[np.ix_(chosen, chosen)] @ s)
    used = list(columns)
    for _ in range(MOST):
        scores = weighed.scores(cells, used)
        worst = int(np.argmax(np.abs(scores)))
        if scores[worst] ** 2 < WORTH:
            break
        used.append(cells[worst])
    noise = weighed.left(used) + len(used)
    return Closure(before, after, min(noise, before, after) if len(columns) else min(noise, before))
