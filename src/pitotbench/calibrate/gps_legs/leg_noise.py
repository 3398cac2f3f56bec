"""The bound of a fixed-speed answer, from the gusts and the sensor noise that the legs show.

The residual of ground velocity and air data, without airspeed and wind, is white noise plus the gust along the
flight path. The gust is a horizontal first-order Gauss-Markov vector of Dryden's length. The levels come from all
legs and turns of the log together, by restricted likelihood. The methods are not least squares, so each plausible
noise is propagated with the weights of the method. The bound is that of the mixture over the noises.

The likelihood treats the gusts of different groups as independent. Each group's airspeed and wind then need only a
4 x 4 matrix of products, and the cost is proportional to the length of the log instead of its cube. Within a group
all correlations count. Compared with the likelihood of all legs at once, no 2σ of the five maneuvers and three data
systems changes by more than 0.02 %.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pitotbench.calibrate.gls.linearized_problem import GUST_LENGTH, GUST_SCALE, WHITE_SCALE
from pitotbench.calibrate.rows.steady_blocks import SECOND
from pitotbench.estimate.markov_noise import Intervals, MarkovNoise, MarkovProcess
from pitotbench.estimate.mixture import half_width
from pitotbench.estimate.restricted_likelihood import weighted_noises
from pitotbench.units import Array, Seconds

_FLOOR = 1e-4  # m/s: keeps the covariance regular for legs without noise
# One standard deviation of the prior on the gust length, as a factor. Legs of half a minute tell little about it.
_LENGTH_FACTOR = 1.6
_FORGOTTEN = 1e5  # s, between groups: some thousand correlation times, so their gusts are independent
_TOUCHING = 1.01 * SECOND  # s, greatest distance between the middles of two blocks that share an edge


@dataclass(frozen=True, slots=True)
class LinearizedGroup:
    """A group linearized at its answer.

    `time` (n,) [s] is the middle of each second, `residual` (n,) [m/s] that of ground velocity against airspeed and
    wind, and `along` (n, 2) the unit vector of the flight path. `gain` (n, 3) is the change of the answer
    [V, W_N, W_E] per residual in each second [-]. `airspeed` [m/s] is the true one.
    """

    time: Seconds
    residual: Array
    along: Array
    gain: Array
    airspeed: float

    def in_order(self) -> "LinearizedGroup":
        """Return the group sorted by time."""
        order = np.argsort(self.time)
        return LinearizedGroup(
            self.time[order], self.residual[order], self.along[order], self.gain[order], self.airspeed
        )


def two_sigma(groups: Sequence[LinearizedGroup]) -> list[Array]:
    """Compute 2σ of the airspeed and the wind components [m/s], (3,), of each group."""
    ordered = [group.in_order() for group in groups]
    noises, weights = plausible_noises(ordered)
    means = np.zeros((len(weights), 3))
    return [half_width(weights, means, np.sqrt(answer_variances(group, noises))) for group in ordered]


def plausible_noises(groups: Sequence[LinearizedGroup]) -> tuple[Array, Array]:
    """Return the nodes of the noise's posterior, (m, 3), and their weights, (m,).

    A node is ln(gust deviation [m/s], gust length [m], white deviation [m/s]). Each group must be sorted by time.
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
    """The prior of the covering method: half-normal levels, log-normal length, as densities of the logarithms."""
    deviation, white = np.exp(phi[0]), np.exp(phi[2])
    levels = -0.5 * (deviation / GUST_SCALE) ** 2 - 0.5 * (white / WHITE_SCALE) ** 2 + phi[0] + phi[2]
    return float(levels - 0.5 * ((phi[1] - np.log(GUST_LENGTH)) / np.log(_LENGTH_FACTOR)) ** 2)


