"""The noise of two independent sets of rows under one regression: log-likelihoods add, and so do normal matrices.

Each set has noise parameters of its own. What one set contributes is remembered by its parameters, so that a change
of the other set's parameters costs no more than small dense algebra: this halves the work of mixed derivatives and
of a grid of nodes.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from pitotbench.units import Array


class Noise(Protocol):
    """What an estimator asks of a covariance."""

    @property
    def log_determinant(self) -> float:
        """ln|C|."""
        ...

    def weigh(self, data: Array) -> Array:
        """C⁻¹ times data of shape (rows, k)."""
        ...


class NoiseStack(Protocol):
    """Several covariances of the same rows."""

    @property
    def log_determinants(self) -> Array:
        """ln|C| of each, (b,)."""
        ...

    def weigh(self, data: Array) -> Array:
        """C⁻¹ of each times data of shape (rows, k): (b, rows, k)."""
        ...


class NoiseOf(Protocol):
    """A family of noises: φ (d,) to a covariance."""

    def __call__(self, phi: Array, /) -> Noise:
        """Return the covariance for φ."""
        ...


@runtime_checkable
class StackingNoiseOf(Protocol):
    """A family that makes many covariances at once, which costs less than one by one."""

    def __call__(self, phi: Array, /) -> Noise:
        """Return the covariance for φ (d,)."""
        ...

    def stack(self, phis: Array) -> NoiseStack:
        """Return the covariances for many φ, (b, d)."""
        ...


def weighed_by_each(noise_of: NoiseOf, phis: Array, data: Array) -> tuple[Array, Array]:
    """Return ln|C|, (b,), and C⁻¹ times data (rows, k), (b, rows, k), for every φ of (b, d).

    Raises numpy.linalg.LinAlgError where one of the covariances is not positive definite.
    """
    if isinstance(noise_of, StackingNoiseOf):
        stack = noise_of.stack(phis)
        weighed = stack.weigh(data)  # before the determinants: a point noise finds both together
        return stack.log_determinants, weighed
    noises = [noise_of(phi) for phi in phis]
    weighed = np.stack([noise.weigh(data) for noise in noises])
    return np.array([noise.log_determinant for noise in noises]), weighed


@dataclass(frozen=True, slots=True)
class _Part:
    """What one set of rows contributes under one noise: ln|C|, C⁻¹D and DᵀC⁻¹D of its own columns D of [Z y]."""

    log_determinant: float
    weighed: Array
    products: Array


@dataclass(slots=True)
class JointNoiseOf:
    """φ = (parameters of the first set, of the second) to a JointNoise.

    `data` (rows, p + 1): instruments and response of the problem that the products are remembered for. `first` has
    `count` parameters and `size` rows.
    """

    data: Array
    first: NoiseOf
    second: NoiseOf
    count: int
    size: int
    _known: dict[tuple[int, bytes], _Part] = field(default_factory=dict)
    _moved: dict[int, NDArray[np.intp]] = field(default_factory=dict)

    def __call__(self, phi: Array, /) -> "JointNoise":
        return JointNoise(self, phi)

    @property
    def rows(self) -> tuple[slice, slice]:
        """The rows of each set."""
        return slice(None, self.size), slice(self.size, None)

    def own(self, phi: Array) -> tuple[Array, Array]:
        """The parameters of each set, of φ (d,) or (b, d)."""
        return phi[..., : self.count], phi[..., self.count :]

    def families(self) -> tuple[NoiseOf, NoiseOf]:
        """The families of the two sets."""
        return self.first, self.second

    def learn(self, phis: Array) -> None:
        """Compute what is not yet known for any φ of (b, d)."""
        for place, own in enumerate(self.own(phis)):
            missing = {(place, phi.tobytes()): phi for phi in own if (place, phi.tobytes()) not in self._known}
            if not missing:
                continue
            data = self.data[self.rows[place]][:, self.columns(place)]
            determinants, weighed = weighed_by_each(self.families()[place], np.stack([*missing.values()]), data)
            parts = zip(determinants, weighed, data.T @ weighed, strict=True)
            self._known |= {key: _Part(float(d), w, q) for key, (d, w, q) in zip(missing, parts, strict=True)}

    def parts(self, phi: Array) -> tuple[_Part, ...]:
        """What each set contributes under φ (d,)."""
        self.learn(phi[None])
        return tuple(self._known[place, own.tobytes()] for place, own in enumerate(self.own(phi)))

    def columns(self, place: int) -> NDArray[np.intp]:
        """The columns of [Z y] that are not zero in the rows of a set."""
        if place not in self._moved:
            self._moved[place] = np.flatnonzero(np.any(self.data[self.rows[place]] != 0.0, axis=0))
        return self._moved[place]


class JointNoise:
    """The block-diagonal covariance of two sets of rows, under φ (d,) of a family."""

    def __init__(self, family: JointNoiseOf, phi: Array) -> None:
        self._family, self._phi = family, phi

    @property
    def log_determinant(self) -> float:
        """ln|C|."""
        return sum(part.log_determinant for part in self._family.parts(self._phi))

    @property
    def first(self) -> tuple[Noise, slice]:
        """The noise of the first set, and its rows."""
        return self._noises()[0], self._family.rows[0]

    def _noises(self) -> Sequence[Noise]:
        families = zip(self._family.families(), self._family.own(self._phi), strict=True)
        return [noise_of(own) for noise_of, own in families]

    def weigh(self, data: Array) -> Array:
        """C⁻¹ times data of shape (rows, k)."""
        parts = zip(self._noises(), self._family.rows, strict=True)
        return np.concatenate([noise.weigh(data[rows]) for noise, rows in parts])

    def products(self) -> Array:
        """[Z y]ᵀC⁻¹[Z y] of the problem, (p + 1, p + 1)."""
        size = self._family.data.shape[1]
        total = np.zeros((size, size))
        for place, part in enumerate(self._family.parts(self._phi)):
            columns = self._family.columns(place)
            total[np.ix_(columns, columns)] += part.products
        return total

    def weighed_instruments(self) -> Array:
        """C⁻¹Z of the problem, (rows, p)."""
        weighed = np.zeros_like(self._family.data)
        for place, part in enumerate(self._family.parts(self._phi)):
            weighed[self._family.rows[place], self._family.columns(place)] = part.weighed
        return weighed[:, :-1]
