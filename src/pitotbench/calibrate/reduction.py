"""One log on its way to an answer: rows, white fit, faulty rows, noise, answer."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pitotbench.calibrate.accuracy import WITHOUT_TEMPERATURE, accuracies_from
from pitotbench.calibrate.gls.altitude_rows import NOISE_COUNT, AltitudeRows
from pitotbench.calibrate.gls.changing_wind import CONSTANT, weigh_winds
from pitotbench.calibrate.gls.latency import estimate_latency, latency_warning, with_latency
from pitotbench.calibrate.gls.linearized_problem import Structure
from pitotbench.calibrate.gls.location import IMPACT, Located, fit_located
from pitotbench.calibrate.gls.posterior import Posterior, posterior_of
from pitotbench.calibrate.model.crosswind import direction_nuisances
from pitotbench.calibrate.model.nuisances import Nuisance, nuisances_of
from pitotbench.calibrate.model.prediction import PredictionModel
from pitotbench.calibrate.observability import require_observable
from pitotbench.calibrate.options import AUTO, CalibrationOptions
from pitotbench.calibrate.output_error import OutputErrorFit
from pitotbench.calibrate.paper import fit_scalar, fit_vector
from pitotbench.calibrate.rows.observations import Observations, observe, observe_again
from pitotbench.calibrate.rows.screening import screen
from pitotbench.pressure_error import MODELS, REFERENCE_PRESSURE
from pitotbench.records.errors import NoAnswerError
from pitotbench.records.log import FlightLog
from pitotbench.units import KNOT

_ILL_CONDITIONED = 1e6
_FULL_SCALE_RATIO = 8.0  # q_ci/q_ref above which the reference pressure is raised to the data
_LEAST_RANGE = 1.01  # of x between the outer knots of a spline, where the airspeed hardly changes
_CHANGED = 0.05  # probability of a constant wind below which its change is said
_DISAGREE = 0.001  # probability of so much disagreement by chance, below which it is said
_MOST_NAMED, _MOST_LISTED = 5, 1000  # rows left out: in a warning, in the diagnostics


@dataclass(frozen=True, slots=True)
class Reduction:
    """A log reduced: what was fitted to which rows, the white fit, the answer, and what was noticed on the way."""

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
    structure: Structure | None = None  # with the most likely wind; None for the method `paper`


def reduce_log(log: FlightLog, options: CalibrationOptions, reference_pressure: float | None = None) -> Reduction:
    """Reduce a log; `reference_pressure` [Pa] None takes the usual one, or one near the data of a fast airplane."""
    if options.accuracies is None:
        options = replace(options, accuracies=accuracies_from(log.header.get("accuracy", {})))
    obs = observe(log, options)
    reference = reference_pressure or reference_of([obs])
    model = PredictionModel(MODELS[options.model], reference, options.error_location == "static", options.wind_down)
    require_observable(model, obs)
    obs, white, left_out = _screened(model, obs, log, options)
    found: dict[str, Any] = {"rows_left_out": [int(row) for row in left_out[:_MOST_LISTED]]}
    nuisances: tuple[Nuisance, ...] = ()
    answer, location, altitude, structure = posterior_of(white), _stated_location(options), None, None
    if options.method == "covering":
        options, obs, located, noticed = _cover(log, options, model, obs, white)
        model, answer, found = located.structure.model, located.answer, found | noticed
        structure = located.structure
        nuisances, location, altitude = structure.nuisances, located.location, structure.altitude
    warnings = _warnings(log, obs, white, left_out, found)
    return Reduction(options, model, obs, white, answer, nuisances, found, warnings, location, altitude, structure)


def _stated_location(options: CalibrationOptions) -> str:
    """Where the error sits for a fit that does not ask the log: as published, unless it is stated."""
    return IMPACT if options.error_location == AUTO else options.error_location


def model_of(
    name: str, options: CalibrationOptions, obs: Observations, reference_pressure: float
) -> PredictionModel:
    """What is fitted; a model with knots gets them over the range of the data."""
    error = MODELS[name].spread_over(*flown_range(obs, reference_pressure))
    return PredictionModel(error, reference_pressure, options.error_location == "static", options.wind_down)


def flown_range(obs: Observations, reference_pressure: float) -> tuple[float, float]:
    """The range of x = q_ci/q_ref in the data, without the outermost thousandths."""
    low, high = (float(q) for q in np.quantile(obs.impact_pressure, [0.001, 0.999]) / reference_pressure)
    return low, max(high, _LEAST_RANGE * low)


def reference_of(observed: Sequence[Observations]) -> float:
    """The usual reference pressure [Pa], or a round one near the data's middle for fast airplanes."""
    middle = float(np.median(np.concatenate([obs.impact_pressure for obs in observed])))
    if middle < _FULL_SCALE_RATIO * REFERENCE_PRESSURE:
        return REFERENCE_PRESSURE
    return float(round(middle, -3))


