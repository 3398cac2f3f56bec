"""One model of a card written by hand: a wind that wanders from leg to leg, and smooth curves."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import groupby, pairwise, product

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_solve_banded, cholesky_banded

from pitotbench import air
from pitotbench.calibration.options import Accuracies
from pitotbench.records.legs import CardLeg, ReadingSteps
from pitotbench.units import KNOT, Array, MetersPerSecond

_ROUNDING = 1.0 / np.sqrt(12.0)  # 1σ of an error that is uniform over one step, in steps
_SMALL = 0.05  # m/s and K, steps of the differences


@dataclass(frozen=True, slots=True)
class LegArrays:
    """The legs of a card as arrays (n,) [SI]: what was read.

    `toward` (n, 2) is the unit vector of the track, or of the heading where `by_heading`.
    """

    indicated_airspeed: Array
    static_pressure: Array
    air_temperature: Array
    ground_speed: Array
    toward: Array
    by_heading: NDArray[np.bool_]

    def true_airspeed(
        self, correction: MetersPerSecond | float, warmer: float = 0.0
    ) -> MetersPerSecond:
        """Return the true airspeed [m/s], (n,), for corrections [m/s]; `warmer` is added to the
        temperature [K].

        The static source errs and the total pressure is right: p = p_i + q_ci − q_c.
        """
        impact = air.impact_pressure(self.indicated_airspeed + correction)
        static = self.static_pressure + air.impact_pressure(self.indicated_airspeed) - impact
        return air.true_airspeed(impact, static, self.air_temperature + warmer)

    def slope(self, correction: MetersPerSecond | float) -> Array:
        """Return dV_t/dΔV [-], (n,)."""
        up, down = self.true_airspeed(correction + _SMALL), self.true_airspeed(correction - _SMALL)
        return np.asarray((up - down) / (2.0 * _SMALL))

    def warmth(self, correction: MetersPerSecond | float) -> Array:
        """Return dV_t/dT [m/s per K], (n,)."""
        up, down = self.true_airspeed(correction, _SMALL), self.true_airspeed(correction, -_SMALL)
        return np.asarray((up - down) / (2.0 * _SMALL))

    def ground_velocity(self, airspeed: Array | float, wind: Array) -> Array:
        """Return the ground velocities, (n, 2) [m/s]: on tracks, or on headings in a wind."""
        drifted = np.broadcast_to(airspeed, len(self.toward))[:, None] * self.toward + wind
        along = np.where(self.by_heading[:, None], unit(drifted), self.toward)
        return np.asarray(self.ground_speed[:, None] * along)


def unit(vectors: Array) -> Array:
    """Return vectors (n, 2) with a length of one."""
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-3))


def leg_arrays(legs: Sequence[CardLeg]) -> LegArrays:
    """Return legs as arrays."""
    track = np.array([leg.track for leg in legs])
    return LegArrays(
        np.array([leg.indicated_airspeed for leg in legs]),
        np.asarray(air.standard_pressure(np.array([leg.pressure_altitude for leg in legs]))),
        np.array([leg.air_temperature for leg in legs]),
        np.array([leg.ground_speed for leg in legs]),
        np.stack([np.cos(track), np.sin(track)], axis=1),
        np.array([leg.by_heading for leg in legs]),
    )


def by_point(legs: Sequence[CardLeg]) -> dict[str, list[int]]:
    """Return the places of the legs of each point."""
    found: dict[str, list[int]] = {}
    for place, leg in enumerate(legs):
        found.setdefault(leg.point, []).append(place)
    return found


# The equation of a leg on a track: the ground velocity g less the wind w has the size of the true
# airspeed, |g − w| = V_t(V_i + ΔV, p, T). On a heading h the ground speed is |V_t h + w|. Either is
# linear in small changes of the wind and of the correction ΔV, y = u·w + s ΔV + readings +
# temperature, and everything is Gaussian. The wind takes a step from leg to leg and a longer one
# from point to point; Δp/q_c of a configuration is a constant, a slope in ln V and a smooth
# departure from both (Rasmussen and Williams, Gaussian Processes for Machine Learning, 2006, ch.
# 2.7). The sizes of the steps and of the departure are not known: each plausible set is weighed by
# its likelihood. The precision of the winds is banded, so that the work grows with the number of
# legs and not with its cube (Rue and Held, Gaussian Markov Random Fields, 2005, §2.4).

_ANY_WIND = 25.0  # m/s, 1σ of a component of the first wind
_CONSTANT, _SLOPE = 0.08, 0.08  # 1σ of Δp/q_c and of its change over a factor e of airspeed
_SCATTER = 0.5  # of the step from leg to leg: what a gust and the pilot leave in each leg alone
_MOST_WIND = 75.0  # m/s, of a component
_MOST_CORRECTION = 0.3  # of the indicated airspeed
_ROUNDS = 4  # of linearization; the equations are nearly linear
# Steps of the wind from leg to leg and from point to point [m/s], departure of the curve [-]: grids
# in factors of about two, with the weight that each has before the card is looked at.
_LEG_STEPS = KNOT * np.array([0.15, 0.3, 0.6, 1.0, 1.6, 2.5, 4.0])
_LEG_WEIGHTS = np.array([0.5, 1.0, 1.5, 1.5, 1.0, 0.6, 0.3])
_POINT_STEPS = KNOT * np.array([0.7, 1.7, 4.0, 9.0])
_POINT_WEIGHTS = np.array([0.7, 1.0, 1.0, 0.6])
# No static source follows a straight line within 0.2 % of the airspeed (0.004 of q_c) over a whole
# envelope.
_DEPARTURES = np.array([0.004, 0.012, 0.03])
_DEPARTURE_WEIGHTS = np.array([0.6, 1.0, 0.6])
_LENGTHS = (0.2, 0.45)  # of ln V, over which the departure changes: factors 1.2 and 1.6 of airspeed
_KNOT_DISTANCE = 0.5  # lengths between two knots of the departure
_JITTER = 1e-9  # of a variance at the knots: keeps their covariance regular
_UNHEARD = 1e8  # (m/s)², variance of a leg that says nothing
_NO_ERROR = 1e-6  # K: a thermometer that is stated to be right
_REFERENCE = 100.0 * KNOT  # m/s, where the slope in ln V is zero


@dataclass(frozen=True, slots=True)
class Sizes:
    """The unknown sizes: steps of the wind from leg to leg and from point to point [m/s], departure
    of the curve [-] and its length in ln V, and the logarithm of their prior weight.
    """

    leg_step: float
    point_step: float
    departure: float
    length: float
    log_weight: float


SIZES = tuple(
    Sizes(float(a), float(b), float(c), length, float(np.log(wa * wb * wc)))
    for (a, wa), (b, wb), (c, wc), length in product(
        zip(_LEG_STEPS, _LEG_WEIGHTS, strict=True),
        zip(_POINT_STEPS, _POINT_WEIGHTS, strict=True),
        zip(_DEPARTURES, _DEPARTURE_WEIGHTS, strict=True),
        _LENGTHS,
    )
)

TYPICAL_SIZES = Sizes(1.0 * KNOT, 4.0 * KNOT, 0.012, 0.45, 0.0)


@dataclass(frozen=True, slots=True)
class LinearCard:
    """A card near its answer: observations y (n,) [m/s], unit vectors u (n, 2) by which they feel
    the wind, slopes (n,) by the correction, their change with temperature (n,) [m/s per K], and the
    variances of the readings (n,) [(m/s)²].
    """

    observed: Array
    along: Array
    slope: Array
    warmth: Array
    reading: Array


@dataclass(frozen=True, slots=True)
class Solution:
    """The answer under one set of sizes: its log-likelihood, and the sizes of the curves' columns
    and of the thermometer's error, (p,), with their covariance (p, p).
    """

    log_likelihood: float
    curves: Array
    covariance: Array


@dataclass(frozen=True, slots=True)
class _Winds:
    """The winds given the curves: the variance (n,) of each leg alone, the banded Cholesky factor
    (3, 2n) of their precision, their change (2n, p + 1) by each column and by the observations, and
    the inner products (p + 1, p + 1) of these with the winds eliminated.
    """

    alone: Array
    factor: Array
    pulled: Array
    inner: Array
    log_determinant: float

    def of(self, curves: Array) -> Array:
        """The wind at each leg for the sizes of the columns, (n, 2) [m/s]."""
        return np.asarray((self.pulled[:, -1] - self.pulled[:, :-1] @ curves).reshape(-1, 2))


class CardModel:
    """The model of the legs of a card, (n,), in the order in which they were flown.

    The leg in the place `unheard` says nothing: the others predict it.
    """

    def __init__(
        self,
        legs: Sequence[CardLeg],
        steps: ReadingSteps,
        stated: Accuracies,
        unheard: int | None = None,
    ) -> None:
        self.legs, self._unheard = list(legs), unheard
        self.arrays, self.steps, self.stated = leg_arrays(legs), steps, stated
        self.speed = self.arrays.indicated_airspeed
        self._configurations = list(dict.fromkeys(leg.configuration for leg in legs))
        self.own = np.array([self._configurations.index(leg.configuration) for leg in legs])
        self._new = np.array([a.point != b.point for a, b in pairwise(legs)], dtype=np.bool_)
        self._departures = {length: _Departure(self.speed, length) for length in _LENGTHS}
        self.linear = self._linearize()

    def _linearize(self) -> LinearCard:
        """Linearize at the answer for the usual sizes, in a few rounds."""
        count = len(self.legs)
        linear = self._at(np.zeros((count, 2)), np.zeros(count))
        for _ in range(_ROUNDS):
            columns = self.regressors(linear, TYPICAL_SIZES.length)
            winds = self._winds(linear, columns, TYPICAL_SIZES)
            curves = self._solved(winds, winds.inner, TYPICAL_SIZES).curves
            correction = self.basis(self.speed, self.own, TYPICAL_SIZES.length) @ curves[:-1]
            linear = self._at(winds.of(curves), correction)
        return linear

    def _at(self, wind: Array, correction: Array) -> LinearCard:
        # A leg that cannot be must not carry the others away: it is judged where a real one could
        # lie.
        wind = np.clip(wind, -_MOST_WIND, _MOST_WIND)
        most = _MOST_CORRECTION * self.speed
        linear = linear_legs(self.arrays, wind, np.clip(correction, -most, most), self.steps)
        if self._unheard is not None:
            linear.reading[self._unheard] = _UNHEARD
        return linear

    def basis(self, speed: MetersPerSecond, own: NDArray[np.intp], length: float) -> Array:
        """Return the columns of the curves, (c, p − 1) [m/s], at airspeeds (c,) [m/s] of the
        configurations of numbers `own` (c,).
        """
        columns = _curve_columns(speed, self._departures[length])
        every = np.zeros((len(speed), len(self._configurations), columns.shape[1]))
        every[np.arange(len(speed)), own] = columns
        return every.reshape(len(speed), -1)

    def deviations(self, sizes: Sizes) -> Array:
        """Return the prior deviation of each column of the curves, and of the thermometer's error,
        (p,).
        """
        knots = len(self._departures[sizes.length].knots)
        one = [_CONSTANT, _SLOPE, *[sizes.departure] * knots]
        probe = max(0.5 * self.stated.temperature_k, _NO_ERROR)  # wrong on every leg alike
        return np.array([*one * len(self._configurations), probe])

    def regressors(self, linear: LinearCard, length: float) -> Array:
        """Return the change of the observations by each column, (n, p)."""
        curves = self.basis(self.speed, self.own, length) * linear.slope[:, None]
        return np.column_stack([curves, linear.warmth])

    def solve(self, sizes: Sizes) -> Solution:
        """Return the answer under one set of sizes."""
        return next(self.solutions([sizes]))

    def solutions(self, choices: Sequence[Sizes]) -> Iterator[Solution]:
        """Yield the answers under some sets of sizes; equal steps in a row share their winds."""
        parts = [self.regressors(self.linear, length) for length in _LENGTHS]
        every = np.column_stack(parts)
        ends = np.cumsum([0, *(part.shape[1] for part in parts)])
        places = {
            length: [*range(first, last), every.shape[1]]
            for length, (first, last) in zip(_LENGTHS, pairwise(ends), strict=True)
        }
        for _, alike in groupby(choices, lambda each: (each.leg_step, each.point_step)):
            first, *others = alike
            winds = self._winds(self.linear, every, first)
            for sizes in (first, *others):
                own = places[sizes.length]
                yield self._solved(winds, winds.inner[np.ix_(own, own)], sizes)

    def _winds(self, linear: LinearCard, columns: Array, sizes: Sizes) -> "_Winds":
        """The legs with their winds eliminated, for columns (n, p) beside them."""
        steps = np.where(self._new, sizes.point_step, sizes.leg_step) ** 2
        alone = linear.reading + (_SCATTER * sizes.leg_step) ** 2
        factor = _wind_factor(linear.along, steps, alone)
        every = np.column_stack([columns, linear.observed])
        weighed = every / alone[:, None]
        seen = (linear.along[:, :, None] * weighed[:, None, :]).reshape(-1, every.shape[1])
        pulled = cho_solve_banded((factor, True), seen)
        size = 4.0 * np.log(_ANY_WIND) + 2.0 * np.sum(np.log(steps)) + np.sum(np.log(alone))
        size += 2.0 * np.sum(np.log(factor[0]))
        return _Winds(alone, factor, pulled, every.T @ weighed - seen.T @ pulled, float(size))

    def _solved(self, winds: "_Winds", inner: Array, sizes: Sizes) -> Solution:
        """The answer from the inner products of these columns, the observation last."""
        prior = self.deviations(sizes)
        precision = inner[:-1, :-1] + np.diag(prior**-2.0)
        covariance = np.linalg.inv(precision)
        curves = covariance @ inner[:-1, -1]
        misfit = float(inner[-1, -1] - inner[:-1, -1] @ curves)
        size = winds.log_determinant + float(np.linalg.slogdet(precision)[1])
        size += 2.0 * float(np.sum(np.log(prior)))
        return Solution(-0.5 * (misfit + size), curves, np.asarray(covariance))

    def weights(self) -> Array:
        """Return the weight of each of `SIZES` after the card is looked at."""
        logs = self._log_weights
        return np.asarray(np.exp(logs - np.logaddexp.reduce(logs)))

    @property
    def log_evidence(self) -> float:
        """The logarithm of the evidence of the card, the sizes marginalized."""
        return float(np.logaddexp.reduce(self._log_weights))

    @cached_property
    def _log_weights(self) -> Array:
        found = zip(SIZES, self.solutions(SIZES), strict=True)
        return np.array([each.log_likelihood + sizes.log_weight for sizes, each in found])

    def others(self, sizes: Sizes) -> "Others":
        """Return what all other legs predict for each leg."""
        along, columns = self.linear.along, self.regressors(self.linear, sizes.length)
        winds = self._winds(self.linear, columns, sizes)
        found = self._solved(winds, winds.inner, sizes)
        pulled = winds.pulled[:, :-1].reshape(len(along), 2, -1)
        blocks, wind = _inverse_blocks(winds.factor), winds.of(found.curves)
        # Mean and covariance of the wind at each leg and of the curves together.
        link = -pulled @ found.covariance
        count = len(found.curves)
        covariances = np.empty((len(along), 2 + count, 2 + count))
        covariances[:, :2, :2] = blocks - link @ np.swapaxes(pulled, 1, 2)
        covariances[:, :2, 2:] = link
        covariances[:, 2:, :2] = np.swapaxes(link, 1, 2)
        covariances[:, 2:, 2:] = found.covariance
        means = np.column_stack([wind, np.broadcast_to(found.curves, (len(along), count))])
        rows = np.column_stack([along, columns])
        left = self.linear.observed - np.sum(rows * means, axis=1)
        rest = winds.alone - np.einsum("nq,nqr,nr->n", rows, covariances, rows)
        return Others(self, sizes, rows, means, covariances, left, rest)

    def curves(
        self, at: MetersPerSecond, configuration: str, choices: Sequence[Sizes]
    ) -> tuple[Array, Array]:
        """Return the correction of a configuration at airspeeds [m/s] and its variance [(m/s)²],
        (m, c), for each choice of sizes.
        """
        own = np.full(len(at), self._configurations.index(configuration))
        means, variances = [], []
        for sizes, found in zip(choices, self.solutions(choices), strict=True):
            columns = self.basis(at, own, sizes.length)
            means.append(columns @ found.curves[:-1])
            variances.append(np.einsum("cp,pq,cq->c", columns, found.covariance[:-1, :-1], columns))
        return np.array(means), np.array(variances)

    def leg_noise(self, rows: Sequence[int], sizes: Sizes) -> Array:
        """Return the covariance [(m/s)²] of the equations of some legs of one point, without what
        they share.

        The wind of the first of them is free, and so is the correction.
        """
        picked = np.asarray(rows)
        passed = sizes.leg_step**2 * (picked - picked[0])
        along = self.linear.along[picked]
        wind = np.minimum(passed[:, None], passed[None, :]) * (along @ along.T)
        alone = self.linear.reading[picked] + (_SCATTER * sizes.leg_step) ** 2
        return np.asarray(wind + np.diag(alone))


@dataclass(frozen=True, slots=True)
class Others:
    """What all other legs predict for each leg, under one set of sizes.

    `rows` (n, q) is the equation of each leg in its wind and the curves, which have the `means`
    (n, q) and `covariances` (n, q, q) of all legs. `left` (n,) [m/s] is what the answer leaves of
    each leg and `rest` (n,) [(m/s)²] the variance of that.
    """

    model: CardModel
    sizes: Sizes
    rows: Array
    means: Array
    covariances: Array
    left: Array
    rest: Array

    @property
    def surprise(self) -> Array:
        """By how many standard deviations each leg departs from what all others predict, (n,)."""
        return np.asarray(self.left / np.sqrt(self.rest))

    def of(self, place: int, leg: CardLeg) -> tuple[float, float]:
        """Return the logarithm of the density of a leg in the place of one that is unheard, and by
        how many standard deviations it departs from what all others predict.
        """
        model, mean, covariance = self.model, self.means[place], self.covariances[place]
        arrays = leg_arrays([leg])
        columns = model.basis(arrays.indicated_airspeed, model.own[[place]], self.sizes.length)
        linear = linear_legs(arrays, mean[None, :2], columns @ mean[2:-1], model.steps)
        seen = np.concatenate([linear.along[0], linear.slope * columns[0], linear.warmth])
        error = float(linear.observed[0] - seen @ mean)
        variance = float(seen @ covariance @ seen + linear.reading[0])
        variance += (_SCATTER * self.sizes.leg_step) ** 2
        surprise = error / float(np.sqrt(variance))
        return -0.5 * (surprise**2 + float(np.log(variance))), surprise


def linear_legs(
    arrays: LegArrays, wind: Array, correction: Array, steps: ReadingSteps
) -> LinearCard:
    """Return the equations of legs near winds (n, 2) and corrections (n,) [m/s].

    A step of the track moves the tip of the ground velocity across itself, one of the heading that
    of the velocity through the air; only its part along the equation counts.
    """
    true, slope, warmth = (
        arrays.true_airspeed(correction),
        arrays.slope(correction),
        arrays.warmth(correction),
    )
    by_heading, toward, ground = arrays.by_heading, arrays.toward, arrays.ground_speed
    ahead = np.where(by_heading, true, ground)
    other = np.where(
        by_heading[:, None], true[:, None] * toward + wind, ground[:, None] * toward - wind
    )
    along, size = unit(other), np.linalg.norm(other, axis=1)
    share = np.where(by_heading, np.sum(along * toward, axis=1), 1.0)
    across = np.abs(along[:, 0] * toward[:, 1] - along[:, 1] * toward[:, 0]) * ahead
    observed = np.where(by_heading, ground - size, size - true)
    observed = observed + np.sum(along * wind, axis=1) + share * slope * correction
    shares = (
        steps.ground_speed,
        steps.track * across,
        steps.indicated_airspeed * share * slope,
        steps.air_temperature * share * warmth,
    )
    reading = _ROUNDING**2 * sum(np.square(each) for each in shares)
    return LinearCard(observed, along, share * slope, share * warmth, np.asarray(reading))


def _wind_factor(along: Array, steps: Array, alone: Array) -> Array:
    """The banded Cholesky factor (3, 2n) of the precision of the winds, north and east in turn, for
    the variances of their steps (n − 1,) and of each leg alone (n,).
    """
    ahead = np.append(1.0 / steps, 0.0)
    prior = np.concatenate([[_ANY_WIND**-2.0], 1.0 / steps]) + ahead
    banded = np.zeros((3, 2 * len(alone)))
    banded[0] = (prior[:, None] + along**2 / alone[:, None]).ravel()
    banded[1, ::2] = along[:, 0] * along[:, 1] / alone
    banded[2] = -np.repeat(ahead, 2)
    return np.asarray(cholesky_banded(banded, lower=True))


def _inverse_blocks(factor: Array) -> Array:
    """The blocks (n, 2, 2) on the diagonal of the inverse of a banded matrix, from its factor
    (Takahashi, Fagan and Chen 1973).
    """
    count = factor.shape[1]
    diagonal, first, second = factor.tolist()
    # Of the inverse: the diagonal, and the elements one and two below it.
    on, near, far = [0.0] * (count + 2), [0.0] * (count + 2), [0.0] * (count + 2)
    for j in range(count - 1, -1, -1):
        a, b = first[j] if j + 1 < count else 0.0, second[j] if j + 2 < count else 0.0
        far[j] = -(a * near[j + 1] + b * on[j + 2]) / diagonal[j]
        near[j] = -(a * on[j + 1] + b * near[j + 1]) / diagonal[j]
        on[j] = (1.0 / diagonal[j] - a * near[j] - b * far[j]) / diagonal[j]
    variances, crossed = np.array(on[:count]).reshape(-1, 2), np.array(near[:count:2])
    return np.stack(
        [np.column_stack([variances[:, 0], crossed]), np.column_stack([crossed, variances[:, 1]])],
        axis=1,
    )


class _Departure:
    """Columns of a smooth departure over ln V: independent sizes of 1 give it a squared exponential
    covariance.
    """

    def __init__(self, speed: MetersPerSecond, length: float) -> None:
        place = np.log(speed / _REFERENCE)
        count = 2 + int(np.ptp(place) / (_KNOT_DISTANCE * length))
        self.length, self.knots = length, np.linspace(place.min(), place.max() + 1e-6, count)
        covariance = self._kernel(self.knots) + _JITTER * np.eye(count)
        self._root = np.linalg.inv(np.linalg.cholesky(covariance)).T

    def _kernel(self, place: Array) -> Array:
        return np.asarray(np.exp(-0.5 * (place[:, None] - self.knots) ** 2 / self.length**2))

    def columns(self, place: Array) -> Array:
        """Return the columns at ln V of (c,), (c, knots)."""
        return np.asarray(self._kernel(place) @ self._root)


def _curve_columns(speed: MetersPerSecond, departure: _Departure) -> Array:
    """The constant, the slope and the departure of a curve, as corrections [m/s] for sizes of
    Δp/q_c.

    A small Δp/q_c moves the airspeed by q_c dV/dq_c times itself.
    """
    place, impact = np.log(speed / _REFERENCE), air.impact_pressure(speed)
    scale = impact * air.calibrated_airspeed_slope(impact)
    columns = np.column_stack([np.ones_like(place), place, departure.columns(place)])
    return np.asarray(columns * scale[:, None])
