"""The height of a log between the fixes of its receiver."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pitotbench.calibration.observations import DENSE, FEWEST_FIXES
from pitotbench.records.log import FlightLog
from pitotbench.timeline import interval, pauses, stretch_numbers
from pitotbench.units import Booleans, Meters, MetersPerSecond, Seconds


@dataclass(frozen=True, slots=True)
class CarriedHeight:
    """Height at every row of the log, from the fixes.

    `height` [m] is interpolated or the integral of the vertical velocity, and NaN where unknown.
    `part` is the stretch of every row. `fresh` marks new fixes, `fixes` are their rows, and
    `seconds` the usual interval between them. `offsets` [m] is the receiver's height minus the
    integral at `fixes`, None without vertical velocity.
    """

    height: Meters
    part: NDArray[np.intp]
    fresh: Booleans
    fixes: NDArray[np.intp]
    seconds: float
    offsets: Meters | None


def carried_height(log: FlightLog, latency: float, by_velocity: bool) -> CarriedHeight:
    """Compute the height of each stretch separately, with fixes `latency` seconds earlier than
    stamped.
    """
    from scipy.interpolate import CubicSpline  # slow to load

    assert log.altitude is not None
    fresh = log.fresh_fixes()
    part = stretch_numbers(log.time, pauses(log.time))
    dense = bool(fresh.mean() > DENSE)
    height, at_fixes, offsets = np.full(len(log), np.nan), [], []
    for number in range(int(part[-1]) + 1):
        fixes = np.flatnonzero((part == number) & fresh)
        if len(fixes) < FEWEST_FIXES:
            continue
        knots, measured = log.time[fixes] - latency, log.altitude[fixes]
        inside = np.flatnonzero((part == number) & (log.time >= knots[0]) & (log.time <= knots[-1]))
        if by_velocity:
            assert log.velocity_down is not None
            integral, height[inside] = _integrated(
                knots, -log.velocity_down[fixes], log.time[inside], dense
            )
            start = float(np.median(measured - integral))
            height[inside] += start
            at_fixes.append(fixes)
            offsets.append(measured - integral - start)
        else:
            curve = np.interp(log.time[inside], knots, measured) if dense else None
            height[inside] = (
                CubicSpline(knots, measured)(log.time[inside]) if curve is None else curve
            )
    seconds = interval(log.time[fresh])
    fixes = np.concatenate(at_fixes) if at_fixes else np.flatnonzero(fresh)
    return CarriedHeight(
        height, part, fresh, fixes, seconds, np.concatenate(offsets) if offsets else None
    )


def _integrated(
    knots: Seconds, climb: MetersPerSecond, time: Seconds, dense: bool
) -> tuple[Meters, Meters]:
    """The integral [m] of a climb rate given at knots, at the knots and at other times."""
    from scipy.interpolate import CubicSpline  # slow to load

    if dense:
        rises = np.concatenate([[0.0], np.cumsum(0.5 * (climb[1:] + climb[:-1]) * np.diff(knots))])
        return rises, np.interp(time, knots, rises)
    integral = CubicSpline(knots, climb).antiderivative()
    return integral(knots), integral(time)
