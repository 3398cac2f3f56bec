"""The noise of two independent sets of rows under one regression: log-likelihoods add, and so do normal matrices.

Each set has noise parameters of its own. What one set contributes is remembered by its parameters, so that a change
of the other set's parameters costs no more than small dense algebra: this halves the work of mixed derivatives and
of a grid of nodes.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Protocol

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


@dataclass(slots=True)
class _Part:
    """The noise of one set of rows, and the products with that set's data, made when first asked for."""

    noise: Noise
    rows: slice
    columns: NDArray[np.intp]  # of [Z y], that are not zero in these rows
    products: Array | None = None
    weighed_instruments: Array | None = None


class JointNoise:
    """The block-diagonal covariance of two sets of rows.

    `data` (rows, p + 1): instruments and response, and `instruments` (rows, p), of the problem that the products
    are remembered for.
    """

    def __init__(self, data: Array, instruments: Array, parts: Sequence[_Part]) -> None:
        self._data, self._instruments, self._parts = data, instruments, parts

    @property
    def log_determinant(self) -> float:
        """ln|C|."""
        return sum(part.noise.log_determinant for part in self._parts)

    @property
    def first(self) -> tuple[Noise, slice]:
        """The noise of the first set, and its rows."""
        return self._parts[0].noise, self._parts[0].rows

    def weigh(self, data: Array) -> Array:
        """C⁻¹ times data of shape (rows, k)."""
        return np.concatenate([part.noise.weigh(data[part.rows]) for part in self._parts])

    def products(self) -> Array:
        """[Z y]ᵀC⁻¹[Z y] of the problem, (p + 1, p + 1)."""
        total = np.zeros((self._data.shape[1], self._data.shape[1]))
        for part in self._parts:
            if part.products is None:
                own = self._data[part.rows][:, part.columns]
                part.products = own.T @ part.noise.weigh(own)
            total[np.ix_(part.columns, part.columns)] += part.products
        return total

    def weighed_instruments(self) -> Array:
        """C⁻¹Z of the problem, (rows, p)."""
        for part in self._parts:
            if part.weighed_instruments is None:
                part.weighed_instruments = part.noise.weigh(self._instruments[part.rows])
        return np.concatenate(
            [part.weighed_instruments for part in self._parts if part.weighed_instruments is not None]
        )


@dataclass(slots=True)
class JointNoiseOf:
    """φ = (parameters of the first set, of the second) to a JointNoise.

    `first` has `count` parameters and `size` rows.
    """

    data: Array
    instruments: Array
    first: Callable[[Array], Noise]
    second: Callable[[Array], Noise]
    count: int
    size: int
    _known: dict[tuple[int, bytes], _Part] = field(default_factory=dict)
    _moved: dict[int, NDArray[np.intp]] = field(default_factory=dict)

    def __call__(self, phi: Array) -> JointNoise:
        rows = self.rows
        own = (phi[: self.count], phi[self.count :])
        parts = []
        for place, noise_of in enumerate((self.first, self.second)):
            key = (place, own[place].tobytes())
            if key not in self._known:
                self._known[key] = _Part(noise_of(own[place]), rows[place], self._columns(place))
            parts.append(self._known[key])
        return JointNoise(self.data, self.instruments, parts)

    @property
    def rows(self) -> tuple[slice, slice]:
        """The rows of each set."""
        return slice(None, self.size), slice(self.size, None)

    def _columns(self, place: int) -> NDArray[np.intp]:
        if place not in self._moved:
            self._moved[place] = np.flatnonzero(np.any(self.data[self.rows[place]] != 0.0, axis=0))
        return self._moved[place]
