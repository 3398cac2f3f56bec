"""Whether a curve of the pressure error can be that of an airplane, whatever its bound says."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from pitotbench.logbook.plausibility import LIMITS
from pitotbench.units import KNOT, Array, Booleans, MetersPerSecond


@dataclass(frozen=True, slots=True)
class CurveVerdict:
    """`plausible`, `doubtful` (worth a warning) or `impossible` (no answer), and a sentence that says why.

    `worst` is the Δp/q_c of the largest size among the points that pass the limit, 0 where none does;
    `indicated_airspeed` [m/s] is where it lies, 0 where none does.
    """

    kind: Literal["plausible", "doubtful", "impossible"]
    worst: float = 0.0
    indicated_airspeed: float = 0.0
    words: str = ""


def judge_curve(
    indicated_airspeed: MetersPerSecond, normalized_pressure_error: Array, normalized_two_sigma: Array
) -> CurveVerdict:
    """Judge a curve Δp/q_c over indicated airspeed [m/s] by its size; arrays of one length, (n,).

    A point passes a limit where it does so by more than its 2σ: a curve that is hardly known is not impossible.
    Impossible: above 0.2, where an airspeed would be wrong by a tenth. Doubtful: above 0.1, which is 5 kt at
    100 kt and the largest error that FAR 23.1323 accepts. The limits are those that a log is judged with.
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
