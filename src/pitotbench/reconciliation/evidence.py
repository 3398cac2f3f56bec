"""The evidence of a log for sets of columns: inner products, sizes with priors, and the floor of
null flights.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular
from scipy.linalg.lapack import dpotrf, dpotrs
from scipy.special import log_ndtr

from pitotbench.effects import effect_of
from pitotbench.reconciliation.equations import SMALLEST, Fit, NormalEquations
from pitotbench.reconciliation.layout import Layout
from pitotbench.reconciliation.null_distribution import ScoreScale, size_label
from pitotbench.reconciliation.signatures import Signature, reads_gusts
from pitotbench.reconciliation.thresholds import THRESHOLDS
from pitotbench.records.calibration import Estimate
from pitotbench.units import Array

# The evidence for linear Gaussian models: how probable a log is when some columns have sizes with
# priors. A log is a vector r = X s + noise with white noise of variance 1 and sizes s of prior N(0,
# P). With A = XᵀX and b = Xᵀr, its probability relative to that without the columns is ln Z = ½ bᵀ
# (P⁻¹ + A)⁻¹ b − ½ ln det(I + P A), the gain of a ridge regression less an Occam factor (MacKay,
# Information Theory, Inference, and Learning Algorithms, 2003, ch. 28; Rasmussen and Williams 2006,
# §2.7). Columns that every model shares are eliminated first.

SINGULAR = 1e-9  # share of a column, or of its power, that is as good as nothing
ROUNDED = 1e-6  # share of a power below which the rest of a difference is rounding


@dataclass(frozen=True, slots=True)
class SizePosterior:
    """The posterior of some sizes: mean, (k,), covariance, (k, k), and the logarithm of the
    evidence.
    """

    mean: Array
    covariance: Array
    log_evidence: float


@dataclass(frozen=True, slots=True)
class Evidence:
    """The inner products of a log, (m + 1, m + 1): columns in units of the noise, and the residual
    last.
    """

    inner: Array

    def of(self, columns: Sequence[int], deviations: Sequence[float] | Array) -> SizePosterior:
        """Return the posterior of the sizes of some columns with these prior deviations, (k,)."""
        if not len(columns):
            return SizePosterior(np.zeros(0), np.zeros((0, 0)), 0.0)
        factor, right, scale = self._factored(columns, deviations)
        solved = _solved(factor, right)
        covariance = _solved(factor, np.eye(len(scale))) * (scale[:, None] * scale)
        return SizePosterior(
            solved * scale, covariance, _log_evidence(factor, float(right @ solved))
        )

    def _factored(
        self, columns: Sequence[int], deviations: Sequence[float] | Array
    ) -> tuple[Array, Array, Array]:
        """The Cholesky factor of I + PA, b in units of the deviations, and these deviations."""
        chosen, scale = np.asarray(columns, dtype=np.intp), np.asarray(deviations, dtype=np.float64)
        scaled = self.inner[chosen[:, None], chosen] * (scale[:, None] * scale)
        scaled.flat[:: len(chosen) + 1] += 1.0
        return _factor(scaled), self.inner[chosen, -1] * scale, scale

    def given(
        self,
        columns: Sequence[int],
        deviations: Sequence[float] | Array,
        kept: Sequence[int] | None = None,
    ) -> tuple["Evidence", float]:
        """Return the evidence with some columns eliminated, and the logarithm of their own
        evidence.

        Only the columns `kept` remain, all of them by default; the columns keep their order. A
        column that is eliminated and kept stands for a further size of its own.
        """
        size = len(self.inner)
        rows = np.arange(size) if kept is None else np.array([*kept, size - 1], dtype=np.intp)
        whole = self.inner[rows[:, None], rows]
        if not len(columns):
            return Evidence(whole), 0.0
        factor, _, scale = self._factored(columns, deviations)
        across = self.inner[np.asarray(columns, dtype=np.intp)[:, None], rows] * scale[:, None]
        removed = across.T @ _solved(factor, across)
        return Evidence(whole - removed), _log_evidence(factor, float(removed[-1, -1]))

    def beside(self, columns: Sequence[int], deviations: Array) -> "Beside":
        """Return the evidence beside a fit whose members have these columns and prior deviations,
        (k,). All columns stay, so that a member's may be asked for as a further size.
        """
        if not len(columns):
            return Beside(self, np.zeros((len(self.inner), 0)))
        factor, _, scale = self._factored(columns, deviations)
        across = self.inner[np.asarray(columns, dtype=np.intp)] * scale[:, None]
        lost = solve_triangular(factor, across, lower=True).T
        return Beside(Evidence(self.inner - lost @ lost.T), lost)

    def less_sizes(self, columns: Sequence[int], sizes: Array) -> "Evidence":
        """Return the evidence of the log less some columns of these sizes, (k,)."""
        chosen = np.asarray(columns, dtype=np.intp)
        inner, taken = self.inner.copy(), self.inner[:, chosen] @ sizes
        inner[:, -1] -= taken
        inner[-1] -= taken
        inner[-1, -1] += taken[chosen] @ sizes
        return Evidence(inner)

    def tempered(self, power: float) -> "Evidence":
        """Return the evidence of the likelihood to some power: that of noise 1/√power times as
        large.
        """
        return Evidence(power * self.inner)


@dataclass(frozen=True, slots=True)
class Beside:
    """The evidence beside the members of a fit, of the likelihood to some `power`.

    `lost`, (m + 1, k), is what k sizes of the members take from it: inner + lost lostᵀ are the
    inner products without members.
    """

    evidence: Evidence
    lost: Array
    power: float = 1.0

    def tempered(self, power: float) -> "Beside":
        """Return the same of the likelihood to a further power."""
        lost = np.sqrt(power) * self.lost
        return Beside(self.evidence.tempered(power), lost, power * self.power)


# LAPACK itself: around matrices of a few sizes SciPy's own functions take ten times as long as the
# arithmetic.
def _factor(matrix: Array) -> Array:
    """The lower Cholesky factor of I + A, (k, k), where A has no negative power but by rounding;
    what stands above its diagonal is of no use.
    """
    factor, failed = dpotrf(matrix, lower=True, clean=False)
    if failed:
        powers, axes = np.linalg.eigh(matrix)
        factor = np.linalg.cholesky((axes * np.maximum(powers, 1.0)) @ axes.T)
    return np.asarray(factor)


def _solved(factor: Array, right: Array) -> Array:
    return np.asarray(dpotrs(factor, right, lower=True)[0])


def _log_evidence(factor: Array, fall: float) -> float:
    """The logarithm of the evidence by the fall of the sum of squares."""
    return 0.5 * fall - float(np.sum(np.log(factor.diagonal())))


# The sizes of one effect, with the prior of an unknown order of magnitude.


@dataclass(frozen=True, slots=True)
class Prior:
    """The prior of the sizes of one effect: typical values, plausible ranges and least scales, (k,)
    each.
    """

    typical: Array
    low: Array
    high: Array
    least: Array

    def deviations(self, scale: float) -> Array:
        """Return the prior deviation of each size at a scale."""
        return np.asarray(np.maximum(scale, self.least) * self.typical)


def prior_of(effect: str, parameters: Sequence[str]) -> Prior:
    """Return the prior of some sizes of an effect or a formula."""
    own = [effect_of(effect).parameter(name) for name in parameters]
    values = [(abs(p.typical), p.low, p.high, 1.0 if p.defining else 0.0) for p in own]
    return Prior(*np.array(values, dtype=float).reshape(-1, 4).T)


def widest(key: tuple[str, str]) -> float:
    """Return the widest prior deviation of a size, by its effect and its parameter."""
    return THRESHOLDS.size_scales[-1] * abs(float(effect_of(key[0]).parameter(key[1]).typical))


@dataclass(frozen=True, slots=True)
class Weighed:
    """An effect weighed: the logarithm of its evidence, its sizes, (k,), and the deviations of the
    prior that suits them best, (k,).
    """

    log_evidence: float
    sizes: Array
    deviations: Array


def weigh(evidence: Evidence, columns: Sequence[int], prior: Prior) -> Weighed:
    """Return the evidence of one effect with the columns of its sizes.

    The prior of the sizes is a mixture of normal distributions, N(0, (λ typical)²), over a ladder
    of scales λ, cut at the plausible range. So no order of magnitude of a size is preferred to
    another. A size that defines its effect has no λ below 1: where it vanishes, the effect is
    another one of the table.
    """
    scales = THRESHOLDS.size_scales
    deviations = np.array([prior.deviations(s) for s in scales])
    found = [evidence.of(columns, each) for each in deviations]
    means = np.array([f.mean for f in found])
    variances = np.array([np.diag(f.covariance) for f in found])
    spread = np.sqrt(np.maximum(variances, SMALLEST))
    inside = _log_inside(means, spread, prior.low, prior.high) - _log_inside(
        np.zeros_like(means), deviations, prior.low, prior.high
    )
    logs = np.array([f.log_evidence for f in found]) + inside.sum(axis=1) - np.log(len(scales))
    total = float(np.logaddexp.reduce(logs))
    sizes = np.exp(logs - total) @ means
    return Weighed(total, sizes, deviations[int(np.argmax(logs))])


def _log_inside(mean: Array, spread: Array, low: Array, high: Array) -> Array:
    """Logarithm of the probability that normal numbers lie in their ranges."""
    upper, lower = (high - mean) / spread, (low - mean) / spread
    flip = (
        lower > 0.0
    )  # both in the upper tail: take the mirror image, where the logarithms are exact
    upper, lower = np.where(flip, -lower, upper), np.where(flip, -upper, lower)
    above, below = log_ndtr(upper), log_ndtr(lower)
    return np.asarray(above + np.log1p(-np.exp(np.minimum(below - above, -SINGULAR))))


# Score a single explanation, and tell its sizes.


def merit(fit: Fit) -> float:
    """Return the gain less the gain that further sizes bring by chance.

    Source: the Bayesian information criterion (Schwarz 1978).
    """
    return fit.gain - THRESHOLDS.free_size_penalty * (len(fit.columns) - 1)


def significance(fit: Fit) -> float:
    """Return the merit as a significance [σ]; 0 for a negative merit."""
    return float(np.sqrt(max(0.0, merit(fit))))


def estimates(signatures: Sequence[Signature], fit: Fit) -> tuple[Estimate, ...]:
    """Return the fitted sizes by the names of their parameters; the bound includes the error of the
    method.
    """
    fitted = zip(fit.columns, fit.sizes, fit.deviations, strict=True)
    return tuple(
        Estimate(
            signatures[c].parameter, float(s), 2.0 * float(np.hypot(d, THRESHOLDS.size_error * s))
        )
        for c, s, d in fitted
    )


def significant(sizes: Sequence[Estimate]) -> tuple[Estimate, ...]:
    """Return the sizes that are beyond their own bound of zero; the largest in its bound where none
    is.
    """
    beyond = tuple(size for size in sizes if abs(size.value) > size.two_sigma)
    return beyond or tuple(sorted(sizes, key=lambda size: -abs(size.value) / size.two_sigma)[:1])


# The floor: what flights without an effect show as well. One covariance of noise, wander, gusts and
# left-over sizes; it is eliminated once, and what remains counts as evidence.


def floored(
    layout: Layout, equations: NormalEquations, scores: ScoreScale, wander: Mapping[str, float]
) -> Evidence:
    """Return the evidence of a log beyond the floor, for its signatures and then its examined
    cells.

    Free parameters are eliminated, then what null flights show: the fluctuating part of each
    signature, the sizes of the vanes, the wander of each channel in its cells, and the sizes that
    are left over. What sizes have on every flight is taken off. `wander` is the surplus of the
    squared scores of a channel over 1.
    """
    k, labels = equations.free, [size_label(s.effect, s.parameter) for s in layout.signatures]
    products = equations.products.sum(axis=0)
    count, places = len(labels), layout.places
    kept = [*range(k, k + count), *(k + column for column, _ in places)]
    spread = np.array([scores.fluctuation.get(label, 1.0) for label in labels])
    moving = np.flatnonzero(spread > 1.0).tolist()
    products = _with_fluctuations(products, [*range(k), *kept[count:]], [k + i for i in moving])
    further = range(len(products) - 1 - len(moving), len(products) - 1)
    plain, _ = Evidence(products).given(range(k), equations.prior**-0.5, [*kept, *further])
    gusts = dict(zip(range(len(kept), len(kept) + len(moving)), spread[moving], strict=True))
    null_sizes = {c: float(np.sqrt(s**2 - 1.0)) for c, s in gusts.items()}
    # A vane reads gusts whole, and so do the residuals: it seems to have a wrong scale, and a
    # flight of another day has other gusts, so that twice that size is usual.
    null_sizes |= {
        i: THRESHOLDS.null_size_margin * float(spread[i])
        for i in moving
        if reads_gusts(layout.signatures[i].effect)
    }
    # What is left of a signature has the rounding of the whole one.
    powers = np.diag(plain.inner)
    whole = dict(zip(gusts, powers[moving], strict=True))
    usable = [c for c in null_sizes if powers[c] > max(SINGULAR, ROUNDED * whole.get(c, 0.0))]
    sized = np.array([null_sizes[c] for c in usable]) / np.sqrt(powers[usable])
    channels = [cell.channel for _, cell in places]
    beyond, _ = plain.given(usable, sized, range(len(kept)))
    beyond, _ = beyond.given(*_wander(plain, count, channels, wander))
    # An effect for a part of the flight is none that every flight has.
    parts = [effect_of(signature.effect).part_of for signature in layout.signatures]
    lasts = ["" if part else label for part, label in zip(parts, labels, strict=True)]
    for label, score in scores.left_over.items():
        if label in lasts:
            beyond = without_score(beyond, lasts.index(label), score)
    return _without_lasting(beyond, *scores.lasting_of(lasts), len(layout.grid))


def _with_fluctuations(products: Array, beside: Sequence[int], columns: Sequence[int]) -> Array:
    """Inner products with what cells and free parameters leave of some columns, before the
    residual.

    An elevator that answers a gust moves with the pitching of the gust, as one of another
    effectiveness would.
    """
    scale = 1.0 / np.sqrt(np.maximum(np.diag(products)[beside], SMALLEST))
    normal = products[np.ix_(beside, beside)] * np.outer(scale, scale)
    across = products[np.ix_(beside, columns)] * scale[:, None]
    turn = np.zeros((len(products), len(columns)))
    turn[columns, range(len(columns))] = 1.0
    turn[beside] -= scale[:, None] * np.linalg.lstsq(normal, across, rcond=SINGULAR)[0]
    every = np.eye(len(products))
    whole = np.hstack([every[:, :-1], turn, every[:, -1:]])
    return np.asarray(whole.T @ products @ whole)


def _wander(
    plain: Evidence, first: int, channels: Sequence[str], wander: Mapping[str, float]
) -> tuple[list[int], Array]:
    """The cells with the prior deviations that the wander of null flights asks for.

    The surplus of a channel is shared among its cells, which overlap. The first cell stands in the
    column `first`.
    """
    columns, deviations = list[int](), list[float]()
    for channel in dict.fromkeys(channels):
        cells = [first + i for i, name in enumerate(channels) if name == channel]
        usable = [c for c in cells if plain.inner[c, c] > SINGULAR]
        surplus = wander.get(channel, 0.0)
        if surplus <= 0.0 or not usable:
            continue
        part = plain.inner[np.ix_(usable, usable)]
        own = np.diag(part)
        overlap = float(np.mean(np.sum(part**2 / np.outer(own, own), axis=1)))
        columns += usable
        deviations += np.sqrt(surplus / overlap / own).tolist()
    return columns, np.array(deviations)


def _without_lasting(
    evidence: Evidence, columns: list[int], scores: Array, products: Array, instants: int
) -> Evidence:
    """Return the evidence without the lasting scores of some columns, (k,), with their mean inner
    products, (k, k), both an instant.

    What null flights show there acts on the residual as sizes would, so that cells and other
    effects see it as well. It is not taken off along an axis on which the log says far less of the
    sizes than null flights do: such scores are none that the log can have.
    """
    usual = instants * THRESHOLDS.lasting_share * products
    normal = evidence.inner[np.ix_(columns, columns)] + usual
    scale = 1.0 / np.sqrt(np.maximum(np.diag(normal), SMALLEST))
    scaled, right = normal * np.outer(scale, scale), instants * scores * scale
    return evidence.less_sizes(columns, scale * np.linalg.lstsq(scaled, right, SINGULAR)[0])


def without_score(evidence: Evidence, column: int, score: float) -> Evidence:
    """Return the evidence with the size of a column eliminated as far as flights without it seem to
    have it.

    `score` is the root mean square of its score there: what remains of a score is that many times
    smaller.
    """
    power = float(evidence.inner[column, column])
    if power <= SMALLEST:
        return evidence
    return evidence.given([column], [np.sqrt((score**2 - 1.0) / power)])[0]
