"""The tasks of a campaign. A task is one flight with all that is computed from it."""

import json
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cache
from hashlib import sha256
from importlib.metadata import version

from pitotbench.bench.code_digest import aircraft_digest, code_digest
from pitotbench.calibrate import CalibrationOptions
from pitotbench.records.case import Case, DataSystem
from pitotbench.records.case_file import write_case

SCHEMA = 2  # of a stored result
KEEP_LOGS = ("none", "failed", "all")


Calibrations = tuple[tuple[str, CalibrationOptions], ...]


@dataclass(frozen=True, slots=True)
class Task:
    """One flight: its name and key, its case, the data systems that sense it and the ways it is calibrated.

    `key` is that of `content_key`. `calibrations` are labels, which may be empty, with the options of each.
    `keep_logs` says which logs are kept: `none`, those of a `failed` calibration, or `all`. `draw` asks for the
    figures of the report.
    """

    name: str
    key: str
    case: Case
    systems: tuple[DataSystem, ...]
    calibrations: Calibrations
    log_format: str = "parquet"
    keep_logs: str = "all"
    draw: bool = False

    def log_name(self, system: DataSystem) -> str:
        """Return the end of the name of a log's file, such as `20_1.parquet`."""
        return f"{system.label.replace('/', '_')}.{self.log_format}"


def content_key(cell: str, case: Case) -> str:
    """Return the key of a flight: the digest of its cell and its seeds, 32 hexadecimal digits."""
    return sha256(f"{cell} {case.truth_seed} {case.sensor_seed}".encode()).hexdigest()[:32]


def cell_digest(case: Case, systems: Sequence[DataSystem], calibrations: Calibrations) -> str:
    """Return the digest of all that decides a result but the seeds: case, calibrations, what computes.

    What computes is the schema, the code with its effects, the files of the aircraft, and JSBSim. Flights that
    differ in their seeds alone have one such digest, which takes longer to make than all else of a task.
    """
    content = [
        SCHEMA,
        write_case(replace(case, das=systems[0], truth_seed=0, sensor_seed=0)),
        [asdict(system) for system in systems],
        [[label, asdict(options)] for label, options in calibrations],
        code_digest(),
        aircraft_digest(case.aircraft),
        _simulator(),
    ]
    return sha256(json.dumps(content, default=repr).encode()).hexdigest()


@cache
def _simulator() -> str:
    return version("jsbsim")


def sharded(tasks: Iterator[Task], shard: tuple[int, int]) -> Iterator[Task]:
    """Give every n-th task, from the k-th on, of a shard (k, n) that counts from 1."""
    part, parts = shard
    return (task for number, task in enumerate(tasks) if number % parts == part - 1)


def options_of_models(models: Sequence[str], options: CalibrationOptions) -> Calibrations:
    """Return one calibration for each model, without labels."""
    return tuple(("", replace(options, model=model)) for model in models)
