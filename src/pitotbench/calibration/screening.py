"""Faulty rows: spikes, dropouts, stuck samples and typing errors are found, left out and listed.

A Student-t residual of four degrees of freedom (Lange, Little and Taylor 1989) gives a row at z
standard deviations the weight 5/(4 + z²). Rows with a weight below a tenth (|z| > 6.8) are left
out. All others have full weight, because block means are nearly Gaussian and the bound needs a
Gaussian likelihood. There are two kinds of z: of a row against its two neighbors (spikes), and of
the median of a second against all others (longer faults). A burst of gusts makes all seconds around
scatter more, and a fault does not: a longer fault has to stand out of that.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from pitotbench import air
from pitotbench.calibration.observations import Observations, divide
from pitotbench.calibration.output_error import airspeed_outputs, fit_output_error
from pitotbench.calibration.prediction import PredictionModel
from pitotbench.records import BadInputError, NoAnswerError
from pitotbench.scatter import NORMAL, deviation_of_sizes, spikes_among
from pitotbench.units import Array, Booleans, percent_text

_FREEDOM = 4.0  # degrees of freedom of the Student's t that weighs the residuals
_LEAST_WEIGHT = 0.1
_FARTHEST = float(np.sqrt((_FREEDOM + 1.0) / _LEAST_WEIGHT - _FREEDOM))  # standard deviations, 6.8
SECOND = 1.0  # s, of a mean: short against a gust, long against the sampling
_AROUND = 31  # s: the median over so many around a fault is the usual residual
_BURST = 11  # s: the median change from second to second over so many is the scatter around a row
_ROUGHEST = 3.0  # times the usual scatter: no burst of gusts is much rougher, a channel gone mad is
_LEAST_SHARE = 0.03  # of the airspeed, the least size of a longer fault
_LEAST_SPIKE = 0.05  # m/s: a smaller error does no harm
_NOWHERE = 1e3  # m/s, residual of a row that the model cannot predict
_ROUNDS = 8  # of fitting and marking, at most
_MOST = 0.3  # share of rows: with more, the faults cannot be separated from good rows


@dataclass(frozen=True, slots=True)
class Screened:
    """The good observations, and the numbers of the log's rows that were left out, (k,)."""

    observations: Observations
    left_out: NDArray[np.intp]


def screen(model: PredictionModel, obs: Observations, theta: Array | None) -> Screened:
    """Leave out faulty rows.

    Parameters: model; obs; theta (p,), a fit to all rows, or None where there is none.
    Raises BadInputError where more than 30 % of the rows are faulty.
    """
    if theta is not None and not _suspicious(model, obs, theta):
        return Screened(obs, np.zeros(0, dtype=np.intp))
    rows = np.flatnonzero(obs.used)
    good = np.ones(len(obs), dtype=np.bool_)
    for _ in range(_ROUNDS):
        residual = _residual(model, obs, _median_fit(model, obs, good))
        again = ~(_spikes(residual) | _long_faults(residual, obs, good))
        if np.array_equal(again, good):
            break
        good = again
    if good.mean() < 1.0 - _MOST:
        raise BadInputError(
            f"{percent_text(1.0 - good.mean())} of the rows disagree with the rest: a channel "
            "may be stuck, "
            "mislabeled or in another unit; look at the columns, or leave the bad part out"
        )
    return Screened(obs.select(good), rows[~good])


def _suspicious(model: PredictionModel, obs: Observations, theta: Array) -> bool:
    residual = _residual(model, obs, theta)
    every = np.ones(len(obs), dtype=np.bool_)
    return bool(np.any(_spikes(residual)) or np.any(_long_faults(residual, obs, every, means=True)))


def _residual(model: PredictionModel, obs: Observations, theta: Array) -> Array:
    """Return measured minus predicted indicated airspeed [m/s], 1000 without a prediction."""
    with np.errstate(invalid="ignore"):
        predicted = air.calibrated_airspeed(model.predict(theta, obs).indicated)
    return np.nan_to_num(air.calibrated_airspeed(obs.impact_pressure) - predicted, nan=_NOWHERE)


def _median_fit(model: PredictionModel, obs: Observations, good: Booleans) -> Array:
    """Fit output error to the row of each good second with the median residual.

    Spikes have no effect on it.
    """
    kept = obs.select(good)
    theta = np.zeros(model.count)
    for _ in range(2):
        middle = kept.at(_middle_rows(_residual(model, kept, theta), divide(kept, SECOND).index))
        try:
            theta = fit_output_error(airspeed_outputs(model, middle), theta).theta
        except NoAnswerError:
            return theta
    return theta


def _middle_rows(residual: Array, block: NDArray[np.intp]) -> NDArray[np.intp]:
    """The row with the median residual of each block; the rows of a block follow one another."""
    starts = np.flatnonzero(np.diff(block, prepend=-1))
    counts = np.diff(starts, append=len(block))
    middle = np.empty(len(starts), dtype=np.intp)
    for count in np.unique(counts):  # blocks of equal length are sorted together
        same = np.flatnonzero(counts == count)
        order = np.argsort(
            residual[starts[same][:, None] + np.arange(count)], axis=1, kind="stable"
        )
        middle[same] = starts[same] + order[:, count // 2]
    return middle


def _spikes(residual: Array) -> Booleans:
    """Rows that differ from both neighbors."""
    second = np.abs(residual[1:-1] - 0.5 * (residual[:-2] + residual[2:]))
    return spikes_among(second, max(_FARTHEST * deviation_of_sizes(second), _LEAST_SPIKE))


def _long_faults(
    residual: Array, obs: Observations, good: Booleans, means: bool = False
) -> Booleans:
    """Rows far from the good ones, and all rows of a second that is far from them.

    A second is judged by the median (or mean) of its residuals. Rows must also be far from the
    usual residual around them. A model that cannot follow the curve gives residuals that change
    slowly; a fault is sudden. Where the seconds around scatter more than usual, far is farther.
    """
    blocks = divide(obs, SECOND)
    level = blocks.mean(residual) if means else residual[_middle_rows(residual, blocks.index)]
    usual = median_filter(level, _AROUND, mode="nearest")[blocks.index]
    sudden = _LEAST_SHARE * air.calibrated_airspeed(obs.impact_pressure)
    rough = _roughness(level, blocks.mean(good.astype(np.float64)) == 1.0)
    rows = _far(residual, residual[good], rough[blocks.index]) & (np.abs(residual - usual) > sudden)
    seconds = _far(level, level[np.unique(blocks.index[good])], rough)[blocks.index]
    return rows | (seconds & (np.abs(level[blocks.index] - usual) > sudden))


def _roughness(level: Array, healthy: Booleans) -> Array:
    """How many times the usual the healthy seconds around each scatter, at least 1, (seconds,).

    The median of the changes from second to second does not see a fault of one or two.
    """
    kept = np.flatnonzero(healthy)
    changes = np.abs(np.diff(level[kept]))
    usual = float(np.median(changes)) if len(changes) else 0.0
    if usual == 0.0:
        return np.ones(len(level))
    around = np.clip(median_filter(changes, _BURST, mode="nearest") / usual, 1.0, _ROUGHEST)
    return np.asarray(
        around[np.clip(np.searchsorted(kept, np.arange(len(level))), 0, len(around) - 1)]
    )


def _far(values: Array, healthy: Array, rough: Array) -> Booleans:
    center = float(np.median(healthy))
    scale = NORMAL * float(np.median(np.abs(healthy - center)))
    return np.asarray(np.abs(values - center) > np.maximum(_FARTHEST * scale * rough, _LEAST_SPIKE))
