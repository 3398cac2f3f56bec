"""Logs that hold one flight or several: one curve for all flights, and a separate wind for each."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from functools import reduce
from operator import add
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from pitotbench import air
from pitotbench.calibration.fit_checks import require_useful
from pitotbench.calibration.flown_tracks import one_sided
from pitotbench.calibration.nuisances import ZERO
from pitotbench.calibration.observations import observe
from pitotbench.calibration.options import Accuracies, CalibrationOptions
from pitotbench.calibration.prediction import curve_airspeeds
from pitotbench.calibration.reduction import CurveScale, Reduction, reduce_log, scale_of
from pitotbench.calibration.result import assemble
from pitotbench.estimation.information import Information, information_from
from pitotbench.estimation.mixture import Posterior
from pitotbench.logbook.flight_parts import flights_between_stops, flights_in
from pitotbench.logbook.identity import require_one_airplane
from pitotbench.logbook.same_flight import overlap, recorders
from pitotbench.normal_equations import ROUNDING, inverse
from pitotbench.records import BadInputError, NoAnswerError
from pitotbench.records.calibration import (
    CalibratedFlight,
    Calibration,
    Estimate,
    Residuals,
    WindEstimate,
)
from pitotbench.records.log import Caution, FlightLog
from pitotbench.units import KNOT, Array, MetersPerSecond

DISAGREE = "flights disagree"  # code of the warning that their curves differ
_DISAGREE = 0.01  # probability of so much disagreement by chance: below it there is a warning


def join(single: Sequence[Reduction]) -> list[tuple[Reduction, MetersPerSecond]]:
    """Give reductions with one reference pressure the joint answer, and airspeeds common to all.

    The airspeeds are indicated [m/s]. The logs are of one airplane. Each log is reduced separately.
    Its answer, as a Gaussian, is information about the curve, the wind of that log and the
    nuisances. The unknowns of the airplane (curve, errors of its sensors) are common to all logs;
    those of the day are separate. A common prior counts once. The sum of the information is the
    joint fit of the linearized problems.
    """
    indicated = [air.calibrated_airspeed(each.observations.impact_pressure) for each in single]
    airspeeds = curve_airspeeds(np.concatenate(indicated))
    warning = _disagreement(single)
    joint = _joined(single)
    return [
        (replace(each, answer=answer, warnings=each.warnings + warning), airspeeds)
        for each, answer in zip(single, joint, strict=True)
    ]


def _joined(single: Sequence[Reduction]) -> list[Posterior]:
    """The joint answer, once per log, in the unknowns of that log."""
    shared: dict[str, int] = {}
    known = [_information(each, number, shared) for number, each in enumerate(single)]
    size = len(shared)
    whole = reduce(add, (information.placed(place, size) for information, place in known))
    priors = _common_priors(single)
    with np.errstate(divide="ignore"):
        deviations = np.array([priors.get(name, 0.0) for name in shared]) ** -0.5
    found = whole.posterior(range(size), deviations, ROUNDING)
    return [
        Posterior(np.ones(1), found.mean[place][None], found.covariance[np.ix_(place, place)][None])
        for _, place in known
    ]


def _information(
    each: Reduction, number: int, shared: dict[str, int]
) -> tuple[Information, NDArray[np.intp]]:
    """The information of one log without the common priors, and the place of each unknown.

    The place is that among the unknowns of all logs. `shared` maps names to these; new unknowns of
    the log are added to it.
    """
    precision = inverse(each.answer.covariance)
    pull = precision @ each.answer.mean
    commons = _common_priors([each])
    names = _names(each, number)
    for place, name in enumerate(names):
        precision[place, place] -= commons.get(name, 0.0)
        shared.setdefault(name, len(shared))
    places = np.array([shared[name] for name in names])
    return information_from(_not_negative(precision), pull), places


def _names(each: Reduction, number: int) -> list[str]:
    """Names of the elements of θ. A name with the log's number belongs to this log alone."""
    winds = [f"wind {axis} {number}" for axis in range(each.model.count - each.model.error_count)]
    others = [n.name if _is_common(each, n.name) else f"{n.name} {number}" for n in each.nuisances]
    return [*each.model.error.parameter_names, *winds, *others]


