"""Record a flight: pass the truth through every sensor, and write the truth where asked for."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from hashlib import sha256
from itertools import accumulate
from pathlib import Path
from typing import Any
from zlib import crc32

import numpy as np

from pitotbench import air
from pitotbench.channels import CHANNELS, Channel
from pitotbench.effects import chosen
from pitotbench.effects.airframe import MASS
from pitotbench.effects.effect import SensorEffect, share_of_size
from pitotbench.effects.response import Signals
from pitotbench.logbook.columns import QUANTITIES, atomic
from pitotbench.pressure_error import MODELS
from pitotbench.pressure_error.models import PressureErrorCurve, PressureErrorRangeError, TableCurve
from pitotbench.records import BadInputError
from pitotbench.records.case import Case, DataSystem, PressureErrorSpec, rate_problem
from pitotbench.records.case_file import case_table, write_case
from pitotbench.records.flight import Flight
from pitotbench.records.log import FlightLog
from pitotbench.sensing.sampling import (
    Instants,
    Schedule,
    flight_rate,
    has_velocity_down,
    require_rates,
    schedule,
)
from pitotbench.timeline import gaps, interval, stretches
from pitotbench.units import FULL_TURN, Array, Meters, Pascal, Seconds
from pitotbench.version import version_of

Curve = PressureErrorCurve | TableCurve

# sensors that only add noise and round
PLAIN = tuple(c for c in CHANNELS.values() if c.noise is not None)


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

    Δp = q_c f(q_ci/q_ref). Where Δp is positive, the airplane flies faster than it reads. As in the
    source, the error is in the impact pressure alone: the static channel reads the true pressure.
    Raises BadInputError where the error cannot be applied.
    """
    try:
        return curve.indicated_impact_pressure(impact_pressure)
    except PressureErrorRangeError as error:
        raise BadInputError(str(error)) from error


def resolution(channel: Channel, das: DataSystem) -> float:
    """Return the smallest step of a plain channel [SI]; 0 means no rounding."""
    return (
        float(getattr(das, channel.resolution))
        if isinstance(channel.resolution, str)
        else channel.resolution
    )


def noise_stream(seed: int, channel: str, das: DataSystem) -> np.random.Generator:
    """Return the random stream of one channel.

    `SeedSequence.spawn` numbers its streams in order. Here the key is made of the channel's name
    and the rates: a new channel then leaves the noise of all others as it was, and another rate is
    another draw.
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
    # 1/resolution is often a whole number. Dividing by it gives the double nearest to the decimal
    # number, which a log writes with few digits (0.3); multiplying by the resolution does not
    # (0.30000000000000004).
    per_unit = 1.0 / resolution
    if abs(per_unit - round(per_unit)) < 1e-9 * per_unit:
        whole = float(round(per_unit))
        return np.rint(values * whole) / whole
    return np.rint(values * per_unit) * resolution


def with_height_error(flight: Flight, das: DataSystem, seed: int) -> Flight:
    """Return the flight with the receiver's slow error in its altitude, if it has one."""
    if das.altitude_drift == 0.0 or "altitude" not in flight.channels:
        return flight
    stream = noise_stream(seed, "altitude_drift", das)
    error = slow_error(flight["time"], das.altitude_drift, das.altitude_drift_time, stream)
    return replace(flight, channels={**flight.channels, "altitude": flight["altitude"] + error})


def slow_error(
    time: Seconds, deviation: float, memory: float, stream: np.random.Generator
) -> Meters:
    """Return a stationary first-order Gauss-Markov process at increasing times [s], (n,).

    `deviation` is its standard deviation and gives the unit, `memory` [s] its correlation time.
    Recorded time may have gaps, in which the process continues.
    """
    new = stream.standard_normal(len(time))
    parts, last = [], 0.0
    for rows in stretches(time, gaps(time)):
        gap = np.inf if rows.start == 0 else float(time[rows.start] - time[rows.start - 1])
        parts.append(_run(new[rows], last, gap, interval(time), memory))
        last = float(parts[-1][-1])
    return np.asarray(deviation * np.concatenate(parts))


def _run(new: Array, before: float, gap: float, step: float, memory: float) -> Array:
    """Return one stretch of unit deviation from such white noise.

    `before` is the value a gap [s] ago.
    """
    kept, across = np.exp(-step / memory), np.exp(-gap / memory)
    drive = np.sqrt(1.0 - kept**2) * new
    drive[0] = np.sqrt(1.0 - across**2) * new[0] + across * before
    # A loop of Python takes 2 ms a flight; SciPy's filter takes less, but half a second to load.
    share = float(kept)
    return np.array(list(accumulate(drive.tolist(), lambda value, more: share * value + more)))


PROBES = ("static_pressure", "impact_pressure", "total_temperature")
# prefix of the channels that hold the values at the probes with the effects in them
_FELT = "felt_"


