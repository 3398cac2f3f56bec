"""Time series of the sensors, and how instruments respond: lags, delays, static source errors.

The input of a lag or a delay is taken as linear between samples, for which the response is exact; a
hold would be half a sample late. Each stretch of the recording begins in its steady state.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import accumulate
from types import MappingProxyType

import numpy as np

from pitotbench.records import BadInputError
from pitotbench.timeline import gaps, interval, stretches
from pitotbench.units import Array, Pascal, Seconds


@dataclass(frozen=True, slots=True)
class Signals:
    """Channels [SI, radians], (n,) each, over one time base [s] of nearly constant rate.

    The time base may have gaps.

    Names are those of a `FlightLog` (`impact_pressure`, `velocity_north` …); any may be missing.
    Raises BadInputError where lengths differ or time does not increase.
    """

    time: Seconds
    channels: Mapping[str, Array]

    def __post_init__(self) -> None:
        if len(self.time) < 2 or not bool(np.all(np.diff(self.time) > 0.0)):
            raise BadInputError(
                "signals need at least two samples, and time that increases strictly"
            )
        for name, values in self.channels.items():
            if values.shape != self.time.shape:
                raise BadInputError(
                    f"channel {name} has {values.shape} samples, time has {self.time.shape}"
                )
        object.__setattr__(self, "channels", MappingProxyType(dict(self.channels)))

    def __getitem__(self, name: str) -> Array:
        return self.channels[name]

    def __contains__(self, name: str) -> bool:
        return name in self.channels

    def __iter__(self) -> Iterator[str]:
        return iter(self.channels)

    def __len__(self) -> int:
        return len(self.time)

    def require(self, effect: str, names: tuple[str, ...]) -> None:
        """Raise BadInputError that names the channels which an effect needs and lacks."""
        missing = [name for name in names if name not in self.channels]
        if missing:
            raise BadInputError(
                f"effect {effect!r} needs the channel{'s' if len(missing) > 1 else ''} "
                f"{', '.join(missing)}; record them, or leave the effect out"
            )

    def with_channels(self, **changed: Array) -> "Signals":
        """Return the signals with some channels replaced."""
        return replace(self, channels={**self.channels, **changed})

    @property
    def interval(self) -> float:
        """The median time between samples [s]."""
        return interval(self.time)

    def stretches(self) -> list[slice]:
        """Return the rows of each stretch without a gap."""
        return stretches(self.time, gaps(self.time))


def first_order(signals: Signals, values: Array, lag: float) -> Array:
    """Return the values [any unit], (n,), behind a first-order lag [s], dy/dt = (u − y)/lag.

    Ramp-invariant discretization (Franklin, Powell and Workman, Digital Control of Dynamic Systems,
    §6.3).
    """
    if lag <= 0.0:
        return values
    ratio = signals.interval / lag
    pole = float(np.exp(-ratio))
    share = -float(np.expm1(-ratio)) / ratio
    return _by_stretch(
        signals, values, np.array([1.0 - share, share - pole]), np.array([1.0, -pole])
    )


def second_order(signals: Signals, values: Array, lag: float, damping: float) -> Array:
    """Return the values, (n,), behind a second-order line.

    `lag` [s] is the delay of a ramp, 2 damping/natural frequency; `damping` [-] is the damping
    ratio.
    """
    if lag <= 0.0:
        return values
    from scipy.signal import cont2discrete

    frequency = 2.0 * damping / lag
    line = (
        np.array([frequency**2]),
        np.array([1.0, 2.0 * damping * frequency, frequency**2]),
    )
    # A first-order hold is the discretization for an input that is linear between samples.
    numerator, denominator, _ = cont2discrete(line, signals.interval, method="foh")
    return _by_stretch(signals, values, numerator.ravel(), denominator)


def delayed(signals: Signals, values: Array, delay: Array | float, angle: bool = False) -> Array:
    """Return the values, (n,), as they were `delay` [s] before, linear between samples.

    The first value of a stretch is held where the delay reaches before it. `angle` marks values in
    radians that start again at a full turn.
    """
    # An angle is unwrapped first: halfway between 359° and 1° lies 0°, not 180°.
    smooth = np.unwrap(values) if angle else values
    late = np.broadcast_to(np.asarray(delay, dtype=np.float64), values.shape)
    out = np.empty_like(smooth)
    for part in signals.stretches():
        time = signals.time[part]
        out[part] = np.interp(time - late[part], time, smooth[part])
    return np.mod(out, 2.0 * np.pi) if angle else out


def _by_stretch(signals: Signals, values: Array, numerator: Array, denominator: Array) -> Array:
    from scipy.signal import lfilter  # slow to load: not with the table of effects

    out = np.empty_like(values)
    for part in signals.stretches():
        start = values[part][0]
        # The flight begins steady: there is no difference before.
        out[part] = start + lfilter(numerator, denominator, values[part] - start)
    return out


def first_order_varying(signals: Signals, values: Array, lag: Array) -> Array:
    """Return the values, (n,), behind a first-order lag (n,) [s] that changes in time.

    The lag is above 0.
    """
    out = np.empty_like(values)
    for part in signals.stretches():
        # The same formula as in `first_order`, with the lag of each step; a filter of constant taps
        # cannot do it.
        u, ratio = values[part], np.diff(signals.time[part]) / lag[part][1:]
        pole, share = np.exp(-ratio), -np.expm1(-ratio) / ratio
        driven = ((share - pole) * u[:-1] + (1.0 - share) * u[1:]).tolist()
        steps = zip(pole.tolist(), driven, strict=True)
        followed = accumulate(steps, lambda y, step: step[0] * y + step[1], initial=float(u[0]))
        out[part] = np.fromiter(followed, dtype=np.float64, count=len(u))
    return out


def displaced(signals: Signals, error: Pascal) -> Signals:
    """Return the signals with the static pressure too high by an error [Pa], (n,).

    The total pressure stays, so the impact pressure (total minus static) falls by as much (Gracey
    1980, NASA RP-1046, ch. 3).
    """
    return signals.with_channels(
        static_pressure=signals["static_pressure"] + error,
        impact_pressure=signals["impact_pressure"] - error,
    )


def play(values: Array, width: float) -> Array:
    """Return values, (n,), through the play operator, half a width [same unit] behind the input.

    Where the input turns back, the output stays until the input has moved by a whole width.
    """
    half = 0.5 * width
    followed = accumulate(values.tolist(), lambda output, u: min(max(output, u - half), u + half))
    return np.fromiter(followed, dtype=np.float64, count=len(values))
