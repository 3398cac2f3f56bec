"""How instruments respond in time, exactly: the input is taken as linear between samples, so nothing is half a
sample late. A stretch begins settled; a pause in the recording begins a new stretch."""

from itertools import accumulate

import numpy as np

from pitotbench.effects.signals import Signals
from pitotbench.units import Array


def first_order(signals: Signals, values: Array, lag: float) -> Array:
    """The values [any unit] behind a first-order lag [s]: dy/dt = (u − y)/lag, ramp-invariant discretization
    (Franklin, Powell and Workman, Digital Control of Dynamic Systems, §6.3)."""
    if lag <= 0.0:
        return values
    ratio = signals.interval / lag
    pole = float(np.exp(-ratio))
    share = -float(np.expm1(-ratio)) / ratio
    return _by_stretch(signals, values, np.array([1.0 - share, share - pole]), np.array([1.0, -pole]))


def second_order(signals: Signals, values: Array, lag: float, damping: float) -> Array:
    """The values behind a second-order line whose delay of a ramp is `lag` [s] = 2 damping/frequency."""
    if lag <= 0.0:
        return values
    frequency = 2.0 * damping / lag
    numerator, denominator = _ramp_invariant(frequency, damping, signals.interval)
    return _by_stretch(signals, values, numerator, denominator)


def delayed(signals: Signals, values: Array, delay: Array | float, angle: bool = False) -> Array:
    """The values as they were `delay` [s] before, linear between samples, held at the start of each stretch."""
    smooth = np.unwrap(values) if angle else values
    late = np.broadcast_to(np.asarray(delay, dtype=np.float64), values.shape)
    out = np.empty_like(smooth)
    for part in signals.stretches():
        time = signals.time[part]
        out[part] = np.interp(time - late[part], time, smooth[part])
    return np.mod(out, 2.0 * np.pi) if angle else out


def _ramp_invariant(frequency: float, damping: float, interval: float) -> tuple[Array, Array]:
    """Numerator and denominator in 1/z of 1/(s²/ω² + 2ζ s/ω + 1) for an input linear between samples."""
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
    """The values behind a first-order lag that changes from sample to sample [s, above 0], (n,) and (n,)."""
    out = np.empty_like(values)
    for part in signals.stretches():
        u, ratio = values[part], np.diff(signals.time[part]) / lag[part][1:]
        pole, share = np.exp(-ratio), -np.expm1(-ratio) / ratio
        driven = ((share - pole) * u[:-1] + (1.0 - share) * u[1:]).tolist()
        steps = zip(pole.tolist(), driven, strict=True)
        followed = accumulate(steps, lambda y, step: step[0] * y + step[1], initial=float(u[0]))
        out[part] = np.fromiter(followed, dtype=np.float64, count=len(u))
    return out
