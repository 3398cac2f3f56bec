"""The sides of an equation-error comparison: a measured motion, and a model's forces in it."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from pitotbench.records import freeze_arrays
from pitotbench.units import Array, Pascal, Radians, Seconds

# What a log must hold to move a model along it, in addition to air data and GPS: the states, and
# the controls that the airplane has. The angles of the flow and the mass can be found without a
# channel.
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
    """What a unit of force or moment along each axis changes in a model's reactions.

    The reactions are those to a `Motion` of n states.

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
    `alpha_rate` is the rate of the angle of attack in the model [rad/s], (n,).
    """

    total: Array
    units: Mapping[str, Array]
    values: Mapping[str, Array]
    alpha_rate: Array


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
