"""Judgment whether a pressure-error curve is possible for an airplane."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from pitotbench.logbook.plausibility import LIMITS
from pitotbench.units import KNOT, Array, Booleans, MetersPerSecond


@dataclass(frozen=True, slots=True)
class CurveVerdict:
    """The verdict: `plausible`, `doubtful` (a warning) or `impossible` (no answer), with a sentence of explanation.

    `worst` [-] is the Δp/q_c of greatest size among the points beyond the limit, and `indicated_airspeed` [m/s] the
    airspeed at that point. Both are 0 where no point is beyond it.
    """

    kind: Literal["plausible", "doubtful", "impossible"]
    worst: float = 0.0
    indicated_airspeed: float = 0.0
    words: str = ""


def judge_curve(
    indicated_airspeed: MetersPerSecond, normalized_pressure_error: Array, normalized_two_sigma: Array
) -> CurveVerdict:
    """Judge a curve Δp/q_c over indicated airspeed [m/s] by its size; arrays of one length, (n,).

    A point is beyond a limit where it exceeds the limit by more than its 2σ: an uncertain curve is not impossible.
    Impossible: above 0.2, an error of a tenth in airspeed. Doubtful: above 0.1, which is 5 kt at 100 kt and the
    largest error that FAR 23.1323 accepts. The limits are those for the judgment of a log.
    Raises ValueError for arrays of different lengths, or for a number that is not finite.
    """
    speed, error, bound = indicated_airspeed, normalized_pressure_error, normalized_two_sigma
    if not speed.shape == error.shape == bound.shape:
        raise ValueError(f"a curve needs arrays of one length, not {speed.shape}, {error.shape}, {bound.shape}")
    if not np.all(np.isfinite([speed, error, bound])):
        raise ValueError("a curve holds a number that is not finite")
    surely = np.abs(error) - bound
    if np.any(surely > LIMITS.curve_refused):
        return _verdict("impossible", speed, error, surely > LIMITS.curve_refused)
    if np.any(surely > LIMITS.curve_doubted):
        return _verdict("doubtful", speed, error, surely > LIMITS.curve_doubted)
    return CurveVerdict("plausible")


def _verdict(
    kind: Literal["doubtful", "impossible"], speed: MetersPerSecond, error: Array, beyond: Booleans
) -> CurveVerdict:
    at = int(np.argmax(np.where(beyond, np.abs(error), -1.0)))
    reason = {
        "doubtful": "a certified airplane's is smaller: check units, gains and zeros of the log",
        "impossible": "no airplane's is so large: a unit, a gain or a zero of the log is wrong",
    }[kind]
    words = (
        f"the pressure error is {error[at]:+.0%} of the impact pressure at {speed[at] / KNOT:.0f} kt indicated; "
        f"{reason}"
    )
    return CurveVerdict(kind, float(error[at]), float(speed[at]), words)
