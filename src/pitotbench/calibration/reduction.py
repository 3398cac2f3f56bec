"""The reduction of one log: selection of rows, white fit, screening of faulty rows, noise and answer."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pitotbench import air
from pitotbench.calibration.altitude import NOISE_COUNT, AltitudeRows
from pitotbench.calibration.covering import CoveringFit, Posterior, Structure, acceleration_effect, posterior_of
from pitotbench.calibration.fit_checks import outside_prior, require_observable
from pitotbench.calibration.location import IMPACT, ErrorPlace, fit_located
from pitotbench.calibration.observations import Observations, observe, observe_again, range_end
from pitotbench.calibration.options import (
    AUTO,
    USUAL,
    WITHOUT_TEMPERATURE,
    CalibrationOptions,
    accuracies_of,
    assumptions_of,
)
from pitotbench.calibration.output_error import OutputErrorFit, fit_scalar
from pitotbench.calibration.prediction import (
    CurveMap,
    Nuisance,
    PredictionModel,
    by_latency,
    curve_airspeeds,
    nuisances_of,
)
from pitotbench.calibration.screening import screen
from pitotbench.calibration.wind import ASKS, JUMP, WindChange, check_wind
from pitotbench.pressure_error import MODELS, REFERENCE_PRESSURE
from pitotbench.records import NoAnswerError
from pitotbench.records.calibration import Assumption, Estimate
from pitotbench.records.log import FlightLog
from pitotbench.units import KNOT

if TYPE_CHECKING:
    from threadpoolctl import ThreadpoolController


# The latency of the GPS velocity against the air data, from planned changes of speed.
# A latency has an effect where the airplane accelerates over the ground along the airspeed. But the ground speed
# also responds to gusts, by an airspeed hold or by drag alone. These small accelerations imitate a latency
# (simulated flights without latency gave −1.0 to −1.5 s on circles and level legs). Therefore only larger
# accelerations count. They are smoothed, which also removes the noise of the velocity. A log without any, of
# steady legs or turns, does not determine the latency.

_PLANNED = 0.4  # m/s²: an idle deceleration has 1, the response to moderate turbulence 0.1

_READINGS = 4  # of the log, at most, each with the latest estimate

_LARGEST = 2.0  # s, of a latency of either sign


def estimate_latency(
    log: FlightLog, options: CalibrationOptions, obs: Observations, structure: Structure, fit: CoveringFit
) -> Estimate:
    """Estimate the latency of the GPS velocity [s], with 2σ.

    It is negative where the air data trail. The 2σ is infinite where the log does not determine it. The rows of the
    fit, `obs`, are read again with each estimate until the estimate settles.
    """
    column = Nuisance("latency_s", _PLANNED, by_latency)
    total = options.gps_latency
    for _ in range(_READINGS):
        read = observe_again(log, replace(options, gps_latency=total), obs)
        found = acceleration_effect(structure, read, fit, column)
        total = float(np.clip(total + found.value, -_LARGEST, _LARGEST))
        if abs(found.value) < 0.1 * found.two_sigma:
            break
    return Estimate("latency_s", total, found.two_sigma)


def with_latency(options: CalibrationOptions, latency: Estimate) -> CalibrationOptions:
    """Return the options with an estimated latency as the GPS latency and its 2σ as the accuracy.

    A greater stated accuracy is kept. Raises NoAnswerError where the latency is unknown.
    """
    if not np.isfinite(latency.two_sigma):
        raise NoAnswerError(
            "the latency is not observable: the log holds no planned change of speed; fly an idle deceleration, "
            "or state the latency in seconds"
        )
    stated = accuracies_of(options.accuracies, {})
    stated = replace(stated, latency_s=max(stated.latency_s, latency.two_sigma))
    return replace(options, gps_latency=latency.value, accuracies=stated)


def latency_warning(latency: float, two_sigma: float) -> str:
    """The warning of a latency that differs from zero by more than its 2σ; both in seconds."""
    late, early = ("GPS velocity", "air data") if latency > 0.0 else ("air data", "GPS velocity")
    return (
        f"the {late} trail the {early} by {abs(latency):.2f} ± {two_sigma:.2f} s (2σ); "
        "use --latency estimated, or state it"
    )


# The reduction of one log: selection of rows, white fit, screening of faulty rows, noise and answer.

_ILL_CONDITIONED = 1e6  # condition number: above it there is a warning

_FULL_SCALE_RATIO = 8.0  # q_ci/q_ref: above it the reference pressure is taken from the data

_LEAST_RANGE = 1.01  # of x between the outer knots of a spline, where the airspeed hardly changes

_DISAGREE = 0.001  # probability of so much disagreement by chance: below it there is a warning

# Probability of so much evidence for a change under a constant wind, above which it is not named. A third of the
# changes that are found by chance would move the curve by enough to be named.
_CHANGED = 0.15

_MATTERS = 0.25  # of 2σ: a change of the wind that moves the curve by less has no warning

_MOST_NAMED, _MOST_LISTED = 5, 1000  # greatest number of left-out rows in a warning and in the diagnostics


@dataclass(frozen=True, slots=True)
class Reduction:
    """The reduction of a log: model, rows, white fit, answer, diagnostics and warnings.

    `options` include the accuracies and the latency that were used. `assumptions` are the accuracies
    assumed for the bound, each with its source.
    """

    options: CalibrationOptions
    model: PredictionModel
    observations: Observations
    white: OutputErrorFit
    answer: Posterior
    nuisances: tuple[Nuisance, ...]
    diagnostics: dict[str, Any]
    warnings: tuple[str, ...]
    error_location: str = IMPACT
    altitude: AltitudeRows | None = None
    assumptions: tuple[Assumption, ...] = ()


def reduce_log(log: FlightLog, options: CalibrationOptions, reference_pressure: float | None = None) -> Reduction:
    """Reduce a log.

    `reference_pressure` [Pa] is q_ref; None takes the usual one, or one near the data of a fast airplane.
    Raises BadInputError for a log that cannot be used, NoAnswerError for one that does not determine the answer.
    """
    assumed = assumptions_of(options.accuracies, log.header)
    options = replace(options, accuracies=accuracies_of(options.accuracies, log.header))
    obs = observe(log, options)
    reference = reference_pressure or reference_of([obs])
    model = PredictionModel(MODELS[options.model], reference, options.error_location == "static", options.wind_down)
    _require_observable(model, obs, log)
    obs, white, left_out = _screened(model, obs, options.robust)
    found: dict[str, Any] = {"rows_left_out": [int(row) for row in left_out[:_MOST_LISTED]]}
    nuisances: tuple[Nuisance, ...] = ()
    departures: tuple[str, ...] = ()
    answer, location, altitude = posterior_of(white), _stated_location(options), None
    if options.method == "covering":
        options, obs, located, noticed = _cover(log, options, model, obs, white)
        model, answer, found = located.structure.model, located.answer, found | noticed
        departures = outside_prior(located.structure, obs, located.fit, located.answer)
        nuisances, location, altitude = located.structure.nuisances, located.location, located.structure.altitude
    return Reduction(
        options=options,
        model=model,
        observations=obs,
        white=white,
        answer=answer,
        nuisances=nuisances,
        diagnostics=found,
        warnings=(*_warnings(log, obs, white, left_out, found), *departures),
        error_location=location,
        altitude=altitude,
        assumptions=_that_matter(assumed, options, obs),
    )


def _require_observable(model: PredictionModel, obs: Observations, log: FlightLog) -> None:
    """Raise NoAnswerError where the rows do not determine the answer; name the sensor's range if that is why."""
    try:
        require_observable(model, obs)
    except NoAnswerError as error:
        end = range_end(log)
        if end is None:
            raise
        raise NoAnswerError(f"{error}; {end.words}") from error


