"""The data of the pictures of a reconciliation: the gap by place, over time, and after each effect."""

from collections.abc import Sequence

import numpy as np

from pitotbench.reconcile.decide.naming import Naming
from pitotbench.reconcile.decide.normal_equations import NormalEquations
from pitotbench.reconcile.null_flights.null_distribution import NullDistribution
from pitotbench.reconcile.residuals.predicted_channels import UNITS
from pitotbench.reconcile.signatures.signatures import columns_of
from pitotbench.records.gap import GapMap, Step, Trace
from pitotbench.units import Array


def gap_map(naming: Naming, null: NullDistribution) -> GapMap:
    """Return the places of the gap before and after the named effects, in σ beyond null flights."""
    index, cells = zip(*naming.layout.places, strict=True)
    channels = tuple(dict.fromkeys(cell.channel for cell in cells))
    places = tuple(dict.fromkeys(cell.where for cell in cells))
    tables = []
    for given in ((), naming.fit.columns):
        table = np.full((len(channels), len(places)), np.nan)
        for cell, value in zip(cells, naming.equations.scores(index, given), strict=True):
            table[channels.index(cell.channel), places.index(cell.where)] = null.scores.of_cell(cell, value)
        tables.append(table)
    return GapMap(channels, places, tables[0], tables[1], null.cell_threshold)


def waterfall(naming: Naming) -> tuple[Step, ...]:
    """Return the sum of squares that remains as the named effects are added one by one.

    The sizes are those fitted together. The effect that removes most comes first. An effect of another flight that
    this one cannot show is left out.
    """
    columns, sizes = list(naming.fit.columns), list(naming.fit.sizes)
    of_effect = columns_of(naming.layout.signatures)
    waiting, added = [name for name in naming.chosen if name in of_effect], list[int]()
    steps = []
    while waiting:
        best = min(waiting, key=lambda n: _remaining(naming.equations, columns, sizes, [*added, *of_effect[n]]))
        waiting.remove(best)
        added += of_effect[best]
        steps.append(Step(best, _remaining(naming.equations, columns, sizes, added)))
    return tuple(steps)


def _remaining(
    equations: NormalEquations, columns: Sequence[int], sizes: Sequence[float], used: Sequence[int]
) -> float:
    """Sum of squares with some columns at their sizes and the others absent; the free parameters are fitted."""
    at = [c for c in columns if c in used]
    s = np.array([size for c, size in zip(columns, sizes, strict=True) if c in used])
    inner = equations.inner
    return float(inner[-1, -1] - 2.0 * s @ inner[at, -1] + s @ inner[np.ix_(at, at)] @ s)


def traces(naming: Naming) -> tuple[Trace, ...]:
    """Return every residual channel over time without free parameters, and the part that the effects explain."""
    layout, columns = naming.layout, list(naming.fit.columns)
    free = layout.free.columns @ naming.equations.free_sizes(columns)
    explained = _sum([layout.signatures[c].column for c in columns], naming.fit.sizes, layout.residuals.values)
    time = layout.track.time[layout.grid.rows]
    gap, used = layout.residuals.values - free, layout.used
    return tuple(
        Trace(name, UNITS[name], time, gap[:, i], explained[:, i], used[:, i])
        for i, name in enumerate(layout.residuals.names)
    )


def _sum(columns: Sequence[Array], sizes: Array, like: Array) -> Array:
    total = np.zeros_like(like)
    for column, size in zip(columns, sizes, strict=True):
        total += column * size
    return total
