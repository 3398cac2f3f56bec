"""How far a fixed-speed answer may be off: gusts and sensor noise as the legs themselves show them.

What ground velocity and air data leave over, once airspeed and wind are taken out, is white noise plus the gust
along the flight path, a horizontal first-order Gauss-Markov vector of Dryden's length. Their levels come from all
legs and turns of the log together, by restricted likelihood; each plausible noise is then carried through the
methods' own weights (they are not least squares), and the bound is that of the mixture.

The likelihood takes the gusts of different groups as independent. Then each group's airspeed and wind need only a
4 x 4 matrix of products, and the cost grows with the length of the log and not with its cube. Within a group all
correlations count. Against the likelihood of all legs at once, no 2σ of the five maneuvers and three data systems
moves by more than 0.02 %.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pitotbench.calibrate.gls.linearized_problem import GUST_LENGTH, GUST_LENGTH_FACTOR, GUST_SCALE, WHITE_SCALE
from pitotbench.calibrate.rows.steady_blocks import SECOND
from pitotbench.estimate.markov_noise import Intervals, MarkovNoise, MarkovProcess
from pitotbench.estimate.mixture import half_width
from pitotbench.estimate.restricted_likelihood import weighted_noises
from pitotbench.units import Array, Seconds

_FLOOR = 1e-4  # m/s: keeps the covariance regular for legs without noise
_FORGOTTEN = 1e5  # s, from one group to the next: some thousand correlation times, so nothing is remembered
_TOUCHING = 1.01 * SECOND  # between the middles of two blocks, up to which they share an edge


@dataclass(frozen=True, slots=True)
class LinearizedGroup:
    """A group around its answer: middle of each second [s], residual of ground against air speed [m/s], (n,), unit
    vector of the flight path, (n, 2), what a residual of 1 m/s in each second does to the answer [V, W_N, W_E],
    (n, 3), and the true airspeed [m/s]."""

    time: Seconds
    residual: Array
    along: Array
    gain: Array
    airspeed: float

    def in_order(self) -> "LinearizedGroup":
        """The same group in the order of time."""
        order = np.argsort(self.time)
        return LinearizedGroup(
            self.time[order], self.residual[order], self.along[order], self.gain[order], self.airspeed
        )


def two_sigma(groups: Sequence[LinearizedGroup]) -> list[Array]:
    """2σ of each group's airspeed and wind components [m/s], (3,)."""
    ordered = [group.in_order() for group in groups]
    noises, weights = plausible_noises(ordered)
    means = np.zeros((len(weights), 3))
    return [half_width(weights, means, np.sqrt(answer_variances(group, noises))) for group in ordered]


def plausible_noises(groups: Sequence[LinearizedGroup]) -> tuple[Array, Array]:
    """ln(gust deviation [m/s], gust length [m], white deviation [m/s]) of the noise's posterior, (m, 3), and
    weights, (m,). The groups are in the order of time, each in itself."""
    level = float(np.concatenate([group.residual for group in groups]).std())
    if level < _FLOOR:  # legs from formulas: there is no noise to be found
        return np.log([[_FLOOR, GUST_LENGTH, _FLOOR]]), np.ones(1)
    likelihood = LegLikelihood(groups)

    def log_posterior(noise: Array) -> float:
        try:
            return likelihood.of(noise) + _log_prior(noise)
        except np.linalg.LinAlgError:
            return -np.inf  # the search goes elsewhere

    return weighted_noises(log_posterior, np.log([level, GUST_LENGTH, 0.3 * level]))


def _log_prior(phi: Array) -> float:
    """As the covering method's: half-normal levels, log-normal length, as densities of the logarithms."""
    deviation, white = np.exp(phi[0]), np.exp(phi[2])
    levels = -0.5 * (deviation / GUST_SCALE) ** 2 - 0.5 * (white / WHITE_SCALE) ** 2 + phi[0] + phi[2]
    return float(levels - 0.5 * ((phi[1] - np.log(GUST_LENGTH)) / np.log(GUST_LENGTH_FACTOR)) ** 2)


