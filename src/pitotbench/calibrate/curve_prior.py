"""What is thought of a pressure-error curve before the flight: one prior for all models, so that their evidence
can be compared.

The curve over the flown range of ln x is a sum of orthonormal (Legendre) polynomials with independent Gaussian
coefficients. Level and slope are wide, and the higher a degree the smaller its coefficient: as 1/degree², the rate
of a curve with a square-integrable second derivative. A model with fewer parameters gets the same density,
restricted to the curves that it can draw, and so no model is favored by how its terms are scaled.
"""

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import legendre

from pitotbench.pressure_error import PressureErrorModel
from pitotbench.units import Array

_LEVEL = 0.06  # Δp/q_c, standard deviation of level and slope: 4 kt at 130 kt
_POINTS = 24  # nodes over the range, more than the degrees used
_DEGREES = 16
_BENDS = (0.25, 0.5, 1.0, 2.0)  # how much the curve bends, against level and slope: unknown, each as likely


@dataclass(frozen=True, slots=True)
class CurvePrior:
    """The prior over x from low to high; `level` [-] is the standard deviation of the curve's level."""

    low: float
    high: float
    level: float = _LEVEL

    def precisions(self, model: PressureErrorModel) -> Array:
        """Prior precision of the model's parameters, one a degree of bending, (4, k, k)."""
        # Gauss-Legendre nodes and weights make the products of polynomials exact.
        place, weight = legendre.leggauss(_POINTS)
        middle, half = 0.5 * np.log(self.high * self.low), 0.5 * np.log(self.high / self.low)
        basis = model.basis(np.exp(middle + half * place))
        degree = np.arange(_DEGREES)
        polynomials = legendre.legvander(place, _DEGREES - 1) * np.sqrt(2.0 * degree + 1.0)
        coefficients = polynomials.T @ (0.5 * weight[:, None] * basis)
        return np.stack([self._precision(coefficients, degree, bend) for bend in _BENDS])

    def _precision(self, coefficients: Array, degree: Array, bend: float) -> Array:
        deviation = self.level * np.where(degree < 2, 1.0, bend / np.maximum(degree, 1) ** 2)
        scaled = coefficients / deviation[:, None]
        return np.asarray(scaled.T @ scaled)
