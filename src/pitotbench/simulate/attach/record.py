"""The record of an attached aircraft: what was found when its autopilot was made. It lies in the aircraft's folder."""

import tomllib
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path

from pitotbench.records.toml_text import write_toml

FILE = "attached.toml"
ELECTRIC = "electric"  # kind of engine: it needs no start


@dataclass(frozen=True, slots=True)
class Attached:
    """What was found about an aircraft at a height.

    Speeds are calibrated [kt]; `fastest_kt` is the maximum level speed, or that of Mach 0.7 where `mach_limited`.
    `missing` are channels of a flight that the aircraft does not serve. The lists have one value a trim point;
    `lever` is the throttle of level flight, `pitch_rate` and `bank` the gains [1/s].
    """

    aircraft: str
    source: str
    altitude_ft: float
    mass_kg: float
    stall_kt: float
    fastest_kt: float
    mach_limited: bool
    engines: int
    engine_kind: str
    engine_time_s: float
    missing: tuple[str, ...]
    speed_kt: tuple[float, ...]
    alpha_deg: tuple[float, ...]
    lever: tuple[float, ...]
    pitch_rate: tuple[float, ...]
    bank: tuple[float, ...]
    climb: float
    speed: float


def write_record(folder: Path, attached: Attached) -> None:
    """Write the record into an aircraft's folder."""
    table = {k: list(v) if isinstance(v, tuple) else v for k, v in asdict(attached).items()}
    (folder / FILE).write_text(write_toml(table), encoding="utf-8")


@cache
def read_record(folder: Path) -> Attached | None:
    """Return the record in an aircraft's folder; None where the aircraft has an autopilot of its own."""
    file = folder / FILE
    if not file.is_file():
        return None
    table = tomllib.loads(file.read_text(encoding="utf-8"))
    return Attached(**{k: tuple(v) if isinstance(v, list) else v for k, v in table.items()})
