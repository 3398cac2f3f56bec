"""An error curve against the limit of FAR 25.1323(c), in numbers and in a sentence."""

from dataclasses import dataclass

import numpy as np

from pitotbench.records.calibration import Calibration
from pitotbench.units import KNOT, Array

_SHARE, _KNOTS = 0.03, 5.0  # the larger of 3 % and 5 kt
# No airplane certified under part 23 or 25 cruises below this speed: for a small drone the rule means nothing.
_SLOWEST_KT = 60.0


@dataclass(frozen=True, slots=True)
class Margin:
    """The smallest distance [kt] to the limit, negative beyond it, and its indicated airspeed [kt]."""

    size_kt: float
    at_kt: float

    def __str__(self) -> str:
        return f"{abs(self.size_kt):.1f} kt (at {self.at_kt:.0f} KIAS)"


def far_limit(indicated_airspeed_kt: Array) -> Array:
    """Largest installation error [kt] that FAR 25.1323(c) allows at indicated airspeeds [kt]."""
    return np.maximum(_SHARE * indicated_airspeed_kt, _KNOTS)


def far_applies(result: Calibration) -> bool:
    """Whether the curve reaches the speeds of the airplanes that the rule is made for."""
    return bool(result.curve.indicated_airspeed[-1] >= _SLOWEST_KT * KNOT)


def far_verdict(result: Calibration) -> str:
    """Whether the curve and its ±2σ bound stay inside the limit, with the smallest margin [kt]."""
    curve = result.curve
    value, bound = curve.correction / KNOT, curve.two_sigma / KNOT
    alone, with_bound = _margin(result, np.abs(value)), _margin(result, np.abs(value) + bound)
    rule = "FAR 25.1323(c) allows the larger of 3 % and 5 kt:"
    if with_bound.size_kt >= 0.0:
        return f"{rule} the curve and its ±2σ bound stay inside, with a margin of {with_bound} or more."
    if alone.size_kt >= 0.0:
        return (
            f"{rule} the curve stays inside, but its ±2σ bound exceeds the limit by up to {with_bound}; "
            "fly more before relying on the curve."
        )
    return f"{rule} the curve exceeds the limit by up to {alone}."


def _margin(result: Calibration, error_kt: Array) -> Margin:
    speed = result.curve.indicated_airspeed / KNOT
    margin = far_limit(speed) - error_kt
    place = int(np.argmin(margin))
    return Margin(float(margin[place]), float(speed[place]))