def _that_matter(
    assumed: tuple[Assumption, ...], options: CalibrationOptions, obs: Observations
) -> tuple[Assumption, ...]:
    """The accuracies that the bound of this log depends on: the usual names, and others that are not zero."""
    if options.method != "covering":
        assumed = tuple(replace(each, two_sigma=0.0, source="method") for each in assumed)
    elif obs.standard_day:
        assumed = tuple(
            Assumption(each.name, WITHOUT_TEMPERATURE, "standard day")
            if each.name == "temperature_k" and each.two_sigma < WITHOUT_TEMPERATURE
            else each
            for each in assumed
        )
    return tuple(each for each in assumed if each.two_sigma > 0.0 or getattr(USUAL, each.name) > 0.0)


def _stated_location(options: CalibrationOptions) -> str:
    """The location of the error for a fit without evidence from the log: as published unless stated."""
    return IMPACT if options.error_location == AUTO else options.error_location


def model_of(
    name: str, options: CalibrationOptions, obs: Observations, reference_pressure: float
) -> PredictionModel:
    """Return the model to be fitted. A model with knots has them over the range of the data."""
    error = MODELS[name].spread_over(*flown_range(obs, reference_pressure))
    return PredictionModel(error, reference_pressure, options.error_location == "static", options.wind_down)


