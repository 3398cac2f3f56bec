"""One model of a card written by hand: a wind that wanders, gusts, and smooth curves."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from pitotbench import air
from pitotbench.calibration.leg_methods import LegAir, Legs, unit
from pitotbench.calibration.options import PRIORS, Accuracies, Priors
from pitotbench.estimation.mixture import Posterior
from pitotbench.estimation.noise import UNIFORM, Intervals, MarkovNoise, MarkovProcess
from pitotbench.estimation.restricted_likelihood import (
    NoiseNode,
    Regression,
    most_likely_noise,
    noise_posterior,
    restricted_log_likelihood,
    solutions,
    solve,
)
from pitotbench.pressure_error.models import SMOOTH
from pitotbench.records.legs import CardLeg, ReadingSteps
from pitotbench.units import KNOT, Array, MetersPerSecond


def at_right_angles(along: Array) -> Array:
    """Return the unit vectors at right angles to others, (n, 2)."""
    return np.stack([-along[:, 1], along[:, 0]], axis=1)


def rows_of(legs: Sequence[CardLeg]) -> Legs:
    """Return the legs of a card as rows, each a leg."""
    track, number = np.array([leg.track for leg in legs]), np.arange(len(legs))
    indicated = LegAir(
        np.asarray(air.impact_pressure(np.array([leg.indicated_airspeed for leg in legs]))),
        np.asarray(air.standard_pressure(np.array([leg.pressure_altitude for leg in legs]))),
        np.array([leg.air_temperature for leg in legs]),
    )
    return Legs(
        indicated,
        number.astype(np.float64),
        np.array([leg.ground_speed for leg in legs]),
        np.stack([np.cos(track), np.sin(track)], axis=1),
        np.array([leg.by_heading for leg in legs]),
        number,
    )


# The equation of a leg on a track: the ground velocity g less the wind w has the size of the true
# airspeed, |g − w| = V_t(V_i + ΔV, p, T). On a heading h the ground speed is |V_t h + w|. Either is
# linear in small changes of the wind and of the correction ΔV: y = u·w + s ΔV + temperature +
# noise. It is the calibration's own problem (estimation.restricted_likelihood). The noise is white,
# the steps of the readings and what a gust leaves in one leg, plus a wind that is a Gauss-Markov
# process; the wind takes a further step where another point begins. The regressors are the smooth
# curves, one a configuration (pressure_error.models), whose departures have rival priors. Beside
# its equation each leg has two outputs that nobody observed, the wind across u and the correction.
# What the others say of all three is what they predict for a leg that is read otherwise.

_ANY_WIND = 25.0  # m/s, 1σ of a component of the wind
_ON_LEG = 1.0 / 3.0  # of the time from leg to leg, during which its numbers are read
_LEVEL = 0.08  # 1σ of Δp/q_c
_MOST_WIND = 75.0  # m/s, of a component
_MOST_CORRECTION = 0.3  # of the indicated airspeed
_OTHER_FLIGHT = 12.0 * KNOT  # step of the wind to another flight
_POINTS = 3  # before and after it
# ln of the noise [m/s]: the wind's step from leg to leg and from point to point, and what a gust
# leaves in one leg alone; 1σ of each about the usual one, as a factor.
USUAL_NOISE = np.log(KNOT * np.array([0.5, 2.5, 0.6]))
NOISE_SPREAD = np.log([2.5, 2.5, 2.2])
_ANY_FLIGHT = USUAL_NOISE + np.log([1.0, 4.0, 1.0])  # in which a step to another flight shows
_NO_ERROR = 1e-6  # K: a thermometer that is stated to be right
_UNHEARD = 1e6  # (m/s)², variance of a number that says nothing
_REFERENCE = float(air.impact_pressure(100.0 * KNOT))  # Pa, of the curve's abscissa


@dataclass(frozen=True, slots=True)
class LinearLegs:
    """Legs near their answer, as linear equations.

    Observations y (n,) [m/s], unit vectors u (n, 2) by which they feel the wind, slopes (n,) by the
    correction, their change with temperature (n,) [m/s per K], and the variances of the readings
    (n,) [(m/s)²].
    """

    observed: Array
    along: Array
    slope: Array
    temperature_slope: Array
    reading: Array


def linear_legs(legs: Legs, wind: Array, correction: Array, steps: ReadingSteps) -> LinearLegs:
    """Return the equations of legs near winds (n, 2) and corrections (n,) [m/s].

    A step of the track moves the tip of the ground velocity across itself, one of the heading that
    of the velocity through the air; only its part along the equation counts.
    """
    true, slope = legs.air.true_airspeed(correction), legs.air.slope(correction)
    by_heading, toward, ground = legs.by_heading, legs.toward, legs.ground_speed
    ahead = np.where(by_heading, true, ground)
    other = ahead[:, None] * toward + np.where(by_heading[:, None], wind, -wind)
    along, size = unit(other), np.linalg.norm(other, axis=1)
    share = np.where(by_heading, np.sum(along * toward, axis=1), 1.0)
    across = np.abs(along[:, 0] * toward[:, 1] - along[:, 1] * toward[:, 0]) * ahead
    observed = np.where(by_heading, ground - size, size - true)
    observed = observed + np.sum(along * wind, axis=1) + share * slope * correction
    temperature_slope = share * legs.air.temperature_slope(correction)
    parts = (
        steps.ground_speed,
        steps.track * across,
        steps.indicated_airspeed * share * slope,
        steps.air_temperature * temperature_slope,
    )
    reading = UNIFORM**2 * sum(np.square(each) for each in parts)
    return LinearLegs(observed, along, share * slope, temperature_slope, np.asarray(reading))


class CardModel:
    """The model of the legs of a card, (n,), in the order in which they were flown.

    Legs whose rows are `struck` say nothing: the others predict them. `steps` of the readings and
    `stated` accuracies are those of the card, `priors` those of its curves.
    """

    def __init__(
        self,
        legs: Sequence[CardLeg],
        steps: ReadingSteps,
        stated: Accuracies,
        struck: frozenset[int] = frozenset(),
        priors: Priors = PRIORS,
    ) -> None:
        self.legs, self.steps, self.stated = tuple(legs), steps, stated
        self.priors = priors
        self.struck_rows = struck
        self.struck = np.array([leg.row in struck for leg in legs])
        self.arrays = rows_of(legs)
        self.speed = self.arrays.air.indicated_airspeed
        names = list(dict.fromkeys(leg.configuration for leg in legs))
        self.configurations = {name: number for number, name in enumerate(names)}
        self.own = np.array([self.configurations[leg.configuration] for leg in legs])
        self._new = np.array(
            [a.point != b.point for a, b in zip(legs, [*legs[1:], legs[-1]], strict=True)]
        )
        impact = self.arrays.air.impact_pressure / _REFERENCE
        self._law = priors.of_curve(SMOOTH.spread_over(float(impact.min()), float(impact.max())))
        self._basis = self.basis(self.speed, self.own)
        self._other_flight = np.zeros(len(legs), dtype=np.bool_)
        wind, correction = np.zeros((len(legs), 2)), np.zeros(len(legs))
        most = _MOST_CORRECTION * self.speed
        for noise in (_ANY_FLIGHT, _ANY_FLIGHT, USUAL_NOISE, USUAL_NOISE):
            # A leg that cannot be must not carry the others away: it is judged where a real one
            # could lie.
            wind = np.clip(wind, -_MOST_WIND, _MOST_WIND)
            self.linear = linear_legs(self.arrays, wind, np.clip(correction, -most, most), steps)
            self.problem = self._regression()
            wind, correction = self._answer(noise)
            self._other_flight = self._new & _another_flight(wind, self._new)

    def without(self, rows: frozenset[int]) -> "CardModel":
        """Return the model of the same card with these rows struck out."""
        if rows == self.struck_rows:
            return self
        return CardModel(self.legs, self.steps, self.stated, rows, self.priors)

    def basis(self, speed: MetersPerSecond, own: NDArray[np.intp]) -> Array:
        """Return the columns of the curves, (c, p − 1) [m/s], at airspeeds (c,) [m/s].

        `own` (c,) are the numbers of the configurations.

        A small Δp/q_c moves the airspeed by q_c dV/dq_c times itself.
        """
        impact = air.impact_pressure(speed)
        columns = self._law.basis(impact / _REFERENCE)
        every = np.zeros((len(speed), len(self.configurations), columns.shape[1]))
        scale = impact * air.calibrated_airspeed_slope(impact)
        every[np.arange(len(speed)), own] = columns * scale[:, None]
        return every.reshape(len(speed), -1)

    def _regression(self) -> Regression:
        """The equations of the legs under each rival prior of the departure."""
        linear = self.linear
        columns = np.column_stack([linear.slope[:, None] * self._basis, linear.temperature_slope])
        probe = max(0.5 * self.stated.temperature_k, _NO_ERROR)  # wrong on every leg alike
        curve = np.tile(np.maximum(self._law.precisions, _LEVEL**-2.0), len(self.configurations))
        thermometer = np.full((len(curve), 1), probe**-2.0)
        precisions = np.column_stack([curve, thermometer])
        return Regression(linear.observed, columns, columns, precisions)

    def white(self, noise: Array) -> Array:
        """Return the variance of each leg without wind, (n,) [(m/s)²]."""
        heard = self.linear.reading + np.exp(2.0 * noise[2])
        return np.where(self.struck, _UNHEARD, heard)

    def wandered(self, noise: Array) -> Array:
        """Return the variance of the wind's steps up to each leg, (n,) [(m/s)²]."""
        return np.concatenate([[0.0], np.cumsum(self._steps(noise).sum(axis=1)[:-1])])

    def _steps(self, noise: Array) -> Array:
        """The variances of the wind's step from each leg to the next, (n, 2) [(m/s)²].

        The second is the part of a step to another point or flight.
        """
        step, jump, _ = np.exp(2.0 * noise)
        other = np.where(self._other_flight, _ANY_WIND**2, jump * self._new)
        return np.column_stack([np.full(len(self.legs), step), other])

    def noise(self, noise: Array, across: bool = False) -> MarkovNoise:
        """Return the covariance of the equations for ln of the noise (3,).

        With `across` it is followed by that of the winds across the equations, which nobody
        observed.
        """
        white, loading = self.white(noise)[None], self.linear.along[None]
        if across:
            white = np.concatenate([white, np.full_like(white, _UNHEARD)])
            loading = np.concatenate([loading, at_right_angles(loading[0])[None]])
        count = len(self.legs)
        edges = (np.arange(count)[:, None] + [0.0, _ON_LEG]).ravel()
        # The variance of an Ornstein-Uhlenbeck process grows by 2σ²/τ a unit of time.
        rate = self._steps(noise) @ [[1.0, 1.0], [0.0, 1.0 / (1.0 - _ON_LEG)]]
        wind = MarkovProcess(_ANY_WIND, 2.0 * _ANY_WIND**2 / rate.ravel(), loading)
        return MarkovNoise(Intervals(edges, 2 * np.arange(count)), white, [wind])

    def _answer(self, noise: Array) -> tuple[Array, Array]:
        """The wind (n, 2) and the correction (n,) of each leg [m/s]: what is not white noise."""
        curves, _ = solve(self.problem, self.noise(noise))
        left = np.zeros((2, len(self.legs)))
        left[0] = self.problem.response - self.problem.regressors @ curves
        weighed = self.noise(noise, across=True).weigh(left.reshape(-1, 1)).reshape(left.shape)
        wind = left[0] - self.white(noise) * weighed[0]
        along = self.linear.along
        sideways = _UNHEARD * weighed[1]
        return wind[:, None] * along - sideways[:, None] * at_right_angles(
            along
        ), self._basis @ curves[:-1]

    @cached_property
    def likeliest_noise(self) -> Array:
        """ln of the likeliest noise, (3,)."""
        return most_likely_noise(self.problem, self.noise, _log_prior, USUAL_NOISE)

    def log_evidence(self, noise: Array) -> float:
        """Return the logarithm of the evidence of the card under one noise."""
        return restricted_log_likelihood(self.problem, self.noise(noise)) + _log_prior(noise)

    def log_evidence_of_heard(self, noise: Array) -> float:
        """Return the same of the legs that are not struck out, to be compared between sets."""
        unheard = 0.5 * np.log(_UNHEARD) * np.count_nonzero(self.struck)
        return self.log_evidence(noise) + float(unheard)

    @cached_property
    def nodes(self) -> tuple[NoiseNode, ...]:
        """The posterior: curves under each plausible noise and departure."""
        return noise_posterior(self.problem, self.noise, _log_prior, self.likeliest_noise)

    @cached_property
    def posterior(self) -> Posterior:
        """The coefficients of the curves and the thermometer's error."""
        return Posterior(
            np.array([node.weight for node in self.nodes]),
            np.stack([node.estimate for node in self.nodes]),
            np.stack([node.covariance for node in self.nodes]),
        )

    def gradient(self, at: MetersPerSecond, configuration: str) -> Array:
        """Return a configuration's change of corrections with coefficients, (c, p).

        `at` are airspeeds (c,) [m/s]. The thermometer is no part of them.
        """
        columns = self.basis(at, np.full(len(at), self.configurations[configuration]))
        return np.column_stack([columns, np.zeros(len(at))])

    def expected_variance(self, at: MetersPerSecond) -> float:
        """Return the first configuration's mean variance [(m/s)²] before a leg is flown.

        The mean is over airspeeds [m/s] and over the rival priors, on a usual day.
        """
        columns = self.gradient(at, self.legs[0].configuration)
        rivals = solutions(self.problem, self.noise(USUAL_NOISE))
        found = [np.einsum("cp,pq,cq->c", columns, each.covariance, columns) for each in rivals]
        return float(np.mean(found))

    def deviations(self, places: Sequence[int], gain: Array) -> Array:
        """Return the deviations, (m,), at each node, of what changes by `gain` (k,) with legs (k,).

        What the legs share is left out: the wind of the first of them is free, and so is the
        correction.
        """
        wandered, white = (each[:, places] for each in self._spread_of_nodes)
        felt = self.linear.along[places] * gain[:, None]
        later = felt.sum(axis=0) - np.cumsum(felt, axis=0)[:-1]  # what a step of the wind moves
        wind = np.diff(wandered) @ np.sum(later**2, axis=1)
        return np.asarray(np.sqrt(wind + white @ gain**2))

    @cached_property
    def _spread_of_nodes(self) -> tuple[Array, Array]:
        """The variances of the wind up to each leg and of the leg alone, at each node, (m, n)."""
        noises = [node.noise for node in self.nodes]
        wandered = np.stack([self.wandered(noise) for noise in noises])
        return wandered, np.stack([self.white(noise) for noise in noises])

    def others(self, noise: Array) -> "Others":
        """Return what all other legs predict for each leg.

        Of data with the covariance K the others predict y − B [K⁻¹y]ᵢ with the covariance B, the
        inverse of block i on the diagonal of K⁻¹. A leg that says nothing has hardly any precision,
        so that the little that another one adds would decide its variance.
        """
        problem, count = self.problem, len(self.legs)
        curves, spread = solve(problem, self.noise(noise))
        across = self.noise(noise, across=True)
        data = np.zeros((2, count, 1 + len(curves)))
        data[0] = np.column_stack([problem.response, problem.regressors])
        # The correction is a third output, without wind.
        pulled = np.zeros((3, count, 1 + len(curves)))
        pulled[:2] = across.weigh(data.reshape(2 * count, -1)).reshape(data.shape)
        pulled[2, :, 1:-1] = self._basis / _UNHEARD
        precision = np.zeros((count, 3, 3))
        precision[:, :2, :2] = across.precision_blocks
        precision[:, 2, 2] = 1.0 / _UNHEARD
        columns = np.moveaxis(pulled[:, :, 1:], 0, 1)
        precision -= columns @ spread @ np.swapaxes(columns, 1, 2)
        covariances = np.asarray(np.linalg.inv(precision), dtype=np.float64)
        left = pulled[:, :, 0].T - columns @ curves
        means = -np.einsum("nom,nm->no", covariances, left)
        means[:, 0] += problem.response
        covariances[:, 0, 0] -= self.white(noise)
        covariances[:, [1, 2], [1, 2]] -= _UNHEARD
        return Others(self, float(np.exp(2.0 * noise[2])), curves, means, covariances)


