"""The evidence of a log for an effect, whose sizes have priors, and the floor of null flights."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import log_ndtr

from pitotbench.effects import effect_of
from pitotbench.effects.effect import Parameter
from pitotbench.estimation.information import SINGULAR, Information
from pitotbench.normal_equations import inverse
from pitotbench.reconciliation.equations import Fit, NormalEquations
from pitotbench.reconciliation.layout import Layout
from pitotbench.reconciliation.null_distribution import ScoreScale, size_label
from pitotbench.reconciliation.signatures import Signature, reads_gusts
from pitotbench.reconciliation.thresholds import THRESHOLDS
from pitotbench.records.calibration import Estimate
from pitotbench.units import Array

NEGLIGIBLE = 1e-9  # share of a column, or of its power, that is as good as nothing
SMALLEST = 1e-300  # sum of squares of an empty column, so that it can be divided by


# The sizes of one effect, with the prior of an unknown order of magnitude.


@dataclass(frozen=True, slots=True)
class Prior:
    """The prior of one effect's sizes: typical values, plausible ranges, least scales, (k,)."""

    typical: Array
    low: Array
    high: Array
    least: Array

    def deviations(self, scale: float) -> Array:
        """Return the prior deviation of each size at a scale."""
        return np.asarray(np.maximum(scale, self.least) * self.typical)


def prior_of(sizes: Sequence[Parameter]) -> Prior:
    """Return the prior of some sizes of an effect or a formula."""
    values = [(abs(p.typical), p.low, p.high, 1.0 if p.defining else 0.0) for p in sizes]
    return Prior(*np.array(values, dtype=float).reshape(-1, 4).T)


def widest(size: Parameter) -> float:
    """Return the widest prior deviation of a size."""
    return THRESHOLDS.size_scales[-1] * abs(size.typical)


@dataclass(frozen=True, slots=True)
class Weighed:
    """An effect weighed: ln of its evidence, its sizes (k,), and the best prior deviations (k,)."""

    log_evidence: float
    sizes: Array
    deviations: Array


def weigh(evidence: Information, columns: Sequence[int], prior: Prior) -> Weighed:
    """Return the evidence of one effect with the columns of its sizes.

    The prior of the sizes is a mixture of normal distributions, N(0, (λ typical)²), over a ladder
    of scales λ, cut at the plausible range. So no order of magnitude of a size is preferred to
    another. A size that defines its effect has no λ below 1: where it vanishes, the effect is
    another one of the table.
    """
    scales = THRESHOLDS.size_scales
    deviations = np.array([prior.deviations(s) for s in scales])
    found = [evidence.posterior(columns, each) for each in deviations]
    means = np.array([f.mean for f in found])
    variances = np.array([np.diag(f.covariance) for f in found])
    spread = np.sqrt(np.maximum(variances, SMALLEST))
    inside = log_inside(means, spread, prior.low, prior.high) - log_inside(
        np.zeros_like(means), deviations, prior.low, prior.high
    )
    logs = np.array([f.log_evidence for f in found]) + inside.sum(axis=1) - np.log(len(scales))
    total = float(np.logaddexp.reduce(logs))
    sizes = np.exp(logs - total) @ means
    return Weighed(total, sizes, deviations[int(np.argmax(logs))])


def log_inside(mean: Array, spread: Array, low: Array, high: Array) -> Array:
    """Logarithm of the probability that normal numbers lie in their ranges."""
    upper, lower = (high - mean) / spread, (low - mean) / spread
    flip = (
        lower > 0.0
    )  # both in the upper tail: take the mirror image, where the logarithms are exact
    upper, lower = np.where(flip, -lower, upper), np.where(flip, -upper, lower)
    above, below = log_ndtr(upper), log_ndtr(lower)
    return np.asarray(above + np.log1p(-np.exp(np.minimum(below - above, -NEGLIGIBLE))))


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
    """Return the fitted sizes by parameter, the error of the method in their bounds."""
    fitted = zip(fit.columns, fit.sizes, fit.deviations, strict=True)
    return tuple(
        Estimate(
            signatures[c].parameter, float(s), 2.0 * float(np.hypot(d, THRESHOLDS.size_error * s))
        )
        for c, s, d in fitted
    )


