"""The closure: how much of the explainable gap an explanation closes, and what is enough."""

from collections.abc import Iterable, Sequence

import numpy as np

from pitotbench.estimation.information import Information
from pitotbench.reconciliation.thresholds import THRESHOLDS
from pitotbench.records.verdict import Closure
from pitotbench.units import Array


def closure_of(
    evidence: Information,
    columns: Sequence[int],
    sizes: Sequence[float],
    cells: Sequence[int],
    covariance: Array | None = None,
    given: Sequence[int] = (),
) -> Closure:
    """Return the closure by effects of given sizes, from the evidence of a log beyond the floor.

    The floor is that of null flights. `columns` are those of the sizes, (k,), and `cells` those of
    the examined cells.

    What flights without an effect show as well is no gap that an effect could close. Beside an
    effect of 10σ it is up to a third of all that stands above the noise.

    `covariance` is that of the sizes, (k, k), where they come from another log. The columns
    `given` are fitted freely, before as well as after: an event of this log is no part of what
    another log can close.

    The sum of squares that noise leaves is that of a fit with free sizes and with every significant
    cell. So an explanation that leaves a gap elsewhere does not close all of it.
    """
    inner, left = evidence.inner, evidence.less(columns, np.asarray(sizes, dtype=float))
    before, after = (float(e.inner[-1, -1]) - e.gain(given) for e in (evidence, left))
    squares = inner[np.ix_(columns, columns)]
    chance = 0.0 if covariance is None else float(np.sum(squares * covariance))
    used = [*columns, *given]
    for _ in range(THRESHOLDS.gap_cells_most if len(cells) else 0):
        scores = evidence.scores(cells, used)
        worst = int(np.argmax(np.abs(scores)))
        if scores[worst] ** 2 < THRESHOLDS.gap_cell:
            break
        used.append(cells[worst])
    noise = float(inner[-1, -1]) - evidence.gain(used) + len(used)
    return Closure(before, after, min(noise, before, after), chance)


def joined_closure(closures: Iterable[Closure]) -> Closure:
    """Return the closure of several flights together: their sums of squares add up."""
    every = list(closures)
    return Closure(*(sum(getattr(c, n) for c in every) for n in ("before", "after", "noise")))


def closes(closure: Closure) -> bool:
    """Return whether effects close enough of the gap of a log that their sizes were not fitted to.

    What is left within chance is enough: a log that shows little of an effect says little of it,
    and so do sizes that are hardly known.
    """
    by_chance = THRESHOLDS.gap_cell + THRESHOLDS.left_by_chance * closure.chance
    return closure.share >= THRESHOLDS.closure_lowest or closure.after - closure.noise < by_chance
