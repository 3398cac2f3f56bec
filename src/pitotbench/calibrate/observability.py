"""Checks that a log determines the requested answer. A number that it does not determine is never returned."""

import numpy as np

from pitotbench.calibrate.model.prediction import PredictionModel
from pitotbench.calibrate.rows.observations import Observations
from pitotbench.records.calibration import Calibration
from pitotbench.records.errors import NoAnswerError
from pitotbench.units import DEGREE, KNOT

_HEADING_SPREAD = 30.0 * DEGREE  # below it the along-track wind and the curve's level are one unknown
_SPEED_RATIO = {1: 1.0, 2: 1.05, 3: 1.10}  # number of terms to the ratio of impact pressures that they need
_SPLINE_RATIO = 1.3  # the same for a model of more terms
_USELESS = 10.0 * KNOT  # a bound beyond this is no answer


def require_observable(model: PredictionModel, obs: Observations) -> None:
    """Raise NoAnswerError where headings or speeds are too similar. The message says what to fly next."""
    for axis, velocity in (("north", obs.velocity_north), ("east", obs.velocity_east)):
        if not np.any(velocity):
            raise NoAnswerError(
                f"the wind is not observable: the ground velocity toward {axis} is zero in every row: check it"
            )
    spread = heading_spread(obs)
    if spread < _HEADING_SPREAD:
        raise NoAnswerError(
            f"the wind is not observable: all headings lie within {spread / DEGREE:.0f}°; "
            "fly a second leg at least 60° away (the reciprocal is best)"
        )
    low, high = np.quantile(obs.impact_pressure, [0.02, 0.98])
    needed = _SPEED_RATIO.get(model.error_count, _SPLINE_RATIO)
    if high / low < needed:
        raise NoAnswerError(
            f"the airspeed hardly changes (impact pressure {low:.0f} to {high:.0f} Pa): the model "
            f"{model.error.name!r} with {model.error_count} parameters needs a ratio of {needed:g}; "
            "use --model bias, or fly a wider speed range"
        )


def heading_spread(obs: Observations) -> float:
    """Return the width of the smallest arc that contains 98 % of the ground tracks [rad]."""
    thin = max(1, len(obs) // 5000)
    track = np.sort(np.arctan2(obs.velocity_east[::thin], obs.velocity_north[::thin]))
    keep = int(np.ceil(0.98 * len(track)))
    wrapped = np.concatenate([track, track + 2.0 * np.pi])
    return float(np.min(wrapped[keep - 1 : keep - 1 + len(track)] - wrapped[: len(track)]))


def require_useful(calibration: Calibration) -> None:
    """Raise NoAnswerError where 2σ of the curve or the wind is above 10 kt or not finite."""
    wind = max(calibration.wind.north.two_sigma, calibration.wind.east.two_sigma)
    curve = float(np.max(calibration.curve.two_sigma))
    if not np.isfinite(wind + curve):
        raise NoAnswerError(
            "the log does not determine the answer: no bound can be given; check the clock, the units and the "
            "columns, or fly longer, on reciprocal headings"
        )
    if max(wind, curve) > _USELESS:
        raise NoAnswerError(
            f"the log does not determine the answer: 2σ would be {curve / KNOT:.1f} kt on the curve and "
            f"{wind / KNOT:.1f} kt on the wind; fly longer, on reciprocal headings, at every speed of interest"
        )
