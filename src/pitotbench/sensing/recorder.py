"""Record a flight: pass the truth through every sensor, and write the truth to a file of its own on request."""

from hashlib import sha256
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

from pitotbench.channels import Channel
from pitotbench.logbook.columns import QUANTITIES, atomic
from pitotbench.records import BadInputError
from pitotbench.records.case import Case, DataSystem, rate_problem
from pitotbench.records.case_file import case_table, read_case, write_case
from pitotbench.records.flight import Flight
from pitotbench.records.log import FlightLog
from pitotbench.sensing.sampling import Instants, Schedule, flight_rate, has_velocity_down, require_rates, schedule
from pitotbench.sensing.sensors import (
    PLAIN,
    PROBES,
    add_noise,
    deviation,
    noise_stream,
    quantize,
    resolution,
    saturate,
    values_at_probes,
    with_height_error,
    with_listed_mass,
    with_probe_effects,
    with_recorder_effects,
)
from pitotbench.units import Array

# Record a flight: pass the truth through every sensor and write the samples on one time base.

TRUTH_FIELDS = ("pressure_error", "wind", "effects")  # of a Case: what the calibrator is to find, so not in a log

# The simulated sensors have noise, resolution and effects, but no constant error beside those: 2σ of each.
EXACT = {"temperature_k": 0.0, "recovery_factor": 0.0, "static_pressure_pa": 0.0, "velocity_mps": 0.0}

# What a flight has to hold: for a calibration, and for a log with every column.
CALIBRATION_CHANNELS = (
    "total_pressure", "static_pressure", "air_temperature", "altitude",
    "velocity_north", "velocity_east", "velocity_down",
)  # fmt: skip

LOG_CHANNELS = tuple(dict.fromkeys((*CALIBRATION_CHANNELS, *(channel.name for channel in PLAIN))))

_FULL_TURN = 2.0 * np.pi


def record(flight: Flight, das: DataSystem, sensor_seed: int, velocity_down: bool | None = None) -> FlightLog:
    """Record a flight with a data system. One flight, system and seed give one log, bit for bit.

    The order is: truth, pressure error, the case's effects on the probes, latency, white noise, range, resolution,
    the case's effects on the samples. GPS velocity and altitude are sampled at the GPS rate and each fix is
    repeated until the next. `velocity_down` says whether that channel is recorded; None means as the system does.
    Raises BadInputError where the rates do not fit the flight or the pressure error cannot be applied.
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
        noisy("impact_pressure", indicated, das.impact_pressure_noise), 0.0, das.impact_pressure_range
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
    values = add_noise(values, deviation(channel, das), noise_stream(seed, channel.name, das))
    if channel.wraps:
        values = np.mod(values, _FULL_TURN)
    values = quantize(values, resolution(channel, das))
    return values[when.fix] if by_gps else values


def header(case: Case, das: DataSystem, sensor_seed: int) -> dict[str, Any]:
    """Return the header of a synthetic log: versions, seeds, accuracies, and the case without its truth.

    It holds a digest of the whole case, so that a truth file can be matched to its log.
    """
    public = case_table(case, omit=(*TRUTH_FIELDS, "das", "accuracy", "truth_seed", "sensor_seed"))
    system = {**case_table_of_system(das), "name": das.label}
    return {
        "format": "pitotbench flight log 1",
        "versions": {name: _version(name) for name in ("pitotbench", "jsbsim", "numpy")},
        "seeds": {"truth": case.truth_seed, "sensor": sensor_seed},
        "case": {**public, "das": system},
        "case_sha256": case_digest(case),
        "accuracy": {**EXACT, **case.accuracy},
    }


def case_table_of_system(das: DataSystem) -> dict[str, Any]:
    """Return a data system as a plain table whose keys end in units."""
    table: dict[str, Any] = case_table(Case(das=das))["das"]
    return table


def case_digest(case: Case) -> str:
    """Return the SHA-256 of the whole case as TOML text, in hexadecimal."""
    return sha256(write_case(case).encode()).hexdigest()


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:  # run from a checkout that is not installed
        return "unknown"


# Write the truth of a flight to a file next to its log, and read it. Only on request: a log holds no truth.

_CASE = b"pitotbench case"

_TRUE = "true_"  # prefix of all columns, so that no reader takes a truth file for a log


def truth_path(log_path: Path | str) -> Path:
    """Return the path of the truth of a log: `<name>.truth.parquet` in the same folder."""
    path = Path(log_path)
    return path.with_name(f"{path.stem}.truth.parquet")


def write_truth(flight: Flight, log_path: Path | str) -> Path:
    """Write all channels [SI], labels and the whole case of a flight next to its log, and return the path.

    Columns have the prefix `true_` and, where a log has the quantity, the suffix of its unit. An error leaves no
    incomplete file.
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


def read_truth(path: Path | str) -> Flight:
    """Read the flight of a truth file. Raises BadInputError for any other file."""
    import pyarrow as pa
    from pyarrow import parquet

    try:
        table = parquet.ParquetFile(Path(path)).read()
    except (pa.ArrowInvalid, OSError) as error:
        raise BadInputError(f"{path}: not a truth file: {error}") from error
    text = (table.schema.metadata or {}).get(_CASE)
    if text is None:
        raise BadInputError(f"{path}: not a truth file; expected the file that was written next to a log")
    units = {_column(name): name for name in QUANTITIES}
    found = {name: table[name].to_numpy() for name in table.column_names if name.startswith(_TRUE)}
    return Flight(
        case=read_case(text.decode()),
        channels={units.get(name, name.removeprefix(_TRUE)): values for name, values in found.items()},
        segment=np.asarray(table["segment"].to_numpy(), dtype=np.str_),
        on_condition=table["on_condition"].to_numpy(),
    )


def _column(name: str) -> str:
    return _TRUE + (QUANTITIES[name].column if name in QUANTITIES else name)
