"""Several logs of one airplane: a curve in common, each log its own wind.

Each log is reduced for itself; its answer, as a Gaussian, is information about the curve, its own wind and the
nuisances. What belongs to the airplane (curve, stated accuracies of its sensors) is common, what belongs to the day
is each log's own, and a prior counts once. Adding information is what a joint fit of linear problems does.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from pitotbench import air
from pitotbench.calibrate.accuracy import Accuracies
from pitotbench.calibrate.gls.posterior import Posterior
from pitotbench.calibrate.model.curve_map import curve_airspeeds
from pitotbench.calibrate.options import CalibrationOptions
from pitotbench.calibrate.reduction import Reduction, reduce_log, reference_of
from pitotbench.calibrate.rows.observations import observe
from pitotbench.records.log import FlightLog
from pitotbench.units import Array, MetersPerSecond

_DISAGREE = 0.01  # probability of so much disagreement by chance, below which it is said


@dataclass(frozen=True, slots=True)
class _Information:
    """What a log knows: precision (p, p) and precision times estimate (p,) without common priors, and the place
    of each of its unknowns among those of all logs, (p,)."""

    precision: Array
    pull: Array
    place: NDArray[np.intp]


def reduce_together(
    logs: Sequence[FlightLog], options: CalibrationOptions
) -> list[tuple[Reduction, MetersPerSecond]]:
    """Each log's reduction with the answer of all, and the indicated airspeeds [m/s] that they cover together."""
    reference = reference_of([observe(log, options) for log in logs])
    single = [reduce_log(log, options, reference) for log in logs]
    indicated = [air.calibrated_airspeed(each.observations.impact_pressure) for each in single]
    airspeeds = curve_airspeeds(np.concatenate(indicated))
    warning = _disagreement(single)
    joint = _joined(single)
    return [
        (replace(each, answer=answer, warnings=each.warnings + warning), airspeeds)
        for each, answer in zip(single, joint, strict=True)
    ]


def _joined(single: Sequence[Reduction]) -> list[Posterior]:
    """The answer of all logs, as seen by each."""
    shared: dict[str, int] = {}
    known = [_information(each, number, shared) for number, each in enumerate(single)]
    size = len(shared)
    precision, pull = np.zeros((size, size)), np.zeros(size)
    for part in known:
        precision[np.ix_(part.place, part.place)] += part.precision
        pull[part.place] += part.pull
    for name, prior in _common_priors(single).items():
        precision[shared[name], shared[name]] += prior
    covariance = _inverse(precision)
    mean = covariance @ pull
    return [
        Posterior(np.ones(1), mean[part.place][None], covariance[np.ix_(part.place, part.place)][None])
        for part in known
    ]


def _information(each: Reduction, number: int, shared: dict[str, int]) -> _Information:
    """What one log knows; `shared` maps names to places and grows by the log's own unknowns."""
    precision = _inverse(each.answer.covariance)
    pull = precision @ each.answer.mean
    commons = _common_priors([each])
    names = _names(each, number)
    for place, name in enumerate(names):
        precision[place, place] -= commons.get(name, 0.0)
        shared.setdefault(name, len(shared))
    return _Information(precision, pull, np.array([shared[name] for name in names]))


def _names(each: Reduction, number: int) -> list[str]:
    """Names of θ: those with the log's number are its own."""
    winds = [f"wind {axis} {number}" for axis in range(each.model.count - each.model.error_count)]
    beside = [n.name if _is_common(each, n.name) else f"{n.name} {number}" for n in each.nuisances]
    return [*each.model.error.parameter_names, *winds, *beside]


def _is_common(each: Reduction, name: str) -> bool:
    """Whether a nuisance belongs to the airplane: a standard day's temperature and a changing wind do not."""
    if name == "temperature_k" and each.observations.standard_day:
        return False
    return any(name == f.name or name.startswith("velocity_") for f in fields(Accuracies))


def _common_priors(single: Sequence[Reduction]) -> dict[str, float]:
    """Prior precision of every common nuisance."""
    return {n.name: 1.0 / n.deviation**2 for each in single for n in each.nuisances if _is_common(each, n.name)}


def _disagreement(single: Sequence[Reduction]) -> tuple[str, ...]:
    """A warning where the logs' curves differ by more than their bounds allow."""
    free = single[0].model.error_count
    means = np.stack([each.answer.mean[:free] for each in single])
    weights = np.stack([_inverse(each.answer.covariance[:free, :free]) for each in single])
    common = np.linalg.solve(weights.sum(axis=0), np.einsum("lij,lj->i", weights, means))
    offset = means - common
    statistic = float(np.einsum("li,lij,lj->", offset, weights, offset))
    statistic = max(statistic, 0.0)  # rounding may bring that of equal curves below zero
    chance = float(chdtrc(free * (len(single) - 1), statistic)) if len(single) > 1 else 1.0
    if chance >= _DISAGREE:
        return ()
    return (
        f"the logs disagree about the curve (by chance in {100.0 * chance:.2g} % of cases): compare them singly",
    )


def _inverse(matrix: Array) -> Array:
    """Inverse of a symmetric matrix of unlike units."""
    scale = np.sqrt(np.abs(np.diag(matrix)))
    return np.asarray(np.linalg.inv(matrix / np.outer(scale, scale)) / np.outer(scale, scale))
