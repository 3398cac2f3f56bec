"""The scale and offset that take the error of a calibrated airspeed out of an autopilot."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from pitotbench.catalog import explain
from pitotbench.logbook.autopilot import AUTOPILOTS, Autopilot, tube_sign
from pitotbench.records import BadInputError, NoAnswerError
from pitotbench.records.calibration import (
    AutopilotSettings,
    Calibration,
    ErrorCurve,
    RecordedAutopilot,
    Setting,
)
from pitotbench.units import Array

_FEWEST = 3  # points of a curve that tell a scale from an offset
# ARSPD_TYPE without a pressure
_NO_PRESSURE = {0: "no sensor", 13: "a water speed", 16: "an airspeed from outside"}
_WITHOUT_OFFSET = 6  # ARSPD_TYPE of the SDP3X: ArduPilot holds its offset at zero


def autopilot_settings(result: Calibration, name: str) -> AutopilotSettings:
    """Return the parameters that take the error out of an autopilot's airspeed, with their 2σ.

    `result` is a calibration of the airspeed that the autopilot showed with the parameters in its
    log. The new ones fit C² = R(d − δ) to the calibrated airspeeds C of the curve, by weighted
    least squares. Their 2σ is that of the curve, whose errors are correlated, plus what the formula
    cannot follow. Each has its derivation. Raises BadInputError for an unknown autopilot, for a log
    without its parameters and for a sensor that does not use them; NoAnswerError for a curve that
    does not tell them, and for an answer that is not to be used.
    """
    if name not in AUTOPILOTS:
        raise BadInputError(explain("autopilot", name, list(AUTOPILOTS)))
    if not result.usable:
        why = next(each.words for each in result.disagreements if each.fatal)
        raise NoAnswerError(f"no parameters from an answer that is not to be used: {why}")
    recorded = result.autopilot or RecordedAutopilot({})
    autopilot, parameters = AUTOPILOTS[name].of_sensor(recorded.sensor), recorded.parameters
    prefix = autopilot.prefix
    fixed = bool(prefix) and parameters.get(f"{prefix}TYPE") == _WITHOUT_OFFSET
    _require(autopilot, parameters, () if fixed else (autopilot.offset,))
    curve = result.curve
    if len(curve.indicated_airspeed) < _FEWEST:
        raise NoAnswerError(
            "the curve has too few airspeeds for a scale and an offset: fly a wider range"
        )
    old = autopilot.ratio_of(parameters[autopilot.gain])
    fit = _fit(curve, old, fixed)
    gain = autopilot.gain_of(fit.ratio)
    # d(gain)/gain = power · dR/R: 1 where the gain is R, ½ where it is a factor of the airspeed
    power = np.log(autopilot.gain_of(4.0 * fit.ratio) / gain) / np.log(4.0)
    span = "{:.0f} to {:.0f} kt".format(*curve.indicated_airspeed_kt[[0, -1]])
    settings = [
        Setting(
            autopilot.gain, gain, gain * power * fit.ratio_two_sigma / fit.ratio,
            parameters[autopilot.gain], f"old value and the slope of the curve, {span} shown",
        )
    ]  # fmt: skip
    if not fixed:
        before, change = parameters[autopilot.offset], tube_sign(parameters, prefix) * fit.offset
        moved = f"{'plus' if change > 0.0 else 'less'} {abs(change):.3g} Pa"
        found = f"old value {moved}, where the corrected airspeed is zero"
        settings.append(
            Setting(autopilot.offset, before + change, fit.offset_two_sigma, before, found)
        )
    for switch, value, reason in autopilot.switches:
        if not (fixed and switch == f"{prefix}SKIP_CAL"):
            settings.append(Setting(switch, value, None, parameters.get(switch), reason))
    return AutopilotSettings(name, tuple(settings), fit.calibrated, fit.bound, recorded.wash)


def _require(autopilot: Autopilot, parameters: Mapping[str, float], more: tuple[str, ...]) -> None:
    missing = [n for n in (autopilot.gain, *more) if n not in parameters]
    if missing:
        has = (
            f"it holds {', '.join(sorted(parameters))}"
            if parameters
            else "it holds none of an autopilot"
        )
        raise BadInputError(
            f"the log does not hold {' and '.join(missing)}, with which its airspeed was shown "
            f"({has}). Calibrate the file that the autopilot wrote (.bin or .ulg), or state the "
            "old values: --params "
            f"{autopilot.title.lower()},{autopilot.gain}=...,{autopilot.offset}=..."
        )
    if not parameters[autopilot.gain] > 0.0:
        raise BadInputError(
            f"the old {autopilot.gain} is {parameters[autopilot.gain]:g}: it must be above zero; "
            f"state that of the flight: --params {autopilot.title.lower()},{autopilot.gain}=..."
        )
    if reason := _REFUSALS[autopilot.title](parameters, autopilot.prefix):
        raise BadInputError(
            f"{reason}; calibrate without --params and correct the airspeed by the card"
        )


def _refuse_ardupilot(parameters: Mapping[str, float], prefix: str) -> str:
    kind = _NO_PRESSURE.get(int(parameters.get(f"{prefix}TYPE", 1)))
    return (
        ""
        if kind is None
        else f"{prefix}TYPE {parameters[f'{prefix}TYPE']:g} is {kind}: no ratio acts on it"
    )


def _refuse_px4(parameters: Mapping[str, float], _: str) -> str:
    why = (
        "PX4 computes the airspeed of an SDP3X with a model of its tube (SENS_EN_SDP3X is set), "
        "not by the formula"
    )
    return why if parameters.get("SENS_EN_SDP3X", 0.0) else ""


# Why the parameters of a log cannot be replaced, empty where they can, by the autopilot's title.
_REFUSALS = {"ArduPilot": _refuse_ardupilot, "PX4": _refuse_px4}


@dataclass(frozen=True, slots=True)
class _Fit:
    """R [m²/s² per Pa] and δ [Pa] with 2σ, and the curve's calibrated airspeeds and bound [m/s]."""

    ratio: float
    ratio_two_sigma: float
    offset: float
    offset_two_sigma: float
    calibrated: Array
    bound: Array


