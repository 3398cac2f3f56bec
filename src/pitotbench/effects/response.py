"""Compute how instruments respond in time: first-order and second-order lags, and delays.

The input is taken as linear between samples, for which the response is exact; a hold would be half a sample late.
Each stretch of the recording begins settled.
"""

from itertools import accumulate

import numpy as np

from pitotbench.effects.signals import Signals
from pitotbench.units import Array


def first_order(signals: Signals, values: Array, lag: float) -> Array:
    """Return the values [any unit], (n,), behind a first-order lag [s], dy/dt = (u − y)/lag.

    Ramp-invariant discretization (Franklin, Powell and Workman, Digital Control of Dynamic Systems, §6.3).
    """
    if lag <= 0.0:
        return values
    ratio = signals.interval / lag
    pole = float(np.exp(-ratio))
    share = -float(np.expm1(-ratio)) / ratio
    return _by_stretch(signals, values, np.array([1.0 - share, share - pole]), np.array([1.0, -pole]))


def second_order(signals: Signals, values: Array, lag: float, damping: float) -> Array:
    """Return the values, (n,), behind a second-order line.

    `lag` [s] is the delay of a ramp, 2 damping/natural frequency; `damping` [-] is the damping ratio.
    """
    if lag <= 0.0:
        return values
    frequency = 2.0 * damping / lag
    numerator, denominator = _ramp_invariant(frequency, damping, signals.interval)
    return _by_stretch(signals, values, numerator, denominator)


def delayed(signals: Signals, values: Array, delay: Array | float, angle: bool = False) -> Array:
    """Return the values, (n,), as they were `delay` [s] before, linear between samples.

    The first value of a stretch is held where the delay reaches before it. `angle` marks values in radians that
    start again at a full turn.
    """
    # An angle is unwrapped first: halfway between 359° and 1° lies 0°, not 180°.
    smooth = np.unwrap(values) if angle else values
    late = np.broadcast_to(np.asarray(delay, dtype=np.float64), values.shape)
    out = np.empty_like(smooth)
    for part in signals.stretches():
        time = signals.time[part]
        out[part] = np.interp(time - late[part], time, smooth[part])
    return np.mod(out, 2.0 * np.pi) if angle else out


def _ramp_invariant(frequency: float, damping: float, interval: float) -> tuple[Array, Array]:
    """Return numerator and denominator in 1/z of 1/(s²/ω² + 2ζ s/ω + 1) for an input linear between samples."""
    from scipy.linalg import expm

    a = np.array([[0.0, 1.0], [-(frequency**2), -2.0 * damping * frequency]])
    b = np.array([0.0, frequency**2])
    block = np.zeros((4, 4))  # the state, the input, its slope a sample
    block[:2, :2], block[:2, 2], block[2, 3] = a * interval, b * interval, 1.0
    power = expm(block)
    step, now, slope = power[:2, :2], power[:2, 2], power[:2, 3]
    # x⁺ = step x + (now − slope) u + slope u⁺; output is the first state; as a ratio of polynomials:
    first, cross = now - slope, np.array([step[0, 1], -step[1, 1]])
    trace, determinant = float(np.trace(step)), float(np.linalg.det(step))
    numerator = np.array([slope[0], first[0] + cross @ slope[::-1], cross @ first[::-1]])
    return numerator, np.array([1.0, -trace, determinant])


def _by_stretch(signals: Signals, values: Array, numerator: Array, denominator: Array) -> Array:
    from scipy.signal import lfilter  # slow to load: not with the table of effects

    out = np.empty_like(values)
    for part in signals.stretches():
        start = values[part][0]
        out[part] = start + lfilter(numerator, denominator, values[part] - start)  # settled: no difference before
    return out


def first_order_varying(signals: Signals, values: Array, lag: Array) -> Array:
    """Return the values, (n,), behind a first-order lag that changes from sample to sample [s, above 0], (n,)."""
    out = np.empty_like(values)
    for part in signals.stretches():
        # The same formula as in `first_order`, with the lag of each step; a filter of constant taps cannot do it.
        u, ratio = values[part], np.diff(signals.time[part]) / lag[part][1:]
        pole, share = np.exp(-ratio), -np.expm1(-ratio) / ratio
        driven = ((share - pole) * u[:-1] + (1.0 - share) * u[1:]).tolist()
        steps = zip(pole.tolist(), driven, strict=True)
        followed = accumulate(steps, lambda y, step: step[0] * y + step[1], initial=float(u[0]))
        out[part] = np.fromiter(followed, dtype=np.float64, count=len(u))
    return out