def significant(sizes: Sequence[Estimate]) -> tuple[Estimate, ...]:
    """Return the sizes that are beyond their own bound of zero, else the largest in its bound."""
    beyond = tuple(size for size in sizes if abs(size.value) > size.two_sigma)
    return beyond or tuple(sorted(sizes, key=lambda size: -abs(size.value) / size.two_sigma)[:1])


# The floor: what flights without an effect show as well. One covariance of noise, wander, gusts and
# left-over sizes; it is eliminated once, and what remains counts as evidence.


def evidence_beyond_floor(
    layout: Layout, equations: NormalEquations, scores: ScoreScale, wander: Mapping[str, float]
) -> Information:
    """Return the evidence of a log's signatures, then of its examined cells, beyond the floor.

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
    plain, _ = Information(products).given(range(k), equations.prior**-0.5, [*kept, *further])
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
    usable = [c for c in null_sizes if powers[c] > max(NEGLIGIBLE, SINGULAR * whole.get(c, 0.0))]
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
    return without_lasting(beyond, *scores.lasting_of(lasts), len(layout.grid))


def _with_fluctuations(products: Array, beside: Sequence[int], columns: Sequence[int]) -> Array:
    """Return the products with fluctuations of columns, what `beside` leave of them, added.

    They stand before the residual. An elevator that answers a gust moves with the pitching of the
    gust, as one of another effectiveness would. `beside` are cells and free parameters.
    """
    across = products[np.ix_(beside, columns)]
    turn = np.zeros((len(products), len(columns)))
    turn[columns, range(len(columns))] = 1.0
    turn[beside] -= inverse(products[np.ix_(beside, beside)], NEGLIGIBLE) @ across
    every = np.eye(len(products))
    whole = np.hstack([every[:, :-1], turn, every[:, -1:]])
    return np.asarray(whole.T @ products @ whole)


def _wander(
    plain: Information, first: int, channels: Sequence[str], wander: Mapping[str, float]
) -> tuple[list[int], Array]:
    """The cells with the prior deviations that the wander of null flights asks for.

    The surplus of a channel is shared among its cells, which overlap. The first cell stands in the
    column `first`.
    """
    columns, deviations = list[int](), list[float]()
    for channel in dict.fromkeys(channels):
        cells = [first + i for i, name in enumerate(channels) if name == channel]
        usable = [c for c in cells if plain.inner[c, c] > NEGLIGIBLE]
        surplus = wander.get(channel, 0.0)
        if surplus <= 0.0 or not usable:
            continue
        part = plain.inner[np.ix_(usable, usable)]
        own = np.diag(part)
        overlap = float(np.mean(np.sum(part**2 / np.outer(own, own), axis=1)))
        columns += usable
        deviations += np.sqrt(surplus / overlap / own).tolist()
    return columns, np.array(deviations)


def without_lasting(
    evidence: Information, columns: list[int], scores: Array, products: Array, instants: int
) -> Information:
    """Return the evidence without the lasting scores of some columns, (k,).

    `products` are their mean inner products, (k, k). Both are those of an instant.

    What null flights show there acts on the residual as sizes would, so that cells and other
    effects see it as well. It is not taken off along an axis on which the log says far less of the
    sizes than null flights do: such scores are none that the log can have.
    """
    usual = instants * THRESHOLDS.lasting_share * products
    normal = evidence.inner[np.ix_(columns, columns)] + usual
    return evidence.less(columns, inverse(normal, NEGLIGIBLE) @ (instants * scores))


def without_score(evidence: Information, column: int, score: float) -> Information:
    """Return the evidence less a column's size, as far as flights without it seem to have it.

    `score` is the root mean square of its score there: what remains of a score is that many times
    smaller.
    """
    power = float(evidence.inner[column, column])
    if power <= SMALLEST:
        return evidence
    return evidence.given([column], [np.sqrt((score**2 - 1.0) / power)])[0]
