"""The reduction of one log: choice of rows, white fit, screening of faults, noise and answer."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pitotbench.airdata import NEEDED, mean_wind
from pitotbench.calibration.altitude import NOISE_COUNT, AltitudeRows
from pitotbench.calibration.covering import (
    CoveringFit,
    FirstPass,
    first_pass,
    flown_of,
    moved_by,
    posterior_of,
)
from pitotbench.calibration.covering_problem import Structure
from pitotbench.calibration.fit_checks import (
    either_way,
    outside_prior,
    require_observable,
    turns_to_one_side,
)
from pitotbench.calibration.location import IMPACT, ErrorPlace, fit_located
from pitotbench.calibration.nuisances import (
    LATENCY,
    Nuisance,
    nuisances_of,
    of_slow_probe,
    with_signs,
)
from pitotbench.calibration.observations import (
    Observations,
    observe,
    range_end,
    spans,
    wind_drifts,
)
from pitotbench.calibration.options import (
    AUTO,
    USUAL,
    WITHOUT_TEMPERATURE,
    CalibrationOptions,
    accuracies_of,
    assumptions_of,
    priors_of,
    stated_of,
    stated_wind,
)
from pitotbench.calibration.output_error import (
    OutputErrorFit,
    fit_scalar,
)
from pitotbench.calibration.prediction import PredictionModel
from pitotbench.calibration.screening import screen
from pitotbench.calibration.wind import MIN_BAYES_FACTOR, check_gain, check_wind
from pitotbench.calibration.wind_path import WindPath
from pitotbench.estimation.mixture import Posterior
from pitotbench.logbook.temperature import weather_report
from pitotbench.pressure_error import MODELS, REFERENCE_PRESSURE
from pitotbench.pressure_error.models import PressureErrorModel, SmoothModel
from pitotbench.records import NoAnswerError
from pitotbench.records.calibration import (
    READ_AT_REST,
    Assumption,
    Diagnostics,
    HeightFound,
    LatencyFound,
    WindChange,
    WindowWind,
)
from pitotbench.records.log import Caution, CurveMove, FlightLog
from pitotbench.timeline import interval, minutes_text
from pitotbench.units import DEGREE, KNOT, Array

if TYPE_CHECKING:
    from threadpoolctl import ThreadpoolController

_ILL_CONDITIONED = 1e6  # condition number: above it there is a warning
_FULL_SCALE_RATIO = 8.0  # q_ci/q_ref: above it the reference pressure is taken from the data
_LEAST_RANGE = 1.01  # of x between the ends, where the airspeed hardly changes
# Probability of so much evidence for a change under a constant wind, above which it is not named. A
# third of the changes that are found by chance would move the curve by enough to be named.
_CHANGED = 0.15
_MOST_NAMED = 5  # left-out rows in a warning
_MOST_LISTED = 1000  # left-out rows in the diagnostics


@dataclass(frozen=True, slots=True)
class Reduction:
    """The reduction of a log: model, rows, white fit, answer, diagnostics and warnings.

    `options` include the accuracies and the priors that were used. `assumptions` are the accuracies
    assumed for the bound, each with its source, and `priors` those that the caller stated.
    `without_height_and_with` are the curve's parameters (K,) by the wind triangle and by both
    equations, empty where the height tells nothing of it; `by_slow_probe` (p + m,) is what a probe
    that is a kelvin off at the slow end alone moves, None where no bound holds it.
    `weather_report` says in words which one tells the log's temperature.
    """

    options: CalibrationOptions
    model: PredictionModel
    observations: Observations
    white: OutputErrorFit
    answer: Posterior
    diagnostics: Diagnostics
    nuisances: tuple[Nuisance, ...] = ()
    warnings: tuple[Caution, ...] = ()
    error_location: str = IMPACT
    altitude: AltitudeRows | None = None
    without_height_and_with: tuple[Array, ...] = ()
    by_slow_probe: Array | None = None
    assumptions: tuple[Assumption, ...] = ()
    priors: Mapping[str, float] = field(default_factory=dict)
    winds: tuple[WindowWind, ...] = ()
    path: WindPath | None = None
    fit: CoveringFit | None = None
    parts: tuple[tuple[float, float], ...] = ()
    log_start: float = 0.0
    left_out: tuple[str, ...] = ()
    weather_report: str = ""


@dataclass(frozen=True, slots=True)
class CurveScale:
    """The reference pressure q_ref [Pa] of a curve, and the flown range of x = q_ci/q_ref.

    The range is `low` to `high`, without the outermost thousandths.
    """

    reference_pressure: float
    low: float
    high: float


def reduce_log(
    log: FlightLog,
    options: CalibrationOptions,
    scale: CurveScale | None = None,
    rows: Observations | None = None,
) -> Reduction:
    """Reduce a log.

    `scale` is that of the curve; None takes the log's own. `rows` are those of the log with these
    options, where it was read before. Raises BadInputError for a log that cannot be used,
    NoAnswerError for one that does not determine the answer.
    """
    used = replace(
        options,
        accuracies=accuracies_of(options.accuracies, log.header),
        priors=priors_of(options.priors, log.header),
    )
    obs = observe(log, used) if rows is None else rows
    model, usable = model_of(used, scale or scale_of([obs])), obs.usable
    _require_observable(model, obs, log)
    near = _along_path(model, used, obs)
    obs, white, left_out = _white(model, obs, used.robust, near)
    found = Diagnostics(white.iterations, tuple(int(row) for row in left_out[:_MOST_LISTED]))
    # Without evidence from the log the place of the error is that of the published method unless
    # stated.
    location = IMPACT if used.error_location == AUTO else used.error_location
    reduction = Reduction(
        used, model, obs, white, posterior_of(white), found, error_location=location
    )
    reduction = reduction if near is None else replace(reduction, path=near.path)
    if used.method == "covering":
        reduction = _cover(log, reduction)
    assumed = assumptions_of(options.accuracies, log.header)
    return replace(
        reduction,
        parts=spans(log.time, usable.rows),
        log_start=log.start,
        left_out=usable.reasons,
        weather_report=weather_report(log),
        warnings=(*_warnings(log, reduction, left_out), *reduction.warnings),
        priors=stated_of(options.priors),
        assumptions=_relevant_assumptions(assumed, used, reduction),
    )


def _require_observable(model: PredictionModel, obs: Observations, log: FlightLog) -> None:
    """Raise NoAnswerError where the rows do not determine the answer.

    The message names the end of the sensor's range where the log shows one.
    """
    try:
        require_observable(model, obs)
    except NoAnswerError as error:
        end = range_end(log)
        if end is None:
            raise
        raise type(error)(f"{error}; {end.words}") from error


def _relevant_assumptions(
    assumed: tuple[Assumption, ...], options: CalibrationOptions, reduction: Reduction
) -> tuple[Assumption, ...]:
    """Return the accuracies that the bound of this log depends on.

    The usual names, others that are not zero, and what the rows at rest say.
    """
    obs = reduction.observations
    at_rest = {n.name: 2.0 * n.measured[1] for n in reduction.nuisances if n.measured is not None}
    if options.method != "covering":
        assumed = tuple(replace(each, two_sigma=0.0, source="method") for each in assumed)
    elif obs.standard_day:
        assumed = tuple(
            Assumption(each.name, WITHOUT_TEMPERATURE, "standard day")
            if each.name == "temperature_k" and each.two_sigma < WITHOUT_TEMPERATURE
            else each
            for each in assumed
        )
    assumed = tuple(
        replace(each, two_sigma=at_rest[each.name], source=READ_AT_REST)
        if each.name in at_rest
        else each
        for each in assumed
    )
    wind = stated_wind(options.wind)
    return (
        *(each for each in assumed if each.two_sigma > 0.0 or getattr(USUAL, each.name) > 0.0),
        *([] if wind is None else [Assumption("wind_kt", 2.0 * wind.deviation / KNOT, "stated")]),
    )


def scale_of(observed: Sequence[Observations]) -> CurveScale:
    """Return the scale of a curve for one log or several."""
    reference = reference_of(observed)
    ranges = [flown_range(obs, reference) for obs in observed]
    return CurveScale(reference, min(low for low, _ in ranges), max(high for _, high in ranges))


def model_of(options: CalibrationOptions, scale: CurveScale) -> PredictionModel:
    """Return the model to be fitted, over the flown range where it is one of a range."""
    error = MODELS[options.law].spread_over(scale.low, scale.high)
    if isinstance(error, SmoothModel):
        error = priors_of(options.priors).of_curve(error)
    static = options.error_location == "static"
    return PredictionModel(error, scale.reference_pressure, static, options.wind_down)


def flown_range(obs: Observations, reference_pressure: float) -> tuple[float, float]:
    """Return the range of x = q_ci/q_ref in the data, without the outermost thousandths."""
    low, high = (
        float(q) for q in np.quantile(obs.impact_pressure, [0.001, 0.999]) / reference_pressure
    )
    return low, max(high, _LEAST_RANGE * low)


def reference_of(observed: Sequence[Observations]) -> float:
    """Return the reference pressure [Pa]: the usual one, of fast airplanes the rounded median."""
    middle = float(np.median(np.concatenate([obs.impact_pressure for obs in observed])))
    if middle < _FULL_SCALE_RATIO * REFERENCE_PRESSURE:
        return REFERENCE_PRESSURE
    return float(round(middle, -3))


_LAWS = ("inverse+", "linear", "bias")  # tried in turn for the white fit, the richest first


def _white(
    model: PredictionModel, obs: Observations, robust: bool, near: FirstPass | None
) -> tuple[Observations, OutputErrorFit, NDArray[np.intp]]:
    """The good rows, the white fit to them, and the numbers of the rows left out, (k,).

    Output error knows no prior: for a model with one, the richest law that the log determines is
    fitted, in the parameters of the model. Raises the NoAnswerError of the simplest law
    where it determines none.
    """
    if not np.any(model.error.precisions):
        return _screened(model, obs, robust, near)
    reasons: list[NoAnswerError] = []
    for name in _LAWS:
        law = replace(model, error=MODELS[name])
        try:
            require_observable(law, obs)
            good, fit, left_out = _screened(law, obs, robust, near)
        except NoAnswerError as error:
            reasons.append(error)
            continue
        return good, _in_parameters_of(model, law, fit), left_out
    raise reasons[-1]


def _in_parameters_of(
    model: PredictionModel, law: PredictionModel, fit: OutputErrorFit
) -> OutputErrorFit:
    """A white fit of a law in the parameters of a smooth model."""
    assert isinstance(model.error, SmoothModel)
    x = np.geomspace(model.error.low, model.error.high)
    turn = np.zeros((model.count, law.count))
    of_law = np.linalg.lstsq(model.error.basis(x), law.error.basis(x))[0]
    turn[: model.error_count, : law.error_count] = of_law
    turn[model.error_count :, law.error_count :] = np.eye(law.count - law.error_count)
    return replace(fit, theta=turn @ fit.theta, covariance=turn @ fit.covariance @ turn.T)


def _screened(
    model: PredictionModel, obs: Observations, robust: bool, near: FirstPass | None
) -> tuple[Observations, OutputErrorFit, NDArray[np.intp]]:
    """Return the good rows, the white fit to them, and the numbers of the rows left out, (k,).

    A drifting wind's path, found `near` the answer, is taken from the rows that are fitted and
    screened.
    """
    flown, start = obs, None
    if near is not None and near.path is not None:
        flown, start = near.path.taken_from(obs), np.zeros(model.count)
        start[model.error_count : model.error_count + 2] = near.theta[1:3]
    fit = None
    with suppress(NoAnswerError):  # faulty rows may keep it from converging
        fit = fit_scalar(model, flown, start)
    none = np.zeros(0, dtype=np.intp)
    if robust:
        screened = screen(model, flown, None if fit is None else fit.theta)
        if len(screened.left_out):
            good = screened.observations
            obs = good if flown is obs else obs.select(good.used[obs.used])
            flown, none, fit = good, screened.left_out, None
    # The fit is repeated without the faulty rows. Where there are none, it raises the error of the
    # first fit again.
    return obs, fit or fit_scalar(model, flown, start), none


def _along_path(
    model: PredictionModel, options: CalibrationOptions, obs: Observations
) -> FirstPass | None:
    """Return the first pass with a drifting wind from the best constant one, else None."""
    if options.method != "covering" or not wind_drifts(options, obs):
        return None
    # A curve of several terms and a wind that drifts far are easily confounded: the path comes from
    # a level alone.
    level = replace(model, error=MODELS["bias"])
    start = np.zeros(level.count)
    start[1:3] = mean_wind({name: getattr(obs, name) for name in NEEDED})
    return first_pass(_structure(level, options, obs, drifting=True), obs, start)


def _structure(
    model: PredictionModel, options: CalibrationOptions, obs: Observations, drifting: bool
) -> Structure:
    priors, wind = priors_of(options.priors), stated_wind(options.wind)
    return Structure(model, nuisances_of(options, obs), drifting, priors, wind=wind)


def _cover(log: FlightLog, white: Reduction) -> Reduction:
    """Give the white reduction the covering fit.

    Raises NoAnswerError where the latency is to be estimated and the log does not determine it.
    """
    found = _covered(white, _located(log, white))
    latency = found.diagnostics.latency
    unknown = latency is None or not np.isfinite(latency.two_sigma)
    if white.options.latency == "estimated" and unknown:
        raise NoAnswerError(
            "the latency is not observable: the log holds no planned change of speed; fly an idle "
            "deceleration, or state the latency in seconds"
        )
    return found


def _located(log: FlightLog, white: Reduction) -> ErrorPlace:
    options, obs = white.options, white.observations
    structure = _structure(white.model, options, obs, wind_drifts(options, obs))
    return fit_located(log, options, structure, obs, white.white.theta, white.path)


def _covered(white: Reduction, located: ErrorPlace) -> Reduction:
    """The reduction with the answer of a located fit and what else it found."""
    structure, fit, obs = located.structure, located.fit, white.observations
    change = None
    answer = with_signs(located.answer, structure.nuisances, structure.model.count)
    stepped: tuple[Caution, ...] = ()
    if white.options.wind == "checked" and not structure.drifting:
        change, answer = check_wind(structure, obs, fit, answer)
        stepped = check_gain(structure, obs, fit, answer, change)
    flown = flown_of(structure, obs, fit)
    outside = outside_prior(structure, obs, fit, located.answer)
    return replace(
        white,
        model=structure.model,
        answer=either_way(structure, outside, answer),
        nuisances=structure.nuisances,
        diagnostics=replace(
            white.diagnostics,
            latency=_latency(
                replace(white, model=structure.model, nuisances=structure.nuisances), located.answer
            ),
            wind_change=change,
            gusts=fit.gusts,
            height_agreement=located.chance,
            static_probability=located.static_probability,
            height=_height_found(structure.altitude, fit),
            departures=_departures(structure.model.error, fit),
        ),
        warnings=(
            *outside,
            *stepped,
            *turns_to_one_side(structure, obs, fit, located.answer, flown),
        ),
        by_slow_probe=moved_by(structure, obs, fit, flown, of_slow_probe(obs)),
        error_location=located.location,
        altitude=structure.altitude,
        without_height_and_with=located.without_height_and_with,
        winds=fit.winds,
        path=fit.path,
        fit=fit,
    )


# share of the prior variance: a log that resolves less does not determine the latency
_LEAST_KNOWN = 0.04


def _latency(reduction: Reduction, found: Posterior) -> LatencyFound | None:
    """Return the latency of the GPS velocity by the log without its prior, None where it is given.

    It is negative where the air data trail. The 2σ is infinite where the log does not determine it:
    it shows where the airplane accelerates over the ground along the airspeed.
    """
    names = [each.name for each in reduction.nuisances]
    if reduction.options.latency == "given" or LATENCY not in names:
        return None
    place = names.index(LATENCY)
    prior, at = reduction.nuisances[place].deviation, reduction.model.count + place
    left = float(found.weights @ found.covariances[:, at, at]) / prior**2
    given = reduction.options.gps_latency
    if left > 1.0 - _LEAST_KNOWN:
        return LatencyFound(given, float("inf"), 0.0)
    freed = 1.0 / (1.0 - left)
    value = given + float(found.mean[at]) * freed
    return LatencyFound(value, 2.0 * prior * float(np.sqrt(left * freed)), 0.0)


def _height_found(rows: AltitudeRows | None, fit: CoveringFit) -> HeightFound | None:
    """The most likely noise of the altitude equation."""
    if rows is None:
        return None
    noise = np.exp(fit.likely.noise[-NOISE_COUNT:])
    level, memory, third = (float(each) for each in noise)
    white, walk = (third, None) if rows.tie is None else (None, third)
    return HeightFound(level, memory, white, walk, len(rows))


def _departures(law: PressureErrorModel, fit: CoveringFit) -> dict[str, float] | None:
    """The probability of each size of a smooth curve's departures."""
    if not isinstance(law, SmoothModel):
        return None
    shares = dict.fromkeys(law.departures, 0.0)
    for node in fit.nodes:
        shares[law.departures[node.rival]] += node.weight
    return {f"{size:g}": share for size, share in shares.items()}


