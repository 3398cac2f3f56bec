"""The factor on the airspeed: what it is, what else explains it, and what to set."""

from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from pitotbench import air
from pitotbench.broken import BROKEN
from pitotbench.logbook.autopilot import autopilot_of
from pitotbench.logbook.plausibility import SPEED_FACTOR
from pitotbench.pressure_error.autopilot_settings import autopilot_settings
from pitotbench.records import BadInputError, NoAnswerError
from pitotbench.records.calibration import Calibration, Disagreement, RecordedAutopilot, Scale
from pitotbench.records.log import GUESSED, NAMED, Caution, FlightLog
from pitotbench.units import percent_text


@dataclass(frozen=True, slots=True)
class ScaleLimits:
    """Where a factor is reported; ratios of the airspeed without unit."""

    reported: float = 0.05  # from 1, beyond which it is reported: usual position errors are below
    own: float = 0.02  # 2σ of an airplane's own position error, relative to a true airspeed
    dense: float = 0.04  # by which true and indicated airspeed must differ to be distinguished
    # odds from which a cause counts: it is named, a sensor's own factor is usable
    told: float = 0.05


LIMITS = ScaleLimits()
# 1σ of the logarithm of a sensor's own factor: ARSPD_RATIO lies between 1.5 and 3 about 2.
_SPREAD = 0.15
# 1σ of the airplane's own error, which is in every factor: its 2σ is what is not reported.
_OWN_ERROR = 0.5 * LIMITS.reported
# Odds of each other cause against a sensor's own factor, before the log is looked at. It is a
# judgment that one log in a hundred has it; none is known to be more frequent than another.
_EACH = 0.01


@dataclass(frozen=True, slots=True)
class _Cause:
    """Another cause of a factor: the factor that it makes, and the units that must not be fixed."""

    words: str
    factor: float
    of: tuple[str, ...]  # of `FlightLog.units_by`; empty for a sensor, which no format fixes


_AIR, _GPS = ("air_data",), ("velocity",)
CAUSES = (
    _Cause("an airspeed in miles per hour that is read as knots", 0.8690, _AIR),
    _Cause("an airspeed in kilometers per hour that is read as knots", 0.5400, _AIR),
    _Cause("an airspeed in feet per second that is read as knots", 0.5925, _AIR),
    _Cause("an airspeed in knots that is read as miles per hour", 1.1508, _AIR),
    _Cause("an airspeed in knots that is read as kilometers per hour", 1.8520, _AIR),
    _Cause("an airspeed in m/s that is read as knots", 1.9438, _AIR),
    _Cause("an airspeed in knots that is read as m/s", 0.5144, _AIR),
    _Cause("a GPS velocity in knots that is read as m/s", 1.9438, _GPS),
    _Cause("a GPS velocity in m/s that is read as knots", 0.5144, _GPS),
    _Cause("a GPS velocity in miles per hour that is read as m/s", 2.2369, _GPS),
    _Cause("a GPS velocity in m/s that is read as miles per hour", 0.4470, _GPS),
    _Cause("a sensor that shows half of the airspeed", 2.0, ()),
    _Cause("a sensor that shows half of the impact pressure", float(np.sqrt(2.0)), ()),
)
_OVER = (0.1, 0.3, 0.5, 0.7, 0.9)  # of the airspeeds of the log
_CHECK = "check the sensor's range setting, and its tube for a leak"


