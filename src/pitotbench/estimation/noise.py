"""Models of noise: Gauss-Markov processes, joint noise of two sets of rows, autoregression."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_banded, solve_toeplitz
from scipy.linalg.lapack import dpbtrf, dpbtrs

from pitotbench.units import Array, Seconds

UNIFORM = 1.0 / float(np.sqrt(12.0))  # standard deviation of what is uniform over one
# interval over correlation time below which the bridge's leading term is exact enough
_SMALL = 1e-2
_SAME = 1e-12  # step over correlation time below which values at two edges are the same to rounding
_SINGULAR = "the covariance of the noise is not positive definite"


@dataclass(frozen=True, slots=True)
class Intervals:
    """The intervals of the data.

    `edges` are times [s], (s,), increasing. `left` is the index of the edge that starts each
    interval, (n,), increasing; the next edge ends it.
    """

    edges: Seconds
    left: NDArray[np.intp]

    @property
    def length(self) -> Seconds:
        """The length of each interval [s], (n,)."""
        return self.edges[self.left + 1] - self.edges[self.left]

    def at_edges(self, values: Array) -> Array:
        """Assign values of intervals, (n,), to the edges, (s,); a shared edge has the later one."""
        edges = np.empty(len(self.edges))
        edges[self.left + 1] = values
        edges[self.left] = values
        return edges


@dataclass(frozen=True, slots=True)
class MarkovProcess:
    """A process with c independent components of equal statistics.

    `deviation` is the standard deviation [unit of the data], a number, or (b,) for a stack of
    noises. `correlation_time` [s], (s,) or (b, s), holds from each edge to the next; its last entry
    is not used. `loading` is the effect of each component on each interval, (n, c), or (o, n, c)
    for o outputs: a column of ones for noise that adds directly, direction cosines for the
    components of a wind. The loadings of two outputs must be at right angles in every interval, so
    that the remainders within an interval are independent.
    """

    deviation: float | Array
    correlation_time: Seconds
    loading: Array


class MarkovNoise:
    """The factored covariance, or a stack of b, of white noise and Markov processes over intervals.

    The likelihood is exact, in linear time. The data are means over short intervals. The states of
    a process are its values at the edges of the intervals. Given these, the mean over an interval
    is known up to an independent remainder, the integral of an Ornstein-Uhlenbeck bridge. A
    Gauss-Markov process has a tridiagonal precision (Rue and Held, Gaussian Markov Random Fields,
    2005, ch. 2). One banded Cholesky factor and the matrix-inversion lemma therefore give products
    with C⁻¹ and log|C| in O(N); C itself is never formed. Intervals may have gaps between them, and
    the white variance may differ from interval to interval. Several outputs an interval (such as
    the velocity along and across the path) may share the processes with different loadings; their
    data follow each other, output by output.

    Parameters: intervals; white, the variance of the white noise [unit²], positive, (n,), or (o, n)
    for o outputs, or (b, o, n) for a stack; processes. A stack costs less than its noises one by
    one: most of the time of a short log goes to the calls on its short arrays. Its numbers are the
    same bit for bit. Raises numpy.linalg.LinAlgError where a covariance is not positive definite.
    For valid input this happens only where a correlation time is so long that two edges have the
    same value to rounding.
    """

    def __init__(
        self, intervals: Intervals, white: Array, processes: Sequence[MarkovProcess]
    ) -> None:
        # Two edges without data between them get an empty interval, without load or weight. Every
        # array is then regular, and slices replace indices, which would take longer than the
        # arithmetic.
        self._step, self._processes = np.diff(intervals.edges), processes
        for process in processes:  # none may have the same value at two edges
            if not np.all(self._step > _SAME * process.correlation_time[..., :-1]):
                raise np.linalg.LinAlgError(_SINGULAR)
        self._rows = intervals.left
        self._stacked = white.ndim == 3
        white = white if self._stacked else np.atleast_2d(white)[None]
        self._variance = np.ones((*white.shape[:2], len(intervals.edges) - 1))
        self._variance[:, :, self._rows] = white
        self._width = sum(process.loading.shape[-1] for process in processes)
        self._states = len(intervals.edges) * self._width
        self._loads = self._interval_means(intervals, processes)

    @cached_property
    def _factored(self) -> tuple[Array, list[Array]]:
        """ln|C| of every noise of a stack, (b,), and the banded Cholesky factors of its states.

        Made when first asked for: of some noises only the parameters are.
        """
        determinants: Array = np.log(self._variance).reshape(len(self._variance), -1).sum(axis=1)
        if not self._processes:
            return determinants, []
        return determinants, self._posterior_precision(self._step, self._processes, determinants)

    @property
    def log_determinant(self) -> float:
        """ln|C|, of one noise."""
        return float(self.log_determinants[0])

    @property
    def log_determinants(self) -> Array:
        """ln|C| of every noise of a stack, (b,)."""
        return self._factored[0]

    def _interval_means(
        self, intervals: Intervals, processes: Sequence[MarkovProcess]
    ) -> list[list[Array]]:
        """Return the loads of interval means on the components at both edges, (b, n) by output.

        The variance of the remainders (the bridges) is added to the white variance. With a = Δ/τ,
        E[mean | edges] = tanh(a/2)/a · (sum of the edges); the remainder follows from the total
        variance.
        """
        outputs = range(self._variance.shape[1])
        loads: list[list[Array]] = [[] for _ in outputs]
        for process in processes:
            deviation = np.asarray(process.deviation)[..., None]
            a = np.atleast_2d(intervals.length / process.correlation_time[..., intervals.left])
            share = np.tanh(0.5 * a) / a
            decay = np.exp(-a)
            remainder = 2.0 * (a - 1.0 + decay) / a**2 - 2.0 * share**2 * (1.0 + decay)
            # For short intervals the formula subtracts nearly equal numbers; its leading term is
            # a/6.
            remainder = np.where(a < _SMALL, a / 6.0, remainder)
            by_output = process.loading.reshape(-1, *process.loading.shape[-2:])
            for output, loading in zip(outputs, by_output, strict=True):
                self._variance[:, output, self._rows] += (
                    deviation**2 * np.sum(loading**2, axis=1) * remainder
                )
                for component in loading.T:
                    load = np.zeros((len(self._variance), self._variance.shape[2]))
                    load[:, self._rows] = deviation * share * component
                    loads[output].append(load)
        return [load + load for load in loads]

    def _at(self, place: int) -> slice:
        """Return the states that load `place` of each interval multiplies, left edges first."""
        return slice(place, place + self._states - self._width, self._width)

    def _posterior_precision(
        self, step: Seconds, processes: Sequence[MarkovProcess], determinants: Array
    ) -> list[Array]:
        """Return banded Cholesky factors, by edge, of the states' precision given the data.

        What they make of ln|C| is added to `determinants`, (b,).
        """
        m = self._width
        bands = np.zeros((len(self._variance), 2 * m, self._states))
        first = 0
        for process in processes:
            # A step has the correlation time of the edge that begins it, as its interval has.
            time = np.atleast_2d(process.correlation_time)[:, :-1]
            decay = np.exp(-step / time)
            innovation = -np.expm1(-2.0 * step / time)
            diagonal = np.ones((len(time), len(step) + 1))
            diagonal[:, 1:] = 1.0 / innovation
            diagonal[:, :-1] += decay**2 / innovation
            count = process.loading.shape[-1]
            for j in range(first, first + count):
                bands[:, 0, j::m] = diagonal
                bands[:, m, j : self._states - m : m] = -decay / innovation
            determinants += count * np.sum(np.log(innovation), axis=1)
            first += count
        self._add_data(bands)
        factors = []
        for place, band in enumerate(bands):
            factor, failed = dpbtrf(band, lower=1, overwrite_ab=1)
            if failed:
                raise np.linalg.LinAlgError(_SINGULAR)
            determinants[place] += 2.0 * float(np.sum(np.log(factor[0])))
            factors.append(factor)
        return factors

    def _add_data(self, bands: Array) -> None:
        """Add the data's information on the states: products of loads over the white variance."""
        for output, loads in enumerate(self._loads):
            for p, load in enumerate(loads):
                weighted = load / self._variance[:, output]
                for q in range(p + 1):
                    bands[:, p - q, self._at(q)] += weighted * loads[q]

    def weigh(self, data: Array) -> Array:
        """Return C⁻¹ times data (n, k), or (o n, k) for o outputs; (b, n, k) of a stack."""
        (stack, outputs, cells), columns = self._variance.shape, data.shape[1]
        # transposed: as the banded solver wants it
        scaled = np.zeros((stack, outputs, columns, cells))
        scaled[..., self._rows] = np.swapaxes(data.reshape(outputs, -1, columns), 1, 2)
        scaled /= self._variance[:, :, None, :]
        if self._factored[1]:
            self._take_off_explained(scaled)
        weighed = np.swapaxes(scaled[..., self._rows], 2, 3).reshape(stack, -1, columns)
        return weighed if self._stacked else np.asarray(weighed[0])

    @property
    def precision_blocks(self) -> Array:
        """The blocks of C⁻¹ between the outputs of each interval, (n, o, o), of one noise.

        The states' covariance at the two edges of an interval is all that they need. It follows
        from the Cholesky factor edge by edge from the last (Takahashi, Fagan and Chin 1973): with
        the blocks A of the factor at an edge and B below it, and G = B A⁻¹, the covariance at an
        edge is (A Aᵀ)⁻¹ + Gᵀ Z G with Z at the next, and −Z G between the two.
        """
        m, square = self._width, self._width**2
        row, column = np.indices((m, m))
        factor = self._factored[1][0].reshape(2 * m, -1, m)
        root = np.linalg.inv(np.tril(np.moveaxis(factor[row - column, :, column], 2, 0)))
        passed = np.moveaxis(factor[m + row - column, :, column], 2, 0) @ root
        # Linear in Z, element by element: one banded system for all edges.
        kept = np.einsum("eac,ebd->ecdab", passed, passed).reshape(-1, square, square)
        bands = np.zeros((2 * square, len(root), square))
        bands[-1] = 1.0
        row, column = np.indices((square, square))
        bands[square - 1 + row - column, 1:, column] = -np.moveaxis(kept[:-1], 0, 2)
        alone = np.swapaxes(root, 1, 2) @ root
        own = solve_banded((0, 2 * square - 1), bands.reshape(2 * square, -1), alone.ravel())
        own = own.reshape(-1, m, m)
        lower = -own[1:] @ passed[:-1]
        edges = np.block([[own[:-1], np.swapaxes(lower, 1, 2)], [lower, own[1:]]])
        white = self._variance[0].T[:, :, None]
        weights = np.moveaxis(np.array(self._loads)[:, :, 0], 2, 0) / white
        blocks = np.eye(white.shape[1]) / white - weights @ edges @ np.swapaxes(weights, 1, 2)
        return np.asarray(blocks[self._rows])

    def _take_off_explained(self, scaled: Array) -> None:
        """Turn data over white variance, (b, o, k, intervals), into C⁻¹ times data, in place."""
        right = np.zeros((len(scaled), scaled.shape[2], self._states))
        for output, loads in enumerate(self._loads):
            for p, load in enumerate(loads):
                right[:, :, self._at(p)] += load[:, None, :] * scaled[:, output]
        for factor, part in zip(self._factored[1], right, strict=True):
            part[...] = dpbtrs(factor, part.T, lower=1, overwrite_b=1)[0].T
        for output, loads in enumerate(self._loads):
            variance = self._variance[:, None, output]
            for p, load in enumerate(loads):
                scaled[:, output] -= load[:, None, :] * right[:, :, self._at(p)] / variance


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
    """What one set of rows contributes under one noise: ln|C|, C⁻¹D and DᵀC⁻¹D.

    D are its own columns of [Z y].
    """

    log_determinant: float
    weighed: Array
    products: Array


