"""Find the end of the impact-pressure sensor's range: rows in which the reading cannot rise any more."""

import numpy as np

from pitotbench.units import Booleans, Pascal

_FEWEST = 10.0  # new samples at the greatest value; sensor noise reaches its greatest value once
_STANDS_OUT = 5.0  # times the samples one step lower; those of a smooth peak are at most 2.4 times as many
_COARSEST = 5.0  # Pa; with coarser steps many rows share the greatest value without a ceiling


def at_ceiling(impact_pressure: Pascal) -> Booleans:
    """Return the rows in which the indicated impact pressure [Pa], (n,), stands at the end of its range, (n,).

    The pressure there is the end of the range or more, and nothing is known beyond that. No row is returned where
    the log shows no such end, and for a reading in steps above 5 Pa, in which a steady speed looks the same.
    """
    top = float(np.max(impact_pressure))
    rows: Booleans = impact_pressure >= top
    none = np.zeros_like(rows)
    if rows.sum() < _FEWEST or rows.all():
        return none
    step = float(np.median(np.diff(np.unique(impact_pressure))))
    usual = np.count_nonzero(~rows) / _runs(impact_pressure[~rows])
    lower = np.count_nonzero((impact_pressure >= top - 1.5 * step) & ~rows)
    found = step <= _COARSEST and rows.sum() >= max(_FEWEST * usual, _STANDS_OUT * lower)
    return rows if found else none


def _runs(values: Pascal) -> int:
    """Return the number of runs of equal values; a recorder repeats the samples of a slower sensor."""
    return 1 + int(np.count_nonzero(np.diff(values)))
