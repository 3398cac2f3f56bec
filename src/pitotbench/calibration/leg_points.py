"""Fixed-speed points from the steady legs and turns of a log: an airspeed, a wind and a correction
for each group, with bounds.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pitotbench.calibration.covering_problem import WindNoise
from pitotbench.calibration.leg_methods import (
    LegAir,
    Legs,
    SolvedGroup,
    by_track,
    solve_group,
    unit,
)
from pitotbench.calibration.observations import Observations, observe
from pitotbench.calibration.options import (
    AUTO,
    PRIORS,
    Accuracies,
    CalibrationOptions,
    Priors,
    accuracies_of,
    priors_of,
)
from pitotbench.calibration.reduction import one_thread
from pitotbench.calibration.screening import SECOND
from pitotbench.estimation.mixture import half_width
from pitotbench.estimation.noise import Intervals
from pitotbench.estimation.restricted_likelihood import weighted_noises
from pitotbench.records import BadInputError, NoAnswerError
from pitotbench.records.calibration import Calibration
from pitotbench.records.legs import FixedSpeedPoint
from pitotbench.records.log import FlightLog
from pitotbench.units import DEGREE, KNOT, Array, Seconds

_WHOLE = 0.8  # share of a block's rows that must be present


def labeled(log: FlightLog) -> bool:
    """Whether the log marks any row as on condition."""
    return log.on_condition is not None and bool(log.on_condition.any())


def block_means(log: FlightLog, obs: Observations) -> Legs:
    """Average the log's rows in blocks; where the log marks rows as on condition, those alone. A
    run is a piece; `time` [s] is the middle of the block.
    """
    run = _runs(log, obs)
    north, east = obs.velocity_north, obs.velocity_east
    channels = np.stack(
        [
            obs.impact_pressure,
            obs.static_pressure,
            obs.probe_temperature,
            np.hypot(north, east),  # the mean of a turning vector is too short
            north,
            east,
        ]
    )
    rows_a_block = SECOND / float(np.median(np.diff(obs.time)))
    rows = np.flatnonzero(run >= 0)
    table = _means(obs.time[rows], channels[:, rows], rows_a_block, run[rows])
    time, impact, pressure, temperature, speed, north, east, number = table
    return Legs(
        LegAir(impact, pressure, temperature, obs.probe_heating, standard_day=obs.standard_day),
        time,
        speed,
        unit(np.stack([north, east], axis=1)),
        np.zeros(len(time), dtype=np.bool_),
        number.astype(np.intp),
    )


def _runs(log: FlightLog, obs: Observations) -> NDArray[np.intp]:
    """The number of each row's run; −1 where the row is not on condition.

    A run is a segment without its rows off condition. In a log without segments it is an
    uninterrupted stretch on condition.
    """
    changed = np.diff(obs.stretch) != 0
    on = np.ones(len(obs), dtype=np.bool_)
    if log.on_condition is not None and labeled(log):
        on = log.on_condition[obs.used]
    if log.segment is not None:
        segment = log.segment[obs.used]
        changed |= segment[1:] != segment[:-1]
    else:
        changed |= on[1:] != on[:-1]
    return np.where(on, np.concatenate([[0], np.cumsum(changed)]), -1)


def _means(time: Seconds, channels: Array, rows_a_block: float, run: NDArray[np.intp]) -> Array:
    """Time, means and number of the run, (c + 2, blocks), for rows (n,) in runs. Incomplete blocks
    are left out.
    """
    if not len(run):
        return np.zeros((len(channels) + 2, 0))
    begun = np.diff(run, prepend=-1) != 0
    start = time[begun][np.cumsum(begun) - 1]  # of the row's run
    # Only blocks that have rows are formed: with one wrong time stamp, all up to the last would
    # fill the memory.
    block = np.floor((time - start) / SECOND + 1e-6)
    first = np.flatnonzero(begun | (np.diff(block, prepend=-1.0) != 0.0))
    count = np.diff(first, append=len(run))
    index = np.repeat(np.arange(len(first)), count)
    whole = count >= _WHOLE * rows_a_block
    means = np.stack([np.bincount(index, channel) for channel in channels])[:, whole] / count[whole]
    middle = start[first] + (block[first] + 0.5) * SECOND
    return np.vstack([middle[whole], means, run[first][whole]])


# Where the log marks what was on condition, the marks are used. Else straight legs and turns are
# found from the ground velocity, which gusts change less than the air data. In both cases a piece
# must be long enough, straight or a full turn, level, and of constant airspeed.

# s, the least on condition that Martos, Kiszely and Foster (2011), III.A, allow a leg
_SHORTEST = 5.0
_STRAIGHT = 5.0 * DEGREE  # largest change of mean track between the halves of a straight leg
# Least change of track of a turn: the ground velocities of a smaller one are only an arc.
_FULL_TURN = 300.0 * DEGREE
# rad/s: straight flight below, a third of a standard-rate turn above (no labels)
_TURN_RATE = 1.0 * DEGREE
# m/s² of ground speed: above it the airspeed is being changed (no labels)
_ACCELERATION = 0.5 * KNOT
_WINDOW = 2  # blocks to either side, for rates of change (no labels)
# Limits between the halves of a piece and between neighbors of one group: m/s of airspeed, and a
# share of the static pressure, about 300 ft.
_DRIFT = 3.0 * KNOT
_LEVEL = 0.01


def steady_groups(log: FlightLog, obs: Observations) -> tuple[Legs, ...]:
    """Find full turns, and groups of straight legs on three tracks or more, sorted by airspeed."""
    blocks = block_means(log, obs)
    if not labeled(log):
        blocks = _stretches(blocks)
    long = [p for p in blocks.pieces() if len(p.time) * SECOND >= _SHORTEST and _holds(p)]
    turns = [
        replace(piece, leg=np.arange(len(piece.leg)), turning=True)
        for piece in long
        if np.ptp(piece.track) >= _FULL_TURN
    ]
    straight = [
        piece for piece in long if abs(float(np.diff(_halves(piece.track))[0])) <= _STRAIGHT
    ]
    groups = [_as_legs(blocks, pieces) for pieces in _by_airspeed(straight)]
    useful = [*turns, *(group for group in groups if group.leg.max() >= 2)]
    return tuple(sorted(useful, key=_airspeed))


def _airspeed(piece: Legs) -> float:
    """The mean indicated true airspeed [m/s]."""
    return float(piece.air.true_airspeed().mean())


def _stretches(blocks: Legs) -> Legs:
    """Return the blocks of straight and turning stretches in runs without labels, each a piece."""
    number, steady = np.zeros(len(blocks.time), dtype=np.intp), np.zeros(len(blocks.time), np.bool_)
    for run in np.unique(blocks.leg):
        own = np.flatnonzero(blocks.leg == run)
        if len(own) <= 2 * _WINDOW:
            continue
        turning = np.abs(_rate(blocks.at(own).track)) > _TURN_RATE
        steady[own] = turning | (np.abs(_rate(blocks.ground_speed[own])) < _ACCELERATION)
        changed = (np.diff(turning) != 0) | (np.diff(steady[own]) != 0)
        number[own] = number.max() + 1 + np.concatenate([[0], np.cumsum(changed)])
    return replace(blocks, leg=number).at(steady)


def _rate(values: Array) -> Array:
    """Rate of change per second, over a window around each block (narrower at the ends)."""
    last = len(values) - 1
    behind, ahead = (np.clip(np.arange(last + 1) + shift, 0, last) for shift in (-_WINDOW, _WINDOW))
    return np.asarray((values[ahead] - values[behind]) / ((ahead - behind) * SECOND))


def _holds(piece: Legs) -> bool:
    """Whether airspeed and height are constant: in the means of the halves gusts average out, and
    drifts do not.
    """
    airspeed, pressure = _halves(piece.air.true_airspeed()), _halves(piece.air.static_pressure)
    return bool(np.ptp(airspeed) <= _DRIFT and np.ptp(pressure) <= _LEVEL * pressure[0])


def _halves(values: Array) -> Array:
    middle = len(values) // 2
    return np.array([values[:middle].mean(), values[middle:].mean()])


def _by_airspeed(pieces: list[Legs]) -> list[list[Legs]]:
    """Group pieces by height, then by airspeed. No chain of neighbors spans more than twice the
    limit.
    """
    heights = [float(np.log(piece.air.static_pressure.mean())) for piece in pieces]
    return [
        chain
        for level in _chains(pieces, heights, _LEVEL)
        for chain in _chains(level, [_airspeed(piece) for piece in level], _DRIFT)
    ]


def _chains(pieces: list[Legs], values: list[float], step: float) -> list[list[Legs]]:
    chains: list[list[Legs]] = []
    first = last = -np.inf
    for place in np.argsort(values):
        value = values[place]
        if value - last > step or value - first > 2.0 * step:
            chains.append([])
            first = value
        chains[-1].append(pieces[place])
        last = value
    return chains


def _as_legs(blocks: Legs, pieces: list[Legs]) -> Legs:
    """Join pieces of the blocks, those on one track to one leg. The legs are numbered by track."""
    leg = by_track(np.array([np.arctan2(*(p.ground_speed @ p.toward)[::-1]) for p in pieces]))
    leg_of = np.full(int(blocks.leg.max()) + 1, -1)
    leg_of[[piece.leg[0] for piece in pieces]] = leg
    joined = replace(blocks, leg=leg_of[blocks.leg])
    return joined.at(joined.leg >= 0)


_STATIC = "static"


@dataclass(frozen=True, slots=True)
class LikelyLocation:
    """`static` is the share of the static source in the answer.

    `doubt` is the standard deviation that the location adds, as a share of the difference between
    the locations.
    """

    static: float
    doubt: float


def location_of(
    options: CalibrationOptions, location: str, probability: float | None = None
) -> LikelyLocation:
    """The location that a calibration found: its options, its place of the error and the
    probability of a static source, None without evidence."""
    if probability is not None:
        return LikelyLocation(probability, float((probability * (1.0 - probability)) ** 0.5))
    # Without evidence the static source is an assumption, and the difference is one standard
    # deviation.
    assumed = (
        options.error_location == AUTO and options.method == "covering" and location == _STATIC
    )
    return LikelyLocation(float(location == _STATIC), float(assumed))


def likely_location(log: FlightLog, options: CalibrationOptions) -> LikelyLocation:
    """Judge the location by the height where the log has it; else take the usual one, with doubt."""
    if options.error_location != AUTO:
        return location_of(options, options.error_location)
    # Slow to load; a stated location needs no fit.
    from pitotbench.calibration.location import assumed_location
    from pitotbench.calibration.reduction import reduce_log

    if log.altitude is not None and options.use_altitude:
        try:
            fit = reduce_log(log, replace(options, method="covering", latency="given"))
        except (NoAnswerError, BadInputError):  # too few airspeeds for a curve
            pass
        else:
            return location_of(options, fit.error_location, fit.diagnostics.static_probability)
    return location_of(options, assumed_location(log.header))


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
# s, between groups: some thousand correlation times, so their gusts are independent
_FORGOTTEN = 1e5
# s, greatest distance between the middles of two blocks that share an edge
_TOUCHING = 1.01 * SECOND


def two_sigma(groups: Sequence[SolvedGroup], priors: Priors = PRIORS) -> list[Array]:
    """Compute 2σ of the airspeed and the wind components [m/s], (3,), of each group."""
    noises, weights = plausible_noises(groups, priors)
    means = np.zeros((len(weights), 3))
    return [
        half_width(weights, means, np.sqrt(answer_variances(group, noises))) for group in groups
    ]


def plausible_noises(groups: Sequence[SolvedGroup], priors: Priors = PRIORS) -> tuple[Array, Array]:
    """Return the nodes of the noise's posterior, (m, 3), and their weights, (m,).

    A node is ln(gust deviation [m/s], gust length [m], white deviation [m/s]).
    """
    level = float(np.concatenate([group.residual for group in groups]).std())
    if level < _FLOOR:  # computed legs without noise
        return np.log([[_FLOOR, priors.gust_length_m, _FLOOR]]), np.ones(1)
    likelihood = LegLikelihood(groups)

    def log_posterior(noise: Array) -> float:
        try:
            return likelihood.of(noise) + _log_prior(noise, priors)
        except np.linalg.LinAlgError:
            return -np.inf  # the search rejects this noise

    return weighted_noises(log_posterior, np.log([level, priors.gust_length_m, 0.3 * level]))


def _log_prior(phi: Array, priors: Priors = PRIORS) -> float:
    """The prior of the covering method: half-normal levels, log-normal length, as densities of the
    logarithms.
    """
    deviation, white = np.exp(phi[0]), np.exp(phi[2])
    levels = (
        -0.5 * (deviation / priors.gust_mps) ** 2
        - 0.5 * (white / priors.white_mps) ** 2
        + phi[0]
        + phi[2]
    )
    return float(
        levels - 0.5 * ((phi[1] - np.log(priors.gust_length_m)) / np.log(_LENGTH_FACTOR)) ** 2
    )


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
            intervals, intervals.at_edges(airspeed), along[None], sensor, memory=None
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
    # (n, 3, 2): change of the answer per gust component
    seen = group.gain[:, :, None] * group.along[:, None, :]
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


def fixed_speed_points(
    log: FlightLog,
    options: CalibrationOptions | None = None,
    location: LikelyLocation | None = None,
) -> tuple[FixedSpeedPoint, ...]:
    """One point for each full turn and each group of legs on three or more tracks at one airspeed.

    `location` is that of the error, where a fit has found it; else it is judged as a fit of the
    curve does. The used options are the row selection, the recovery factor, the error location, the
    priors of gusts and white noise, and the accuracies (stated, else the header's, else the usual
    ones). The 2σ covers gusts, sensor noise and GPS noise as found in the log, and the accuracies.
    Raises BadInputError for a log that cannot be used, NoAnswerError for one without such legs or
    turns.
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
        _point(one, bound, stated, place)
        for one, bound in zip(solved, two_sigma(solved, priors_of(options.priors)), strict=True)
    )


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
        legs=1 if group.turning else int(group.leg.max()) + 1,
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