def values_at_probes(
    flight: Flight, das: DataSystem, at: Callable[[Array], Array]
) -> dict[str, Array]:
    """Return static and indicated impact pressure and total temperature at the probes, (n,) [SI].

    Parameters: flight; das; at, a function that takes a channel of the flight to the instants
    wanted. Raises BadInputError where the case's pressure error cannot be applied.
    """
    if _FELT + PROBES[0] in flight.channels:
        return {name: at(flight[_FELT + name]) for name in PROBES}
    # The pressure error comes first; the effects then act on the indicated pressures.
    static, temperature = at(flight["static_pressure"]), at(flight["air_temperature"])
    impact = at(flight["total_pressure"]) - static
    mach = air.mach_from_impact_pressure(impact, static)
    error = flight.case.pressure_error
    indicated = indicated_impact_pressure(impact, known_curve(error))
    # Where the total pressure is right, p_i − p = q_c − q_ci; an error of the total source leaves
    # p_i alone.
    return {
        "static_pressure": static + (impact - indicated) if error.location == "static" else static,
        "impact_pressure": indicated,
        "total_temperature": air.total_temperature(temperature, mach, das.recovery_factor),
    }


def with_probe_effects(flight: Flight, das: DataSystem) -> Flight:
    """Return the flight with the case's effects on the probes, if there are any.

    Raises UnknownNameError for an unknown effect, BadInputError for impossible parameters.
    """
    choices = _sensor_effects(flight.case, after_noise=False)
    if not choices:
        return flight
    plain = {c.name: flight[c.name] for c in PLAIN if c.name in flight.channels}
    signals = Signals(flight["time"], plain | values_at_probes(flight, das, lambda values: values))
    for effect, sizes in choices:  # one after the other, in the order of the case
        signals = effect.apply(signals, sizes)
    changed = {(_FELT + name if name in PROBES else name): signals[name] for name in signals}
    return replace(flight, channels={**flight.channels, **changed})


def with_listed_mass(flight: Flight) -> Flight:
    """Return the flight with the mass of its weight sheet.

    The sheet lacks any mass that an effect or a patch of the aircraft adds.

    Otherwise the mass column would reveal the effect, and a model flown at that mass would show no
    gap.
    """
    time = flight["time"] - flight["time"][0]
    added = (
        c for c in chosen(flight.case.effects) if MASS.name in (c.effect.name, c.effect.part_of)
    )
    unlisted = flight.unlisted_mass + sum(
        c.sizes["mass_kg"] * share_of_size(c.effect, time, c.sizes) for c in added
    )
    if not np.any(unlisted) or "mass" not in flight.channels:
        return flight
    return replace(flight, channels={**flight.channels, "mass": flight["mass"] - unlisted})


def with_recorder_effects(log: FlightLog, case: Case) -> FlightLog:
    """Return the log with the case's effects on recorded samples, if there are any."""
    choices = _sensor_effects(case, after_noise=True)
    if not choices:
        return log
    channels = {
        name: values
        for name, values in log.channels().items()
        if values.dtype == float and name != "time"
    }
    signals = Signals(log.time, channels)
    for effect, sizes in choices:
        signals = effect.apply(signals, sizes)
    changed: dict[str, Any] = dict(signals.channels)
    return replace(log, **changed)


def _sensor_effects(
    case: Case, after_noise: bool
) -> list[tuple[SensorEffect, Mapping[str, float]]]:
    found = [
        (c.effect, c.sizes) for c in chosen(case.effects) if isinstance(c.effect, SensorEffect)
    ]
    return [(effect, sizes) for effect, sizes in found if effect.after_noise == after_noise]


# Fields of a Case that the calibrator is to find, and that no log holds.
TRUTH_FIELDS = ("pressure_error", "wind", "effects")
# The simulated sensors have noise, resolution and effects, but no other constant error: 2σ
# of each.
EXACT = {
    "temperature_k": 0.0,
    "recovery_factor": 0.0,
    "static_pressure_pa": 0.0,
    "velocity_mps": 0.0,
    "total_source": 0.0,
}
# Nor has their receiver a filter or a late height, or their static source an error of its own in
# turns: 1σ of the priors of a calibration.
EXACT_COLUMNS = {"receiver_smoothing_s2": 0.0, "turn_lift": 0.0, "height_latency_s": 0.0}
# What a flight has to hold: for a calibration, and for a log with every column.
CALIBRATION_CHANNELS = (
    "total_pressure", "static_pressure", "air_temperature", "altitude",
    "velocity_north", "velocity_east", "velocity_down",
)  # fmt: skip
LOG_CHANNELS = tuple(dict.fromkeys((*CALIBRATION_CHANNELS, *(channel.name for channel in PLAIN))))


