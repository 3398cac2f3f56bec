"""The evidence of a log for sets of effects: sizes with priors, errors of form, wander of null
flights, a rest.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np
from scipy.linalg.lapack import dpotrf, dpotrs
from scipy.special import log_ndtr

from pitotbench.reconciliation.equations import Fit, whitened_columns
from pitotbench.reconciliation.layout import Layout
from pitotbench.reconciliation.noise import NoiseModel
from pitotbench.reconciliation.null_distribution import ScoreScale, size_label
from pitotbench.reconciliation.signatures import FITTED, Signature, columns_of, reads_gusts
from pitotbench.reconciliation.thresholds import THRESHOLDS
from pitotbench.records.calibration import Estimate
from pitotbench.units import Array

# The evidence for linear Gaussian models: how probable a log is when some columns have sizes with
# priors. A log is a vector r = X s + noise with white noise of variance 1 and sizes s of prior N(0,
# P). With A = XᵀX and b = Xᵀr, its probability relative to that without the columns is ln Z = ½ bᵀ
# (P⁻¹ + A)⁻¹ b − ½ ln det(I + P A), the gain of a ridge regression less an Occam factor (MacKay,
# Information Theory, Inference, and Learning Algorithms, 2003, ch. 28; Rasmussen and Williams 2006,
# §2.7). Columns that every model shares are eliminated first.


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

    def log_evidence_of(self, columns: Sequence[int], deviations: Sequence[float] | Array) -> float:
        """Return the logarithm of the evidence for some columns with these prior deviations, (k,).

        It spares the covariance of the sizes, which costs most where the columns are many.
        """
        if not len(columns):
            return 0.0
        factor, right, _ = self._factored(columns, deviations)
        return _log_evidence(factor, float(right @ _solved(factor, right)))

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

        Only the columns `kept` remain, all of them by default; the columns keep their order.
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

    def tempered(self, power: float) -> "Evidence":
        """Return the evidence of the likelihood to some power: that of noise 1/√power times as
        large.
        """
        return Evidence(power * self.inner)

    def __add__(self, other: "Evidence") -> "Evidence":
        """Return the evidence of two logs with the same columns and the same sizes: the inner
        products add up.
        """
        return Evidence(self.inner + other.inner)


# LAPACK itself: around matrices of a few sizes SciPy's own functions take ten times as long as the
# arithmetic.
def _factor(matrix: Array) -> Array:
    """The lower Cholesky factor, (k, k); what stands above its diagonal is of no use."""
    factor, failed = dpotrf(matrix, lower=True, clean=False)
    if failed:
        raise np.linalg.LinAlgError("the inner products of a log are not positive definite")
    return np.asarray(factor)


def _solved(factor: Array, right: Array) -> Array:
    return np.asarray(dpotrs(factor, right, lower=True)[0])


def _log_evidence(factor: Array, fall: float) -> float:
    """The logarithm of the evidence by the fall of the sum of squares."""
    return 0.5 * fall - float(np.sum(np.log(factor.diagonal())))


# Form error: the directions in which a real effect differs from its entry in the table. No entry
# has exactly the form of the real effect, and at 100σ a difference of 5 % stands at 5σ. It does not
# lie just anywhere: it is a share of the effect's own signature in one channel, its signature a
# little earlier or later, one that grows with airspeed, bank, power, altitude or time, or one that
# is not linear in its size. These directions are free parameters of the effect, with a prior in
# proportion to its size (model discrepancy: Kennedy and O'Hagan 2001).

LEAST_SHARE = (
    0.02  # of the whitened sum of squares that a channel must hold to have a direction of its own
)
SHIFT = 1.0  # s; the shift in time that counts like a change by the whole size
TINY = 1e-300  # so that an empty column can be scaled


def form_directions(layout: Layout, noise: NoiseModel, columns: Sequence[Array]) -> list[Array]:
    """Return the directions of form error of each of some signatures (n, c), whitened, (n, c, k).

    Each direction is in units of one size of the effect.
    """
    whiten = noise.whitener(layout.grid, layout.residuals.slack)
    return [whiten(_directions(layout, noise, column)) for column in columns]


def _directions(layout: Layout, noise: NoiseModel, column: Array) -> Array:
    grid, slack = layout.grid, layout.residuals.slack
    power = np.sum(noise.innovations(column, grid, slack) ** 2, axis=0)
    parts = []
    for channel in np.flatnonzero(power > LEAST_SHARE * max(float(power.sum()), TINY)):
        alone = np.zeros_like(column)
        alone[:, channel] = column[:, channel]
        parts.append(alone)
    parts.append(SHIFT * np.gradient(column, grid.step, axis=0))
    parts += [column * shape[:, None] for shape in _variables(layout).T]
    spread = np.sqrt(np.mean(column**2, axis=0)) + TINY
    parts.append(column * (np.abs(column) / spread - 1.0))
    return np.stack(parts, axis=2)


def _variables(layout: Layout) -> Array:
    """The variables of the cells, (n, v), each of mean 0 and deviation 1."""
    count = len({cell.where for cell in layout.cells})
    first = layout.cells[:count]
    chosen = [
        i
        for i, cell in enumerate(first)
        if cell.variable and not cell.variable.startswith("heading")
    ]
    return layout.shapes[:, chosen]


# Score an explanation: how well one or several effects explain a gap, for the number of their
# sizes.


def merit(fit: Fit) -> float:
    """Return the gain less the gain that further sizes bring by chance.

    Source: the Bayesian information criterion (Schwarz 1978).
    """
    return fit.gain - THRESHOLDS.free_size_penalty * (len(fit.columns) - 1)


def significance(fit: Fit) -> float:
    """Return the merit as a significance [σ]; 0 for a negative merit."""
    return float(np.sqrt(max(0.0, merit(fit))))


# Sizes of effects, with their bounds as estimates.


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


LOWEST = 1e-12  # of a deviation, so that it can be divided by


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


@dataclass(frozen=True, slots=True)
class Weighed:
    """A set of effects weighed: the logarithm of its evidence, and its sizes with their covariance."""

    log_evidence: float
    sizes: Array
    covariance: Array


def weigh(evidence: Evidence, columns: Sequence[Sequence[int]], priors: Sequence[Prior]) -> Weighed:
    """Return the evidence of some effects, each with the columns of its sizes, for all their sizes
    together.

    The prior of an effect's sizes is a mixture of normal distributions, N(0, (λ typical)²), over a
    ladder of scales λ, cut at the plausible range. So no order of magnitude of a size is preferred
    to another. A size that defines its effect has no λ below 1: where it vanishes, the effect is
    another one of the table.
    """
    scales, used = THRESHOLDS.size_scales, [c for each in columns for c in each]
    if not used:
        return Weighed(0.0, np.zeros(0), np.zeros((0, 0)))
    low, high = (np.concatenate([getattr(p, end) for p in priors]) for end in ("low", "high"))
    ladders = product(*_ladders(evidence, used, priors))
    deviations = np.array(
        [
            np.concatenate([p.deviations(s) for s, p in zip(chosen, priors, strict=True)])
            for chosen in ladders
        ]
    )
    found = [evidence.of(used, each) for each in deviations]
    means, covariances = np.array([f.mean for f in found]), np.array([f.covariance for f in found])
    spread = np.sqrt(np.maximum(np.diagonal(covariances, axis1=1, axis2=2), LOWEST**2))
    inside = _log_inside(means, spread, low, high) - _log_inside(
        np.zeros_like(means), deviations, low, high
    )
    logs = (
        np.array([f.log_evidence for f in found])
        + inside.sum(axis=1)
        - len(priors) * np.log(len(scales))
    )
    total = float(np.logaddexp.reduce(logs))
    weights = np.exp(logs - total)
    mean = np.sum(weights[:, None] * means, axis=0)
    covariance = np.sum(weights[:, None, None] * covariances, axis=0)
    return Weighed(total, mean, covariance)


def _ladders(
    evidence: Evidence, columns: Sequence[int], priors: Sequence[Prior]
) -> list[tuple[float, ...]]:
    """The scales to be tried for each effect: all for a single one; else the two next to its size.

    With a smaller scale the prior excludes the size, and a larger one costs only its Occam factor.
    """
    scales = THRESHOLDS.size_scales
    if len(priors) == 1:
        return [scales]
    widest = np.concatenate([p.deviations(scales[-1]) for p in priors])
    sizes, ladders, first = np.abs(evidence.of(columns, widest).mean), [], 0
    for prior in priors:
        ratio = float(np.max(sizes[first : first + len(prior.typical)] / prior.typical))
        nearest = int(np.argmin(np.abs(np.log(np.array(scales)) - np.log(max(ratio, LOWEST)))))
        ladders.append(scales[nearest : nearest + 2])
        first += len(prior.typical)
    return ladders


def _log_inside(mean: Array, spread: Array, low: Array, high: Array) -> Array:
    """Logarithm of the probability that normal numbers lie in their ranges."""
    upper, lower = (high - mean) / spread, (low - mean) / spread
    flip = (
        lower > 0.0
    )  # both in the upper tail: take the mirror image, where the logarithms are exact
    upper, lower = np.where(flip, -lower, upper), np.where(flip, -upper, lower)
    above, below = log_ndtr(upper), log_ndtr(lower)
    return np.asarray(above + np.log1p(-np.exp(np.minimum(below - above, -LOWEST))))


# The evidence of one log for sets of effects, with their form error, the wander of null flights,
# and a rest.

ROOMS = ("airspeed", "specific_force", "acceleration", "engine", "turning")
SMALLEST = 1e-300
SINGULAR = 1e-9  # singular value below which cells and free parameters are the same
LEAST_POWER = 1e-9  # of a direction that the free parameters take up whole
SMOOTH_LEAST = 0.2  # σ; a smooth form error below it changes nothing


@dataclass(frozen=True, slots=True)
class Rest:
    """A smooth discrepancy of unknown form: its place, its cells with their prior deviations, and
    its own prior.
    """

    place: str
    columns: tuple[int, ...]
    deviations: Array
    log_prior: float


class LogEvidence:
    """What one log says of every set of effects.

    Free parameters are eliminated, and so are the wander that null flights have in the cells, the
    sizes that effects have there (`null_scores`), and the form error of the effects that are in the
    model. Directions of form error are added when an effect first needs them. `least_bayes_factor`
    is the logarithm of the Bayes factor from which the log shows a gap, infinite where it shows
    none.
    """

    def __init__(
        self,
        layout: Layout,
        noise: NoiseModel,
        wander: Mapping[str, float],
        null_scores: ScoreScale | None = None,
        least_bayes_factor: float = THRESHOLDS.gap_bayes_factor,
    ) -> None:
        self.least_bayes_factor = least_bayes_factor
        self.layout, self._noise = layout, noise
        self.signatures = layout.signatures
        self.columns = columns_of(layout.signatures)
        white = whitened_columns(layout, noise)
        k = layout.free.columns.shape[2]
        rows = white.reshape(-1, white.shape[2])
        self._products = rows.T @ rows
        # Columns in blocks, as they were added: to join them would copy them all each time.
        self._blocks, self._residual = [rows[:, :-1]], rows[:, -1:]
        self._free = range(k)
        self._free_deviations = layout.free.deviations
        self._wander = wander
        self._null_scores = null_scores or ScoreScale({}, {}, {}, {})
        self.labels = tuple(size_label(s.effect, s.parameter) for s in layout.signatures)
        self.typical = np.array(
            [abs(FITTED[s.effect].parameter(s.parameter).typical) for s in self.signatures]
        )
        self._power = self._power_by_channel()
        self._directions: dict[int, tuple[int, ...]] = {}
        self._cells = self._places()
        self._fluctuating = self._add_fluctuations()
        self._model_error: tuple[list[int], Array] = [], np.zeros(0)
        self._update()
        if layout.in_model:  # what is in the model has its form error there
            self._model_error = self.form_error(layout.in_model)
            self._update()

    @property
    def names(self) -> tuple[str, ...]:
        """The effects, in all their forms, that this log can show."""
        return tuple(self.columns)

    def directions(self, columns: Iterable[int]) -> tuple[tuple[int, ...], Array]:
        """Return the columns of form error of some signatures, and the signature that each belongs
        to, (d,).
        """
        wanted = list(columns)
        new = [c for c in wanted if c not in self._directions]
        if new:
            self._add(new)
        found = [(d, c) for c in wanted for d in self._directions[c]]
        return tuple(d for d, _ in found), np.array([c for _, c in found], dtype=np.intp)

    def _add(self, new: Sequence[int]) -> None:
        parts = form_directions(self.layout, self._noise, [self.signatures[c].column for c in new])
        places = self._append(
            np.concatenate([part.reshape(-1, part.shape[2]) for part in parts], axis=1)
        )
        for column, part in zip(new, parts, strict=True):
            self._directions[column] = tuple(next(places) for _ in range(part.shape[2]))
        self._update()

    def _append(self, added: Array) -> Iterator[int]:
        """Add whitened columns, (n·c, k), before the residual; return their places."""
        last = self._products.shape[0] - 1
        across = np.concatenate([block.T @ added for block in (*self._blocks, self._residual)])
        own = added.T @ added
        count = added.shape[1]
        order = [*range(last), *range(last + 1, last + 1 + count), last]
        whole = np.block([[self._products, across], [across.T, own]])
        self._products = whole[np.ix_(order, order)]
        self._blocks.append(added)
        first = last - len(self._free)
        return iter(range(first, first + count))

    def _add_fluctuations(self) -> dict[int, float]:
        """Add what every cell leaves of the signatures that gusts imitate, and return their null
        scores by place.

        An elevator that answers a gust moves with the pitching of the gust, as one of another
        effectiveness would.
        """
        surplus = [
            self._null_scores.fluctuation.get(label, 1.0) ** 2 - 1.0 for label in self.labels
        ]
        imitated = [i for i, more in enumerate(surplus) if more > 0.0]
        if not imitated:
            return {}
        k = len(self._free)
        beside = [*self._free, *(k + c for cells in self._cells.values() for c in cells)]
        columns = [k + i for i in imitated]
        scale = 1.0 / np.sqrt(np.maximum(np.diag(self._products)[beside], SMALLEST))
        normal = self._products[np.ix_(beside, beside)] * np.outer(scale, scale)
        across = self._products[np.ix_(beside, columns)] * scale[:, None]
        reproduced = scale[:, None] * np.linalg.lstsq(normal, across, rcond=SINGULAR)[0]
        rows = self._blocks[0]
        places = self._append(rows[:, columns] - rows[:, beside] @ reproduced)
        return {
            place: float(np.sqrt(surplus[i])) for place, i in zip(places, imitated, strict=True)
        }

    def _update(self) -> None:
        k = len(self._free)
        kept = range(k, self._products.shape[0] - 1)
        plain, _ = Evidence(self._products).given(self._free, self._free_deviations, kept)
        without_sizes, _ = plain.given(*self._null_sizes(plain))
        base, _ = without_sizes.given(*self._null_wander(plain))
        for label, score in self._null_scores.left_over.items():
            base = (
                without_score(base, self.labels.index(label), score)
                if label in self.labels
                else base
            )
        self.base, _ = base.given(*self._model_error)

    def _power_by_channel(self) -> dict[str, Array]:
        """The sum of squares of one unit of each signature in each channel, (s,)."""
        grid, slack = self.layout.grid, self.layout.residuals.slack
        columns = np.stack([s.column for s in self.signatures], axis=2)
        power = np.sum(self._noise.innovations(columns, grid, slack) ** 2, axis=0)
        return dict(zip(self.layout.residuals.names, power, strict=True))

    def form_error(self, sizes: Mapping[tuple[str, str], float]) -> tuple[list[int], Array]:
        """Return the columns of the form error of effects of these sizes, and their prior
        deviations, (d,).

        They are the directions of each effect, and a smooth discrepancy in each channel that it
        acts on.
        """
        index = {(s.effect, s.parameter): i for i, s in enumerate(self.signatures)}
        own = {index[k]: abs(float(v)) for k, v in sizes.items() if k in index}
        if not own:
            return [], np.zeros(0)
        directions, owner = self.directions(own)
        columns = list(directions)
        power = np.diag(self.base.inner)
        # What the free parameters leave of a direction is at most as long as what they leave of the
        # effect.
        length = np.sqrt(power[owner] / np.maximum(power[list(directions)], LEAST_POWER))
        sized = np.array([own[c] for c in owner.tolist()]) * np.minimum(1.0, length)
        deviations = (THRESHOLDS.form_error * sized).tolist()
        squared = np.zeros(len(self.signatures))
        whole = np.sum(list(self._power.values()), axis=0)[list(own)]
        squared[list(own)] = np.array(list(own.values())) ** 2 * np.minimum(
            1.0, power[list(own)] / np.maximum(whole, SMALLEST)
        )
        for channel, cells in self._cells.items():
            acting = THRESHOLDS.smooth_error * float(np.sqrt(self._power[channel] @ squared))
            usable = [c for c in cells if power[c] > SMALLEST]
            if acting > SMOOTH_LEAST and usable:
                columns += usable
                deviations += [acting / float(np.sqrt(len(usable) * power[c])) for c in usable]
        return columns, np.array(deviations)

    def _places(self) -> dict[str, list[int]]:
        """The cells of each channel."""
        found: dict[str, list[int]] = {}
        for column, cell in self.layout.places:
            found.setdefault(cell.channel, []).append(column)
        return found

    def _null_wander(self, plain: Evidence) -> tuple[list[int], Array]:
        """The cells with the prior deviations that the wander of null flights asks for.

        The surplus of the squared scores of a channel over 1 is shared among its cells, which
        overlap.
        """
        columns, deviations = [], []
        for channel, cells in self._cells.items():
            surplus = self._wander.get(channel, 0.0)
            power = np.diag(plain.inner)[cells]
            usable = [c for c, p in zip(cells, power, strict=True) if p > SMALLEST]
            if surplus <= 0.0 or not usable:
                continue
            part = plain.inner[np.ix_(usable, usable)]
            own = np.diag(part)
            overlap = float(np.mean(np.sum(part**2 / np.outer(own, own), axis=1)))
            columns += usable
            deviations += [float(np.sqrt(surplus / overlap / p)) for p in own]
        return columns, np.array(deviations)

    def _null_sizes(self, plain: Evidence) -> tuple[list[int], Array]:
        """The columns of effects that null flights show, with the prior deviations of their sizes
        there.

        A size like that of null flights is no evidence; only what exceeds it is. For the
        fluctuating part of each signature this is what null flights have beyond noise. A vane reads
        gusts whole, and so do the residuals: it seems to have a wrong scale, and a flight of
        another day has other gusts, so that twice that size is usual.
        """
        spreads = [self._null_scores.fluctuation.get(label, 1.0) for label in self.labels]
        vanes = [
            c for c, s in enumerate(self.signatures) if reads_gusts(s.effect) and spreads[c] > 1.0
        ]
        scores = self._fluctuating | {c: THRESHOLDS.null_size_margin * spreads[c] for c in vanes}
        powers = np.diag(plain.inner)
        usable = [c for c in scores if powers[c] > SMALLEST]
        return usable, np.array([scores[c] for c in usable]) / np.sqrt(powers[usable])

    def beyond(self, sizes: Mapping[tuple[str, str], float], power: float = 1.0) -> Evidence:
        """Return the evidence with effects of about these sizes eliminated, and their form error
        with them.

        It is that of the likelihood to some power.
        """
        index = {(s.effect, s.parameter): i for i, s in enumerate(self.signatures)}
        own = {index[k]: abs(v) for k, v in sizes.items() if k in index}
        directions, errors = self.form_error(sizes)
        deviations = [max(value, float(self.typical[column])) for column, value in own.items()]
        return self.base.tempered(power).given(
            [*own, *directions], np.concatenate([deviations, errors])
        )[0]

    @cached_property
    def rests(self) -> list[Rest]:
        """The smooth discrepancies: of one channel, of a family of channels, and of all, in several
        sizes.
        """
        sizes = THRESHOLDS.rest_sizes
        families = {room: [c for c in self._cells if _room(c) == room] for room in ROOMS}
        alone = 0.5 / len(self._cells)
        groups: list[tuple[tuple[str, ...], float]] = [
            ((channel,), alone) for channel in self._cells
        ]
        shown = {name: tuple(each) for name, each in families.items() if len(each) > 1}
        groups += [(each, 0.25 / len(shown)) for each in shown.values()]
        groups += [(tuple(self._cells), 0.25)]
        found = []
        power = np.diag(self.base.inner)
        for channels, prior in groups:
            columns = [
                c for channel in channels for c in self._cells[channel] if power[c] > SMALLEST
            ]
            if not columns:
                continue
            unit = 1.0 / np.sqrt(power[columns] * len(columns))
            place = (
                channels[0]
                if len(channels) == 1
                else ("all" if len(channels) == len(self._cells) else _room(channels[0]))
            )
            found += [
                Rest(place, tuple(columns), s * unit, float(np.log(prior / len(sizes))))
                for s in sizes
            ]
        return found


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


def _room(channel: str) -> str:
    for room in ("airspeed", "specific_force"):
        if channel.startswith(room):
            return room
    if channel.startswith("acceleration"):
        return "acceleration"
    if channel in ("roll_acceleration", "pitch_acceleration", "yaw_acceleration"):
        return "turning"
    return "engine" if channel.split("_")[-1] in ("left", "right", "split") else channel
