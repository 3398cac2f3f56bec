"""What the bench knows of an aircraft: its autopilot, and the forces of its model in a measured
motion.
"""

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from platformdirs import user_cache_path

from pitotbench.records import freeze_arrays
from pitotbench.units import Array, Pascal, Radians, Seconds

# What was found about an aircraft when the bench attached its autopilot to it.

# Kinds of engines: an electric one needs no start; a turboprop's gas generator goes to idle with
# each restart.
ELECTRIC, TURBOPROP = "electric", "turboprop"


@dataclass(frozen=True, slots=True)
class Attached:
    """What was found about an aircraft at a height.

    Speeds are calibrated [kt]; `fastest_kt` is the maximum level speed, or that of Mach 0.7 where
    `mach_limited`. `missing` are channels of a flight that the aircraft does not serve. The lists
    have one value a trim point; `lever` is the throttle of level flight, `pitch_rate` and `bank`
    the gains [1/s]. `warnings` tell slopes of the wrong sign, and tables that level flight leaves.
    """

    aircraft: str
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
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class StepResponse:
    """One step of the autopilot, flown in smooth air.

    `time` [s] from the step, `change` of the quantity from its value before, in `unit`; `step` is
    the change asked for. `overshoot` is a share of the step; `settled` [s] is the time after which
    it stays within 10 %.
    """

    quantity: str
    unit: str
    speed_kt: float
    step: float
    time: Array
    change: Array
    overshoot: float
    settled: float


@dataclass(frozen=True, slots=True)
class ManeuverCheck:
    """One maneuver tried in light turbulence.

    `on_condition` is the share of the samples on its legs, steps or circles that is within the
    card's tolerances. `failure` says why it was not flown; the numbers are then None.
    """

    maneuver: str
    speeds_kt: tuple[float, ...]
    minutes: float | None = None
    on_condition: float | None = None
    failure: str = ""


@dataclass(frozen=True, slots=True)
class AircraftCheck:
    """What can be flown with an aircraft. `attached` is None for one with an autopilot of its own.

    `set_to_zero` are the properties that its files read and nothing writes.
    """

    aircraft: str
    attached: Attached | None
    steps: tuple[StepResponse, ...]
    maneuvers: tuple[ManeuverCheck, ...]
    set_to_zero: tuple[str, ...] = ()


# The performance of a model in steady flight, beside a handbook.


@dataclass(frozen=True, slots=True)
class PerformanceFigure:
    """One figure of a model's performance [`unit`] in a condition, and the published one where
    there is any.
    """

    name: str
    condition: str
    model: float
    unit: str
    published: float | None = None

    @property
    def difference(self) -> float | None:
        """The model's figure less the published one [`unit`]."""
        return None if self.published is None else self.model - self.published


@dataclass(frozen=True, slots=True)
class Performance:
    """The performance of an aircraft at a mass [kg]; `skipped` holds what it lacks: name and
    reason.
    """

    aircraft: str
    mass: float
    figures: tuple[PerformanceFigure, ...]
    skipped: tuple[tuple[str, str], ...]


# The two sides of an equation-error comparison: a measured motion, and the forces of a model in
# that motion.


# What a log must hold to move a model along it, beside air data and GPS: the states, and the controls
# that the airplane has. The angles of the flow and the mass can be found without a channel.
STATES = ("roll", "pitch", "heading", "roll_rate", "pitch_rate", "yaw_rate", "specific_force_x")
CONTROLS = ("elevator", "aileron", "rudder", "throttle_left", "throttle_right")


@dataclass(frozen=True, slots=True, kw_only=True)
class Motion:
    """Measured states and controls of an airplane at increasing times; arrays (n,), SI and radians.

    A model that is put into these states needs no equations of motion and cannot drift.
    `temperature_offset` is the mean offset of a standard day [K], height by height, that has the
    measured air temperature at the measured pressure. A control that the airplane does not have is
    NaN. Raises RecordError where lengths differ.
    """

    time: Seconds
    static_pressure: Pascal
    mach: Array
    angle_of_attack: Radians
    sideslip: Radians
    roll: Radians
    pitch: Radians
    heading: Radians
    roll_rate: Array
    pitch_rate: Array
    yaw_rate: Array
    elevator: Radians
    aileron: Radians
    rudder: Radians
    throttle_left: Array
    throttle_right: Array
    mass: Array
    temperature_offset: float = 0.0

    def __post_init__(self) -> None:
        freeze_arrays(self, len(self.time))


@dataclass(frozen=True, slots=True, kw_only=True)
class Reaction:
    """The forces and engine readings of a model along a `Motion`; arrays (n,), one entry a state.

    Specific force [m/s²] and angular acceleration [rad/s²] are in body axes. The engine readings
    are manifold pressure [Pa], propeller speed [rad/s] and fuel flow [kg/s]; those that the model
    does not have are 0.
    """

    specific_force_x: Array
    specific_force_y: Array
    specific_force_z: Array
    roll_acceleration: Array
    pitch_acceleration: Array
    yaw_acceleration: Array
    manifold_pressure_left: Pascal
    manifold_pressure_right: Pascal
    propeller_speed_left: Array
    propeller_speed_right: Array
    fuel_flow_left: Array
    fuel_flow_right: Array

    def __post_init__(self) -> None:
        freeze_arrays(self, len(self.specific_force_x))


