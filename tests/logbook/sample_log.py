"""A log as columns, to be spoiled one way at a time: gusty enough that no sensor seems to stand
still.
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pitotbench import FlightLog, air
from pitotbench.logbook.columns import parse_column

ROWS = 600
RATE = 10.0


def columns() -> dict[str, NDArray]:
    """Canonical columns of one minute at 10 Hz with a 10 Hz GPS."""
    rng = np.random.default_rng(4)
    time = np.arange(ROWS) / RATE
    speed, heading = 65.0 + 8.0 * np.sin(time / 20.0), time / 30.0
    static = 81200.0 + 3.0 * rng.standard_normal(ROWS)
    mach = (speed + 0.2 * rng.standard_normal(ROWS)) / air.sound_speed(276.0)
    return {
        "time_s": time,
        "impact_pressure_pa": air.impact_pressure_from_mach(mach, static),
        "static_pressure_pa": static,
        "total_temperature_k": air.total_temperature(276.0, speed / air.sound_speed(276.0))
        + 0.1 * rng.standard_normal(ROWS),
        "velocity_north_mps": speed * np.cos(heading) + 5.0,
        "velocity_east_mps": speed * np.sin(heading) - 6.0,
        "velocity_down_mps": 0.1 * rng.standard_normal(ROWS),
        "altitude_m": 1830.0 + rng.standard_normal(ROWS),
        "specific_force_z_mps2": -9.8 + 0.1 * rng.standard_normal(ROWS),
        "angle_of_attack_rad": 0.05 + 0.01 * rng.standard_normal(ROWS),
        "throttle_left": np.full(ROWS, 0.6),
        "propeller_speed_left_radps": 240.0 + rng.standard_normal(ROWS),
        "segment": np.where(time < 30.0, "leg 1", "leg, 2"),
        "on_condition": time < 40.0,
    }


def log() -> FlightLog:
    """The same as a record."""
    return FlightLog(**{parse_column(name)[0].name: values for name, values in columns().items()})


def write(path: Path, table: dict[str, NDArray], above: str = "") -> Path:
    """Write columns as CSV by hand, so that the reader is not tested with its own writer."""
    lines = [",".join(table)]
    for row in zip(*table.values(), strict=True):
        lines.append(",".join(f'"{cell}"' if "," in str(cell) else str(cell) for cell in row))
    path.write_text(above + "\n".join(lines) + "\n", encoding="utf-8")
    return path