def with_scale(result: Calibration, log: FlightLog) -> Calibration:
    """Return a calibration with its factor on the airspeed, which is the mean of its curve.

    A large factor is reported with what else may make it. One that no sensor has and a mistake of
    unit may make is not to be used, as only one of its causes leaves the answer right.
    """
    if result.wind is None or any(each.code == BROKEN for each in result.warnings):
        return result  # what is broken explains a factor
    scale = _of_curve(result)
    if abs(scale.factor - 1.0) <= scale.two_sigma:
        return replace(result, scale=scale)
    own, odds = _odds(result, scale, log)
    told = [each for each in odds if each[1] >= LIMITS.told]
    named = [f"{cause.words} ({percent_text(share)})" for cause, share in told]
    meant = tuple(cause.words for cause, _ in told if cause.of)
    result = replace(result, scale=replace(scale, units=meant))
    # A true airspeed is not among them: with its factor the airspeed is right at this height.
    mistaken = own < LIMITS.told and any(cause.of and cause in CAUSES for cause, _ in told)
    # One cause, one story: a unit explains the size of the curve as well.
    told_by = (SPEED_FACTOR, *(["curve size"] if mistaken else []))
    others = tuple(each for each in result.warnings if each.code not in told_by)
    sensors = [cause.words for cause, _ in told if not cause.of]
    if mistaken:
        reported = (
            f"the airspeed reads {1.0 / scale.factor:.2f} times the right one, which is "
            f"{' or '.join(named)}: name the column by its unit"
            f"{f' or {_CHECK}' if sensors else ''}"
        )
        finding = Disagreement("scale", reported, 0.0, fatal=True)
        return replace(result, disagreements=(finding, *result.disagreements), warnings=others)
    if meant or abs(scale.factor - 1.0) > LIMITS.reported:
        factor = f"{scale.factor:.3f} ± {scale.two_sigma:.3f}"
        says = f"multiply the airspeed by {factor}{_settings(result, scale)}"
        words = [each for each, (cause, _) in zip(named, told, strict=True) if cause.of]
        if words:
            says = f"{says}. {words[0][0].upper()}{' or '.join(words)[1:]} does so as well"
        says += "".join(f". {each.capitalize()} does so: {_CHECK}" for each in sensors)
        caution = Caution(says, "scale", size=scale.factor)
        result = replace(result, warnings=(caution, *others))
    return result


def _of_curve(result: Calibration) -> Scale:
    """Return the factor on the airspeed that the curve holds.

    The ratios of calibrated and indicated airspeed over the speeds of the log are one factor and,
    at each of them, the airplane's own error. A zero that was read at rest is none of the factor.
    """
    curve, flown = result.curve, np.quantile(result.residuals.indicated_airspeed, _OVER)
    count, zero = len(curve.correction), result.zero_at_rest
    known = [np.interp(flown, curve.indicated_airspeed, point) for point in np.eye(count)]
    pressure = air.impact_pressure(flown) - (0.0 if zero is None else zero.value)
    share = np.stack(known, axis=1) / air.calibrated_airspeed(pressure)[:, None]
    unsure = 0.5 * curve.two_sigma * share
    correlation = np.ones((count, count)) if curve.correlation is None else curve.correlation
    weight = np.linalg.solve(
        unsure @ correlation @ unsure.T + _OWN_ERROR**2 * np.eye(len(flown)), np.ones(len(flown))
    )
    ratio = share @ (curve.indicated_airspeed + curve.correction)
    return Scale(float(weight @ ratio / np.sum(weight)), float(2.0 / np.sqrt(np.sum(weight))))


def _odds(
    result: Calibration, scale: Scale, log: FlightLog
) -> tuple[float, list[tuple[_Cause, float]]]:
    """The probability of a sensor's own factor, and of each other cause of such a factor.

    The greatest comes first. What a recorder's format fixes is none.
    """
    by = log.units_by
    free = {name for name, what in by.items() if what in (NAMED, GUESSED)}
    causes = [each for each in CAUSES if free.issuperset(each.of)]
    if "air_data" in free:
        causes += _true_airspeed(result, log)
    unsure = 0.5 * scale.two_sigma / scale.factor
    spread = float(np.hypot(_OWN_ERROR, unsure))
    weights = [_EACH * _density(np.log(scale.factor / each.factor), spread) for each in causes]
    own = _density(np.log(scale.factor), float(np.hypot(_SPREAD, unsure)))
    whole = own + sum(weights)
    found = [(each, weight / whole) for each, weight in zip(causes, weights, strict=True)]
    return own / whole, sorted(found, key=lambda pair: -pair[1])


def _density(distance: float, spread: float) -> float:
    return float(np.exp(-0.5 * (distance / spread) ** 2) / spread)


def _true_airspeed(result: Calibration, log: FlightLog) -> list[_Cause]:
    """Return the cause that the column has true airspeed, if that would explain the curve.

    Else more of the curve would be left than an airplane's own error.
    """
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
    if abs(dense - 1.0) <= LIMITS.dense or float(np.max(np.abs(left))) >= bound:
        return []
    words = (
        f"a true airspeed in the column of the indicated one (the air density makes {dense:.3f})"
    )
    return [_Cause(words, dense, _AIR)]


def _settings(result: Calibration, scale: Scale) -> str:
    """Return the factor in words as an autopilot's parameter.

    The value is that of `--params`, where that gives one.
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
