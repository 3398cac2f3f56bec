"""Autoregressive noise: a channel predicted from its past."""

import numpy as np
from scipy.linalg import solve_toeplitz

from pitotbench.units import Array

RIDGE = 1e-4  # share of white noise that is added, so that the equations stay well posed
SMALLEST = 1e-30  # variance of a channel that does not change


def yule_walker(autocovariance: Array) -> tuple[Array, float]:
    """Return the prediction coefficients, (p,), and the standard deviation of the innovations.

    Parameters: autocovariance at lags 0 to p, (p + 1,). Source: the Yule-Walker equations (Lütkepohl, New
    Introduction to Multiple Time Series Analysis, 2005, ch. 3), solved by Levinson's recursion.
    """
    covariance = autocovariance.copy()
    covariance[0] = max(autocovariance[0] * (1.0 + RIDGE), SMALLEST)
    coefficients = solve_toeplitz(covariance[:-1], covariance[1:])
    variance = max(covariance[0] - coefficients @ covariance[1:], RIDGE * covariance[0])
    return coefficients, float(np.sqrt(variance))
