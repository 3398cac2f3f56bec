"""What a naming rests on, laid out to be drawn: the gap by place, over time, and after each effect."""

from collections.abc import Sequence

import numpy as np

from pitotbench.reconcile.decide.naming import Naming
from pitotbench.reconcile.decide.normal_equations import NormalEquations
from pitotbench.reconcile.null_flights.null_distribution import Knowledge
from pitotbench.reconcile.residuals.layout import columns_of
from pitotbench.reconcile.residuals.predicted_channels import UNITS
from pitotbench.records.gap import GapMap, Step, Trace
from pitotbench.units import Array


def gap_map(named: Naming, known: Knowledge) -> GapMap:
    """Where the gap sits before and after what was named, in σ beyond what null flights show there."""
    index, cells = zip(*named.layout.places, strict=True)
    channels = tuple(dict.fromkeys(cell.channel for cell in cells))
    places = tuple(dict.fromkeys(cell.where for cell in cells))
    tables = []
    for given in ((), named.fit.columns):
        table = np.full((len(channels), len(places)), np.nan)
        for cell, value in zip(cells, named.evidence.scores(index, given), strict=True):
            told = known.told_at(cell, value)
            table[channels.index(cell.channel), places.index(cell.where)] = told
        tables.append(table)
    return GapMap(channels, places, tables[0], tables[1], known.cell_threshold)


def waterfall(named: Naming) -> tuple[Step, ...]:
    """The sum of squares left as the named effects are added one by one, with the sizes fitted together; the one
    that takes out most comes first."""
    columns, sizes = list(named.fit.columns), list(named.fit.sizes)
    of_effect = columns_of(named.layout.signatures)
    waiting, added = list(named.chosen), list[int]()
    steps = []
    while waiting:
        best = min(waiting, key=lambda n: _left(named.evidence, columns, sizes, [*added, *of_effect[n]]))
        waiting.remove(best)
        added += of_effect[best]
        steps.append(Step(best, _left(named.evidence, columns, sizes, added)))
    return tuple(steps)


def _left(weighed: NormalEquations, columns: Sequence[int], sizes: Sequence[float], used: Sequence[int]) -> float:
    """Sum of squares with some columns at their sizes, the others absent, nuisances free."""
    at = [c for c in columns if c in used]
    s = np.array([size for c, size in zip(columns, sizes, strict=True) if c in used])
    inner = weighed.inner
    return float(inner[-1, -1] - 2.0 * s @ inner[at, -1] + s @ inner[np.ix_(at, at)] @ s)


def traces(named: Naming) -> tuple[Trace, ...]:
    """Every residual channel over time without its nuisances, and what was named says of it."""
    layout, columns = named.layout, list(named.fit.columns)
    nuisances = layout.nuisance.columns @ named.evidence.nuisance_sizes(columns)
    explained = _sum([layout.signatures[c].column for c in columns], named.fit.sizes, layout.residuals.values)
    time = layout.track.time[layout.grid.rows]
    gap = layout.residuals.values - nuisances
    return tuple(
        Trace(name, UNITS[name], time, gap[:, i], explained[:, i]) for i, name in enumerate(layout.residuals.names)
    )


def _sum(columns: Sequence[Array], sizes: Array, like: Array) -> Array:
    total = np.zeros_like(like)
    for column, size in zip(columns, sizes, strict=True):
        total += column * size
    return total