def _another_flight(wind: Array, new: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Whether another flight, in another wind, begins after each leg (n,).

    The winds (n, 2) [m/s] of some points before and after differ in their medians, which a slip
    does not move.

    `new` (n,) says whether another point begins.
    """
    ends = np.flatnonzero(new)
    found = np.zeros(len(new), dtype=np.bool_)
    if len(ends) < 2 * _POINTS:
        return found
    points = np.add.reduceat(wind, [0, *ends + 1]) / np.diff([0, *ends + 1, len(new)])[:, None]
    middles = np.median(sliding_window_view(points, _POINTS, axis=0), axis=2)
    step = np.linalg.norm(middles[_POINTS:] - middles[:-_POINTS], axis=1)
    here = np.linalg.norm(np.diff(points, axis=0), axis=1)[_POINTS - 1 : 1 - _POINTS]
    found[ends[_POINTS - 1 : 1 - _POINTS]] = np.minimum(step, here) > _OTHER_FLIGHT
    return found


def _log_prior(noise: Array) -> float:
    return float(-0.5 * np.sum(((noise - USUAL_NOISE) / NOISE_SPREAD) ** 2))


@dataclass(frozen=True, slots=True)
class Others:
    """What all other legs predict for each leg.

    `means` (n, 3) and `covariances` (n, 3, 3) of its equation, of the wind across and of the
    correction [m/s].

    `alone` [(m/s)²] is the variance that a gust leaves in a leg, `curves` (p,) the coefficients.
    """

    model: CardModel
    alone: float
    curves: Array
    means: Array
    covariances: Array

    @property
    def surprise(self) -> Array:
        """By how many standard deviations each leg departs from what all others predict, (n,)."""
        linear = self.model.linear
        variance = self.covariances[:, 0, 0] + linear.reading + self.alone
        return np.asarray((linear.observed - self.means[:, 0]) / np.sqrt(variance))

    def of(self, place: int, legs: Sequence[CardLeg]) -> tuple[Array, Array]:
        """Return errors of legs in the place of one against all others, and variances, (m,) each.

        The errors are in m/s.
        """
        model, own = self.model, np.full(len(legs), self.model.own[place])
        along, slope = model.linear.along[place], float(model.linear.slope[place])
        axes = np.concatenate([along[None], at_right_angles(along[None])])
        equation, across, correction = self.means[place]
        wind = np.array([equation - slope * correction, across]) @ axes
        arrays = rows_of(legs)
        here = model.basis(model.speed[[place]], own[:1])
        elsewhere = (model.basis(arrays.air.indicated_airspeed, own) - here) @ self.curves[:-1]
        linear = linear_legs(
            arrays, np.tile(wind, (len(legs), 1)), correction + elsewhere, model.steps
        )
        turned = linear.along @ axes.T
        seen = np.column_stack([turned, linear.slope - turned[:, 0] * slope])
        variance = np.einsum("mo,op,mp->m", seen, self.covariances[place], seen)
        error = linear.observed - linear.along @ wind - linear.slope * (correction + elsewhere)
        return error, variance + linear.reading + self.alone
