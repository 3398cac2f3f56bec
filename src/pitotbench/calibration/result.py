"""Assemble the Calibration from a reduction by either method; a display's steps widen its bound."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from pitotbench import air
from pitotbench.calibration.covering import drift_of
from pitotbench.calibration.covering_problem import Structure
from pitotbench.calibration.fit_checks import FLY_HEADINGS, disagreements, heading_spread
from pitotbench.calibration.location import STATIC, fit_by_height
from pitotbench.calibration.nuisances import ZERO, Nuisance
from pitotbench.calibration.observations import Observations, observe, spans, wind_drifts
from pitotbench.calibration.options import (
    AUTO,
    WITHOUT_TEMPERATURE,
    CalibrationOptions,
    accuracies_of,
    assumptions_of,
    priors_of,
    stated_of,
)
from pitotbench.calibration.output_error import OutputErrorFit
from pitotbench.calibration.prediction import CurveMap, PredictionModel, curve_airspeeds
from pitotbench.calibration.reduction import Reduction, model_of, scale_of
from pitotbench.estimation.mixture import Posterior
from pitotbench.estimation.noise import UNIFORM
from pitotbench.records import NoAnswerError
from pitotbench.records.calibration import (
    Calibration,
    DayTemperature,
    Diagnostics,
    ErrorCurve,
    Estimate,
    Residuals,
    Share,
    WindEstimate,
    WindowWind,
)
from pitotbench.records.log import Caution, FlightLog
from pitotbench.units import DEGREE, KNOT, Array, MetersPerSecond, Seconds

_FEWEST_POINTS = 2  # of a curve


def assemble(reduction: Reduction, airspeeds: MetersPerSecond | None = None) -> Calibration:
    """Assemble the Calibration of a reduction.

    `airspeeds` (c,) [m/s] are the indicated airspeeds of the curve; None takes the range of the
    log. Raises NoAnswerError where the impact pressure is hardly more than its zero offset.
    """
    model, obs, white, answer = (
        reduction.model,
        reduction.observations,
        reduction.white,
        reduction.answer,
    )
    zero = found_zero(model, answer, reduction.nuisances)
    if airspeeds is None:
        airspeeds = curve_airspeeds(air.calibrated_airspeed(obs.impact_pressure))
    curve = CurveMap(model, _above_zero(airspeeds, zero), 0.0 if zero is None else zero.value)
    residuals = residuals_of(reduction)
    assumed = (  # neither stated nor seen in the height
        reduction.error_location == STATIC
        and reduction.options.error_location == AUTO
        and reduction.diagnostics.static_probability is None
    )
    stated = accuracies_of(reduction.options.accuracies, {})
    drawn = _curve(curve, white, answer, reduction.nuisances)
    each = _estimates(model, answer)
    shares = _shares(curve, answer, reduction.nuisances, each, drawn.two_sigma)
    wind = WindEstimate(*each[model.error_count : model.count])
    return Calibration(
        model=reduction.options.law,
        method=reduction.options.method,
        parameters=each[: model.error_count],
        reference_pressure=model.reference_pressure,
        wind=wind,
        curve=with_altitude(drawn, curve, answer, obs, stated.total_source, assumed),
        residual_two_sigma=2.0 * float(white.deviation[0]),
        samples=len(obs),
        converged=True,
        reason=white.reason,
        condition_number=white.condition_number,
        residuals=residuals,
        warnings=(*reduction.warnings, *_of_standard_day(reduction, shares, drawn)),
        shares=shares,
        diagnostics=reduction.diagnostics,
        error_location=reduction.error_location,
        day=_day(reduction, shares, curve),
        assumptions=reduction.assumptions,
        priors=reduction.priors,
        impact_pressure_zero=zero,
        winds=reduction.winds or _one_window(reduction, wind),
        parts=reduction.parts,
        log_start=reduction.log_start,
        left_out=reduction.left_out,
        disagreements=disagreements(
            reduction.diagnostics.height_agreement,
            residuals,
            drawn,
            reduction.path is not None,
            [curve.correction(k) for k in reduction.without_height_and_with],
        ),
        place_assumed=assumed,
        mach=float(np.max(air.mach_from_impact_pressure(obs.impact_pressure, obs.static_pressure))),
    )


_DOUBTED = 5.0  # K, of a probe: what a user can be asked to rule out


def _day(reduction: Reduction, shares: Sequence[Share], curve: CurveMap) -> DayTemperature | None:
    """Return what the temperature is, and what a probe that is off by 5 K would do to the curve.

    The latter is what the log does not show of such an error, at all airspeeds or at the slowest
    alone. None where the temperature is assumed, or stated as exact.
    """
    obs, stated = reduction.observations, accuracies_of(reduction.options.accuracies, {})
    part = next((each for each in shares if each.name == "temperature_k"), None)
    if part is None or obs.standard_day or reduction.by_slow_probe is None:
        return None
    free = reduction.model.error_count
    gradient = curve.correction_gradient(reduction.answer.mean[:free])
    slow = float(np.max(np.abs(gradient @ reduction.by_slow_probe[:free])))
    mach = air.mach_from_impact_pressure(obs.impact_pressure, obs.static_pressure)
    temperature = obs.probe_temperature / (1.0 + obs.probe_heating * mach**2)
    standard = air.standard_temperature(air.pressure_altitude(obs.static_pressure))
    # The share is 2σ of the temperature times the slope; the log shows the rest of an error.
    unseen = part.estimate.two_sigma / stated.temperature_k**2
    departure = float(np.median(temperature - standard))
    return DayTemperature(departure, _DOUBTED * unseen * part.curve, _DOUBTED * slow)


def _one_window(reduction: Reduction, wind: WindEstimate) -> tuple[WindowWind, ...]:
    """The wind of the whole log as one window."""
    obs = reduction.observations
    span = float(obs.time[0]), float(obs.time[-1])
    return (WindowWind(*span, float(np.mean(obs.height())), wind.north, wind.east),)


def assemble_by_height(log: FlightLog, options: CalibrationOptions) -> Calibration:
    """Return the Calibration by height alone, without wind, of a log with all headings alike.

    Raises as `location.fit_by_height` does.
    """
    used = replace(
        options,
        accuracies=accuracies_of(options.accuracies, log.header),
        priors=priors_of(options.priors, log.header),
    )
    obs = observe(log, used)
    model = model_of(used, scale_of([obs]))
    found = fit_by_height(log, used, obs, model)
    k, indicated = found.answer.mean, air.calibrated_airspeed(found.impact_pressure)
    curve = CurveMap(found.model, curve_airspeeds(air.calibrated_airspeed(obs.impact_pressure)))
    gradient = curve.correction_gradient(k)
    bounds = found.answer.two_sigma(gradient)
    drawn = ErrorCurve(
        indicated_airspeed=curve.indicated_airspeed,
        correction=curve.correction(k),
        two_sigma=bounds,
        simultaneous_two_sigma=found.answer.simultaneous(gradient, bounds),
        white_two_sigma=bounds,
        normalized_pressure_error=curve.normalized(k),
        normalized_two_sigma=found.answer.two_sigma(curve.basis()),
        correlation=found.answer.correlation(gradient),
    )
    airspeed = found.left * air.calibrated_airspeed_slope(found.impact_pressure, indicated)
    residuals = Residuals(found.time, indicated, airspeed, obs.used)
    words = (
        f"the wind is unknown: all headings lie within {heading_spread(obs) / DEGREE:.0f}°. The "
        "curve is that of the static source, by height and pressure alone. They cannot show a pressure "
        f"error that is the same at all airspeeds; it is taken as none. To check it, {FLY_HEADINGS}"
    )
    return Calibration(
        model=model.error.name,
        method="height",
        parameters=_estimates(found.model, found.answer)[: found.model.error_count],
        reference_pressure=model.reference_pressure,
        wind=None,
        curve=with_altitude(
            drawn, curve, found.answer, obs, accuracies_of(used.accuracies, {}).total_source
        ),
        residual_two_sigma=2.0 * float(np.std(airspeed)),
        samples=len(obs),
        converged=True,
        reason="by height alone",
        condition_number=1.0,
        residuals=residuals,
        diagnostics=Diagnostics(0),
        warnings=(*log.cautions, Caution(words, "one heading")),
        error_location=STATIC,
        assumptions=assumptions_of(options.accuracies, log.header),
        priors=stated_of(options.priors),
        parts=spans(log.time, obs.usable.rows),
        log_start=log.start,
        left_out=obs.usable.reasons,
        mach=float(np.max(air.mach_from_impact_pressure(obs.impact_pressure, obs.static_pressure))),
    )


def found_zero(
    model: PredictionModel, answer: Posterior, nuisances: Sequence[Nuisance]
) -> Estimate | None:
    """Return the zero offset of the impact pressure [Pa], or None where it was not estimated."""
    place = _zero_place(model, nuisances)
    if place is None:
        return None
    only = np.eye(len(answer.mean))[[place]]
    return Estimate(ZERO, float(answer.mean[place]), float(answer.two_sigma(only)[0]))


def _zero_place(model: PredictionModel, nuisances: Sequence[Nuisance]) -> int | None:
    names = [nuisance.name for nuisance in nuisances]
    return model.count + names.index(ZERO) if ZERO in names else None


def _above_zero(airspeeds: MetersPerSecond, zero: Estimate | None) -> MetersPerSecond:
    """The airspeeds whose impact pressure exceeds the zero offset plus its 2σ.

    Raises NoAnswerError where there are fewer than two.
    """
    if zero is None:
        return airspeeds
    above = air.impact_pressure(airspeeds) > zero.value + zero.two_sigma
    if np.count_nonzero(above) < _FEWEST_POINTS:
        raise NoAnswerError(
            f"the impact pressure is hardly more than its zero offset ({zero.value:+.0f} ± "
            f"{zero.two_sigma:.0f} "
            "Pa, 2σ): fly faster, or set the sensor's zero before the flight"
        )
    return airspeeds[above]


def _estimates(model: PredictionModel, answer: Posterior) -> tuple[Estimate, ...]:
    """Every unknown with its 2σ; the nuisances, which stand behind curve and wind, have no name."""
    names = (*model.error.parameter_names, "north", "east", "down")[: model.count]
    bounds = answer.two_sigma(np.eye(len(answer.mean)))
    return tuple(
        Estimate(name, float(v), float(b))
        for name, v, b in zip((*names, *[""] * len(bounds)), answer.mean, bounds, strict=False)
    )


def _curve(
    curve: CurveMap, white: OutputErrorFit, answer: Posterior, nuisances: Sequence[Nuisance]
) -> ErrorCurve:
    k = answer.mean[: curve.model.error_count]
    gradient, basis = (
        correction_gradient(curve, answer, nuisances),
        over_all_parameters(curve.basis(), answer),
    )
    bounds = answer.two_sigma(gradient)
    part = gradient[:, : curve.model.count]
    white_variance = np.einsum("cp,pq,cq->c", part, white.covariance, part)
    return ErrorCurve(
        indicated_airspeed=curve.indicated_airspeed,
        correction=curve.correction(k),
        two_sigma=bounds,
        simultaneous_two_sigma=answer.simultaneous(gradient, bounds),
        white_two_sigma=2.0 * np.sqrt(white_variance),
        normalized_pressure_error=curve.normalized(k),
        normalized_two_sigma=answer.two_sigma(basis),
        correlation=answer.correlation(gradient),
    )


def with_altitude(
    curve: ErrorCurve,
    of: CurveMap,
    answer: Posterior,
    obs: Observations,
    total_source: float,
    assumed: bool = False,
) -> ErrorCurve:
    """Add the altitude correction [m] and its 2σ where the error is the static source's.

    Both are computed at the median of the log's static pressures. Where the place of the error is
    `assumed`, there may be no error of the altitude at all, and the 2σ holds 0. `total_source` is
    2σ of the total source's share.
    """
    if not of.model.static_error:
        return curve
    pressure = float(np.median(obs.static_pressure))
    k = answer.mean[: of.model.error_count]
    gradient = over_all_parameters(of.altitude_gradient(k, pressure), answer)
    correction = of.altitude(k, pressure)
    bound = np.hypot(answer.two_sigma(gradient), of.altitude_by_total(k, pressure, total_source))
    if assumed:
        bound = np.hypot(bound, correction)
    return replace(
        curve,
        altitude_correction=correction,
        altitude_two_sigma=bound,
        altitude_assumed=assumed,
        highest=float(air.pressure_altitude(np.min(obs.static_pressure))),
    )


def correction_gradient(curve: CurveMap, answer: Posterior, nuisances: Sequence[Nuisance]) -> Array:
    """Return the derivative of the correction [m/s] by all of θ, (c, p).

    θ includes the zero offset.
    """
    k = answer.mean[: curve.model.error_count]
    gradient, place = (
        over_all_parameters(curve.correction_gradient(k), answer),
        _zero_place(curve.model, nuisances),
    )
    if place is not None:
        gradient[:, place] = curve.correction_by_zero(k)
    return gradient


def over_all_parameters(gradient: Array, answer: Posterior) -> Array:
    """Extend a gradient (c, K) over the error parameters by zeros to one over θ, (c, p)."""
    wide = np.zeros((len(gradient), len(answer.mean)))
    wide[:, : gradient.shape[1]] = gradient
    return wide


def _shares(
    curve: CurveMap,
    answer: Posterior,
    nuisances: Sequence[Nuisance],
    each: Sequence[Estimate],
    whole: MetersPerSecond,
) -> tuple[Share, ...]:
    """The contribution of each nuisance to the bounds.

    `whole` (c,) are those of the curve, `each` those of each unknown.
    """
    free, count = curve.model.error_count, curve.model.count
    gradient = correction_gradient(curve, answer, nuisances)
    wind = np.eye(len(answer.mean))[free : free + 2]
    bounds = np.array([axis.two_sigma for axis in each[free : free + 2]])
    return tuple(
        Share(
            nuisance.name,
            replace(each[place], name=nuisance.name),
            float(np.sqrt(np.mean(answer.two_sigma_by(place, gradient, whole) ** 2))),
            float(np.max(answer.two_sigma_by(place, wind, bounds))),
        )
        for place, nuisance in enumerate(nuisances, start=count)
    )


def _of_standard_day(
    reduction: Reduction, shares: Sequence[Share], curve: ErrorCurve
) -> Iterator[Caution]:
    """What the temperature of a log without one contributes to the bound, and where to find it.

    The published method takes its sensors for exact, and the standard day with them.
    """
    if reduction.observations.standard_day:
        report = f" ({reduction.weather_report})" if reduction.weather_report else ""
        whole = float(np.sqrt(np.mean(curve.two_sigma**2)))
        part = next((each.curve for each in shares if each.name == "temperature_k"), None)
        assumed = (
            "and taken for exact"
            if part is None
            else f"±{WITHOUT_TEMPERATURE:.0f} K (2σ), which contributes ±{part / KNOT:.1f} kt to "
            f"the curve's ±{whole / KNOT:.1f} kt (as squares)"
        )
        yield Caution(
            f"no temperature in the log: a standard day is assumed, {assumed}; state the day's: "
            f"--temperature-c 18±2@ground{report}",
            "standard day",
        )


def residuals_of(reduction: Reduction) -> Residuals:
    """Return what is left of each sample by the answer of a reduction with all of its unknowns.

    A zero offset and the other constant errors found are part of the prediction, as they are of the
    correction and of the wind. Gusts across the path lengthen the airspeed by σ²/V on average.
    """
    model, obs, values = reduction.model, reduction.observations, reduction.answer.mean
    if reduction.fit is not None and wind_drifts(reduction.options, obs):
        priors = priors_of(reduction.options.priors)
        structure = Structure(model, reduction.nuisances, True, priors, reduction.altitude)
        obs = drift_of(structure, obs, reduction.fit, values).taken_from(obs)
    prediction, gusts = model.predict(values[: model.count], obs), reduction.diagnostics.gusts
    moved = (0.0 if gusts is None else gusts.deviation**2) / prediction.true_airspeed
    for nuisance, value in zip(reduction.nuisances, values[model.count :], strict=True):
        moved += value * nuisance.column(prediction, obs)
    predicted = np.maximum(prediction.indicated + prediction.slope * moved, 0.0)
    indicated = air.calibrated_airspeed(obs.impact_pressure)
    airspeed = indicated - air.calibrated_airspeed(predicted)
    return Residuals(time=obs.time, indicated_airspeed=indicated, airspeed=airspeed, used=obs.used)


_NEAR = 10.0 * KNOT  # m/s: readings that decide about the curve at an airspeed
_WINDOW = 10.0  # s: scatter within it is that of gusts, not a change of the maneuver's airspeed
_FEWEST = 5  # rows of a window that tell a scatter
_ORDERS = np.arange(1.0, 51.0)


def with_display_steps(calibration: Calibration, log: FlightLog) -> Calibration:
    """Return a calibration whose curve has the steps of the log's display in its bounds.

    The header's table `display` holds the steps: `airspeed_mps` and `ground_speed_mps`. A log
    without a display comes back unchanged.
    """
    steps = log.header.get("display", {})
    if not isinstance(steps, Mapping) or not steps:
        return calibration
    curve = calibration.curve
    added = display_two_sigma(log, curve.indicated_airspeed, steps)
    if not np.any(added):
        return calibration
    wider = np.hypot(1.0, added / curve.two_sigma)
    widened = replace(
        curve,
        two_sigma=curve.two_sigma * wider,
        simultaneous_two_sigma=curve.simultaneous_two_sigma * wider,
        normalized_two_sigma=curve.normalized_two_sigma * wider,
        altitude_two_sigma=None
        if curve.altitude_two_sigma is None
        else curve.altitude_two_sigma * wider,
    )
    knots = float(added.max()) / KNOT
    words = f"the steps of the display add up to {knots:.2f} kt to the bound, as squares"
    caution = Caution(words, "display steps", size=knots)
    return replace(calibration, curve=widened, warnings=(*calibration.warnings, caution))


def display_two_sigma(
    log: FlightLog, indicated_airspeed: MetersPerSecond, steps: Mapping[str, float]
) -> MetersPerSecond:
    """Return the 2σ of corrections at indicated airspeeds that a display's steps leave, (c,) [m/s].

    The residual of a log cannot show it. On a steady leg a display shows one number, which is wrong
    by up to half a step and never scatters. Near each airspeed the mean of the readings errs as the
    mean of so many independent rounding errors as there are different readings; a reading that
    stands for long counts once. Where gusts move the reading to and fro, its rounding errors change
    from row to row. They are then part of the residual, which the bound already holds, and their
    mean is nearly zero. With a scatter of σ steps the share of the mean's variance that stays is
    the sum over k of 6/(π k)² |φ(2π k)|², where φ is the characteristic function of what moves the
    reading (B. Widrow and I. Kollár, Quantization Noise, 2008). No shape is assumed for it: the
    share is that of a sinusoid, whose envelope |φ(2π k)|² <= 1/(√2 π² k σ) falls slowest of the
    usual ones.
    """
    speed = np.asarray(air.calibrated_airspeed(log.impact_pressure))
    variance = np.zeros(len(indicated_airspeed))
    velocity = (log.velocity_north, log.velocity_east)
    readings = {
        "airspeed_mps": (speed, (speed,)),
        "ground_speed_mps": (np.hypot(*velocity), velocity),
    }
    for name, (shown, channels) in readings.items():
        step = steps.get(name, 0.0)
        if not isinstance(step, int | float) or not step > 0.0:
            continue
        stays = share_that_stays(log.time, shown / step)
        near = [np.abs(speed - at) < _NEAR for at in indicated_airspeed]
        left = [
            min(np.mean(stays[rows]), 1.0 / _different(channels, rows)) if rows.any() else 1.0
            for rows in near
        ]
        variance += (UNIFORM * step) ** 2 * np.array(left)
    return np.asarray(2.0 * np.sqrt(variance))


def share_that_stays(time: Seconds, reading: Array) -> Array:
    """Return the share, 0 to 1, of the rounding variance that a reading's mean keeps, (n,).

    `reading` (n,) is in steps. A reading that stands still keeps 1. The scatter is taken within
    windows of ten seconds, less the variance of the rounding itself (Sheppard's correction); a
    window of few rows keeps 1.
    """
    _, window, count = np.unique(
        (time - time[0]) // _WINDOW, return_inverse=True, return_counts=True
    )
    mean = np.bincount(window, reading) / count
    squares = np.bincount(window, (reading - mean[window]) ** 2) / np.maximum(count - 1, 1)
    scatter = np.sqrt(np.maximum(squares - UNIFORM**2, 0.0))
    scatter[count < _FEWEST] = 0.0
    with np.errstate(divide="ignore"):
        envelope = np.minimum(1.0, 1.0 / (np.sqrt(2.0) * np.pi**2 * _ORDERS[:, None] * scatter))
    kept = np.sum(envelope / _ORDERS[:, None] ** 2, axis=0) / np.sum(1.0 / _ORDERS**2)
    return np.asarray(kept[window])


def _different(channels: tuple[Array, ...], near: Array) -> float:
    """Return how many different readings the chosen rows hold, at least 1.

    A reading of many rows counts once.
    """
    _, counts = np.unique(np.stack([c[near] for c in channels]), axis=1, return_counts=True)
    return float(counts.sum() ** 2 / np.sum(counts.astype(np.float64) ** 2))
