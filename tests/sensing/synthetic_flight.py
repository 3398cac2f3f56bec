"""A flight from formulas, not from the simulator: smooth, with a known answer and, if asked for, a
gap.
"""

import numpy as np

from pitotbench import Case, Flight, air
from pitotbench.records.case import DataSystem, PressureErrorSpec
from pitotbench.sensing.recorder import PLAIN
from pitotbench.units import Array

RATE = 100.0
STATIC_PRESSURE = 81200.0  # Pa, about 6,000 ft
AIR_TEMPERATURE = 276.3  # K
NOISE_FIELDS = [name for name in DataSystem.__dataclass_fields__ if name.endswith("_noise")]
RESOLUTION_FIELDS = [
    name for name in DataSystem.__dataclass_fields__ if name.endswith("_resolution")
]
PERFECT = DataSystem(
    air_rate=100.0, gps_rate=100.0, **dict.fromkeys(NOISE_FIELDS + RESOLUTION_FIELDS, 0.0)
)


def flight(seconds: float = 30.0, gap: float = 0.0, case: Case | None = None) -> Flight:
    """A slow turn while slowing down from 130 kt; with a gap [s] in time after two fifths."""
    n = round(seconds * RATE) + 1
    time = 10.0 + np.arange(n) / RATE
    time[2 * n // 5 :] += gap
    speed = 65.0 + 8.0 * np.cos((time - 10.0) / 20.0)
    heading = np.mod(6.0 + (time - 10.0) / 20.0, 2.0 * np.pi)  # passes north
    mach = speed / air.sound_speed(AIR_TEMPERATURE)
    static = STATIC_PRESSURE + 30.0 * np.sin(time / 9.0)
    channels: dict[str, Array] = {c.name: 0.1 * np.sin(time / 5.0 + i) for i, c in enumerate(PLAIN)}
    channels |= {
        "time": time,
        "velocity_north": speed * np.cos(heading) + 5.0,
        "velocity_east": speed * np.sin(heading) - 6.0,
        "velocity_down": 0.3 * np.sin(time / 3.0),
        "altitude": 1830.0 + np.sin(time / 4.0),
        "heading": heading,
        "specific_force_z": np.full(n, -9.8),
        "manifold_pressure_left": np.full(n, 9e4),
        "manifold_pressure_right": np.full(n, 9e4),
        "mass": np.full(n, 2900.0),
        "static_pressure": static,
        "total_pressure": static + air.impact_pressure_from_mach(mach, static),
        "air_temperature": np.full(n, AIR_TEMPERATURE),
        "wind_north": np.full(n, 5.0),
        "power_left": np.full(n, 1.5e5),
    }
    segment = np.where(np.arange(n) < n // 2, "leg 1", "turn")
    return Flight(case or Case(), channels, segment, segment == "leg 1")


def unbiased(**changes: object) -> Case:
    """A case without pressure error."""
    return Case(pressure_error=PressureErrorSpec("bias", (0.0,)), **changes)
