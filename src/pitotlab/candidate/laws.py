"""Laws of a pressure-error curve for a fit: each a basis with a normal prior.

A law is Δp/q_c = B(q_ci) z with independent normal z, so that a fit needs no more of it than its
columns and the standard deviations of z. A published model and a smooth curve differ in nothing
else.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pitotbench.pressure_error.models import PressureErrorModel, SplineModel, spline_between
from pitotbench.units import Array, Pascal

KNOTS = 13  # of a smooth curve, evenly spaced in ln q_ci over the flown range
_LEAST_EIGENVALUE = 1e-2  # share of the largest one: smaller departures are left out
_POINTS = 50  # over the range, at which the terms of a published model are made orthonormal
_LEAST_PRESSURE = 1.0  # Pa: a smaller one has no logarithm that means anything


@dataclass(frozen=True, slots=True)
class Law:
    """A law over a range of indicated impact pressures `low` to `high` [Pa].

    The first columns of the basis are a level and a slope over half the range in ln q_ci, where
    `line` says so; the others are the terms of `model` times `terms` (K, r). `deviations` (r + 2,)
    or (r,) are those of z [-]. Where `departure` is set, z is in units of a size that the log
    tells.
    """

    model: PressureErrorModel | None
    reference_pressure: float
    low: float
    high: float
    line: bool
    terms: Array
    deviations: Array
    departure: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.deviations)

    def basis(self, impact_pressure: Pascal) -> Array:
        """Return the columns at indicated impact pressures (n,) [Pa], (n, columns) [-]."""
        q = np.maximum(impact_pressure, _LEAST_PRESSURE)
        own = self._own(q)
        if not self.line:
            return own
        place = (np.log(q) - 0.5 * np.log(self.low * self.high)) / self._half
        return np.column_stack([np.ones_like(q), place, own])

    def slope(self, impact_pressure: Pascal) -> Array:
        """Return the derivatives of the columns by the impact pressure, (n, columns) [1/Pa]."""
        q = np.maximum(impact_pressure, _LEAST_PRESSURE)
        own = np.zeros((len(q), 0))
        if self.model is not None:
            own = self.model.basis_slope(q / self.reference_pressure) @ self.terms
            own = own / self.reference_pressure
        if not self.line:
            return own
        return np.column_stack([np.zeros_like(q), 1.0 / (q * self._half), own])

    def parameters(self) -> Array:
        """Return the map (K, columns) from z to the parameters of the model.

        Those of a smooth curve are its values at the knots.
        """
        if not self.line:
            return self.terms
        assert isinstance(self.model, SplineModel)
        return self.basis(np.asarray(self.model.knots) * self.reference_pressure)

    @property
    def _half(self) -> float:
        return 0.5 * float(np.log(self.high / self.low))

    def _own(self, q: Pascal) -> Array:
        if self.model is None:
            return np.zeros((len(q), 0))
        return np.asarray(self.model.basis(q / self.reference_pressure) @ self.terms)


def no_law() -> Law:
    """Return the law of a source without an error."""
    none = np.zeros(0)
    return Law(None, 1.0, 1.0, 2.0, False, np.zeros((0, 0)), none, none.astype(np.bool_))


def line(low: float, high: float, level: float, slope: float) -> Law:
    """Return a straight line in ln q_ci with deviations of its level and its slope."""
    both = np.array([level, slope])
    return Law(None, 1.0, low, high, True, np.zeros((0, 0)), both, np.zeros(2, np.bool_))


def smooth(
    low: float,
    high: float,
    reference_pressure: float,
    level: float,
    slope: float,
    departure_length: float,
) -> Law:
    """Return a straight line in ln q_ci plus departures from it.

    The departures are a natural cubic spline through 13 knots, whose values have a Matérn
    covariance of order 3/2 and a length of `departure_length` half ranges (Rasmussen and Williams,
    Gaussian Processes for Machine Learning, 2006, eq. 4.17), by its leading eigenvectors.
    """
    place = np.linspace(-1.0, 1.0, KNOTS)
    apart = np.sqrt(3.0) * np.abs(place[:, None] - place) / departure_length
    values, vectors = np.linalg.eigh((1.0 + apart) * np.exp(-apart))
    kept = values > _LEAST_EIGENVALUE * values[-1]
    terms = vectors[:, kept] * np.sqrt(values[kept])
    model = spline_between(low / reference_pressure, high / reference_pressure, KNOTS)
    departures = np.ones(terms.shape[1])
    return Law(
        model,
        reference_pressure,
        low,
        high,
        True,
        terms,
        np.concatenate([[level, slope], departures]),
        np.concatenate([[False, False], departures > 0.0]),
    )


def published(
    model: PressureErrorModel, low: float, high: float, reference_pressure: float, size: float
) -> Law:
    """Return a model of the table under a prior of `size` [-] on each orthonormal term over the
    range.
    """
    x = np.geomspace(low, high, _POINTS) / reference_pressure
    terms = np.linalg.inv(np.linalg.qr(model.basis(x))[1]) * np.sqrt(len(x))
    count = terms.shape[1]
    return Law(
        model,
        reference_pressure,
        low,
        high,
        False,
        terms,
        np.full(count, size),
        np.zeros(count, np.bool_),
    )