@dataclass(slots=True)
class JointNoiseOf:
    """φ = (parameters of the first set, of the second) to a JointNoise.

    `data` (rows, p + 1): instruments and response of the problem that the products are remembered
    for. `first` has `count` parameters and `size` rows.
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
            missing = {
                (place, phi.tobytes()): phi
                for phi in own
                if (place, phi.tobytes()) not in self._known
            }
            if not missing:
                continue
            data = self.data[self.rows[place]][:, self.columns(place)]
            determinants, weighed = weighed_by_each(
                self.families()[place], np.stack([*missing.values()]), data
            )
            parts = zip(determinants, weighed, data.T @ weighed, strict=True)
            self._known |= {
                key: _Part(float(d), w, q) for key, (d, w, q) in zip(missing, parts, strict=True)
            }

    def parts(self, phi: Array) -> tuple[_Part, ...]:
        """What each set contributes under φ (d,)."""
        keys = [(place, own.tobytes()) for place, own in enumerate(self.own(phi))]
        if not all(key in self._known for key in keys):
            self.learn(phi[None])
        return tuple(self._known[key] for key in keys)

    def columns(self, place: int) -> NDArray[np.intp]:
        """The columns of [Z y] that are not zero in the rows of a set."""
        if place not in self._moved:
            self._moved[place] = np.flatnonzero(np.any(self.data[self.rows[place]] != 0.0, axis=0))
        return self._moved[place]


class JointNoise:
    """The block-diagonal covariance of two sets of rows, under φ (d,) of a family.

    Each set has noise parameters of its own. What one set contributes is remembered by its
    parameters, so that a change of the other set's parameters costs no more than small dense
    algebra: this halves the work of mixed derivatives and of a grid of nodes.
    """

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


RIDGE = 1e-4  # share of white noise that is added, so that the equations stay well posed
SMALLEST = 1e-30  # variance of a channel that does not change


def yule_walker(autocovariance: Array) -> tuple[Array, float]:
    """Return the prediction coefficients, (p,), and the standard deviation of the innovations.

    Parameters: autocovariance at lags 0 to p, (p + 1,). Source: the Yule-Walker equations
    (Lütkepohl, New Introduction to Multiple Time Series Analysis, 2005, ch. 3), solved by
    Levinson's recursion.
    """
    covariance = autocovariance.copy()
    covariance[0] = max(autocovariance[0] * (1.0 + RIDGE), SMALLEST)
    coefficients = solve_toeplitz(covariance[:-1], covariance[1:])
    variance = max(covariance[0] - coefficients @ covariance[1:], RIDGE * covariance[0])
    return coefficients, float(np.sqrt(variance))
