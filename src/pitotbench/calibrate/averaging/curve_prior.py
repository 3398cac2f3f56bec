"""The prior of a pressure-error curve before the flight: a law of the table plus a departure from it.

No airplane follows a formula exactly, so each law is a first approximation. Over the flown range of ln x the curve
is a law plus a sum of orthonormal (Legendre) polynomials from degree 2 on. Their coefficients are independent and
Gaussian and fall as 1/degree², the rate of curves with a square-integrable second derivative. The size of the
departure is unknown: all sizes of a fixed list are equally likely. Where a flight has gaps between its speeds, the
departure keeps the bound wide there.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import legendre

from pitotbench.pressure_error import PressureErrorModel
from pitotbench.units import Array

LEVEL = 0.06  # Δp/q_c, standard deviation of a curve's level and slope: 4 kt at 130 kt
DEPARTURES = (0.0005, 0.001, 0.002, 0.004, 0.008)  # Δp/q_c, root mean square: 0.03 to 0.5 kt at 130 kt
LAWLESS = "spline"  # the model whose law is a straight line in ln x: the rest is departure
_LAWLESS_SHARE = 0.5  # probability that the curve follows no law of the table
_DEGREES = 16  # the next coefficient's deviation is 1/64 of that of degree 2
_POINTS = 24  # of the quadrature; more than the degrees, so that the projection is well determined


@dataclass(frozen=True, slots=True)
class Hypothesis:
    """One hypothesis of the curve.

    `name` is the model that serves as the law and `departure` [-] the size of the departure from it. `probability`
    is that before the flight; `covariance` (c, c) [-] is that of the curve's values at the requested points.
    """

    name: str
    departure: float
    probability: float
    covariance: Array


def hypotheses(laws: Sequence[PressureErrorModel], x: Array, level: float = LEVEL) -> list[Hypothesis]:
    """Combine every law, and the straight line, with a departure of every size.

    Parameters: laws of the table; x (c,), increasing points, evenly spaced in ln x over the range; level [-], the
    standard deviation of the curve's level and slope. The probabilities of the result sum to 1.
    """
    place = np.linspace(-1.0, 1.0, len(x))
    departure = _departure(place)
    families = [(LAWLESS, _LAWLESS_SHARE if laws else 1.0, _of_line(place, level))]
    families += [(law.name, (1.0 - _LAWLESS_SHARE) / len(laws), _of_law(law, x, level)) for law in laws]
    return [
        Hypothesis(name, size, share / len(DEPARTURES), family + size**2 * departure)
        for name, share, family in families
        for size in DEPARTURES
    ]


def _departure(place: Array) -> Array:
    """Covariance, at places in [-1, 1], of departures whose root mean square is 1."""
    variance = np.arange(2, _DEGREES, dtype=np.float64) ** -4
    polynomials = _orthonormal(place)[:, 2:]
    return np.asarray((polynomials * variance) @ polynomials.T / variance.sum())


def _of_line(place: Array, level: float) -> Array:
    """Covariance of straight lines at places in [-1, 1]."""
    line = _orthonormal(place)[:, :2]
    return np.asarray(level**2 * line @ line.T)


def _of_law(law: PressureErrorModel, x: Array, level: float) -> Array:
    """Covariance at x of the curves of a law.

    Curves of moderate level and slope, with a bend that falls with the degree, are more likely. This does not
    depend on the scale of the law's terms.
    """
    place, weight = legendre.leggauss(_POINTS)
    inner = np.exp(0.5 * np.log(x[0] * x[-1]) + 0.5 * np.log(x[-1] / x[0]) * place)
    coefficients = _orthonormal(place).T @ (0.5 * weight[:, None] * law.basis(inner))
    scaled = coefficients / (level / np.maximum(np.arange(_DEGREES), 1.0) ** 2)[:, None]
    basis = law.basis(x)
    return np.asarray(basis @ np.linalg.solve(scaled.T @ scaled, basis.T))


def _orthonormal(place: Array) -> Array:
    """Legendre polynomials at places in [-1, 1], (n, degrees), each with a mean square of 1."""
    return np.asarray(legendre.legvander(place, _DEGREES - 1) * np.sqrt(2.0 * np.arange(_DEGREES) + 1.0))
