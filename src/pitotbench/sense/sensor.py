"""What a sensor does to the truth, one small function a piece: error, noise, range, resolution."""

from zlib import crc32

import numpy as np

from pitotbench.channels import CHANNELS, Channel
from pitotbench.pressure_error import MODELS, PressureErrorCurve, PressureErrorRangeError, TableCurve
from pitotbench.records.case import DataSystem, PressureErrorSpec
from pitotbench.records.errors import BadInputError
from pitotbench.units import Array, Pascal

Curve = PressureErrorCurve | TableCurve

PLAIN = tuple(c for c in CHANNELS.values() if c.noise is not None)  # sensors that only add noise and round


def known_curve(spec: PressureErrorSpec) -> Curve:
    """The pressure error that a case injects.

    Raises UnknownNameError for an unknown model, BadInputError for parameters that do not fit it.
    """
    try:
        if spec.model == "table":
            return TableCurve(spec.airspeed, spec.values)
        return PressureErrorCurve(MODELS[spec.model], spec.parameters, spec.reference_pressure)
    except ValueError as error:
        known = spec.model == "table" or spec.model in MODELS
        raise (BadInputError(str(error)) if known else error) from error


def indicated_impact_pressure(impact_pressure: Pascal, curve: Curve) -> Pascal:
    """What the transducer sees, q_ci = q_c − Δp, of the true impact pressure [Pa].

    Δp = q_c − q_ci = q_c f(q_ci/q_ref): where Δp is positive the airplane flies faster than it reads. The error
    sits in the impact pressure alone, as the source injects it; the static channel reads the true pressure.
    Raises BadInputError where the error cannot be applied.
    """
    try:
        return curve.indicated_impact_pressure(impact_pressure)
    except PressureErrorRangeError as error:
        raise BadInputError(str(error)) from error


def deviation(channel: Channel, das: DataSystem) -> float:
    """Standard deviation of a plain channel's white noise [SI]."""
    return float(getattr(das, channel.noise)) if isinstance(channel.noise, str) else channel.noise or 0.0


def resolution(channel: Channel, das: DataSystem) -> float:
    """Smallest step of a plain channel [SI]; 0 means none."""
    return float(getattr(das, channel.resolution)) if isinstance(channel.resolution, str) else channel.resolution


def noise_stream(seed: int, channel: str, das: DataSystem) -> np.random.Generator:
    """A channel's own random stream.

    The spawn key of `SeedSequence.spawn` is a running number; here it is made of the channel's name and the
    rates, so that a new channel moves no other one's noise and another rate is another draw.
    """
    key = (crc32(channel.encode()), round(das.air_rate * 1e6), round(das.gps_rate * 1e6))
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=key))


def add_noise(values: Array, deviation: float, stream: np.random.Generator) -> Array:
    """White noise of a standard deviation on top; 0 leaves the values alone."""
    if deviation == 0.0:
        return values
    noise = stream.standard_normal(len(values))
    noise *= deviation
    noise += values
    return noise


def saturate(values: Array, low: float, high: float) -> Array:
    """Hold values at the ends of the sensor's range."""
    return np.clip(values, low, high)


def quantize(values: Array, resolution: float) -> Array:
    """Round to multiples of a resolution; 0 means none.

    Where the resolution is one over a whole number, dividing gives the nearest double to the decimal number,
    which takes few digits to write; multiplying would not.
    """
    if resolution == 0.0:
        return values
    per_unit = 1.0 / resolution
    if abs(per_unit - round(per_unit)) < 1e-9 * per_unit:
        whole = float(round(per_unit))
        return np.rint(values * whole) / whole
    return np.rint(values * per_unit) * resolution