@dataclass(frozen=True, slots=True, kw_only=True)
class UnitForces:
    """What a unit of force or moment along each axis changes in a model's reactions to a `Motion`
    of n states.

    `changes` holds by aerodynamic axis (DRAG, SIDE, ROLL, PITCH, YAW) the change by 1 lb or 1 lb
    ft, (n, 6): the specific forces [m/s²], then the angular accelerations [rad/s²]. `properties`
    holds by path the properties that functions of force read, in JSBSim's units, (n,).
    """

    changes: Mapping[str, Array]
    properties: Mapping[str, Array]


@dataclass(frozen=True, slots=True, kw_only=True)
class AeroTerms:
    """The aerodynamic forces of a model along a `Motion` of n states, and what they are made of.

    `total` are forces [lb] and moments [lb ft] of the air in body axes, (n, 6). `units` holds by
    aerodynamic axis the change of `total` by 1 lb or 1 lb ft along it, (n, 6). `values` holds the
    values of functions by name, (n,): forces and moments along their axes, or coefficients.
    `alpha_rate` is the rate of the angle of attack in the model [rad/s], (n,). `wing` is area [m²],
    span and chord [m]; `inertia` is I_xx, I_yy, I_zz, I_xz [kg m²].
    """

    total: Array
    units: Mapping[str, Array]
    values: Mapping[str, Array]
    alpha_rate: Array
    wing: tuple[float, ...]
    inertia: tuple[float, ...]
    mass: float


@dataclass(frozen=True, slots=True)
class PatchErrors:
    """What the patches of an aircraft may be off by, of a patch of k sizes.

    `sizes` are those that were patched, by effect and parameter; `covariance` is that of two of
    them; `forms` are the deviations of each form as a share of its size.
    """

    sizes: Mapping[tuple[str, str], float] = field(default_factory=dict)
    covariance: Mapping[tuple[tuple[str, str], tuple[str, str]], float] = field(
        default_factory=dict
    )
    forms: Mapping[tuple[str, str], float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelForces:
    """All that a model answers to a `Motion` of n states, engines running.

    `air` are the forces [lb] of all but the engines, and the moments [lb ft] of all with the
    engines, in body axes about the center of gravity, (n, 6). `thrust` [lb] and `power` [hp] are
    those of all engines, `weight` [lb] and `gravity_center` [in, x aft] those of the loaded
    airplane, (n,) each; `inertia` is I_xx, I_yy, I_zz, I_xz [slug ft²], (n, 4). `values` holds
    functions of the file by name, (n,). `wing` is area [ft²], span and chord [ft].
    """

    air: Array
    thrust: Array
    power: Array
    weight: Array
    gravity_center: Array
    inertia: Array
    values: Mapping[str, Array]
    wing: tuple[float, ...]


# Two versions of a model compared along one flown motion.


@dataclass(frozen=True, slots=True)
class ChannelChange:
    """What changed in a channel in a phase of a flown motion: root mean square and largest change
    [`unit`].

    `share` is the largest change over the channel's largest value in the whole motion,
    `coefficient` the root mean square as a coefficient; None where the channel has none.
    """

    channel: str
    phase: str
    unit: str
    change: float
    largest: float
    share: float
    coefficient: float | None


@dataclass(frozen=True, slots=True)
class TermChange:
    """One difference between two files, and what it alone changes in flight.

    `name` is the field's, `part` that of the file. `old` and `new` are the coefficient or the
    number [`unit`], None where the part holds none. `effects` are its changes by channel, each over
    the whole motion, the largest share first; it is empty for a difference without an effect.
    """

    name: str
    part: str
    unit: str
    old: float | None
    new: float | None
    effects: tuple[ChannelChange, ...]


@dataclass(frozen=True, slots=True)
class ModelComparison:
    """What changed in flight between two files of an airplane, along a motion that the old one
    flew.

    `time` [s] is that of the motion, (n,), and `traces` the change of each channel that changed,
    (n,). `located` holds the phases of each channel. `remarks` say what the terms do not add up to.
    """

    old: str
    new: str
    card: str
    time: Array
    traces: Mapping[str, Array]
    channels: tuple[ChannelChange, ...]
    located: tuple[ChannelChange, ...]
    terms: tuple[TermChange, ...]
    remarks: tuple[str, ...] = ()

    @property
    def largest(self) -> float:
        """The largest change of any channel, as a share of the channel's largest value."""
        return max((each.share for each in self.channels), default=0.0)


def cache_folder() -> Path:
    """Return the folder of the cache: `$PITOTBENCH_CACHE`, else that of the system for this user."""
    return Path(
        os.environ.get("PITOTBENCH_CACHE") or user_cache_path("pitotbench", appauthor=False)
    )
