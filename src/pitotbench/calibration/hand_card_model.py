"""One model of a whole card: winds that wander from leg to leg and from point to point, and a
smooth curve.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise, product

import numpy as np

from pitotbench import air
from pitotbench.calibration.options import USUAL, Accuracies
from pitotbench.records.legs import CardLeg, HandPlan, ReadingSteps
from pitotbench.units import DEGREE, FOOT, KNOT, Array, MetersPerSecond

# The equation of a leg: the ground velocity less the wind has the size of the true airspeed. |g −
# w| = V_t(V_i + ΔV, p, T). It is linear in small changes of the wind w and of the correction ΔV.

_ROUNDING = 1.0 / np.sqrt(
    12.0
)  # standard deviation of an error that is uniform over one step, in steps
_SMALL = 0.05  # m/s and K, steps of the differences


@dataclass(frozen=True, slots=True)
class LegArrays:
    """The legs of a card as arrays (n,) [SI]: what was read, and the ground velocity (n, 2)."""

    indicated_airspeed: Array
    static_pressure: Array
    air_temperature: Array
    velocity: Array

    def true_airspeed(
        self, correction: MetersPerSecond | float, warmer: float = 0.0
    ) -> MetersPerSecond:
        """Return the true airspeed [m/s], (n,), for corrections [m/s]; `warmer` is added to the
        temperature [K].

        The static source errs and the total pressure is right: p = p_i + q_ci − q_c.
        """
        calibrated = self.indicated_airspeed + correction
        impact, indicated = (
            air.impact_pressure(calibrated),
            air.impact_pressure(self.indicated_airspeed),
        )
        static = self.static_pressure + indicated - impact
        return air.true_airspeed(impact, static, self.air_temperature + warmer)

    def slope(self, correction: MetersPerSecond | float) -> Array:
        """Return dV_t/dΔV [-], (n,)."""
        up, down = self.true_airspeed(correction + _SMALL), self.true_airspeed(correction - _SMALL)
        return np.asarray((up - down) / (2.0 * _SMALL))

    def warmth(self, correction: MetersPerSecond | float) -> Array:
        """Return dV_t/dT [m/s per K], (n,)."""
        up, down = self.true_airspeed(correction, _SMALL), self.true_airspeed(correction, -_SMALL)
        return np.asarray((up - down) / (2.0 * _SMALL))


def leg_arrays(legs: Sequence[CardLeg]) -> LegArrays:
    """Return legs as arrays."""
    speed, track = (
        np.array([getattr(leg, name) for leg in legs]) for name in ("ground_speed", "track")
    )
    return LegArrays(
        np.array([leg.indicated_airspeed for leg in legs]),
        np.asarray(air.standard_pressure(np.array([leg.pressure_altitude for leg in legs]))),
        np.array([leg.air_temperature for leg in legs]),
        np.stack([speed * np.cos(track), speed * np.sin(track)], axis=1),
    )


def reading_variance(
    arrays: LegArrays, along: Array, steps: ReadingSteps, correction: Array
) -> Array:
    """Return the variance [(m/s)²], (n,), that the steps of the displays leave in the equation of
    each leg.

    `along` (n, 2) is the unit vector of the flight path through the air. A step of the track moves
    the tip of the ground velocity across itself; only its part along the flight path counts.
    """
    across = np.abs(along[:, 0] * arrays.velocity[:, 1] - along[:, 1] * arrays.velocity[:, 0])
    shares = (
        steps.ground_speed,
        steps.track * across,
        steps.indicated_airspeed * arrays.slope(correction),
        steps.air_temperature * arrays.warmth(correction),
    )
    return np.asarray(_ROUNDING**2 * sum(np.square(share) for share in shares))


# With the equations of the legs linearized, everything is Gaussian: y = u·w + s ΔV + readings +
# temperature. The wind takes a step from leg to leg and a longer one from point to point; Δp/q_c of
# a configuration is a constant, a slope in ln V and a smooth departure from both (Rasmussen and
# Williams, Gaussian Processes for Machine Learning, 2006, ch. 2.7). The sizes of the steps and of
# the departure are not known: each plausible set is weighed by its likelihood.

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


@dataclass(frozen=True, slots=True)
class Sizes:
    """The unknown sizes: steps of the wind from leg to leg and from point to point [m/s], departure
    of the curve [-] and its length in ln V, and the logarithm of their prior weight."""

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
    """A card near its answer: observations y (n,) [m/s], unit vectors of the flight paths (n, 2),
    slopes (n,) of the true airspeed by the correction, its change with temperature (n,), variances
    of the readings (n,)."""

    observed: Array
    along: Array
    slope: Array
    warmth: Array
    reading: Array


class CardModel:
    """The model of the legs of a card, (n,) in their order."""

    def __init__(self, legs: Sequence[CardLeg], steps: ReadingSteps, stated: Accuracies) -> None:
        self.legs = list(legs)
        self._arrays, self._steps, self._stated = leg_arrays(legs), steps, stated
        self.speed = self._arrays.indicated_airspeed
        self._configuration = np.array([leg.configuration for leg in legs])
        new = np.array([False, *(a.point != b.point for a, b in pairwise(legs))])
        same = (self._configuration[:, None] == self._configuration[None, :]).astype(np.float64)
        first = np.arange(len(legs)) == 0
        self._leg_steps = _passed((~new & ~first).astype(np.float64))
        self._point_steps = _passed(new.astype(np.float64))
        straight, bent = _curve_prior(self.speed, self.speed)
        self._straight, self._bent = (
            straight * same,
            {length: each * same for length, each in bent.items()},
        )
        self.linear = self._linearize()

    def _linearize(self) -> LinearCard:
        """Linearize at the answer for the usual sizes, in a few rounds."""
        count = len(self.legs)
        linear = self._at(np.zeros((count, 2)), np.zeros(count))
        for _ in range(_ROUNDS):
            covariance, wind_prior, curve_prior = self._priors(linear, TYPICAL_SIZES)
            solved = np.linalg.solve(covariance, linear.observed)
            wind = wind_prior @ (linear.along * solved[:, None])
            linear = self._at(wind, curve_prior @ (linear.slope * solved))
        return linear

    def _at(self, wind: Array, correction: Array) -> LinearCard:
        # A leg that cannot be must not carry the others away: it is judged where a real one could
        # lie.
        wind = np.clip(wind, -_MOST_WIND, _MOST_WIND)
        correction = np.clip(
            correction, -_MOST_CORRECTION * self.speed, _MOST_CORRECTION * self.speed
        )
        through = self._arrays.velocity - wind
        size = np.maximum(np.linalg.norm(through, axis=1), 1e-3)
        along = through / size[:, None]
        slope, true = self._arrays.slope(correction), self._arrays.true_airspeed(correction)
        observed = size + np.sum(along * wind, axis=1) - true + slope * correction
        reading = reading_variance(self._arrays, along, self._steps, correction)
        return LinearCard(observed, along, slope, self._arrays.warmth(correction), reading)

    def _priors(self, linear: LinearCard, sizes: Sizes) -> tuple[Array, Array, Array]:
        """Return the covariances [(m/s)²], (n, n), of the observations, of a component of the wind
        between legs, and of the correction."""
        wind = (
            _ANY_WIND**2
            + sizes.leg_step**2 * self._leg_steps
            + sizes.point_step**2 * self._point_steps
        )
        curve = self._straight + sizes.departure**2 * self._bent[sizes.length]
        # A probe that is wrong is wrong on every leg.
        constant = (0.5 * self._stated.temperature_k) ** 2 * np.outer(linear.warmth, linear.warmth)
        alone = linear.reading + (_SCATTER * sizes.leg_step) ** 2
        both = wind * (linear.along @ linear.along.T) + curve * np.outer(linear.slope, linear.slope)
        return both + constant + np.diag(alone), wind, curve

    def covariance(self, sizes: Sizes) -> Array:
        """Return the covariance of the observations [(m/s)²], (n, n)."""
        return self._priors(self.linear, sizes)[0]

    def log_likelihoods(self, choices: Sequence[Sizes]) -> Array:
        """Return the logarithm of the likelihood of the observations for each choice of sizes,
        (m,).
        """
        factors = np.linalg.cholesky(np.stack([self.covariance(sizes) for sizes in choices]))
        scaled = np.linalg.solve(
            factors, np.broadcast_to(self.linear.observed, factors.shape[:2])[..., None]
        )[..., 0]
        pivots = np.log(np.diagonal(factors, axis1=1, axis2=2)).sum(axis=1)
        return np.asarray(-0.5 * np.sum(scaled**2, axis=1) - pivots)

    def weights(self) -> Array:
        """Return the weight of each of `SIZES` after the card is looked at."""
        logs = self.log_likelihoods(SIZES) + np.array([sizes.log_weight for sizes in SIZES])
        weights = np.exp(logs - logs.max())
        return np.asarray(weights / weights.sum())

    def surprise(self, sizes: Sizes = TYPICAL_SIZES) -> Array:
        """Return by how many standard deviations each leg departs from what all others predict,
        (n,).
        """
        inverse = np.linalg.inv(self.covariance(sizes))
        return np.asarray((inverse @ self.linear.observed) / np.sqrt(np.diagonal(inverse)))

    def curves(
        self, at: MetersPerSecond, configuration: str, choices: Sequence[Sizes]
    ) -> tuple[Array, Array]:
        """Return the correction of a configuration at airspeeds [m/s] and its variance [(m/s)²],
        (m, c), for each choice of sizes."""
        here = (self._configuration == configuration) * self.linear.slope
        straight, bent = _curve_prior(at, self.speed)
        own_straight, own_bent = _curve_prior(at, at)
        means, variances = [], []
        for sizes in choices:
            cross = (straight + sizes.departure**2 * bent[sizes.length]) * here
            own = np.diagonal(own_straight + sizes.departure**2 * own_bent[sizes.length])
            solved = np.linalg.solve(
                self.covariance(sizes), np.column_stack([self.linear.observed, cross.T])
            )
            means.append(cross @ solved[:, 0])
            variances.append(own - np.einsum("cn,nc->c", cross, solved[:, 1:]))
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


def _curve_prior(one: MetersPerSecond, other: MetersPerSecond) -> tuple[Array, dict[float, Array]]:
    """Return the covariance [(m/s)²] of the correction at airspeeds (m,) and (n,), (m, n): that of
    constant and slope, and that of a departure of size 1, by its length.

    A small Δp/q_c moves the airspeed by q_c dV/dq_c times itself.
    """
    first, second = (np.log(np.asarray(each) / (100.0 * KNOT)) for each in (one, other))
    moved = [
        air.impact_pressure(v) * air.calibrated_airspeed_slope(air.impact_pressure(v))
        for v in (one, other)
    ]
    scale = np.outer(moved[0], moved[1])
    squared = (first[:, None] - second[None, :]) ** 2
    straight = (_CONSTANT**2 + _SLOPE**2 * np.outer(first, second)) * scale
    return straight, {length: np.exp(-0.5 * squared / length**2) * scale for length in _LENGTHS}


def _passed(steps: Array) -> Array:
    """Return how many steps two legs have in common since the first leg, (n, n)."""
    count = np.cumsum(steps)
    return np.asarray(np.minimum(count[:, None], count[None, :]))


# The tracks that a card was meant to be flown on: the first leg of every point on about one track,
# and so on. In little wind a wrong track leaves the airspeeds as they are; beside the same legs of
# the other points it shows.

_FEWEST = 3  # other points that fly the same leg
_TIGHT = 12.0 * DEGREE  # from their middle, within which all but one of them lie


def expected_tracks(legs: Sequence[CardLeg]) -> dict[int, float]:
    """Return the track [rad] that the other points fly on each leg, by row; no entry where they
    show none.
    """
    places: dict[str, int] = {}
    by_place: dict[int, list[CardLeg]] = {}
    for leg in legs:
        places[leg.point] = places.get(leg.point, -1) + 1
        by_place.setdefault(places[leg.point], []).append(leg)
    return {
        leg.row: middle
        for group in by_place.values()
        for leg in group
        if (middle := _middle([other.track for other in group if other is not leg])) is not None
    }


def _middle(tracks: Sequence[float]) -> float | None:
    """Return the track around which all but at most one of the tracks lie; None where they do not
    agree.
    """
    if len(tracks) < _FEWEST:
        return None
    away = np.abs(turn_between(np.asarray(tracks)[:, None], np.asarray(tracks)[None, :]))
    best = int(np.argmin(np.median(away, axis=1)))
    near = away[best] <= _TIGHT
    if np.count_nonzero(~near) > 1 or np.count_nonzero(near) < _FEWEST:
        return None
    return float(tracks[best] + np.mean(turn_between(np.asarray(tracks)[near], tracks[best])))


def turn_between(one: "np.ndarray | float", other: "np.ndarray | float") -> np.ndarray:
    """Return the angle from one track to another [rad], within half a turn."""
    return np.asarray((np.asarray(one) - np.asarray(other) + np.pi) % (2.0 * np.pi) - np.pi)


# Which legs to fly by hand for a wanted bound: the card's own model, before a leg is flown. The
# bound of a curve depends on speeds, tracks and reading steps alone, and on how much the wind
# wanders, which is averaged over the sizes that the card's model takes for possible.

DISPLAY = ReadingSteps(KNOT, 10.0 * FOOT, 1.0, KNOT, DEGREE)
LEG_MINUTES = 1.5  # 30 s on the leg, and the turn to the next
POINT_MINUTES = 1.5  # to set up another airspeed
_LEGS, _POINTS, _TIMES = (3, 4), (3, 4, 5, 6, 8), (1, 2, 3, 4)
_SPEEDS = 7
_TEMPERATURE = 278.15  # K; the bound hardly depends on it


def plans_by_hand(
    low: float, high: float, wind: tuple[float, float] = (0.0, 0.0), stated: Accuracies = USUAL
) -> list[HandPlan]:
    """Return cards for a curve between two indicated airspeeds [m/s], the shortest first, each
    better than all shorter ones. `wind` [m/s] is toward north and east."""
    plans = [
        _plan(legs, points, times, low, high, wind, stated)
        for legs, points, times in product(_LEGS, _POINTS, _TIMES)
    ]
    better: list[HandPlan] = []
    for plan in sorted(plans, key=lambda each: (each.minutes, each.two_sigma)):
        if not better or plan.two_sigma < better[-1].two_sigma:
            better.append(plan)
    return better


def _plan(
    legs: int,
    points: int,
    times: int,
    low: float,
    high: float,
    wind: tuple[float, float],
    stated: Accuracies,
) -> HandPlan:
    speeds = np.linspace(low, high, points)
    order = np.concatenate([speeds if turn % 2 == 0 else speeds[::-1] for turn in range(times)])
    card = [
        _leg(number * legs + leg, number, float(speed), 2.0 * np.pi * leg / legs, wind)
        for number, speed in enumerate(order)
        for leg in range(legs)
    ]
    model = CardModel(card, DISPLAY, stated)
    weights = np.exp([sizes.log_weight for sizes in SIZES])
    _, variances = model.curves(np.linspace(low, high, _SPEEDS), "", SIZES)
    variance = float(weights @ variances.mean(axis=1) / weights.sum())
    minutes = len(card) * LEG_MINUTES + len(order) * POINT_MINUTES
    return HandPlan(legs, tuple(map(float, speeds)), times, minutes, 2.0 * float(np.sqrt(variance)))


def _leg(row: int, number: int, speed: float, track: float, wind: tuple[float, float]) -> CardLeg:
    """Return a leg at 5,000 ft along a track, with about the ground speed that it would have."""
    along = np.array([np.cos(track), np.sin(track)])
    ground = max(1.08 * speed + float(along @ np.array(wind)), 1.0)
    return CardLeg(
        row=row + 1,
        point=str(number),
        configuration="",
        indicated_airspeed=speed,
        pressure_altitude=5000.0 * FOOT,
        air_temperature=_TEMPERATURE,
        ground_speed=ground,
        track=track,
    )
