"""A deviation that outliers do not enlarge."""

import numpy as np

from pitotbench.units import Array

NORMAL = 1.4826  # standard deviation of a normal distribution over its median absolute deviation


def robust_deviation(values: Array) -> Array:
    """Return the deviation of each column by its median absolute deviation (Hampel 1974).

    Parameters: values, (n,) or (n, c). Returns a standard deviation for normal noise, () or (c,), in the unit of
    the values.
    """
    return np.asarray(NORMAL * np.median(np.abs(values - np.median(values, axis=0)), axis=0))
