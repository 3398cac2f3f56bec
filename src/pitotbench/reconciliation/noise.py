"""The noise of the residual channels: autoregressions, and the innovations' correlation.

The order of the autoregression is high enough for gusts, for vibration of the control loops and for
differenced GPS noise, so that no spectrum has to be assumed. Gusts and noisy sensors show in
several channels at once; the correlation between channels counts them once. The noise is learned on
null flights, or from the log itself where there are none (Lütkepohl, New Introduction to Multiple
Time Series Analysis, 2005, ch. 3; here each channel is predicted from its past alone).
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import toeplitz

from pitotbench.estimation.noise import yule_walker
from pitotbench.reconciliation.track import Grid
from pitotbench.units import Array

ORDER = 12  # instants, so 6 s at two instants a second
INDEPENDENT = 0.02  # share of each channel's innovations taken as independent, so that no combination has no noise
SMALLEST = 1e-30  # sum of squares of a channel that does not change
UNUSABLE = 1e6  # slack of instants that are not used, in the unit of any channel
BLOCK = 32_768  # values: a quarter of a megabyte
UNCHANGED = 1e-6  # share of a deviation that slack may add before the correlation is computed anew


@dataclass(frozen=True, slots=True)
class NoiseModel:
    """The noise of the residual channels.

    `coefficients` predict each channel from its past, (c, p). `deviations` are the standard
    deviations of the innovations, (c,), and `correlation` is their correlation between channels,
    (c, c).
    """

    names: tuple[str, ...]
    coefficients: Array
    deviations: Array
    correlation: Array

    def innovations(self, values: Array, grid: Grid, slack: Array) -> Array:
        """Return the innovations of each channel over their deviations, (n, c) or (n, c, k).

        `slack` (n, c) adds to the deviations. Rows whose past is not complete, or holds an unused
        instant, are zero.
        """
        scale = self._scale(grid, slack)
        return self._unpredicted(values) * (scale if values.ndim == 2 else scale[:, :, None])

    def _unpredicted(self, values: Array) -> Array:
        """Return values less what their past predicts.

        Block by block, so that a block stays near the processor.
        """
        flat = values.reshape(len(values), -1)
        weights = np.repeat(self.coefficients, flat.shape[1] // len(self.coefficients), axis=0).T
        out, rows = flat.copy(), max(1, BLOCK // max(1, flat.shape[1]))
        for begin in range(0, len(flat), rows):
            end = min(begin + rows, len(flat))
            for lag, weight in enumerate(weights, start=1):
                first = max(begin, lag)
                if first < end:
                    out[first:end] -= flat[first - lag : end - lag] * weight
        return out.reshape(values.shape)

    def _scale(self, grid: Grid, slack: Array) -> Array:
        """What turns an innovation into deviations, (n, c); 0 where the past is not complete."""
        complete = complete_past(grid, slack, self.coefficients.shape[1])
        return np.where(complete[:, None], 1.0 / np.hypot(self.deviations, slack), 0.0)

    def decorrelation(self, slack: Array) -> Array:
        """Return the matrices that make the innovations of an instant uncorrelated, (n, c, c).

        The slack of a channel is independent of the other channels.
        """
        share = self.deviations / np.hypot(self.deviations, slack)
        no_slack = np.all(share > 1.0 - UNCHANGED, axis=1)
        out = np.empty((*share.shape, share.shape[1]))
        out[no_slack] = np.linalg.inv(np.linalg.cholesky(self.correlation))
        s = share[~no_slack]
        if len(s):
            joint = self.correlation * s[:, :, None] * s[:, None, :]
            diagonal = np.arange(len(self.names))
            joint[:, diagonal, diagonal] = 1.0
            out[~no_slack] = np.linalg.inv(np.linalg.cholesky(joint))
        return out

    def given_others(self, innovations: Array) -> Array:
        """Return each innovation less its prediction from the other channels then, (n, c) [σ]."""
        precision = np.linalg.inv(self.correlation)
        return np.asarray(innovations @ precision / np.sqrt(np.diag(precision)))

    def apart(self, names: Iterable[str]) -> "NoiseModel":
        """Return the noise with some channels uncorrelated with all others."""
        own = np.isin(self.names, [*names])
        return replace(self, correlation=np.where(own[:, None] == own, self.correlation, 0.0))

    def whitener(self, grid: Grid, slack: Array) -> Callable[[Array], Array]:
        """Return `whiten` for one grid and slack, so that many values share the decorrelation."""
        weights = self.decorrelation(slack) * self._scale(grid, slack)[:, None, :]

        def whiten(values: Array) -> Array:
            unpredicted = self._unpredicted(values)
            if values.ndim == 2:
                return np.asarray(weights @ unpredicted[:, :, None])[:, :, 0]
            return np.asarray(weights @ unpredicted)

        return whiten

    def whiten(self, values: Array, grid: Grid, slack: Array) -> Array:
        """Return uncorrelated innovations with deviation 1, for values (n, c) or (n, c, k)."""
        return self.whitener(grid, slack)(values)

    def whiten_alone(self, shapes: Array, grid: Grid, slack: Array) -> Array:
        """Return shapes (n, s), each in one channel only, whitened, (n, c, c·s).

        The last axis has the shapes of one channel after another.
        """
        (n, s), c = shapes.shape, len(self.names)
        innovations = self.innovations(np.broadcast_to(shapes[:, None, :], (n, c, s)), grid, slack)
        # Each shape is in one channel only, so that its decorrelation is an outer product.
        return np.asarray(self.decorrelation(slack)[:, :, :, None] * innovations[:, None]).reshape(
            n, c, c * s
        )


def complete_past(grid: Grid, slack: Array, order: int) -> NDArray[np.bool_]:
    """Return the instants with `order` + 1 used instants of their stretch before them.

    One more than the order, because differences are 0 at the first instant of a stretch. An instant
    at the end of a sensor's range holds no measurement, and none is predicted from it.
    """
    unused = np.all(slack >= UNUSABLE, axis=1)
    complete: NDArray[np.bool_] = _since_start(grid, unused) > order
    return complete


def autocovariance(values: Array, grid: Grid, order: int = ORDER) -> Array:
    """Return the means of lagged products of residuals (n, c) at lags 0 to p, (c, p + 1).

    No product goes over a gap. A residual of exactly zero is that of an instant that is not used,
    and does not count. The mean at a lag is tapered by the share of the instants that have a
    partner in a log without gaps, so that no noise has a negative power (Brockwell and Davis 1991,
    §7.2): a short log would get innovations of nearly zero. Where gaps still make one, the sums are
    divided by the number of instants.
    """
    used, since = values != 0.0, _since_start(grid)
    instants = np.maximum(1, np.count_nonzero(values[since >= 1], axis=0))
    tapered, divided = np.empty((2, values.shape[1], order + 1))
    for lag in range(order + 1):
        inside = since >= lag + 1
        pairs = np.count_nonzero((used & np.roll(used, lag, axis=0))[inside], axis=0)
        sums = np.sum((values * np.roll(values, lag, axis=0))[inside], axis=0)
        tapered[:, lag] = sums / np.maximum(1, pairs) * np.maximum(0.0, 1.0 - lag / instants)
        divided[:, lag] = sums / instants
    positive = [np.linalg.eigvalsh(toeplitz(row))[0] > 0.0 for row in tapered]
    return np.where(np.array(positive)[:, None], tapered, divided)


def learned(names: tuple[str, ...], logs: Iterable[tuple[Array, Grid, Array]]) -> NoiseModel:
    """Return the noise model of some logs, each given by residuals, grid and slack.

    The residuals are without free parameters (n, c), as is the slack (n, c).
    """
    logs = list(logs)
    uncorrelated = _autoregressions(
        names, np.mean([autocovariance(values, grid) for values, grid, _ in logs], axis=0)
    )
    innovations = [uncorrelated.innovations(values, grid, slack) for values, grid, slack in logs]
    products = sum((each.T @ each for each in innovations), np.zeros((len(names), len(names))))
    root = np.sqrt(np.maximum(np.diag(products), SMALLEST))
    correlation = products / np.outer(root, root)
    return replace(
        uncorrelated,
        correlation=(1.0 - INDEPENDENT) * correlation + INDEPENDENT * np.eye(len(names)),
    )


def _since_start(grid: Grid, unused: NDArray[np.bool_] | bool = False) -> NDArray[np.intp]:
    """Number of instants since the start of the stretch, or since the last unused instant, (n,)."""
    place = np.arange(len(grid))
    return np.asarray(place - np.maximum.accumulate(np.where(grid.first | unused, place, 0)))


def _autoregressions(names: tuple[str, ...], covariance: Array) -> NoiseModel:
    """The noise model of autocovariances, (c, p + 1), each channel alone."""
    predictors = [yule_walker(row) for row in covariance]
    coefficients = np.array([weights for weights, _ in predictors])
    return NoiseModel(
        names,
        coefficients,
        np.array([deviation for _, deviation in predictors]),
        np.eye(len(names)),
    )
