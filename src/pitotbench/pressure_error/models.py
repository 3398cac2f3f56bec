"""The models of a pressure error, a smooth one, and curves of them.

Source: Martos, Kiszely and Foster (2011), Fig 4.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from numpy.polynomial import legendre

from pitotbench import air
from pitotbench.units import Array, Pascal

Term = Callable[[Array], Array]


@dataclass(frozen=True, slots=True)
class TermModel:
    """A model of Δp/q_c that is linear in its parameters.

    `terms` holds a term and its slope for each parameter.

    The models of Martos, Kiszely and Foster (2011, Fig 4) are such sums in x = q_ci/q_ref. The
    source shows Inverse+ only as a figure; k1 + k2 x + k3/x is our reading of it.
    """

    name: str
    parameter_names: tuple[str, ...]
    terms: tuple[tuple[Term, Term], ...]
    formula: str

    def basis(self, x: Array) -> Array:
        """Return the terms at x = q_ci/q_ref, (n,), as an array (n, k) [-] of k parameters."""
        return _columns([term for term, _ in self.terms], x)

    def curve(self, x: Array, parameters: Array) -> tuple[Array, Array]:
        """Return Δp/q_c for parameters (k,), and its derivative with respect to x, (n,) each."""
        return self.basis(x) @ parameters, _columns([s for _, s in self.terms], x) @ parameters

    @property
    def precisions(self) -> Array:
        """No prior of the parameters, (1, k)."""
        return np.zeros((1, len(self.terms)))

    def spread_over(self, low: float, high: float) -> "TermModel":
        """Return the model itself: a formula has no range."""
        return self


def _columns(terms: Sequence[Term], x: Array) -> Array:
    """Return the terms as columns, (n, k)."""
    # Each column is contiguous in memory, because fits work column by column.
    rows = np.empty((len(terms), *np.shape(x)))
    for row, term in zip(rows, terms, strict=True):
        row[...] = term(x)
    return rows.transpose(*range(1, rows.ndim), 0)


ONE: tuple[Term, Term] = (np.ones_like, np.zeros_like)
X: tuple[Term, Term] = (lambda x: x, np.ones_like)
X_SQUARED: tuple[Term, Term] = (lambda x: x * x, lambda x: 2.0 * x)
ONE_OVER_X: tuple[Term, Term] = (lambda x: 1.0 / x, lambda x: -1.0 / (x * x))

BIAS = TermModel("bias", ("k1",), (ONE,), "k1")
LINEAR = TermModel("linear", ("k1", "k2"), (ONE, X), "k1 + k2 x")
QUADRATIC = TermModel("quadratic", ("k1", "k2", "k3"), (ONE, X, X_SQUARED), "k1 + k2 x + k3 x²")
INVERSE = TermModel("inverse", ("k1", "k2"), (ONE, ONE_OVER_X), "k1 + k2/x")
INVERSE_PLUS = TermModel("inverse+", ("k1", "k2", "k3"), (ONE, X, ONE_OVER_X), "k1 + k2 x + k3/x")


_LEAST = 1e-3  # of the low end: the smallest x used, so that a bad iterate still has a logarithm


_DEGREES = 8  # polynomials of degree 0 to 7
_RIVALS = (0.25, 1.0, 4.0)  # of the usual size of the departures
_LEAST_RANGE = 2.0  # ratio of the ends, as from 100 to 141 kt: over less a curve changes by less
_QUADRATURE = 24  # points, more than the degrees


def _sizes() -> Array:
    """What each polynomial is multiplied by: all departures together have a mean square of 1."""
    size = np.ones(_DEGREES)
    size[2:] = np.arange(2, _DEGREES) ** -2.0
    size[2:] /= np.linalg.norm(size[2:])
    return np.asarray(size * np.sqrt(2.0 * np.arange(_DEGREES) + 1.0))


_SIZES = _sizes()
_DERIVED = legendre.legder(np.eye(_DEGREES))  # of each polynomial, in those of lower degree


@dataclass(frozen=True, slots=True)
class SmoothModel:
    """A smooth curve over x = q_ci/q_ref from `low` to `high`, a straight line in ln x beyond.

    A curve of which nothing is known but that it is smooth. It is a level, a slope in ln x, a part
    in 1/x (the error of a static source follows the angle of attack, and the lift coefficient of
    level flight is proportional to 1/x), and departures from these. Over the flown range of ln x, u
    from −1 to 1, they are Legendre polynomials with a mean square of 1. The departures fall as
    1/degree², the rate of curves with a square-integrable second derivative. Their size is one of a
    few, alike likely: the log decides.

    `slope`, `lift` and `departure` [Δp/q_c] are one standard deviation of the root mean square of
    the slope's part, of the part in 1/x, and of the departures in the middle one of the rival
    priors. `level` is one of the level, for a fit that hardly sees it: unknown elsewhere.
    """

    name: str
    low: float
    high: float
    level: float = np.inf
    slope: float = 0.06
    lift: float = 0.06
    departure: float = 0.002

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """The names of the parameters: the level, the slope, the part in 1/x, the departures."""
        return tuple(f"k{number}" for number in range(1, _DEGREES + 2))

    @property
    def formula(self) -> str:
        """The model in words, with its range."""
        level, slope, lift, *others = self.parameter_names
        return (
            f"{level} level, {slope} slope in ln x, {lift} part in 1/x, {', '.join(others)} "
            f"departures (Legendre polynomials of ln x); x from {self.low:.2f} to {self.high:.2f}"
        )

    @property
    def precisions(self) -> Array:
        """The rival priors of the parameters as precisions, (r, k)."""
        known = [self.level, self.slope, self.lift]
        return np.array([[*known, *[size] * (_DEGREES - 2)] for size in self.departures]) ** -2.0

    @property
    def departures(self) -> tuple[float, ...]:
        """The sizes of the departures in the rival priors, (r,) [Δp/q_c]."""
        return tuple(share * self.departure for share in _RIVALS)

    def basis(self, x: Array) -> Array:
        """Return the terms at x, (n,), as an array (n, k)."""
        place, inside = self._places(x)
        terms, beyond = self._terms(inside), place - inside
        return terms + beyond[..., None] * self._slopes(inside) if np.any(beyond) else terms

    def curve(self, x: Array, parameters: Array) -> tuple[Array, Array]:
        """Return Δp/q_c for parameters (k,), and its derivative with respect to x, (n,) each.

        The polynomials are summed before they are evaluated: the terms one by one take longer.
        """
        place, inside = self._places(x)
        level, slope, scatter = _lift_over(self._half)
        share, decay = parameters[2] / scatter, np.exp(-self._half * inside)
        sums = _SIZES * (
            np.delete(parameters, 2) - share * np.pad([level, slope], (0, _DEGREES - 2))
        )
        by_place = legendre.legval(inside, _DERIVED @ sums) - self._half * share * decay
        value = legendre.legval(inside, sums) + share * decay + (place - inside) * by_place
        return value, by_place / (self._half * np.asarray(x))

    def spread_over(self, low: float, high: float) -> "SmoothModel":
        """Return the model over another range, or the least one for which the prior is meant."""
        margin = float(np.sqrt(max(_LEAST_RANGE * low / high, 1.0)))
        return replace(self, low=low / margin, high=high * margin)

    @property
    def _half(self) -> float:
        return 0.5 * float(np.log(self.high / self.low))

    def _places(self, x: Array) -> tuple[Array, Array]:
        floor = np.maximum(x, _LEAST * self.low)
        place = (np.log(floor) - 0.5 * np.log(self.low * self.high)) / self._half
        return place, np.clip(place, -1.0, 1.0)

    def _terms(self, place: Array) -> Array:
        polynomials = legendre.legvander(place, _DEGREES - 1) * _SIZES
        return self._with_lift(polynomials, np.exp(-self._half * place))

    def _slopes(self, place: Array) -> Array:
        slopes = legendre.legvander(place, _DEGREES - 2) @ _DERIVED * _SIZES
        return self._with_lift(slopes, -self._half * np.exp(-self._half * place))

    def _with_lift(self, of_degree: Array, lift: Array) -> Array:
        """The terms, or their slopes, with what level and slope leave of 1/x in the third place."""
        level, slope, scatter = _lift_over(self._half)
        unlike_lift = (lift - level * of_degree[..., 0] - slope * of_degree[..., 1]) / scatter
        # each column is contiguous in memory, because fits work column by column
        rows = [
            of_degree[..., 0],
            of_degree[..., 1],
            unlike_lift,
            *np.moveaxis(of_degree[..., 2:], -1, 0),
        ]
        return np.moveaxis(np.stack(rows), 0, -1)


@cache
def _lift_over(half: float) -> tuple[float, float, float]:
    """The level, the slope and the scatter of 1/x over u; ln x spans `half` to each side."""
    place, weight = legendre.leggauss(_QUADRATURE)
    lift = np.exp(-half * place)
    level, slope = 0.5 * (weight * lift) @ (legendre.legvander(place, 1) * _SIZES[:2])
    return float(level), float(slope), float(np.sqrt(0.5 * weight @ lift**2 - level**2))


SMOOTH = SmoothModel("smooth", 0.5, 4.0)
PressureErrorModel = TermModel | SmoothModel


_ITERATIONS = 60  # of the secant method, which needs some six
_TOLERANCE = 1e-12  # of the impact pressure, near what a double holds


class PressureErrorRangeError(ValueError):
    """The pressure error has no solution at an impact pressure. The message says where and why."""


class _Curve(ABC):
    """What the curves share: true and indicated impact pressure of one another."""

    __slots__ = ()

    @abstractmethod
    def normalized(self, indicated_impact_pressure: Pascal) -> Array:
        """Return Δp/q_c [-] at an indicated impact pressure [Pa], any shape."""

    def impact_pressure(self, indicated_impact_pressure: Pascal) -> Pascal:
        """Return the true q_c = q_ci/(1 − f) of an indicated impact pressure [Pa], any shape."""
        q_ci = np.asarray(indicated_impact_pressure, dtype=np.float64)
        return q_ci / (1.0 - self.normalized(q_ci))

    def indicated_impact_pressure(self, impact_pressure: Pascal) -> Pascal:
        """Return the indicated impact pressure of a true one [Pa], (n,): q_ci = q_c (1 − f(q_ci)).

        Raises PressureErrorRangeError where no solution is found, because f is close to 1 or above.
        """
        return invert(self.normalized, impact_pressure)


@dataclass(frozen=True, slots=True)
class PressureErrorCurve(_Curve):
    """A pressure-error curve Δp/q_c = f(q_ci/q_ref).

    Δp = q_c − q_ci has the sign of Martos et al. (2011).

    `reference_pressure` is q_ref [Pa]. Raises ValueError where the number of parameters does not
    fit the model.
    """

    model: PressureErrorModel
    parameters: tuple[float, ...]
    reference_pressure: float

    def __post_init__(self) -> None:
        if len(self.parameters) != len(self.model.parameter_names):
            wanted = ", ".join(self.model.parameter_names)
            raise ValueError(
                f"model {self.model.name!r} takes the parameters {wanted}, got {self.parameters}"
            )

    def normalized(self, indicated_impact_pressure: Pascal) -> Array:
        """Return Δp/q_c [-] at an indicated impact pressure [Pa], any shape."""
        x = np.asarray(indicated_impact_pressure, dtype=np.float64) / self.reference_pressure
        return np.asarray(self.model.basis(x) @ np.asarray(self.parameters))


def invert(normalized: Callable[[Array], Array], impact_pressure: Pascal) -> Pascal:
    """Solve q_ci = q_c (1 − f(q_ci)) for q_ci [Pa], (n,), sample by sample, by the secant method.

    `normalized` is f as a function of q_ci [Pa]. Raises PressureErrorRangeError where no solution
    is found.
    """
    q_c = np.asarray(impact_pressure, dtype=np.float64)
    # Two starting points for the secant: no error, and one step of the fixed-point iteration from
    # there.
    old = q_c.copy()
    gap_old = q_c * (1.0 - normalized(old)) - old
    new = old + gap_old
    for _ in range(_ITERATIONS):
        gap = q_c * (1.0 - normalized(new)) - new
        if not np.all(np.isfinite(gap)) or np.any(new <= 0.0):
            break
        if np.all(np.abs(gap) <= _TOLERANCE * q_c):
            return new
        step = new - old
        # Without a usable slope (a step near zero, a flat difference) take −1, which is right for
        # small f.
        slope = np.divide(
            gap - gap_old, step, out=np.full_like(step, -1.0), where=np.abs(step) > 1e-9 * q_c
        )
        old, gap_old = new, gap
        new = new - gap / np.where(np.abs(slope) < 0.1, -1.0, slope)
    low, high = float(np.min(q_c)), float(np.max(q_c))
    raise PressureErrorRangeError(
        f"the pressure error has no indicated impact pressure for q_c between {low:.0f} and "
        f"{high:.0f} Pa; it must stay well below 1 and vary slowly there: check its parameters and "
        "reference pressure"
    )


@dataclass(frozen=True, slots=True)
class TableCurve(_Curve):
    """Δp/q_c [-] over two or more increasing indicated airspeeds [m/s], linear, held at the ends.

    Raises ValueError for fewer points, or airspeeds that do not increase.
    """

    airspeed: tuple[float, ...]
    values: tuple[float, ...]

    def __post_init__(self) -> None:
        if len(self.airspeed) < 2 or len(self.airspeed) != len(self.values):
            raise ValueError(
                "a pressure-error table needs at least two airspeeds, and one value for each"
            )
        if not np.all(np.diff(self.airspeed) > 0.0):
            raise ValueError("the airspeeds of a pressure-error table must increase")

    def normalized(self, indicated_impact_pressure: Pascal) -> Array:
        """Return Δp/q_c [-] at an indicated impact pressure [Pa], any shape."""
        speed = air.calibrated_airspeed(indicated_impact_pressure)
        return np.interp(speed, self.airspeed, self.values)
