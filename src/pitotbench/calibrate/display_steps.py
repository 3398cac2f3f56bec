"""The share of the bound that the steps of a display make: what the residual of a log cannot show.

On a steady leg a display shows one number, which is wrong by up to half a step and never scatters. Near each
airspeed the mean of the readings errs as the mean of so many independent rounding errors as there are different
readings; a reading that stands for long counts once.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from pitotbench import air
from pitotbench.records.calibration import Calibration
from pitotbench.records.log import FlightLog
from pitotbench.units import KNOT, Array, MetersPerSecond

_NEAR = 10.0 * KNOT  # m/s: readings that decide about the curve at an airspeed
_ROUNDING = 1.0 / np.sqrt(12.0)  # standard deviation of an error that is uniform over a step


def with_display_steps(calibration: Calibration, log: FlightLog) -> Calibration:
    """Return a calibration whose curve has the steps of the log's display in its bounds; as it is without any.

    The header's table `display` holds the steps: `airspeed_mps` and `ground_speed_mps`.
    """
    steps = log.header.get("display", {})
    if not isinstance(steps, Mapping) or not steps:
        return calibration
    curve = calibration.curve
    added = display_two_sigma(log, curve.indicated_airspeed, steps)
    if not np.any(added):
        return calibration
    wider = np.hypot(1.0, added / curve.two_sigma)
    widened = replace(
        curve,
        two_sigma=curve.two_sigma * wider,
        simultaneous_two_sigma=curve.simultaneous_two_sigma * wider,
        normalized_two_sigma=curve.normalized_two_sigma * wider,
        altitude_two_sigma=None if curve.altitude_two_sigma is None else curve.altitude_two_sigma * wider,
    )
    words = f"the steps of the display add up to {float(added.max()) / KNOT:.2f} kt to the bound, as squares"
    return replace(calibration, curve=widened, warnings=(*calibration.warnings, words))


def display_two_sigma(
    log: FlightLog, indicated_airspeed: MetersPerSecond, steps: Mapping[str, float]
) -> MetersPerSecond:
    """Return 2σ [m/s] that the steps of a display leave in the correction at indicated airspeeds, (c,) [m/s]."""
    speed = np.asarray(air.calibrated_airspeed(log.impact_pressure))
    variance = np.zeros(len(indicated_airspeed))
    readings = {"airspeed_mps": (speed,), "ground_speed_mps": (log.velocity_north, log.velocity_east)}
    for name, channels in readings.items():
        step = steps.get(name, 0.0)
        if not isinstance(step, int | float) or not step > 0.0:
            continue
        counts = np.array([_different(channels, np.abs(speed - at) < _NEAR) for at in indicated_airspeed])
        variance += (_ROUNDING * step) ** 2 / counts
    return np.asarray(2.0 * np.sqrt(variance))


def _different(channels: tuple[Array, ...], near: Array) -> float:
    """Return how many different readings the chosen rows hold, a reading of many rows counting once; at least 1."""
    if not near.any():
        return 1.0
    _, counts = np.unique(np.stack([c[near] for c in channels]), axis=1, return_counts=True)
    return float(counts.sum() ** 2 / np.sum(counts.astype(np.float64) ** 2))
