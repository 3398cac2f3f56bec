"""The errors of a calibration of a simulated flight, whose truth is known."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Score:
    """Errors against the truth, over the scored airspeed range.

    Speeds in m/s; `curve_coverage` is the share of curve points inside 2σ, `on_condition_share` that of the
    flight's samples on condition, `minutes` the recorded time, `samples` the number of rows fitted.
    """

    minutes: float
    samples: int
    residual_two_sigma: float
    two_sigma: float
    curve_rms_error: float
    wind_error: float
    curve_coverage: float
    on_condition_share: float