def _fit(curve: ErrorCurve, old: float, fixed: bool) -> _Fit:
    speed, two_sigma = curve.indicated_airspeed + curve.correction, curve.two_sigma
    pressure = curve.indicated_airspeed**2 / old
    terms = pressure[:, None] if fixed else np.column_stack([pressure, np.ones_like(pressure)])
    weight = 1.0 / (speed * np.maximum(two_sigma, 1e-9))
    inverse = np.linalg.pinv(terms * weight[:, None]) * weight  # from C² to the coefficients
    slope, level = (*(inverse @ speed**2), 0.0)[:2]
    if not slope > 0.0:
        raise NoAnswerError(
            "the corrected airspeed does not grow with the pressure: the curve is no scale and "
            "offset; calibrate without --params and correct the airspeed by the card"
        )
    by_speed = inverse * (2.0 * speed)
    known = np.ones((len(speed),) * 2) if curve.correlation is None else curve.correlation
    covariance = by_speed @ (known * np.outer(two_sigma, two_sigma)) @ by_speed.T
    if curve.correlation is None:  # how the errors go together is not known: take the worst
        covariance = np.diag((np.abs(by_speed) @ two_sigma) ** 2)
    shown = np.sqrt(np.maximum(slope * pressure + level, 0.0))
    left = np.abs(shown - speed)
    offset = -level / slope
    toward = np.array([offset, 1.0][: len(covariance)]) / slope  # of −δ
    return _Fit(
        ratio=float(slope),
        ratio_two_sigma=float(np.sqrt(covariance[0, 0]) + 2.0 * slope * np.max(left / speed)),
        offset=float(offset),
        offset_two_sigma=float(
            np.sqrt(toward @ covariance @ toward) + np.max(2.0 * speed * left) / slope
        ),
        calibrated=speed,
        bound=two_sigma + left,
    )