def _is_common(each: Reduction, name: str) -> bool:
    """Whether a nuisance is common to all logs.

    The temperature of a standard day, a zero that the log shows at rest and a changing wind are
    not.
    """
    if name == "temperature_k" and each.observations.standard_day:
        return False
    if name == ZERO and each.observations.rests:
        return False
    return any(name == f.name or name.startswith("velocity_") for f in fields(Accuracies))


def _common_priors(single: Sequence[Reduction]) -> dict[str, float]:
    """Prior precision of every common unknown: the parameters of the curve, and the nuisances."""
    with np.errstate(divide="ignore"):
        laws = 1.0 / np.mean([_law_variance(each) for each in single], axis=0)
    curve = dict(zip(single[0].model.error.parameter_names, map(float, laws), strict=True))
    return curve | {
        n.name: 1.0 / n.deviation**2
        for each in single
        for n in each.nuisances
        if _is_common(each, n.name)
    }


def _law_variance(each: Reduction) -> Array:
    """Return the variance of the prior of the curve's parameters over its rivals, (K,).

    The rivals are weighted by the log; a flat one is infinite.
    """
    with np.errstate(divide="ignore"):
        variances = 1.0 / each.model.error.precisions
    if each.fit is None:
        return np.full(variances.shape[1], np.inf)
    weights = np.array([node.weight for node in each.fit.nodes])
    return np.asarray(weights @ variances[[node.rival for node in each.fit.nodes]])


def _disagreement(single: Sequence[Reduction]) -> tuple[Caution, ...]:
    """A warning where the logs' curves differ by more than their bounds allow."""
    free = single[0].model.error_count
    means = np.stack([each.answer.mean[:free] for each in single])
    weights = np.stack([inverse(each.answer.covariance[:free, :free]) for each in single])
    common = np.linalg.solve(weights.sum(axis=0), np.einsum("lij,lj->i", weights, means))
    offset = means - common
    statistic = float(np.einsum("li,lij,lj->", offset, weights, offset))
    statistic = max(statistic, 0.0)  # rounding may bring that of equal curves below zero
    chance = float(chdtrc(free * (len(single) - 1), statistic)) if len(single) > 1 else 1.0
    if chance >= _DISAGREE:
        return ()
    text = (
        f"the flights disagree about the curve (by chance in {100.0 * chance:.2g} % of cases): "
        "compare them singly"
    )
    return (Caution(text, DISAGREE, size=chance),)


def _not_negative(matrix: Array) -> Array:
    """A symmetric matrix without its negative eigenvalues, in units of its diagonal.

    A mixture is wider than each of its parts: of what a log hardly tells, less is left of its
    answer than the prior holds.
    """
    scale = np.sqrt(np.maximum(np.abs(np.diag(matrix)), np.finfo(np.float64).tiny))
    values, vectors = np.linalg.eigh(matrix / np.outer(scale, scale))
    kept = (vectors * np.maximum(values, 0.0)) @ vectors.T
    return np.asarray(kept * np.outer(scale, scale))


T = TypeVar("T")
_FEWEST = 2  # flights of one log


@dataclass(frozen=True, slots=True)
class _Part(Generic[T]):
    """A flight cut from a log, with what came of it."""

    log: FlightLog
    found: T
    place: int
    number: int
    count: int
    left_out: tuple[int, ...] = ()


# The reduced flights of a log by its identity and the scale of the curve: what is fitted once.
Known = dict[tuple[int, CurveScale], list[_Part[tuple[Reduction, Calibration]]]]


def reduce_flights(
    logs: Sequence[FlightLog], options: CalibrationOptions, known: Known | None = None
) -> list[CalibratedFlight]:
    """Calibrate every flight of the logs, with one curve for all and a separate wind for each.

    A log is cut where its recording pauses for more than five minutes. A flight that determines no
    answer by itself, such as a taxi or a leg on one heading, is left out where two others remain;
    else the log is reduced as one flight. Where two recorders wrote one flight, each log has a
    curve of its own, and they share the wind.

    What `known` holds of a log with these options is not fitted again, and what is fitted is put
    there. Raises as `reduce_log` does.
    """
    require_one_airplane(logs)
    fitted: Known = {} if known is None else known
    places = range(len(logs))
    several = [[place] for place in places] if recorders(logs) else [list(places)]
    curves = [_of_one_curve(logs, own, options, fitted) for own in several]
    parts = [part for own in curves for part, *_ in own]
    if len(parts) == 1:
        return [_flight(parts[0], parts[0].found[1], 1)]
    winds = iter(_with_winds_of_flights(parts, [r for own in curves for _, r, _ in own]))
    found = []
    for own in curves:
        joint = assemble_together([(next(winds), airspeeds) for *_, airspeeds in own])
        found += [
            replace(_flight(part, calibration, len(own)), leader=own[0][0].place)
            for (part, *_), calibration in zip(own, joint, strict=True)
        ]
    return found