def record(
    flight: Flight, das: DataSystem, sensor_seed: int, velocity_down: bool | None = None
) -> FlightLog:
    """Record a flight with a data system. One flight, system and seed give one log, bit for bit.

    The order is: truth, pressure error, the case's effects on the probes, latency, white noise,
    range, resolution, the case's effects on the samples. GPS velocity and altitude are sampled at
    the GPS rate and each fix is repeated until the next. `velocity_down` says whether that channel
    is recorded; None means as the system does. Raises BadInputError where the rates do not fit the
    flight or the pressure error cannot be applied.
    """
    require_rates(das, flight_rate(flight["time"]))
    if problem := rate_problem(flight.case.integration_rate, das.air_rate):
        raise BadInputError(f"data system {das.label}: {problem}")
    flight = with_height_error(with_probe_effects(with_listed_mass(flight), das), das, sensor_seed)
    when = schedule(flight["time"], das.air_rate, das.gps_rate, das.air_latency, das.gps_latency)
    down = has_velocity_down(das) if velocity_down is None else velocity_down
    plain = [c for c in PLAIN if c.name in flight.channels and (down or c.name != "velocity_down")]
    log = FlightLog(
        time=when.time,
        **_air_data(flight, das, when.air, sensor_seed),
        **{c.name: _plain(flight[c.name], c, das, when, sensor_seed) for c in plain},
        gps_fresh=when.fresh,
        segment=flight.segment[when.rows.below],
        on_condition=flight.on_condition[when.rows.below],
        header=header(flight.case, das, sensor_seed),
    )
    return with_recorder_effects(log, flight.case)


def _air_data(flight: Flight, das: DataSystem, when: Instants, seed: int) -> dict[str, Array]:
    """Return impact pressure, static pressure and total temperature as recorded [SI]."""
    probes = values_at_probes(flight, das, when.of)
    static, indicated, probe = (probes[name] for name in PROBES)

    def noisy(name: str, values: Array, deviation: float) -> Array:
        return add_noise(values, deviation, noise_stream(seed, name, das))

    # Noise comes before the range: a sensor at its end shows no noise beyond it.
    indicated = saturate(
        noisy("impact_pressure", indicated, das.impact_pressure_noise),
        0.0,
        das.impact_pressure_range,
    )
    static = noisy("static_pressure", static, das.static_pressure_noise)
    probe = noisy("total_temperature", probe, das.temperature_noise)
    return {
        "impact_pressure": quantize(indicated, das.impact_pressure_resolution),
        "static_pressure": quantize(static, das.static_pressure_resolution),
        "total_temperature": quantize(probe, das.temperature_resolution),
    }


def _plain(truth: Array, channel: Channel, das: DataSystem, when: Schedule, seed: int) -> Array:
    """Return one channel whose sensor only adds noise and rounds."""
    by_gps = channel.source == "gps"  # a fix at the GPS rate, held until the next
    instants = when.gps if by_gps else when.rows
    # A heading is unwrapped before interpolation: halfway between 359° and 1° lies 0°, not 180°.
    values = instants.of(np.unwrap(truth) if channel.wraps else truth)
    deviation = (
        float(getattr(das, channel.noise))
        if isinstance(channel.noise, str)
        else channel.noise or 0.0
    )
    values = add_noise(values, deviation, noise_stream(seed, channel.name, das))
    if channel.wraps:
        values = np.mod(values, FULL_TURN)
    values = quantize(values, resolution(channel, das))
    return values[when.fix] if by_gps else values


def header(case: Case, das: DataSystem, sensor_seed: int) -> dict[str, Any]:
    """Return a synthetic log's header: versions, seeds, accuracies, the case without its truth.

    A digest of the whole case is in it, so that a truth file can be matched to its log.
    """
    public = case_table(case, omit=(*TRUTH_FIELDS, "das", "accuracy", "truth_seed", "sensor_seed"))
    system = {**case_table(Case(das=das))["das"], "name": das.label}
    return {
        "format": "pitotbench flight log 1",
        "versions": {name: version_of(name) for name in ("pitotbench", "jsbsim", "numpy")},
        "seeds": {"truth": case.truth_seed, "sensor": sensor_seed},
        "case": {**public, "das": system},
        "case_sha256": sha256(write_case(case).encode()).hexdigest(),
        "accuracy": {**EXACT, **case.accuracy},
        "priors": EXACT_COLUMNS,
    }


_CASE = b"pitotbench case"
_TRUE = "true_"  # prefix of all columns, so that no reader takes a truth file for a log


def truth_path(log_path: Path | str) -> Path:
    """Return the path of the truth of a log: `<name>.truth.parquet` in the same folder."""
    path = Path(log_path)
    return path.with_name(f"{path.stem}.truth.parquet")


def write_truth(flight: Flight, log_path: Path | str) -> Path:
    """Write channels [SI], labels and the case of a flight next to its log, and return the path.

    Columns have the prefix `true_` and, where a log has the quantity, the suffix of its unit. An
    error leaves no incomplete file.
    """
    import pyarrow as pa
    from pyarrow import parquet

    columns = {_column(name): values for name, values in flight.channels.items()}
    table = pa.table({**columns, "segment": flight.segment, "on_condition": flight.on_condition})
    target = truth_path(log_path)
    with atomic(target) as temporary:
        metadata = {_CASE: write_case(flight.case).encode()}
        parquet.write_table(table.replace_schema_metadata(metadata), temporary, compression="zstd")
    return target


def _column(name: str) -> str:
    return _TRUE + (QUANTITIES[name].column if name in QUANTITIES else name)