def _screened(
    model: PredictionModel, obs: Observations, log: FlightLog, options: CalibrationOptions
) -> tuple[Observations, OutputErrorFit, NDArray[np.intp]]:
    """The rows that count, the white fit to them, and the rows left out, (k,)."""
    fit = _white_fit(model, obs, log, options)
    none = np.zeros(0, dtype=np.intp)
    if options.robust and (options.form == "scalar" or options.method == "covering"):
        screened = screen(model, obs, None if fit is None else fit.theta)
        if len(screened.left_out):
            obs, none, fit = screened.observations, screened.left_out, None
    # Fitted again without the faulty rows; without any, the error says why there is no fit.
    return obs, fit or fit_scalar(model, obs), none


def _white_fit(
    model: PredictionModel, obs: Observations, log: FlightLog, options: CalibrationOptions
) -> OutputErrorFit | None:
    """The published fit; None where faulty rows may keep it from converging."""
    if options.form == "vector" and options.method == "paper":
        return fit_vector(model, obs, log)
    try:
        return fit_scalar(model, obs)
    except NoAnswerError:
        return None


def _cover(
    log: FlightLog, options: CalibrationOptions, model: PredictionModel, obs: Observations, white: OutputErrorFit
) -> tuple[CalibrationOptions, Observations, Located, dict[str, Any]]:
    """The covering fit; where the latency is to be estimated, of the log read again with it."""
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
    if options.wind == "checked":
        located, change = _with_checked_wind(located, obs)
        found |= change
    fit = located.fit
    found |= {
        "gust_deviation_mps": fit.gust_deviation,
        "gust_length_m": fit.gust_length,
        "wind_deviation_mps": fit.wind_deviation,
        "blocks": fit.blocks,
        **_altitude_found(located),
    }
    return options, obs, located, found


def _with_checked_wind(located: Located, obs: Observations) -> tuple[Located, dict[str, Any]]:
    """The answer that allows for a wind that changes, and what was found of it."""
    winds = weigh_winds(located.structure, obs, located.fit, located.answer)
    found: dict[str, Any] = {"wind_probability": winds.shares}
    if winds.change is not None and winds.shares[CONSTANT] < _CHANGED:
        kind = "jump" if winds.structure.jump is not None else "drift"
        begin, end = (float(obs.time[0]) + t for t in (winds.change.begin, winds.change.end))
        found["wind_change"] = {"kind": kind, "size_mps": winds.change.size, "from_s": begin, "to_s": end}
    return replace(located, structure=winds.structure, fit=winds.fit, answer=winds.answer), found


def _altitude_found(located: Located) -> dict[str, Any]:
    """What the altitude equation adds to the diagnostics."""
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
    crosswind = options.form == "vector"
    nuisances = (*nuisances_of(options, obs), *(direction_nuisances() if crosswind else ()))
    return Structure(model, nuisances, options.wind == "drifting", crosswind)


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
    if len(left_out):
        times = ", ".join(f"{t:.2f}" for t in log.time[left_out[:_MOST_NAMED]])
        more = f" and {len(left_out) - _MOST_NAMED} more" if len(left_out) > _MOST_NAMED else ""
        warnings.append(f"{len(left_out)} rows disagree with all others and are left out, at {times}{more} s")
    if "wind_change" in found:
        warnings.append(_of_changing_wind(found["wind_change"]))
    agreement = found.get("height_agreement", 1.0)
    if agreement < _DISAGREE:
        warnings.append(
            "the wind triangle and the height disagree about the curve (by chance in "
            f"{100.0 * agreement:.2g} % of cases): the model may not follow the curve (try --model auto, or a "
            "narrower range of speeds), or temperature or height may be off by more than stated"
        )
    latency_bound = found.get("latency_two_sigma_s")  # None also where the log says nothing about the latency
    if latency_bound is not None and abs(found["latency_left_s"]) > latency_bound:
        warnings.append(latency_warning(found["latency_s"], latency_bound))
    return tuple(warnings)


def _of_changing_wind(change: Mapping[str, Any]) -> str:
    """What a change of the wind means, in words."""
    jumps, begin, end = change["kind"] == "jump", change["from_s"], change["to_s"]
    when = f"around {0.5 * (begin + end):.0f} s" if jumps else f"between {begin:.0f} and {end:.0f} s"
    verb = "jumps" if jumps else "drifts"
    return (
        f"the wind {verb} by about {change['size_mps'] / KNOT:.1f} kt {when}: the bound allows for it; "
        "if that wind is not credible, the model may not follow the curve (try --model auto)"
    )