def _of_one_curve(
    logs: Sequence[FlightLog], places: Sequence[int], options: CalibrationOptions, known: "Known"
) -> list[tuple[_Part[tuple[Reduction, Calibration]], Reduction, MetersPerSecond | None]]:
    """Return the flights at some places with their joint answer, and airspeeds common to all.

    The airspeeds are indicated [m/s], None for those of a single flight.
    """
    rows = {id(logs[place]): observe(logs[place], options) for place in places}
    scale = scale_of([*rows.values()])

    def reduced(log: FlightLog) -> tuple[Reduction, Calibration]:
        reduction = reduce_log(log, options, scale, rows.pop(id(log), None))
        alone = assemble(reduction)
        require_useful(alone, log)
        return reduction, alone

    parts = list[_Part[tuple[Reduction, Calibration]]]()
    for place in places:
        key = id(logs[place]), scale
        if key not in known:
            known[key] = _parts(logs[place], 0, reduced)
        parts += [replace(part, place=place) for part in known[key]]
    if len(parts) == 1:
        return [(parts[0], parts[0].found[0], None)]
    joint = join([part.found[0] for part in parts])
    return [(part, *answer) for part, answer in zip(parts, joint, strict=True)]


_ONE_SPAN = 0.9  # of two recordings in common, from which on both met the same mean wind


def _with_winds_of_flights(
    parts: Sequence[_Part[Any]], single: Sequence[Reduction]
) -> list[Reduction]:
    """Give each recorder of a flight the mean wind of the one that knows it best.

    Two recorders meet the same gusts, so that their errors are not independent: the better wind
    stands for both, and their mean would pretend to more. The better answer stays as it is.
    """
    spans = [float(part.log.time[-1] - part.log.time[0]) for part in parts]
    others: list[list[int]] = [[n] for n in range(len(parts))]
    for i, j in recorders([part.log for part in parts]):
        if overlap(parts[i].log, parts[j].log) > _ONE_SPAN * max(spans[i], spans[j]):
            others[i].append(j)
            others[j].append(i)
    known = [_wind_of(each) for each in single]
    best = [min(own, key=lambda n: float(np.trace(known[n][1]))) for own in others]
    return [
        each if own == n else _with_wind(each, *known[own])
        for n, (each, own) in enumerate(zip(single, best, strict=True))
    ]


def _wind_of(each: Reduction) -> tuple[Array, Array]:
    """The mean wind of a reduction, (2,), and its covariance, (2, 2)."""
    first = each.model.error_count
    axes = slice(first, first + 2)
    return each.answer.mean[axes], each.answer.covariance[axes, axes]


def _with_wind(each: Reduction, wind: Array, covariance: Array) -> Reduction:
    """Return the reduction with another mean wind, and what follows for all other unknowns.

    Where its own wind contradicts that one, it keeps its own and gets a warning.
    """
    own, spread = _wind_of(each)
    offset = wind - own
    chance = float(chdtrc(2, offset @ inverse(spread + covariance) @ offset))
    if chance < _DISAGREE:
        text = (
            f"the recorders disagree about the wind by {np.hypot(*offset) / KNOT:.1f} kt: each "
            "keeps its own; compare their velocities and airspeeds"
        )
        return replace(
            each, warnings=(*each.warnings, Caution(text, "recorders disagree", size=chance))
        )
    answer, axes = each.answer, slice(each.model.error_count, each.model.error_count + 2)
    gains = answer.covariances[:, :, axes] @ np.linalg.inv(answer.covariances[:, axes, axes])
    means = answer.means + np.einsum("mpa,ma->mp", gains, wind - answer.means[:, axes])
    change = covariance - answer.covariances[:, axes, axes]
    known = answer.covariances + gains @ change @ np.swapaxes(gains, 1, 2)
    return replace(each, answer=Posterior(answer.weights, means, known))


