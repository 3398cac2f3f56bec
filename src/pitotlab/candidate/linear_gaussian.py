"""Linear equations with normal unknowns and correlated noise of unknown size, marginalized.

y = Xβ + e with β ~ N(0, 1/Λ(φ)) and e ~ N(0, C(φ)). The parameters φ, logarithms of the sizes and
lengths of the noise, have a prior. Given φ the answer is normal; the answer with φ marginalized is
a mixture of such normals (integrated nested Laplace approximations: Rue, Martino and Chopin,
Journal of the Royal Statistical Society B 71, 2009), each weighted by the likelihood of φ.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pitotbench.records import NoAnswerError
from pitotbench.units import Array

Precision = Callable[[Array], Array]  # φ (b, d) to the precision of each unknown, (b, p)
LogPrior = Callable[[Array], Array]  # φ (b, d) to the logarithm of its density, (b,)

UNDETERMINED = (
    "the log does not determine the answer within its noise: check the clock, the units and the "
    "columns, or choose a model with fewer parameters"
)


class NoiseStack(Protocol):
    """Several covariances of the same rows."""

    @property
    def log_determinants(self) -> Array:
        """ln|C| of each, (b,)."""
        ...

    def weigh(self, data: Array) -> Array:
        """C⁻¹ D under each, (b, rows, k)."""
        ...


class NoiseOf(Protocol):
    """A family of covariances."""

    def stack(self, phis: Array) -> NoiseStack:
        """Return the covariances for parameters φ (b, d)."""
        ...


@dataclass(frozen=True, slots=True)
class Search:
    """How the mode of φ is searched and how its posterior is drawn.

    `difference` is the step of numerical derivatives, `longest` that of the search, in units of
    ln φ. A step that gains less than `settled` in log-posterior ends the search. `draws` is the
    number of values of φ; they scatter `wider` times the normal that fits the mode. No direction
    counts as narrower or wider than `narrowest` and `widest`.
    """

    difference: float = 0.03
    longest: float = 2.0
    settled: float = 0.1
    steps: int = 60
    renewed: int = 6  # steps after which the second derivatives are computed anew
    halvings: int = 12
    flattest: float = 0.2
    draws: int = 48
    far: float = 1.5
    shortest_side: float = 0.4
    longest_side: float = 2.5
    seldom: float = 1e-3  # share of the weight below which a draw is left out
    wider: float = 1.15
    narrowest: float = 0.05
    widest: float = 1.5
    seed: int = 20111


@dataclass(frozen=True, slots=True)
class Equations:
    """Equations whose noise is independent of that of all others.

    `residual` (n,) is what is left at the unknowns' values `point` (q,); `regressors` (n, q) of the
    unknowns `places` (q,); `instruments` (n, q), the regressors or smoothed copies that do not
    share their measurement noise; `noise_of` gives the noise for the parameters `own` of φ.
    """

    residual: Array
    point: Array
    regressors: Array
    instruments: Array
    places: NDArray[np.intp]
    noise_of: NoiseOf
    own: slice


@dataclass(frozen=True, slots=True)
class _Products:
    """Products of columns D of one set of equations, DᵀC⁻¹D (k, k), and ln|C|."""

    log_determinant: float
    squares: Array


@dataclass(frozen=True, slots=True)
class Hypothesis:
    """One prior of the unknowns: its name, its probability before the data, its precision for φ."""

    name: str
    probability: float
    precision_of: Precision


@dataclass(frozen=True, slots=True)
class Normal:
    """The answer given one φ and hypothesis: weight, mean (p,) and covariance (p, p)."""

    weight: float
    hypothesis: int
    noise: Array
    mean: Array
    covariance: Array


@dataclass(slots=True)
class LinearGaussian:
    """The problem: sets of equations that share `count` unknowns.

    `hypotheses` are rival priors of the unknowns, with a precision of 0 for a flat one; `log_prior`
    is the density of φ. What a set of equations contributes is remembered by its own parameters, so
    that a change of another set's costs no more than dense algebra of p unknowns.
    """

    equations: Sequence[Equations]
    count: int
    hypotheses: Sequence[Hypothesis]
    log_prior: LogPrior
    _known: dict[tuple[int, bool, bytes], _Products] = field(default_factory=dict)

    def heights(self, phis: Array, hypothesis: int = 0) -> Array:
        """The log-posterior of φ at (b, d), up to a constant; −∞ where β is not determined, (b,)."""
        try:
            squares, response, log_determinants = self._sums(phis)
            precision = self.hypotheses[hypothesis].precision_of(phis)
            diagonal = np.arange(self.count)
            squares[:, diagonal, diagonal] += precision
            diagonals = np.diagonal(squares, axis1=1, axis2=2)
            if not np.all(diagonals > 0.0):
                raise np.linalg.LinAlgError(UNDETERMINED)
            scale = np.sqrt(diagonals)
            root = np.linalg.cholesky(squares / scale[:, :, None] / scale[:, None, :])
        except np.linalg.LinAlgError:
            if len(phis) == 1:
                return np.array([-np.inf])  # the search then tries a shorter step
            return np.concatenate([self.heights(phi[None], hypothesis) for phi in phis])
        pulled = np.linalg.solve(root, (response[:, :-1] / scale)[..., None])[..., 0]
        log_normal = np.sum(np.log(np.diagonal(root, axis1=1, axis2=2)) + np.log(scale), axis=1)
        known = np.where(precision > 0.0, precision, 1.0)
        misfit = response[:, -1] - np.sum(pulled**2, axis=1)
        return np.asarray(
            self.log_prior(phis)
            + np.log(self.hypotheses[hypothesis].probability)
            - 0.5 * (log_determinants + misfit - np.sum(np.log(known), axis=1))
            - log_normal
        )

    def solve(self, phi: Array, hypothesis: int = 0) -> tuple[Array, Array]:
        """Return the unknowns (p,) and their covariance (p, p) given φ (d,).

        Raises NoAnswerError where the equations do not determine them.
        """
        p = self.count
        squares, mixed, pulled = np.zeros((p, p)), np.zeros((p, p)), np.zeros(p)
        for number, part in enumerate(self.equations):
            (found,) = self._products(number, phi[None, part.own], True)
            q, within = len(part.places), np.ix_(part.places, part.places)
            squares[within] += found.squares[:q, :q]
            mixed[within] += found.squares[:q, q + 1 :]
            pulled[part.places] += found.squares[:q, q]
        prior = np.diag(self.hypotheses[hypothesis].precision_of(phi[None])[0])
        scale = np.sqrt(np.diag(squares + prior))
        if not np.all(scale > 0.0):
            raise NoAnswerError(UNDETERMINED)
        scales = np.outer(scale, scale)
        try:
            inverse = np.linalg.inv((mixed + prior) / scales) / scales
        except np.linalg.LinAlgError as error:
            raise NoAnswerError(UNDETERMINED) from error
        covariance = inverse @ (squares + prior) @ inverse.T
        return inverse @ pulled, np.asarray(0.5 * (covariance + covariance.T))

    @property
    def owners(self) -> list[slice]:
        """The parameters of φ that belong to one set of equations each."""
        return [part.own for part in self.equations]

    @property
    def rivals(self) -> int:
        """The number of hypotheses."""
        return len(self.hypotheses)

    def answers(self, phi: Array, hypothesis: int, weight: float) -> list[Normal]:
        """The one answer given φ."""
        return [Normal(weight, hypothesis, phi, *self.solve(phi, hypothesis))]

    def information(self, phi: Array) -> tuple[Array, Array]:
        """What the equations say of the unknowns given φ (d,): precision (p, p) and pull (p,)."""
        squares, response, _ = (part[0] for part in self._sums(phi[None]))
        return squares, response[:-1]

    def by_instruments(self, phi: Array, hypothesis: int = 0) -> tuple[Array, Array]:
        """The unknowns (p,) and their covariance (p, p) given φ (d,), instruments as regressors."""
        squares, response, _ = (part[0] for part in self._sums(phi[None]))
        precision = squares + np.diag(self.hypotheses[hypothesis].precision_of(phi[None])[0])
        scale = np.sqrt(np.diag(precision))
        covariance = np.linalg.inv(precision / np.outer(scale, scale)) / np.outer(scale, scale)
        return covariance @ response[:-1], covariance

    def _sums(self, phis: Array) -> tuple[Array, Array, Array]:
        """ZᵀC⁻¹Z, [ZᵀC⁻¹y, yᵀC⁻¹y] and ln|C| of all equations, for each φ of (b, d)."""
        b, p = len(phis), self.count
        squares, response, log_determinants = np.zeros((b, p, p)), np.zeros((b, p + 1)), np.zeros(b)
        for number, part in enumerate(self.equations):
            found = self._products(number, phis[:, part.own])
            products = np.stack([each.squares for each in found])
            squares[np.ix_(np.arange(b), part.places, part.places)] += products[:, :-1, :-1]
            response[:, [*part.places, p]] += products[:, :, -1]
            log_determinants += [each.log_determinant for each in found]
        return squares, response, log_determinants

    def _products(self, number: int, owns: Array, regressors: bool = False) -> list[_Products]:
        """Products of [Z y], or [Z y X] with the regressors, for the φ of one set of equations."""
        part = self.equations[number]
        keys = [(number, regressors, own.tobytes()) for own in owns]
        missing = {k: own for k, own in zip(keys, owns, strict=True) if k not in self._known}
        if missing:
            # The same residual for both: what smoothing takes off the columns is no noise.
            seen = part.regressors if regressors else part.instruments
            data = np.column_stack([part.instruments, part.residual + seen @ part.point])
            if regressors:
                data = np.column_stack([data, part.regressors])
            noises = part.noise_of.stack(np.stack([*missing.values()]))
            squares = np.swapaxes(noises.weigh(data), 1, 2) @ data
            for key, d, s in zip(missing, noises.log_determinants, squares, strict=True):
                self._known[key] = _Products(float(d), s)
        return [self._known[key] for key in keys]


class Surface(Protocol):
    """A log-posterior of φ, of one or several hypotheses."""

    @property
    def owners(self) -> list[slice]:
        """Parameters of φ whose mixed derivatives with those of other owners are negligible."""
        ...

    @property
    def rivals(self) -> int:
        """The number of hypotheses."""
        ...

    def heights(self, phis: Array, hypothesis: int = 0, /) -> Array:
        """The log-posterior at φ (b, d), −∞ where there is none, (b,)."""
        ...

    def answers(self, phi: Array, hypothesis: int, weight: float, /) -> list[Normal]:
        """The answers given one φ, which share `weight`."""
        ...


@dataclass(frozen=True, slots=True)
class Mode:
    """The mode of φ, (d,), and minus the second derivatives of its log-posterior there, (d, d)."""

    place: Array
    curvature: Array


def mode_of(
    problem: Surface, near: Mode | Array, search: Search, enough: float, hypothesis: int = 0
) -> Mode:
    """Return the mode of φ, searched from a place (d,) or from the mode of a similar problem.

    Newton's method with numerical derivatives. The second derivatives are updated with each step
    (Broyden, Fletcher, Goldfarb and Shanno 1970), and computed anew now and then. The search ends
    with a step that gains less than `enough` in log-posterior. Raises NoAnswerError where it does
    not converge.
    """
    if isinstance(near, Mode):
        place, curvature = near.place, near.curvature
        here, slope = _slope(problem, place, search, hypothesis)
    else:
        place = near
        here, slope, curvature = _around(problem, place, search, hypothesis)
    for number in range(1, search.steps + 1):
        if number % search.renewed == 0:
            here, slope, curvature = _around(problem, place, search, hypothesis)
        if not (
            np.isfinite(here) and np.all(np.isfinite(slope)) and np.all(np.isfinite(curvature))
        ):
            raise NoAnswerError(UNDETERMINED)
        # Absolute eigenvalues make each step go uphill even where the function is not yet concave.
        values, vectors = np.linalg.eigh(curvature)
        step = vectors @ ((vectors.T @ slope) / np.maximum(np.abs(values), search.flattest))
        step *= min(1.0, search.longest / max(float(np.linalg.norm(step)), 1e-12))
        if float(slope @ step) < enough:
            return Mode(place + step, curvature)
        for _ in range(search.halvings):
            there, ahead = _slope(problem, place + step, search, hypothesis)
            if np.isfinite(there) and there > here:
                break
            step = 0.5 * step
        else:
            return Mode(place, curvature)
        curvature = _updated(curvature, step, slope - ahead)
        place, here, slope = place + step, there, ahead
    raise NoAnswerError(
        "the noise of this log has no most likely level: look for stuck or constant channels"
    )


def with_curvature(problem: Surface, mode: Mode, search: Search, hypothesis: int = 0) -> Mode:
    """Return the mode with its second derivatives computed anew."""
    return Mode(mode.place, _around(problem, mode.place, search, hypothesis)[2])


def _updated(curvature: Array, step: Array, change: Array) -> Array:
    """The curvature after a step over which the slope fell by `change`."""
    if float(step @ change) <= 0.0:
        return curvature
    along = curvature @ step
    length = float(step @ along)
    if length <= 0.0:
        return curvature
    fresh = np.outer(change, change) / float(step @ change)
    return np.asarray(curvature - np.outer(along, along) / length + fresh)


def drawn(
    found: Sequence[tuple[Surface, Mode]],
    search: Search,
    hypothesis: int = 0,
    weighted: bool = True,
) -> tuple[tuple[Normal, ...], Array]:
    """Return the answers at values of φ drawn around the mode of each rival surface.

    Each mode is that of one hypothesis; the answers are those of all, weighted by their likelihood.
    Many parameters are drawn from the normal at their mode alone, not `weighted`: importance
    weights then rest on a few draws. Returns also the share of each surface. Raises NoAnswerError
    where the equations determine no answer.
    """
    draws = [draws_of(surface, mode, search, hypothesis) for surface, mode in found]
    logs = []
    for (surface, mode), (phis, base) in zip(found, draws, strict=True):
        rivals = range(surface.rivals)
        heights = np.array([surface.heights(phis, h) for h in rivals])
        if not weighted:
            flat = heights - np.logaddexp.reduce(heights, axis=0)
            at_mode = surface.heights(mode.place[None], hypothesis)[0]
            heights = flat + at_mode - base + np.mean(base)
        logs.append(heights + base)
    highest = max(float(np.max(log)) for log in logs)
    if not np.isfinite(highest):
        raise NoAnswerError(UNDETERMINED)
    weights = [np.exp(log - highest) for log in logs]
    total = sum(float(weight.sum()) for weight in weights)
    answers = [
        answer
        for (surface, _), (phis, _), weight in zip(found, draws, weights, strict=True)
        for h, i in np.argwhere(weight > search.seldom * total)
        for answer in surface.answers(phis[i], int(h), float(weight[h, i]))
    ]
    kept = sum(each.weight for each in answers)
    scaled = tuple(replace(each, weight=each.weight / kept) for each in answers)
    return scaled, np.array([float(weight.sum()) / total for weight in weights])


def draws_of(
    problem: Surface, mode: Mode, search: Search, hypothesis: int = 0
) -> tuple[Array, Array]:
    """Draw values of φ around a mode, (m, d), each with the logarithm of its base weight, (m,).

    The draws come in pairs on both sides of the mode, with a fixed seed.
    """
    axes, d = _axes(mode.curvature, search), len(mode.place)
    ahead, behind = _sides(problem, mode.place, axes, search, hypothesis)
    half = np.random.default_rng(search.seed).standard_normal((search.draws // 2, d))
    z = np.concatenate([np.zeros((1, d)), half, -half])
    sides = search.wider * np.where(z >= 0.0, ahead, behind)
    volume = float(np.linalg.slogdet(axes)[1])
    return mode.place + (z * sides) @ axes.T, np.sum(0.5 * z**2 + np.log(sides), axis=1) + volume


def _sides(
    problem: Surface, place: Array, axes: Array, search: Search, hypothesis: int
) -> tuple[Array, Array]:
    """How far the posterior reaches on either side of its mode, along each axis, (d,) (d,).

    In units of the axes' lengths, 1 for a normal (the split normal of Rue, Martino and Chopin 2009,
    §6.5): levels that the log hardly shows reach far toward zero.
    """
    d, far = len(place), search.far
    heights = problem.heights(
        np.concatenate([place[None], place + far * axes.T, place - far * axes.T]), hypothesis
    )
    fall = np.maximum(heights[0] - heights[1:], 0.5 * (far / search.longest_side) ** 2)
    sides = np.clip(far / np.sqrt(2.0 * fall), search.shortest_side, search.longest_side)
    return sides[:d], sides[d:]


def _slope(problem: Surface, place: Array, search: Search, hypothesis: int) -> tuple[float, Array]:
    """Return the height and its central first derivatives, (d,)."""
    step = np.eye(len(place)) * search.difference
    heights = problem.heights(np.array([place, *(place + step), *(place - step)]), hypothesis)
    ahead, behind = np.split(heights[1:], 2)
    with np.errstate(invalid="ignore"):
        return float(heights[0]), (ahead - behind) / (2.0 * search.difference)


def _around(
    problem: Surface, place: Array, search: Search, hypothesis: int
) -> tuple[float, Array, Array]:
    """Return the height, the central first derivatives, (d,), and minus the second ones, (d, d)."""
    d, h = len(place), search.difference
    step = np.eye(d) * h
    owners = problem.owners
    pairs = [(i, j) for i in range(d) for j in range(i) if not _apart(i, j, owners)]
    both = [place + step[i] + step[j] for i, j in pairs]
    places = np.array([place, *(place + step), *(place - step), *both])
    (here,), ahead, behind, mixed = np.split(
        problem.heights(places, hypothesis), [1, d + 1, 2 * d + 1]
    )
    with np.errstate(invalid="ignore"):
        curvature = np.diag((2.0 * here - ahead - behind) / h**2)
        for (i, j), value in zip(pairs, mixed, strict=True):
            curvature[i, j] = curvature[j, i] = -((value - ahead[i] - ahead[j] + here) / h**2)
        return float(here), (ahead - behind) / (2.0 * h), curvature


def _apart(i: int, j: int, owners: Sequence[slice]) -> bool:
    """Whether two parameters belong to different sets of equations, which share little."""
    of = [{n for n, own in enumerate(owners) if own.start <= k < own.stop} for k in (i, j)]
    return bool(of[0] and of[1] and not of[0] & of[1])


def _axes(curvature: Array, search: Search) -> Array:
    """The principal axes of the posterior at its mode, one standard deviation long, (d, d)."""
    values, vectors = np.linalg.eigh(curvature)
    deviations = 1.0 / np.sqrt(np.maximum(values, 1e-6))
    return np.asarray(vectors * np.clip(deviations, search.narrowest, search.widest))
