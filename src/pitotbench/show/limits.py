"""An error curve against a limit of airspeed and altitude errors, in numbers and in sentences."""

import re
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from pitotbench.air import (
    GAS_CONSTANT,
    GRAVITY,
    SEA_LEVEL_PRESSURE,
    SEA_LEVEL_TEMPERATURE,
    impact_pressure,
)
from pitotbench.records import BadInputError
from pitotbench.records.calibration import Calibration
from pitotbench.show.reader_units import QUOTED
from pitotbench.units import FOOT, KNOT, Array

AUTO, NONE = "auto", "none"
_TRANSPORT = 0.6  # Mach number from which on the rule of transport airplanes judges
# No airplane certified under part 23 or 25 cruises below this speed.
_SLOWEST_KT = 60.0
# At sea level in the standard atmosphere, where the rules apply: 1/(ρ g), with ρ = p/(R T).
_FEET_A_PASCAL = GAS_CONSTANT * SEA_LEVEL_TEMPERATURE / (SEA_LEVEL_PRESSURE * GRAVITY) / FOOT
_OWN_NAME = "Your limit"
_NUMBER = r"\d+(?:\.\d+)?"
_OWN = re.compile(rf"(?P<percent>{_NUMBER})%,(?P<knots>{_NUMBER})kt(?:,(?P<feet>{_NUMBER})ft)?")
_LEAST_FEET = 30.0  # both rules: the limit need not be less


@dataclass(frozen=True, slots=True)
class Limit:
    """The largest errors that a rule allows.

    Airspeed: the larger of `share` of the airspeed and `knots`. Altitude: `feet` for each 100 kt of
    airspeed, 30 ft or more, or None where the rule says nothing about it. `why` says why a rule
    that nobody named was taken.
    """

    name: str
    share: float
    knots: float
    altitude_name: str = ""
    feet: float | None = None
    why: str = ""

    @property
    def label(self) -> str:
        """The name in a legend."""
        return "your limit" if self.name == _OWN_NAME else f"limit of {self.name}"

    def airspeed(self, airspeed_kt: Array) -> Array:
        """Largest allowed airspeed error [kt] at airspeeds [kt]."""
        return np.maximum(self.share * airspeed_kt, self.knots)

    def altitude(self, airspeed_kt: Array) -> Array | None:
        """Largest allowed altitude error [ft] at airspeeds [kt]."""
        return (
            None if self.feet is None else np.maximum(self.feet * airspeed_kt / 100.0, _LEAST_FEET)
        )


# 14 CFR 25.1323(c) and 25.1325(e); 14 CFR 23.1323(b) and 23.1325(e) as they stood before amendment
# 23-64 (2017).
_RULES = {
    "far25": Limit("FAR 25.1323(c)", 0.03, 5.0, "FAR 25.1325(e)", 30.0),
    "far23": Limit("FAR 23.1323(b)", 0.03, 5.0, "FAR 23.1325(e)", 30.0),
}


@dataclass(frozen=True, slots=True)
class Margin:
    """The smallest distance to a limit, negative beyond it, and its indicated airspeed [kt]."""

    size: float
    unit: str
    at_kt: float

    def __str__(self) -> str:
        digits = 1 if self.unit == "kt" else 0
        return f"{abs(self.size):.{digits}f} {self.unit} (at {self.at_kt:.0f} KIAS)"


@dataclass(frozen=True, slots=True)
class LimitJudgment:
    """A curve against one limit: its margin alone, and that with its ±2σ bound."""

    rule: str
    allows: str
    alone: Margin
    with_bound: Margin

    @property
    def verdict(self) -> str:
        """`inside` with the bound, `open` where only the bound exceeds the limit, or `outside`."""
        return (
            "inside"
            if self.with_bound.size >= 0.0
            else "open"
            if self.alone.size >= 0.0
            else "outside"
        )

    @property
    def sentence(self) -> str:
        """The judgment in one sentence."""
        said = {
            "inside": f"Inside {self.rule}, ±2σ included: closest {self.with_bound} to spare",
            "open": f"Not shown to be inside {self.rule}: the ±2σ reaches {self.with_bound} "
            "beyond; fly more before relying on the curve",
            "outside": f"Outside {self.rule} by up to {self.alone}",
        }
        return f"{said[self.verdict]}. The rule allows {self.allows}."