def assemble_together(
    joint: Sequence[tuple[Reduction, MetersPerSecond | None]],
) -> list[Calibration]:
    """Assemble the Calibration of each reduction with the joint answer, all with one band.

    The band holds for the whole curve.
    """
    found = [assemble(reduction, airspeeds) for reduction, airspeeds in joint]
    # The band comes from random draws of all unknowns, of which each flight has its own.
    band = found[0].curve.simultaneous_two_sigma
    return [replace(each, curve=replace(each.curve, simultaneous_two_sigma=band)) for each in found]


def of_one_log(log: FlightLog, cut: Sequence[CalibratedFlight]) -> Calibration:
    """Return the flights of one log, which share their curve, as one calibration of the log.

    The winds, the parts and the residuals are those of all flights, the wind the mean of theirs.
    """
    flights = [each.calibration for each in cut]
    first = flights[0]
    if len(flights) == 1:
        return first
    found = [each.known_wind for each in flights]

    def mean(axis: str) -> Estimate:
        parts: list[Estimate] = [getattr(wind, axis) for wind in found]
        bound = float(np.linalg.norm([part.two_sigma for part in parts])) / len(parts)
        return Estimate(axis, float(np.mean([part.value for part in parts])), bound)

    def every(name: str) -> tuple[Any, ...]:
        return tuple({item: 0 for each in flights for item in getattr(each, name)})

    time, indicated, airspeed = (
        np.concatenate([getattr(each.residuals, name) for each in flights])
        for name in ("time", "indicated_airspeed", "airspeed")
    )
    joined = ("warnings", "winds", "parts", "left_out", "disagreements", "points")
    lists: dict[str, Any] = {name: every(name) for name in joined}
    whole = replace(
        first,
        wind=WindEstimate(mean("north"), mean("east")),
        residual_two_sigma=2.0 * float(np.std(airspeed)),
        residuals=Residuals(time, indicated, airspeed, np.isin(log.time, time)),
        samples=sum(each.samples for each in flights),
        converged=all(each.converged for each in flights),
        mach=max(each.mach for each in flights),
        **lists,
    )
    # An airspeed that one flight flew to one side only may have been flown to all in another.
    doubted = any(each.one_sided for each in flights)
    return replace(whole, one_sided=one_sided(log, whole) if doubted else ())


def _parts(log: FlightLog, place: int, reduce: Callable[[FlightLog], T]) -> list[_Part[T]]:
    """Cut a log into its flights and reduce each; one part where fewer than two give an answer.

    That part is the whole log. Where the whole gives no answer, as of two winds, the log is cut at
    shorter pauses and at stops.
    """
    found = _answered(flights_in(log), place, reduce)
    if len(found) >= _FEWEST:
        return found
    try:
        return [_Part(log, reduce(log), place, 1, 1)]
    except NoAnswerError:
        found = _answered(flights_between_stops(log), place, reduce)
        if len(found) < _FEWEST:
            raise
        return found


def _answered(
    flights: Sequence[FlightLog], place: int, reduce: Callable[[FlightLog], T]
) -> list[_Part[T]]:
    """The flights of a log that have an answer; none of a log that is not cut."""
    found: list[_Part[T]] = []
    missing: list[int] = []
    for number, flight in enumerate(flights if len(flights) > 1 else [], start=1):
        try:
            found.append(_Part(flight, reduce(flight), place, number, len(flights)))
        except (NoAnswerError, BadInputError):
            missing.append(number)
    return [replace(part, left_out=tuple(missing)) for part in found]


def _flight(part: _Part[T], calibration: Calibration, joined: int) -> CalibratedFlight:
    """The flight of a part, with the warnings that the cutting of its log makes."""
    warnings = list(calibration.warnings)
    if part.left_out:
        names = ", ".join(str(number) for number in part.left_out)
        text = f"flight {names} of this log determines no answer by itself and is left out"
        warnings.append(Caution(text, "flight left out"))
    calibration = replace(calibration, warnings=tuple(warnings))
    return CalibratedFlight(part.log, calibration, part.place, part.number, part.count, joined)