def flown_range(obs: Observations, reference_pressure: float) -> tuple[float, float]:
    """Return the range of x = q_ci/q_ref in the data, without the outermost thousandths."""
    low, high = (float(q) for q in np.quantile(obs.impact_pressure, [0.001, 0.999]) / reference_pressure)
    return low, max(high, _LEAST_RANGE * low)


def reference_of(observed: Sequence[Observations]) -> float:
    """Return the usual reference pressure [Pa], or for fast airplanes the median of the data, rounded."""
    middle = float(np.median(np.concatenate([obs.impact_pressure for obs in observed])))
    if middle < _FULL_SCALE_RATIO * REFERENCE_PRESSURE:
        return REFERENCE_PRESSURE
    return float(round(middle, -3))


def _screened(
    model: PredictionModel, obs: Observations, robust: bool
) -> tuple[Observations, OutputErrorFit, NDArray[np.intp]]:
    """The good rows, the white fit to them, and the numbers of the rows left out, (k,)."""
    fit = _white_fit(model, obs)
    none = np.zeros(0, dtype=np.intp)
    if robust:
        screened = screen(model, obs, None if fit is None else fit.theta)
        if len(screened.left_out):
            obs, none, fit = screened.observations, screened.left_out, None
    # The fit is repeated without the faulty rows. Where there are none, it raises the error of the first fit again.
    return obs, fit or fit_scalar(model, obs), none


def _white_fit(model: PredictionModel, obs: Observations) -> OutputErrorFit | None:
    """The published fit; None where faulty rows may keep it from converging."""
    try:
        return fit_scalar(model, obs)
    except NoAnswerError:
        return None


def _cover(
    log: FlightLog, options: CalibrationOptions, model: PredictionModel, obs: Observations, white: OutputErrorFit
) -> tuple[CalibrationOptions, Observations, ErrorPlace, dict[str, Any]]:
    """Run the covering fit; an estimated latency is applied to the log, which is then read and fitted again."""
    structure = _structure(model, options, obs)
    located = fit_located(log, options, structure, obs, white.theta)
    found: dict[str, Any] = {}
    if options.latency != "given":
        latency = estimate_latency(log, options, obs, located.structure, located.fit)
        found = {
            "latency_s": latency.value,
            "latency_two_sigma_s": latency.two_sigma if np.isfinite(latency.two_sigma) else None,
            "latency_left_s": 0.0 if options.latency == "estimated" else latency.value - options.gps_latency,
        }
        if options.latency == "estimated":
            options = with_latency(options, latency)
            obs = observe_again(log, options, obs)
            structure = _structure(model, options, obs)
            located = fit_located(log, options, structure, obs, white.theta)
    fit = located.fit
    if options.wind == "checked":
        found |= _wind_found(check_wind(located.structure, obs, fit), located, obs)
    found |= {
        "gust_deviation_mps": fit.gust_deviation,
        "gust_length_m": fit.gust_length,
        "wind_deviation_mps": fit.wind_deviation,
        "blocks": fit.blocks,
        **_altitude_found(located),
    }
    return options, obs, located, found


def _wind_found(change: WindChange | None, located: ErrorPlace, obs: Observations) -> dict[str, Any]:
    """The diagnostics of a change of the wind; the last is its effect on the curve over the curve's 2σ."""
    if change is None:
        return {}
    model, answer = located.structure.model, located.answer
    flown = curve_airspeeds(air.calibrated_airspeed(obs.impact_pressure))
    gradient = CurveMap(model, flown, 0.0).correction_gradient(answer.mean[: model.error_count])
    moved = np.abs(gradient @ change.moved[: model.error_count])
    bounds = answer.two_sigma(np.pad(gradient, ((0, 0), (0, len(answer.mean) - model.error_count))))
    return {
        "wind_change_bayes_factor": change.bayes_factor,
        "wind_change_chance": change.chance,
        "wind_change_kind": change.kind,
        "wind_change_mps": change.size,
        "wind_change_time_s": change.time if change.kind == JUMP else None,
        "wind_change_moves_mps": float(np.max(moved)),
        "wind_change_share": float(np.max(moved / bounds)),
    }


