"""The configuration of one synthetic flight and of its sensing.

A `Case` holds the truth (wind, pressure error, effects), so the calibrator must not import it. Values are SI and
radians; `metadata["suffix"]` names the unit in which a value is written to TOML.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from pitotbench.records.integration import USUAL_RATE
from pitotbench.units import DEGREE, FOOT, KNOT

TURBULENCE_SEVERITY = {"none": 0, "light": 1, "moderate": 2}  # Milspec severity index (MIL-F-8785C)
ERROR_LOCATIONS = ("impact", "static", "total")
PILOTS = ("none", "good", "busy")
VERTICAL_VELOCITIES = ("usual", "recorded", "missing")


@dataclass(frozen=True, slots=True)
class Wind:
    """The mean wind, uniform over the maneuver.

    `speed` [m/s]; `from_direction` [rad, true], where the wind comes from, as in a weather report: a wind from 270°
    moves the air toward east; `up` [m/s], its upward part.
    """

    speed: float = field(default=15.0 * KNOT, metadata={"suffix": "kt"})
    from_direction: float = field(default=300.0 * DEGREE, metadata={"suffix": "deg"})
    up: float = field(default=0.0, metadata={"suffix": "mps"})


@dataclass(frozen=True, slots=True)
class PressureErrorSpec:
    """The true pressure error Δp/q_c = f(q_ci/q_ref): a model of the table and its parameters.

    The default is plausible for a light twin: +0.3 kt at 100, −0.8 kt at 126 and −1.7 kt at 160 KIAS. Its size is
    such that a Bias fit has about twice the residual of the other models, as in Martos et al. 2011, Fig 9.
    With `model = "table"`, `airspeed` [m/s, indicated] and `values` [-] are the points of the curve.
    `location` says which pressure has the error: `impact` (the impact pressure alone, as in the source), `static`
    (the static pressure reads Δp too high) or `total` (the total pressure reads Δp too low).
    """

    model: str = "inverse+"
    parameters: tuple[float, ...] = (-0.060, 0.006, 0.060)
    reference_pressure: float = field(default=1630.28, metadata={"suffix": "pa"})
    airspeed: tuple[float, ...] = field(default=(), metadata={"suffix": "kt"})
    values: tuple[float, ...] = ()
    location: str = "impact"


@dataclass(frozen=True, slots=True)
class DataSystem:
    """A data system (DAS): its rates [Hz] and the properties of its sensors.

    Each `…_noise` is the standard deviation of the white noise of a sample. A resolution of 0 means no rounding. A
    latency [s] is the time from an event to its stamp. `altitude_drift` is the standard deviation of the slow part
    of a receiver's height error, a first-order Gauss-Markov process of correlation time `altitude_drift_time`.
    `vertical_velocity` says whether the GPS velocity down is `recorded` or `missing`; `usual` is as in the source,
    where only an integrated IMU/GPS records it.
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
    vertical_velocity: str = "usual"

    @property
    def label(self) -> str:
        """The short name: air-data rate over GPS rate, for example `20/1`."""
        return f"{self.air_rate:g}/{self.gps_rate:g}"


@dataclass(frozen=True, slots=True)
class EffectSpec:
    """One effect of the effects table with its parameters, whose names end in their units."""

    name: str
    parameters: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Case:
    """One flight and its sensing. The same Case gives the same log, bit for bit.

    `card` overrides numbers of the maneuver's card; names end in a unit, for example `{"dwell_s": 20.0}`.

    `fuel` is the share of the fuel in the aircraft's file (1 is that load). `ballast` [kg] lies at the center of
    gravity and is negative where the airplane is lighter than its file. Both are on the weight sheet, so the mass
    column of the log includes them.

    `integration_rate` [Hz] is that of the simulator, which is also the rate of the flight's truth. Another than
    the usual one is a whole multiple of the data system's air-data rate (`records.integration`).

    `accuracy` states 2σ of constant sensor errors that the residual cannot show, for example
    `{"temperature_k": 1.0}`. It goes to the calibrator with the log and changes nothing in the flight.

    `truth_seed` drives turbulence and the pilot, `sensor_seed` the sensors.
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
    integration_rate: float = field(default=USUAL_RATE, metadata={"suffix": "hz"})
    truth_seed: int = 1
    sensor_seed: int = 1
