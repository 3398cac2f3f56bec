"""A model without a formula: a natural cubic spline in ln x, for curves that no formula of the table follows.

Its parameters are the values of Δp/q_c at the knots (the cardinal basis: de Boor, A Practical Guide to Splines,
1978, ch. IV), so they can be read off a plot. Beyond the outer knots the curve is a straight line in ln x.
"""

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from pitotbench.units import Array

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

_LEAST = 1e-3  # of the first knot: the smallest x used, so that a bad iterate still has a logarithm


@dataclass(frozen=True, slots=True)
class SplineModel:
    """A natural cubic spline in ln x through one value at each knot; knots are values of x = q_ci/q_ref.

    Raises ValueError for fewer than three knots, and for knots that are not positive and increasing.
    """

    name: str
    knots: tuple[float, ...]

    def __post_init__(self) -> None:
        if len(self.knots) < 3 or self.knots[0] <= 0.0 or not np.all(np.diff(self.knots) > 0.0):
            raise ValueError(f"a spline needs at least three knots that increase from above zero, got {self.knots}")

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """The names of the parameters, k1, k2 …: one for each knot."""
        return tuple(f"k{number}" for number in range(1, len(self.knots) + 1))

    @property
    def formula(self) -> str:
        """The model in words, with the place of every parameter's knot."""
        places = ", ".join(f"{k} at {x:.2f}" for k, x in zip(self.parameter_names, self.knots, strict=True))
        return f"natural cubic in ln x through {places}"

    def basis(self, x: Array) -> Array:
        """Return the cardinal functions at x, (n,), as an array (n, k): each is 1 at its knot, 0 at the others."""
        # Outside the knots the curve continues with the slope at the last knot; inside, `beyond` is zero.
        place, inside = self._places(x)
        spline = _cardinal(self.knots)
        values = spline(inside)
        beyond = place - inside
        if np.any(beyond):
            values = values + beyond[..., None] * spline(inside, 1)
        return np.asarray(values)

    def basis_slope(self, x: Array) -> Array:
        """Return the derivatives of the cardinal functions with respect to x, (n, k)."""
        _, inside = self._places(x)
        return np.asarray(_cardinal(self.knots)(inside, 1) / x[..., None])

    def spread_over(self, low: float, high: float) -> "SplineModel":
        """Return a spline with the same number of knots, evenly spaced in ln x between low and high."""
        return spline_between(low, high, len(self.knots))

    def _places(self, x: Array) -> tuple[Array, Array]:
        place = np.log(np.maximum(x, _LEAST * self.knots[0]))
        return place, np.clip(place, np.log(self.knots[0]), np.log(self.knots[-1]))


def spline_between(low: float, high: float, count: int) -> SplineModel:
    """Return a spline with `count` knots, evenly spaced in ln x between low and high."""
    return SplineModel("spline", tuple(float(x) for x in np.geomspace(low, high, count)))


@cache
def _cardinal(knots: tuple[float, ...]) -> "CubicSpline":
    from scipy.interpolate import CubicSpline  # slow to load: the other models do without it

    return CubicSpline(np.log(knots), np.eye(len(knots)), bc_type="natural")


SPLINE = spline_between(0.5, 4.0, 5)  # about 70 to 200 KIAS; a calibration replaces it by the range of its log