def _altitude_found(located: ErrorPlace) -> dict[str, Any]:
    """The diagnostics of the altitude equation."""
    found: dict[str, Any] = {}
    if located.chance is not None:
        found["height_agreement"] = located.chance
    if located.static_probability is not None:
        found["static_probability"] = located.static_probability
    rows = located.structure.altitude
    if rows is not None:
        level, memory, third = np.exp(max(located.fit.nodes, key=lambda node: node.weight).noise[-NOISE_COUNT:])
        found |= {
            "height_deviation_m": float(level),
            "height_memory_s": float(memory),
            "height_white_m" if rows.tie is None else "height_walk_m_per_root_s": float(third),
            "altitude_rows": len(rows),
        }
    return found


def _structure(model: PredictionModel, options: CalibrationOptions, obs: Observations) -> Structure:
    return Structure(model, nuisances_of(options, obs), options.wind == "drifting")


def _warnings(
    log: FlightLog,
    obs: Observations,
    white: OutputErrorFit,
    left_out: NDArray[np.intp],
    found: Mapping[str, Any],
) -> tuple[str, ...]:
    warnings = list(log.header.get("warnings", ()))
    if obs.standard_day:
        warnings.append(
            f"no temperature in the log: a standard day is assumed, {WITHOUT_TEMPERATURE:.0f} K off at most (2σ); "
            "its part of the bound is listed"
        )
    if white.condition_number > _ILL_CONDITIONED:
        warnings.append(
            f"condition number {white.condition_number:.1e}: the parameters are nearly confounded; "
            "trust the curve inside the flown speeds, not the single parameters"
        )
    end = range_end(log)
    if end is not None:
        warnings.append(end.words)
    if len(left_out):
        times = ", ".join(f"{t:.2f}" for t in log.time[left_out[:_MOST_NAMED]])
        more = f" and {len(left_out) - _MOST_NAMED} more" if len(left_out) > _MOST_NAMED else ""
        warnings.append(f"{len(left_out)} rows disagree with all others and are left out, at {times}{more} s")
    agreement = found.get("height_agreement", 1.0)
    if agreement < _DISAGREE:
        warnings.append(
            "the wind triangle and the height disagree about the curve (by chance in "
            f"{100.0 * agreement:.2g} % of cases): the model may not follow the curve (try --model auto, or a "
            "narrower range of speeds), or temperature or height may be off by more than stated"
        )
    if _wind_changed(found):
        warnings.append(_wind_warning(found))
    latency_bound = found.get("latency_two_sigma_s")  # None also where the log does not determine the latency
    if latency_bound is not None and abs(found["latency_left_s"]) > latency_bound:
        warnings.append(latency_warning(found["latency_s"], latency_bound))
    return tuple(warnings)


def _wind_changed(found: Mapping[str, Any]) -> bool:
    """Whether the log asks for a change of the wind that matters, and a constant wind would seldom look so."""
    asked = found.get("wind_change_bayes_factor", 0.0) > ASKS and found["wind_change_chance"] < _CHANGED
    return bool(asked and found["wind_change_share"] > _MATTERS)


def _wind_warning(found: Mapping[str, Any]) -> str:
    knots, time = found["wind_change_mps"] / KNOT, found["wind_change_time_s"]
    when = "over the log" if time is None else f"about {time:.0f} s after the first row"
    return (
        f"the wind may have changed by about {knots:.1f} kt {when}, which would move the curve by up to "
        f"{found['wind_change_moves_mps'] / KNOT:.1f} kt; the bound assumes a constant wind: compare with --wind "
        "drifting, or fly each speed on opposite headings"
    )


# Linear algebra on one thread: faster for arrays of this size, and the same digits on any number of cores.


@contextmanager
def one_thread() -> Iterator[None]:
    """Limit the linear-algebra libraries to one thread within the context."""
    with _controller().limit(limits=1):
        yield


@cache
def _controller() -> "ThreadpoolController":
    """Find the loaded libraries, once, because this takes longer than a fit.

    The BLAS of NumPy and that of SciPy must be loaded before. The estimators load both on import.
    """
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()