def limit_named(text: str) -> Limit | str | None:
    """Return the limit of a flag.

    `far25`, `far23`, `none` (None), `auto` (itself), or your own such as `2%,3kt,40ft`.

    In an own limit, the altitude error [ft] is for each 100 kt and may be left out. Raises
    BadInputError for any other text.
    """
    if text in _RULES:
        return _RULES[text]
    if text in (AUTO, NONE):
        return AUTO if text == AUTO else None
    parts = _OWN.fullmatch(text)
    if parts is None:
        raise BadInputError(
            f"--limit {text!r}: give auto, far25, far23, none, or your own as "
            "PERCENT%,KNOTSkt[,FEETft], such as 2%,3kt,30ft (the altitude error is for each 100 kt)"
        )
    feet = float(parts["feet"]) if parts["feet"] else None
    return Limit(_OWN_NAME, float(parts["percent"]) / 100.0, float(parts["knots"]), _OWN_NAME, feet)


def limit_for(result: Calibration, limit: Limit | str | None = AUTO) -> Limit | None:
    """Return the limit that judges a curve: the one given, else FAR 23 or 25 by the Mach number.

    Both are rules of airplanes, for their speeds: none judges a drone or a glider.
    """
    if not isinstance(limit, str):
        return limit
    other_kind = any(each.kind for each in result.provenance.inputs)
    if other_kind or result.curve.indicated_airspeed[-1] < _SLOWEST_KT * KNOT:
        return None
    fast = result.mach >= _TRANSPORT
    return replace(
        _RULES["far25" if fast else "far23"],
        why=f" (the log {'reaches' if fast else 'stays below'} Mach 0.6)",
    )


def judgments(result: Calibration, limit: Limit | str | None = AUTO) -> list[LimitJudgment]:
    """Return the curve against the limit of airspeed, and of altitude if the static source errs.

    The log has to show that.
    """
    chosen = limit_for(result, limit)
    if chosen is None or not result.usable:  # no rule judges an answer that is not to be used
        return []
    curve = result.curve
    speed = curve.indicated_airspeed / KNOT
    own = f"{100.0 * chosen.share:g} % and {chosen.knots:g}{QUOTED}kt"
    words = f"the larger of {own}{chosen.why}"
    left = chosen.airspeed(speed) - np.abs(curve.correction) / KNOT
    found = [_judged(chosen.name, words, speed, left, curve.two_sigma / KNOT, "kt")]
    allowed = chosen.altitude(speed)
    if allowed is not None and curve.altitude_correction is not None and not result.place_assumed:
        # The rules hold at sea level, where a pressure error is fewer feet than at altitude.
        scale = _FEET_A_PASCAL * impact_pressure(curve.indicated_airspeed + curve.correction)
        left = allowed - np.abs(curve.normalized_pressure_error) * scale
        words = (
            f"{chosen.feet:g}{QUOTED}ft for each 100{QUOTED}kt at sea level, 30{QUOTED}ft or more"
        )
        bound = curve.normalized_two_sigma * scale
        found.append(_judged(chosen.altitude_name, words, speed, left, bound, "ft"))
    return found


def judgments_json(result: Calibration, limit: Limit | str | None = AUTO) -> list[dict[str, Any]]:
    """The same as plain data; the unit of the margins is in their keys."""
    return [
        {
            "rule": each.rule,
            "verdict": each.verdict,
            f"margin_{each.with_bound.unit}": each.with_bound.size,
            f"margin_of_curve_alone_{each.alone.unit}": each.alone.size,
            "at_kias": each.with_bound.at_kt,
        }
        for each in judgments(result, limit)
    ]


def _judged(
    rule: str, allows: str, speed_kt: Array, left: Array, bound: Array, unit: str
) -> LimitJudgment:
    """The judgment of what an error leaves of a limit at airspeeds, and of its bound there."""
    places = [(margin, int(np.argmin(margin))) for margin in (left, left - bound)]
    return LimitJudgment(
        rule, allows, *(Margin(float(m[at]), unit, float(speed_kt[at])) for m, at in places)
    )
