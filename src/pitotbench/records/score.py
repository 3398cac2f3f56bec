"""How a calibration did against a truth that only a simulator knows."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Score:
    """Errors against the truth: `curve_rms_error` and `wind_error` [m/s], `curve_coverage` the share of curve points
    inside 2σ, over the stated airspeed range; `on_condition_share` of the flight; `minutes` flown; `samples` fitted.
    """

    minutes: float
    samples: int
    residual_two_sigma: float
    two_sigma: float
    curve_rms_error: float
    wind_error: float
    curve_coverage: float
    on_condition_share: float
