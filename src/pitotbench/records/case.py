"""The configuration of one synthetic flight: everything that decides what is flown and what is sensed.

A `Case` holds the truth (wind, pressure error, effects) and so may not be imported by the calibrator.
Values are SI and radians; `metadata["suffix"]` names the unit in which a value is written to TOML.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from pitotbench.units import DEGREE, FOOT, KNOT

TURBULENCE_SEVERITY = {"none": 0, "light": 1, "moderate": 2}  # Milspec severity index (MIL-F-8785C)
ERROR_LOCATIONS = ("impact", "static", "total")
PILOTS = ("none", "good", "busy")


@dataclass(frozen=True, slots=True)
class Wind:
    """Mean wind, uniform over the maneuver: speed [m/s], the direction it blows from [rad, true], and an
    upward part [m/s]."""

    speed: float = field(default=15.0 * KNOT, metadata={"suffix": "kt"})
    from_direction: float = field(default=300.0 * DEGREE, metadata={"suffix": "deg"})
    up: float = field(default=0.0, metadata={"suffix": "mps"})


@dataclass(frozen=True, slots=True)
class PressureErrorSpec:
    """The known pressure error Δp/q_c = f(q_ci/q_ref): a model of the table and its parameters.

    The default is a plausible light twin: +0.3 kt at 100, −0.8 kt at 126 and −1.7 kt at 160 KIAS. Its size is
    chosen so that a Bias fit leaves about twice the residual of the others, as in Martos et al. 2011, Fig 9.
    With `model = "table"`, `airspeed` [m/s, indicated] and `values` [-] hold the curve instead.
    `location`: `impact` (as the source injects it: the impact pressure alone is corrupted), `static` (the static
    pressure reads Δp too high) or `total` (the total pressure reads Δp too low).
    """

    model: str = "inverse+"
    parameters: tuple[float, ...] = (-0.060, 0.006, 0.060)
    reference_pressure: float = field(default=1630.28, metadata={"suffix": "pa"})
    airspeed: tuple[float, ...] = field(default=(), metadata={"suffix": "kt"})
    values: tuple[float, ...] = ()
    location: str = "impact"


@dataclass(frozen=True, slots=True)
class DataSystem:
    """A data system (DAS): rates [Hz] and per-channel sensor properties.

    Standard deviations are of white noise per sample; a resolution of 0 means no quantization; latencies [s]
    say how long after the event a sample is stamped. `altitude_drift` is the standard deviation of the slow part of
    a receiver's height error, a first-order Gauss-Markov process with the correlation time `altitude_drift_time`.
    """

    air_rate: float = field(default=50.0, metadata={"suffix": "hz"})
    gps_rate: float = field(default=50.0, metadata={"suffix": "hz"})
    impact_pressure_noise: float = field(default=12.0, metadata={"suffix": "pa"})
    impact_pressure_range: float = field(default=13789.5, metadata={"suffix": "pa"})
    impact_pressure_resolution: float = field(default=0.2, metadata={"suffix": "pa"})
    static_pressure_noise: float = field(default=10.0, metadata={"suffix": "pa"})
    static_pressure_resolution: float = field(default=1.5, metadata={"suffix": "pa"})
    temperature_noise: float = field(default=0.1, metadata={"suffix": "k"})
    temperature_resolution: float = field(default=0.01, metadata={"suffix": "k"})
    velocity_noise: float = field(default=0.05, metadata={"suffix": "mps"})
    velocity_resolution: float = field(default=0.001, metadata={"suffix": "mps"})
    altitude_noise: float = field(default=1.5, metadata={"suffix": "m"})
    altitude_drift: float = field(default=0.0, metadata={"suffix": "m"})
    altitude_drift_time: float = field(default=90.0, metadata={"suffix": "s"})
    attitude_noise: float = field(default=0.002, metadata={"suffix": "rad"})
    rate_noise: float = field(default=0.002, metadata={"suffix": "radps"})
    acceleration_noise: float = field(default=0.03, metadata={"suffix": "mps2"})
    vane_noise: float = field(default=0.003, metadata={"suffix": "rad"})
    air_latency: float = field(default=0.0, metadata={"suffix": "s"})
    gps_latency: float = field(default=0.0, metadata={"suffix": "s"})
    recovery_factor: float = 1.0

    @property
    def label(self) -> str:
        """The usual short name, air rate over GPS rate, for example `20/1`."""
        return f"{self.air_rate:g}/{self.gps_rate:g}"


@dataclass(frozen=True, slots=True)
class EffectSpec:
    """One physical effect of the effects table with its parameters (names carry their unit suffix)."""

    name: str
    parameters: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Case:
    """One flight and its sensing, completely: the same Case gives the same log, bit for bit.

    `fuel` is the share of the fuel that the aircraft's file loads (1 is full tanks); `ballast` [kg] lies at its
    center of gravity, negative where the airplane is lighter than the file says. Both are on the weight sheet, so
    the mass column of the log holds them.
    `card` overrides numbers of the maneuver's card (names carry their unit suffix, for example
    `{"dwell_s": 20.0}`). `accuracy` states 2σ of what the residual cannot show (`{"temperature_k": 1.0}`); it is
    told to the calibrator and changes nothing of the flight. `truth_seed` drives turbulence and the pilot,
    `sensor_seed` the sensors.
    """

    aircraft: str = "navajo"
    maneuver: str = "step_decrease"
    card: Mapping[str, Any] = field(default_factory=dict)
    altitude: float = field(default=6000.0 * FOOT, metadata={"suffix": "ft"})
    temperature_offset: float = field(default=0.0, metadata={"suffix": "k"})
    wind: Wind = field(default_factory=Wind)
    fuel: float = 1.0
    ballast: float = field(default=0.0, metadata={"suffix": "kg"})
    turbulence: str = "light"
    pilot: str = "none"
    pressure_error: PressureErrorSpec = field(default_factory=PressureErrorSpec)
    das: DataSystem = field(default_factory=DataSystem)
    effects: tuple[EffectSpec, ...] = ()
    accuracy: Mapping[str, float] = field(default_factory=dict)
    truth_seed: int = 1
    sensor_seed: int = 1
