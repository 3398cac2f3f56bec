"""The factor on the airspeed: what it is, what else explains it, and what to set."""

from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from pitotbench import air
from pitotbench.broken import BROKEN
from pitotbench.calibration.options import CalibrationOptions, accuracies_of
from pitotbench.calibration.prediction import ZERO
from pitotbench.calibration.reduction import reduce_log
from pitotbench.logbook.autopilot import autopilot_of
from pitotbench.logbook.plausibility import SPEED_FACTOR
from pitotbench.pressure_error.autopilot_settings import autopilot_settings
from pitotbench.records import BadInputError, NoAnswerError
from pitotbench.records.calibration import Calibration, Disagreement, RecordedAutopilot, Scale
from pitotbench.records.log import Caution, FlightLog
from pitotbench.units import Array


@dataclass(frozen=True, slots=True)
class ScaleLimits:
    """Where a factor is found anew and reported; ratios of the airspeed without unit."""

    refined: float = 0.02  # from 1; a factor that may lie beyond has a fit of its own
    slowest: float = 5.0  # m/s over the ground, of the rows of that fit: an autopilot's in flight
    reported: float = 0.05  # from 1, beyond which it is reported: usual position errors are below
    zero: float = 100.0  # Pa, 2σ of the sensor's zero: that of an autopilot's sensor
    gain: float = 0.5  # of a factor, in logarithms: where the gain makes less, it is a zero
    half: float = 0.06  # of the factor, by which a sensor that reads half may differ
    own: float = 0.02  # 2σ of an airplane's own position error, relative to a true airspeed
    dense: float = 0.04  # by which true and indicated airspeed must differ to be distinguished


LIMITS = ScaleLimits()
# Factors that a unit makes: what the column holds, and what it is read as.
UNITS = {
    0.8690: "an airspeed in miles per hour that is read as knots",
    0.5400: "an airspeed in kilometers per hour that is read as knots",
    0.5925: "an airspeed in feet per second that is read as knots",
    1.1508: "an airspeed in knots that is read as miles per hour",
    1.8520: "an airspeed in knots that is read as kilometers per hour",
    1.9438: "an airspeed in m/s that is read as knots, or a GPS velocity in knots read as m/s",
    0.5144: "a GPS velocity in m/s that is read as knots",
    2.2369: "a GPS velocity in miles per hour that is read as m/s",
    0.4470: "a GPS velocity in m/s that is read as miles per hour",
}
_STEP = 1e-4  # of Δp/q_c, and Pa, for the derivative of the factor
_OVER = (0.1, 0.3, 0.5, 0.7, 0.9)  # of the impact pressures of the log
_HALVES = {2.0: "half of the airspeed", float(np.sqrt(2.0)): "half of the impact pressure"}


def with_scale(result: Calibration, log: FlightLog, options: CalibrationOptions) -> Calibration:
    """Return a calibration with its factor on the airspeed.

    A large factor is reported, and one that a unit makes as well is not to be used.
    """
    if result.wind is None or any(each.code == BROKEN for each in result.warnings):
        return result  # what is broken explains a factor
    scale = _of_curve(result)
    # Where a temperature is assumed, the mean of the curve depends on the law that was chosen.
    assumed = log.air_temperature is None and log.total_temperature is None
    if assumed or abs(scale.factor - 1.0) + scale.two_sigma > LIMITS.refined:
        scale = _refined(scale, log, options)
    known = abs(scale.factor - 1.0) > scale.two_sigma
    scale = replace(scale, units=tuple(_meanings(result, scale, log)) if known else ())
    result = replace(result, scale=scale)
    if scale.units:
        words = (
            f"{_factor_words(scale)}, and so would {' or '.join(scale.units)}: the log does not "
            "tell which; look into the recorder's settings before you use either"
        )
        reported = Disagreement("scale", words, 0.0, fatal=True)
        result = replace(result, disagreements=(*result.disagreements, reported))
    if known and abs(scale.factor - 1.0) > LIMITS.reported:
        words = f"{_factor_words(scale)}{_settings(result, scale)}{_half(scale)}"
        caution = Caution(words, "scale", size=scale.factor)
        others = [each for each in result.warnings if each.code != SPEED_FACTOR]
        result = replace(result, warnings=(caution, *others))
    return result


def _of_curve(result: Calibration) -> Scale:
    """The mean ratio of calibrated and indicated airspeed over the curve."""
    curve = result.curve
    weight = curve.indicated_airspeed / curve.two_sigma
    ratio = 1.0 + curve.correction / curve.indicated_airspeed
    factor = float(np.average(ratio, weights=weight**2))
    return Scale(factor, float(np.median(1.0 / weight)))


