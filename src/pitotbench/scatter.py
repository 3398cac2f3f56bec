"""The standard deviation of normal noise, seen through outliers, coarse steps and slow signals."""

from math import comb, sqrt

import numpy as np

from pitotbench.units import Array, Booleans

NORMAL = 1.4826  # standard deviation of a normal distribution over its median absolute deviation
_LARGE = 0.95  # a quantile of a normal variable's size
_LARGE_DEVIATIONS = 1.96  # the same in standard deviations


def robust_deviation(values: Array) -> Array:
    """Return the deviation of each column by its median absolute deviation (Hampel 1974).

    Parameters: values, (n,) or (n, c). Returns a standard deviation for normal noise, () or (c,),
    in the unit of the values.
    """
    return np.asarray(NORMAL * np.median(np.abs(values - np.median(values, axis=0)), axis=0))


def deviation_of_sizes(sizes: Array) -> float:
    """Return the standard deviation of normal noise from the sizes of its values, in their unit.

    Parameters: sizes, (n,). Most differences of coarsely rounded data are zero, so the larger ones
    set the scale there.
    """
    common, large = np.quantile(sizes, [0.5, _LARGE])
    return max(NORMAL * float(common), float(large) / _LARGE_DEVIATIONS)


def white_differences(values: Array, order: int = 2) -> Array:
    """Return the differences of some order, in which white noise keeps its deviation.

    Slow signals cancel in them. Parameters: values, (n,). Returns (n − order,).
    """
    return np.asarray(np.diff(values, order) / sqrt(comb(2 * order, order)))


def spikes_among(second: Array, least: float) -> Booleans:
    """Return which of n samples are spikes, (n,), by the sizes of second differences, (n − 2,).

    A spike's second difference is above `least` and the largest of three: those of its neighbors
    are half as large. The first and the last sample have none.
    """
    tallest = (second >= np.concatenate([[0.0], second[:-1]])) & (
        second >= np.append(second[1:], 0.0)
    )
    return np.concatenate([[False], (second > least) & tallest, [False]])
