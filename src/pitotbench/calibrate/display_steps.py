"""The share of the bound that the steps of a display make: what the residual of a log cannot show.

On a steady leg a display shows one number, which is wrong by up to half a step and never scatters. Near each
airspeed the mean of the readings errs as the mean of so many independent rounding errors as there are different
readings; a reading that stands for long counts once.

Where gusts move the reading to and fro, its rounding errors change from row to row. They are then part of the
residual, which the bound already holds, and their mean is nearly zero. With a scatter of σ steps the share of the
mean's variance that stays is the sum over k of 6/(π k)² |φ(2π k)|², where φ is the characteristic function of what
moves the reading (B. Widrow and I. Kollár, Quantization Noise, 2008). No shape is assumed for it: the share is that
of a sinusoid, whose envelope |φ(2π k)|² <= 1/(√2 π² k σ) falls slowest of the usual ones.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from pitotbench import air
from pitotbench.records.calibration import Calibration
from pitotbench.records.log import FlightLog
from pitotbench.units import KNOT, Array, MetersPerSecond, Seconds

_NEAR = 10.0 * KNOT  # m/s: readings that decide about the curve at an airspeed
_ROUNDING = 1.0 / np.sqrt(12.0)  # standard deviation of an error that is uniform over a step
_WINDOW = 10.0  # s: scatter within it is that of gusts, not a change of the maneuver's airspeed
_FEWEST = 5  # rows of a window that tell a scatter
_ORDERS = np.arange(1.0, 51.0)


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
    velocity = (log.velocity_north, log.velocity_east)
    readings = {"airspeed_mps": (speed, (speed,)), "ground_speed_mps": (np.hypot(*velocity), velocity)}
    for name, (shown, channels) in readings.items():
        step = steps.get(name, 0.0)
        if not isinstance(step, int | float) or not step > 0.0:
            continue
        stays = share_that_stays(log.time, shown / step)
        near = [np.abs(speed - at) < _NEAR for at in indicated_airspeed]
        left = [min(np.mean(stays[rows]), 1.0 / _different(channels, rows)) if rows.any() else 1.0 for rows in near]
        variance += (_ROUNDING * step) ** 2 * np.array(left)
    return np.asarray(2.0 * np.sqrt(variance))


def share_that_stays(time: Seconds, reading: Array) -> Array:
    """Return the share of the rounding variance that the mean of a reading keeps, (n,), from 0 to 1.

    `reading` (n,) is in steps. A reading that stands still keeps 1. The scatter is taken within windows of ten
    seconds, less the variance of the rounding itself (Sheppard's correction); a window of few rows keeps 1.
    """
    _, window, count = np.unique((time - time[0]) // _WINDOW, return_inverse=True, return_counts=True)
    mean = np.bincount(window, reading) / count
    squares = np.bincount(window, (reading - mean[window]) ** 2) / np.maximum(count - 1, 1)
    scatter = np.sqrt(np.maximum(squares - _ROUNDING**2, 0.0))
    scatter[count < _FEWEST] = 0.0
    with np.errstate(divide="ignore"):
        envelope = np.minimum(1.0, 1.0 / (np.sqrt(2.0) * np.pi**2 * _ORDERS[:, None] * scatter))
    kept = np.sum(envelope / _ORDERS[:, None] ** 2, axis=0) / np.sum(1.0 / _ORDERS**2)
    return np.asarray(kept[window])


def _different(channels: tuple[Array, ...], near: Array) -> float:
    """Return how many different readings the chosen rows hold, a reading of many rows counting once; at least 1."""
    _, counts = np.unique(np.stack([c[near] for c in channels]), axis=1, return_counts=True)
    return float(counts.sum() ** 2 / np.sum(counts.astype(np.float64) ** 2))