def _refined(scale: Scale, log: FlightLog, options: CalibrationOptions) -> Scale:
    """The factor of a fit of a gain and a zero, which is the same whatever the file's mapping
    advises: the mean ratio of calibrated and shown airspeed over the speeds of the log.

    With Δp/q_c = k and a zero z the impact pressure is (q − z)/(1 − k). Where the zero makes the
    ratio another at another airspeed, half of that is in the bound.
    """
    stated = accuracies_of(options.accuracies, log.header)
    zero = replace(stated, impact_pressure_zero_pa=LIMITS.zero)
    try:
        plain = replace(options, model="bias", method="covering", accuracies=zero)
        slowest = max(options.ground_speed_min, LIMITS.slowest)
        found = reduce_log(log, replace(plain, ground_speed_min=slowest))
    except NoAnswerError:
        return scale
    answer, names = found.answer, [each.name for each in found.nuisances]
    places = [0, found.model.count + names.index(ZERO)]
    shown = np.quantile(found.observations.impact_pressure, _OVER)

    def ratios(gain: float, offset: float) -> Array:
        right = np.maximum(shown - offset, 0.0) / max(1.0 - gain, 1e-6)
        return air.calibrated_airspeed(right) / air.calibrated_airspeed(shown)

    k, z = (float(answer.mean[place]) for place in places)
    by_gain, whole = (abs(np.log(np.mean(ratios(k, offset)))) for offset in (0.0, z))
    if whole > LIMITS.reported and by_gain < LIMITS.gain * whole:
        z, places = 0.0, places[:1]  # what would be reported is the zero's, which the curve holds
    here = ratios(k, z)
    toward = np.zeros((1, len(answer.mean)))
    moved = (k + _STEP, z), (k, z + _STEP)
    for place, (gain, offset) in zip(places, moved, strict=False):
        toward[0, place] = float(np.mean(ratios(gain, offset) - here)) / _STEP
    bound = float(answer.two_sigma(toward)[0])
    return Scale(float(np.mean(here)), float(np.hypot(bound, 0.5 * np.ptp(here))))


def _meanings(result: Calibration, scale: Scale, log: FlightLog) -> list[str]:
    """What else makes such a factor, in words."""
    found = [words for ratio, words in UNITS.items() if abs(scale.factor - ratio) < scale.two_sigma]
    # What a true airspeed as large as the shown one would be as a calibrated airspeed.
    static, shown = float(np.median(log.static_pressure)), result.curve.indicated_airspeed
    height = air.pressure_altitude(static)
    temperature = float(air.standard_temperature(height))
    if log.air_temperature is not None:
        temperature = float(np.median(log.air_temperature))
    mach = shown / air.sound_speed(temperature)
    right = air.calibrated_airspeed(air.impact_pressure_from_mach(mach, static))
    left = (shown + result.curve.correction) / right - 1.0
    bound = np.hypot(float(np.median(result.curve.two_sigma / shown)), LIMITS.own)
    dense = float(np.mean(right / shown))
    if abs(dense - 1.0) > LIMITS.dense and float(np.max(np.abs(left))) < bound:
        found.append(
            "a true airspeed in the column of the indicated one (the air density makes "
            f"{dense:.3f})"
        )
    return found


def _factor_words(scale: Scale) -> str:
    return f"multiply the airspeed by {scale.factor:.3f} ± {scale.two_sigma:.3f}"


def _settings(result: Calibration, scale: Scale) -> str:
    """The factor as the parameter of an autopilot: the value that `--params` gives, where it gives
    one.
    """
    recorded = result.autopilot or RecordedAutopilot({})
    if name := autopilot_of(recorded.parameters, recorded.sensor):
        with suppress(BadInputError, NoAnswerError):
            gain = autopilot_settings(result, name).settings[0]
            return (
                f"; as {gain.name} {gain.value:.5g} ± {gain.two_sigma:.2g} (old {gain.old:g}; "
                "--params gives the offset as well)"
            )
    return f"; as ARSPD_RATIO the old one times {scale.factor**2:.3f}, as ASPD_SCALE times " + (
        f"{scale.factor:.3f}"
    )


def _half(scale: Scale) -> str:
    near = [
        words
        for ratio, words in _HALVES.items()
        if abs(scale.factor - ratio) < max(LIMITS.half * ratio, scale.two_sigma)
    ]
    return "".join(
        f". A sensor that shows {words} does so: check its range setting, and its tube for a leak"
        for words in near
    )