def _warnings(
    log: FlightLog, reduction: Reduction, left_out: NDArray[np.intp]
) -> Iterator[Caution]:
    """The warnings of the log and those of its reduction, in the order in which they are shown."""
    found, condition = reduction.diagnostics, reduction.white.condition_number
    for caution in log.cautions:
        if not _turned_by_delay(log, caution, found.latency):
            yield caution
    if condition > _ILL_CONDITIONED:
        yield Caution(
            f"condition number {condition:.1e}: the parameters are nearly confounded; "
            "trust the curve inside the flown speeds, not the single parameters",
            "confounded",
            size=condition,
        )
    end = range_end(log)
    if end is not None:
        yield Caution(end.words, "range end", "impact_pressure")
    if len(left_out):
        since = log.time[left_out[:_MOST_NAMED]] - log.start
        times = ", ".join(minutes_text(moment, 2) for moment in since)
        more = f" and {len(left_out) - _MOST_NAMED} more" if len(left_out) > _MOST_NAMED else ""
        text = f"{len(left_out)} rows disagree with all others and are left out, at {times}{more}"
        yield Caution(text, "faulty rows", size=len(left_out))
    change = found.wind_change  # named where it matters, and a constant wind would seldom look so
    if (
        change is not None
        and change.bayes_factor > MIN_BAYES_FACTOR
        and change.chance < _CHANGED
        and _moves(change).matters
    ):
        yield _wind_warning(change)