class LegLikelihood:
    """The restricted likelihood of the noise, given groups that each have their own airspeed and wind.

    Parameters: groups, each in the order of time.
    """

    def __init__(self, groups: Sequence[LinearizedGroup]) -> None:
        lengths = [len(group.time) for group in groups]
        self._first = np.cumsum([0, *lengths[:-1]])
        self._along = np.concatenate([group.along for group in groups])
        self._intervals = _intervals(groups, self._first)
        self._airspeed = np.empty(len(self._intervals.edges))
        for side in (1, 0):  # from an edge on, that of the block which it begins
            self._airspeed[self._intervals.left + side] = np.repeat([group.airspeed for group in groups], lengths)
        residual = np.concatenate([group.residual for group in groups])
        self._data = np.column_stack([np.ones(len(residual)), self._along, residual])

    def of(self, noise: Array) -> float:
        """The restricted log-likelihood (Harville 1974), up to a constant, of ln(gust deviation [m/s], gust length
        [m], white deviation [m/s]).

        Raises numpy.linalg.LinAlgError where the legs do not determine airspeed and wind.
        """
        deviation, length, white = np.exp(noise)
        gust = MarkovProcess(deviation, length / self._airspeed, self._along)
        factored = MarkovNoise(self._intervals, np.full(len(self._data), white**2 + _FLOOR**2), [gust])
        weighed = factored.weigh(self._data)
        products = np.add.reduceat(self._data[:, :, None] * weighed[:, None, :], self._first)
        scale = np.sqrt(np.diagonal(products, axis1=1, axis2=2))
        factors = np.linalg.cholesky(products / scale[:, :, None] / scale[:, None, :])
        # The last row of a factor is the residual explained by airspeed and wind, and what remains of it.
        pivots = np.diagonal(factors, axis1=1, axis2=2) * scale
        log_normal = 2.0 * np.sum(np.log(pivots[:, :-1]))
        return float(-0.5 * (factored.log_determinant + log_normal + np.sum(pivots[:, -1] ** 2)))


def _intervals(groups: Sequence[LinearizedGroup], first: NDArray[np.intp]) -> Intervals:
    """The seconds of all groups, one group after the other, so far apart that no gust is remembered."""
    step = np.diff(np.concatenate([group.time for group in groups]))
    step[first[1:] - 1] = _FORGOTTEN
    time = np.concatenate([[0.0], np.cumsum(np.minimum(step, _FORGOTTEN))])
    left = np.concatenate([[0], np.cumsum(np.where(step < _TOUCHING, 1, 2))])
    edges = np.empty(left[-1] + 2)
    edges[left + 1] = time + 0.5 * SECOND
    edges[left] = time - 0.5 * SECOND
    return Intervals(edges, left)


def answer_variances(group: LinearizedGroup, noises: Array) -> Array:
    """Variances of a group's airspeed and wind components [(m/s)²], (m, 3), of noises (m, 3): white noise plus the
    exact mean of the gust over each second. The group is in the order of time."""
    deviation, length, white = np.exp(noises.T)
    a = SECOND * group.airspeed / length
    same, other = 2.0 * (a - 1.0 + np.exp(-a)) / a**2, 2.0 * (np.cosh(a) - 1.0) / a**2
    seen = group.gain[:, :, None] * group.along[:, None, :]  # (n, 3, 2): what a gust in one second does
    earlier = _remembered(seen, np.exp(-a * np.diff(group.time, prepend=group.time[0])[:, None] / SECOND))
    shared = 2.0 * np.einsum("nkc,nmkc->mk", seen, earlier)
    gust = same[:, None] * np.sum(seen**2, axis=(0, 2)) + other[:, None] * shared
    return np.asarray(deviation[:, None] ** 2 * gust + white[:, None] ** 2 * np.sum(group.gain**2, axis=0))


def _remembered(seen: Array, decay: Array) -> Array:
    """The sum over all earlier seconds, each as far as it is correlated with this one, (n, m, 3, 2).

    `decay`, (n, m), is from one second to the next. One pass: an exponential memory needs the last sum only.
    """
    sums = np.zeros((*decay.shape, *seen.shape[1:]))
    for second in range(1, len(seen)):
        sums[second] = decay[second, :, None, None] * (sums[second - 1] + seen[second - 1])
    return sums
