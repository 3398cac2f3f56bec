"""Fixed-speed points from legs and turns: an airspeed, a wind and a correction for each group, with
bounds.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from pitotbench.calibration.covering import GUST_LENGTH, GUST_SCALE, WHITE_SCALE, WindNoise
from pitotbench.calibration.leg_methods import SolvedGroup, horseshoe_of_legs, solve_group
from pitotbench.calibration.legs import (
    SECOND,
    LikelyLocation,
    likely_location,
    location_of,
    steady_groups,
)
from pitotbench.calibration.observations import observe
from pitotbench.calibration.options import Accuracies, CalibrationOptions, accuracies_of
from pitotbench.calibration.reduction import one_thread
from pitotbench.estimation.noise import Intervals
from pitotbench.estimation.restricted_likelihood import half_width, weighted_noises
from pitotbench.records import NoAnswerError
from pitotbench.records.calibration import Calibration
from pitotbench.records.legs import FixedSpeedPoint
from pitotbench.records.log import FlightLog
from pitotbench.units import Array

# The bound of a fixed-speed answer, from the gusts and the sensor noise that the legs show. The
# residual of ground velocity and air data, without airspeed and wind, is white noise plus the gust
# along the flight path. The gust is a horizontal first-order Gauss-Markov vector of Dryden's
# length. The levels come from all legs and turns of the log together, by restricted likelihood. The
# methods are not least squares, so each plausible noise is propagated with the weights of the
# method. The bound is that of the mixture over the noises. The likelihood treats the gusts of
# different groups as independent. Each group's airspeed and wind then need only a 4 x 4 matrix of
# products, and the cost is proportional to the length of the log instead of its cube. Within a
# group all correlations count. Compared with the likelihood of all legs at once, no 2σ of the five
# maneuvers and three data systems changes by more than 0.02 %.

_FLOOR = 1e-4  # m/s: keeps the covariance regular for legs without noise
# One standard deviation of the prior on the gust length, as a factor. Legs of half a minute tell
# little about it.
_LENGTH_FACTOR = 1.6
_FORGOTTEN = (
    1e5  # s, between groups: some thousand correlation times, so their gusts are independent
)
_TOUCHING = (
    1.01 * SECOND
)  # s, greatest distance between the middles of two blocks that share an edge


def two_sigma(groups: Sequence[SolvedGroup]) -> list[Array]:
    """Compute 2σ of the airspeed and the wind components [m/s], (3,), of each group."""
    noises, weights = plausible_noises(groups)
    means = np.zeros((len(weights), 3))
    return [
        half_width(weights, means, np.sqrt(answer_variances(group, noises))) for group in groups
    ]


def plausible_noises(groups: Sequence[SolvedGroup]) -> tuple[Array, Array]:
    """Return the nodes of the noise's posterior, (m, 3), and their weights, (m,).

    A node is ln(gust deviation [m/s], gust length [m], white deviation [m/s]).
    """
    level = float(np.concatenate([group.residual for group in groups]).std())
    if level < _FLOOR:  # computed legs without noise
        return np.log([[_FLOOR, GUST_LENGTH, _FLOOR]]), np.ones(1)
    likelihood = LegLikelihood(groups)

    def log_posterior(noise: Array) -> float:
        try:
            return likelihood.of(noise) + _log_prior(noise)
        except np.linalg.LinAlgError:
            return -np.inf  # the search rejects this noise

    return weighted_noises(log_posterior, np.log([level, GUST_LENGTH, 0.3 * level]))


def _log_prior(phi: Array) -> float:
    """The prior of the covering method: half-normal levels, log-normal length, as densities of the
    logarithms.
    """
    deviation, white = np.exp(phi[0]), np.exp(phi[2])
    levels = (
        -0.5 * (deviation / GUST_SCALE) ** 2 - 0.5 * (white / WHITE_SCALE) ** 2 + phi[0] + phi[2]
    )
    return float(levels - 0.5 * ((phi[1] - np.log(GUST_LENGTH)) / np.log(_LENGTH_FACTOR)) ** 2)


class LegLikelihood:
    """The restricted likelihood of the noise. Each group has a separate airspeed and wind."""

    def __init__(self, groups: Sequence[SolvedGroup]) -> None:
        lengths = [len(group.group.time) for group in groups]
        self._first = np.cumsum([0, *lengths[:-1]])
        along = np.concatenate([group.along for group in groups])
        intervals = _intervals(groups, self._first)
        airspeed = np.repeat([group.answer[0] for group in groups], lengths)
        sensor = np.zeros(len(along))  # in the white part
        self._noise_of = WindNoise(
            intervals, intervals.at_edges(airspeed), along[None], sensor, drifting=False
        )
        residual = np.concatenate([group.residual for group in groups])
        self._data = np.column_stack([np.ones(len(residual)), along, residual])

    def of(self, noise: Array) -> float:
        """The restricted log-likelihood (Harville 1974), up to a constant.

        `noise` (3,) is ln(gust deviation [m/s], gust length [m], white deviation [m/s]).
        Raises numpy.linalg.LinAlgError where the legs do not determine airspeed and wind.
        """
        factored = self._noise_of(noise)
        weighed = factored.weigh(self._data)
        products = np.add.reduceat(self._data[:, :, None] * weighed[:, None, :], self._first)
        scale = np.sqrt(np.diagonal(products, axis1=1, axis2=2))
        factors = np.linalg.cholesky(products / scale[:, :, None] / scale[:, None, :])
        # The last row of a factor holds the residual explained by airspeed and wind; its last
        # element is the rest.
        pivots = np.diagonal(factors, axis1=1, axis2=2) * scale
        log_normal = 2.0 * np.sum(np.log(pivots[:, :-1]))
        return float(-0.5 * (factored.log_determinant + log_normal + np.sum(pivots[:, -1] ** 2)))


def _intervals(groups: Sequence[SolvedGroup], first: NDArray[np.intp]) -> Intervals:
    """The seconds of all groups in one series, with gaps between groups that no gust correlation
    spans.
    """
    step = np.diff(np.concatenate([group.group.time for group in groups]))
    step[first[1:] - 1] = _FORGOTTEN
    time = np.concatenate([[0.0], np.cumsum(np.minimum(step, _FORGOTTEN))])
    left = np.concatenate([[0], np.cumsum(np.where(step < _TOUCHING, 1, 2))])
    edges = np.empty(left[-1] + 2)
    edges[left + 1] = time + 0.5 * SECOND
    edges[left] = time - 0.5 * SECOND
    return Intervals(edges, left)


def answer_variances(group: SolvedGroup, noises: Array) -> Array:
    """Variances of a group's airspeed and wind components [(m/s)²], (m, 3), under noises (m, 3).

    The noise is white noise plus the exact mean of the gust over each second.
    """
    deviation, length, white = np.exp(noises.T)
    a = SECOND * float(group.answer[0]) / length
    same, other = 2.0 * (a - 1.0 + np.exp(-a)) / a**2, 2.0 * (np.cosh(a) - 1.0) / a**2
    seen = (
        group.gain[:, :, None] * group.along[:, None, :]
    )  # (n, 3, 2): change of the answer per gust component
    earlier = _remembered(
        seen, np.exp(-a * np.diff(group.group.time, prepend=group.group.time[0])[:, None] / SECOND)
    )
    shared = 2.0 * np.einsum("nkc,nmkc->mk", seen, earlier)
    gust = same[:, None] * np.sum(seen**2, axis=(0, 2)) + other[:, None] * shared
    return np.asarray(
        deviation[:, None] ** 2 * gust + white[:, None] ** 2 * np.sum(group.gain**2, axis=0)
    )


def _remembered(seen: Array, decay: Array) -> Array:
    """The sum over all earlier seconds, weighted by their correlation with this one, (n, m, 3, 2).

    `decay` (n, m) is the correlation with the second before. One pass is enough: with an
    exponential correlation each sum follows from the last.
    """
    sums = np.zeros((*decay.shape, *seen.shape[1:]))
    for second in range(1, len(seen)):
        sums[second] = decay[second, :, None, None] * (sums[second - 1] + seen[second - 1])
    return sums


# Fixed-speed points from a log: each group of steady legs or turn gives one airspeed, wind and
# correction.


def fixed_speed_points(
    log: FlightLog,
    options: CalibrationOptions | None = None,
    location: LikelyLocation | None = None,
) -> tuple[FixedSpeedPoint, ...]:
    """One point for each full turn and each group of legs on three or more tracks at one airspeed.

    `location` is that of the error, where a fit has found it; else it is judged as a fit of the
    curve does. The used options are the row selection, the recovery factor, the error location and
    the accuracies (stated, else the header's, else the usual ones). The 2σ covers gusts, sensor
    noise and GPS noise as found in the log, and the accuracies. Raises BadInputError for a log that
    cannot be used, NoAnswerError for one without such legs or turns.
    """
    with one_thread():
        return _points(log, options or CalibrationOptions(), location)


def _points(
    log: FlightLog, options: CalibrationOptions, location: LikelyLocation | None
) -> tuple[FixedSpeedPoint, ...]:
    solved = [solve_group(group) for group in steady_groups(log, observe(log, options))]
    if not solved:
        raise NoAnswerError(
            "no fixed-speed point in this log: no full turn, and no three steady legs at one "
            "airspeed and height; "
            "fly four legs 90° apart, at least 5 s each, or a full turn at constant bank"
        )
    stated = accuracies_of(options.accuracies, log.header)
    place = location or likely_location(log, options)
    return tuple(
        _point(each, bound, stated, place)
        for one, found in zip(solved, two_sigma(solved), strict=True)
        for each, bound in ((one, found), *_horseshoe(one, found))
    )


def _horseshoe(one: SolvedGroup, bound: Array) -> list[tuple[SolvedGroup, Array]]:
    """The answer of the horseshoe method, in addition to that of three legs, for tracks nearly 90°
    apart.

    The tracks are not exactly 90° apart, so the formula has an error. It is the difference from the
    three-leg answer and widens the bound.
    """
    legs = one.group.leg_means(one.velocity)
    airspeed = None if one.method != "three_leg" else horseshoe_of_legs(legs)
    if airspeed is None:
        return []
    off = np.array([abs(airspeed - one.answer[0]), 0.0, 0.0])
    answer = np.array([airspeed, *one.answer[1:]])
    return [(replace(one, method="horseshoe", answer=answer), bound + off)]


def _point(
    one: SolvedGroup, bound: Array, stated: Accuracies, place: LikelyLocation
) -> FixedSpeedPoint:
    """The point, with the doubt about the location of the error in its correction and its bound."""
    group, true = one.group, float(one.answer[0])
    (static, static_bound), (total, total_bound) = (
        replace(one.air, static_error=where).corrected(true, float(bound[0]), stated)
        for where in (True, False)
    )
    correction = total + place.static * (static - total)
    likely_bound = static_bound if place.static >= 0.5 else total_bound
    indicated = float(one.air.indicated_airspeed)
    return FixedSpeedPoint(
        method=one.method,
        legs=group.legs,
        seconds=len(group.time) * SECOND,
        indicated_airspeed=indicated,
        calibrated_airspeed=indicated + correction,
        correction=correction,
        two_sigma=float(np.hypot(likely_bound, 2.0 * place.doubt * (static - total))),
        true_airspeed=true,
        true_airspeed_two_sigma=float(bound[0]),
        spread=one.spread,
        wind_north=float(one.answer[1]),
        wind_east=float(one.answer[2]),
        wind_two_sigma=float(np.hypot(bound[1:].max(), stated.velocity_mps)),
    )


def cross_check(
    log: FlightLog, options: CalibrationOptions | None = None, found: Calibration | None = None
) -> tuple[FixedSpeedPoint, ...]:
    """The fixed-speed points to compare a curve with; none where the log has no such legs or turns.

    The location of the error is that of the curve's calibration, where it is given.
    """
    chosen = options or CalibrationOptions()
    location = None
    if found is not None:
        location = location_of(chosen, found.error_location, found.diagnostics.static_probability)
    try:
        return fixed_speed_points(log, chosen, location)
    except NoAnswerError:
        return ()
