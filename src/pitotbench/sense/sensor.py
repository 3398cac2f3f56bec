"""The parts of a simulated sensor, one function each: pressure error, noise, range, resolution."""

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
    """Return the pressure error of a case as a curve.

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
    """Return the indicated impact pressure q_ci = q_c − Δp of a true impact pressure q_c [Pa].

    Δp = q_c f(q_ci/q_ref). Where Δp is positive, the airplane flies faster than it reads. As in the source, the
    error is in the impact pressure alone: the static channel reads the true pressure.
    Raises BadInputError where the error cannot be applied.
    """
    try:
        return curve.indicated_impact_pressure(impact_pressure)
    except PressureErrorRangeError as error:
        raise BadInputError(str(error)) from error


def deviation(channel: Channel, das: DataSystem) -> float:
    """Return the standard deviation of a plain channel's white noise [SI]."""
    return float(getattr(das, channel.noise)) if isinstance(channel.noise, str) else channel.noise or 0.0


def resolution(channel: Channel, das: DataSystem) -> float:
    """Return the smallest step of a plain channel [SI]; 0 means no rounding."""
    return float(getattr(das, channel.resolution)) if isinstance(channel.resolution, str) else channel.resolution


def noise_stream(seed: int, channel: str, das: DataSystem) -> np.random.Generator:
    """Return the random stream of one channel.

    `SeedSequence.spawn` numbers its streams in order. Here the key is made of the channel's name and the rates: a
    new channel then leaves the noise of all others as it was, and another rate is another draw.
    """
    key = (crc32(channel.encode()), round(das.air_rate * 1e6), round(das.gps_rate * 1e6))
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=key))


def add_noise(values: Array, deviation: float, stream: np.random.Generator) -> Array:
    """Return the values, (n,), with white noise of a standard deviation added; 0 adds nothing."""
    if deviation == 0.0:
        return values
    # In place: three temporary arrays a channel would cost more than the noise itself.
    noise = stream.standard_normal(len(values))
    noise *= deviation
    noise += values
    return noise


def saturate(values: Array, low: float, high: float) -> Array:
    """Return the values, (n,), limited to the sensor's range."""
    return np.clip(values, low, high)


def quantize(values: Array, resolution: float) -> Array:
    """Return the values, (n,), rounded to multiples of a resolution; 0 means no rounding."""
    if resolution == 0.0:
        return values
    # 1/resolution is often a whole number. Dividing by it gives the double nearest to the decimal number, which a
    # log writes with few digits (0.3); multiplying by the resolution does not (0.30000000000000004).
    per_unit = 1.0 / resolution
    if abs(per_unit - round(per_unit)) < 1e-9 * per_unit:
        whole = float(round(per_unit))
        return np.rint(values * whole) / whole
    return np.rint(values * per_unit) * resolution