class LegLikelihood:
    """The restricted likelihood of the noise. Each group has a separate airspeed and wind.

    Parameters: groups, each sorted by time.
    """

    def __init__(self, groups: Sequence[LinearizedGroup]) -> None:
        lengths = [len(group.time) for group in groups]
        self._first = np.cumsum([0, *lengths[:-1]])
        self._along = np.concatenate([group.along for group in groups])
        self._intervals = _intervals(groups, self._first)
        self._airspeed = np.empty(len(self._intervals.edges))
        for side in (1, 0):  # the left edges last: a shared edge has the airspeed of the block that begins there
            self._airspeed[self._intervals.left + side] = np.repeat([group.airspeed for group in groups], lengths)
        residual = np.concatenate([group.residual for group in groups])
        self._data = np.column_stack([np.ones(len(residual)), self._along, residual])

    def of(self, noise: Array) -> float:
        """The restricted log-likelihood (Harville 1974), up to a constant.

        `noise` (3,) is ln(gust deviation [m/s], gust length [m], white deviation [m/s]).
        Raises numpy.linalg.LinAlgError where the legs do not determine airspeed and wind.
        """
        deviation, length, white = np.exp(noise)
        gust = MarkovProcess(deviation, length / self._airspeed, self._along)
        factored = MarkovNoise(self._intervals, np.full(len(self._data), white**2 + _FLOOR**2), [gust])
        weighed = factored.weigh(self._data)
        products = np.add.reduceat(self._data[:, :, None] * weighed[:, None, :], self._first)
        scale = np.sqrt(np.diagonal(products, axis1=1, axis2=2))
        factors = np.linalg.cholesky(products / scale[:, :, None] / scale[:, None, :])
        # The last row of a factor holds the residual explained by airspeed and wind; its last element is the rest.
        pivots = np.diagonal(factors, axis1=1, axis2=2) * scale
        log_normal = 2.0 * np.sum(np.log(pivots[:, :-1]))
        return float(-0.5 * (factored.log_determinant + log_normal + np.sum(pivots[:, -1] ** 2)))


def _intervals(groups: Sequence[LinearizedGroup], first: NDArray[np.intp]) -> Intervals:
    """The seconds of all groups in one series, with gaps between groups that no gust correlation spans."""
    step = np.diff(np.concatenate([group.time for group in groups]))
    step[first[1:] - 1] = _FORGOTTEN
    time = np.concatenate([[0.0], np.cumsum(np.minimum(step, _FORGOTTEN))])
    left = np.concatenate([[0], np.cumsum(np.where(step < _TOUCHING, 1, 2))])
    edges = np.empty(left[-1] + 2)
    edges[left + 1] = time + 0.5 * SECOND
    edges[left] = time - 0.5 * SECOND
    return Intervals(edges, left)


def answer_variances(group: LinearizedGroup, noises: Array) -> Array:
    """Variances of a group's airspeed and wind components [(m/s)²], (m, 3), under noises (m, 3).

    The noise is white noise plus the exact mean of the gust over each second. The group must be sorted by time.
    """
    deviation, length, white = np.exp(noises.T)
    a = SECOND * group.airspeed / length
    same, other = 2.0 * (a - 1.0 + np.exp(-a)) / a**2, 2.0 * (np.cosh(a) - 1.0) / a**2
    seen = group.gain[:, :, None] * group.along[:, None, :]  # (n, 3, 2): change of the answer per gust component
    earlier = _remembered(seen, np.exp(-a * np.diff(group.time, prepend=group.time[0])[:, None] / SECOND))
    shared = 2.0 * np.einsum("nkc,nmkc->mk", seen, earlier)
    gust = same[:, None] * np.sum(seen**2, axis=(0, 2)) + other[:, None] * shared
    return np.asarray(deviation[:, None] ** 2 * gust + white[:, None] ** 2 * np.sum(group.gain**2, axis=0))


def _remembered(seen: Array, decay: Array) -> Array:
    """The sum over all earlier seconds, weighted by their correlation with this one, (n, m, 3, 2).

    `decay` (n, m) is the correlation with the second before. One pass is enough: with an exponential correlation
    each sum follows from the last.
    """
    sums = np.zeros((*decay.shape, *seen.shape[1:]))
    for second in range(1, len(seen)):
        sums[second] = decay[second, :, None, None] * (sums[second - 1] + seen[second - 1])
    return sums