def _turned_by_delay(log: FlightLog, caution: Caution, latency: LatencyFound | None) -> bool:
    """Return whether a latency alone explains a warning of turned axes.

    As the airplane turns, a late track is turned back. A latency that is known to be none, or not
    known at all, explains nothing.
    """
    if caution.code != "axes turned" or log.heading is None or latency is None:
        return False
    rate = float(np.mean(np.diff(np.unwrap(log.heading)))) / interval(log.time) / DEGREE
    known = latency.two_sigma < abs(latency.value)
    return known and abs(-rate * latency.value - caution.size) < abs(rate) * latency.two_sigma


def _moves(change: WindChange) -> CurveMove:
    return CurveMove(change.moves, change.share)


def _wind_warning(change: WindChange) -> Caution:
    knots = change.size / KNOT
    when = (
        "over the log"
        if np.isnan(change.time)
        else f"about {change.time:.0f} s after the first row"
    )
    return Caution(
        f"the wind may have changed by about {knots:.1f} kt {when}, which would move the curve by "
        "up to "
        f"{change.moves / KNOT:.1f} kt; the bound holds both winds; each speed on opposite "
        "headings narrows it",
        "wind",
        size=knots,
        moves=_moves(change),
    )


@contextmanager
def one_thread() -> Iterator[None]:
    """Limit the linear-algebra libraries to one thread within the context.

    One thread is faster for arrays of this size, and gives the same digits on any number of cores.
    """
    with _controller().limit(limits=1):
        yield


@cache
def _controller() -> "ThreadpoolController":
    """Find the loaded libraries, once, because this takes longer than a fit.

    The BLAS of NumPy and that of SciPy must be loaded before. The estimators load both on import.
    """
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()
