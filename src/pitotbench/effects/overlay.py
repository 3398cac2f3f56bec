"""What an effect puts on an aircraft, as data: functions of named sizes; `simulate` writes it into a copy."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields

from pitotbench.effects.expression import Expression

Point = tuple[float, float, float]  # inches, structural axes: x aft, y right, z up


@dataclass(frozen=True, slots=True)
class PropertySetting:
    """A property of the aircraft that is written anew at every step."""

    path: str
    value: Expression


@dataclass(frozen=True, slots=True)
class AxisFunction:
    """A force [lb] or moment [lb ft] added to an axis of the aerodynamics: LIFT, DRAG, SIDE, ROLL, PITCH, YAW."""

    axis: str
    value: Expression


@dataclass(frozen=True, slots=True)
class MassPoint:
    """A mass [lb] at a point of the structure; it may be negative, where something was left out."""

    weight: Expression
    location: Point


@dataclass(frozen=True, slots=True)
class BodyForce:
    """A force [lb] forward along the body's x axis at a point of the structure."""

    value: Expression
    location: Point


@dataclass(frozen=True, slots=True)
class WindTerm:
    """A wind [ft/s] toward `north`, `east` or `down` on top of the steady wind."""

    toward: str
    value: Expression


@dataclass(frozen=True, slots=True)
class Overlay:
    """All that effects add. `sizes` are new properties that the expressions name; `a + b` holds both.

    In a loaded aircraft a size is the property of that path and may be set at any time. Functions of drag that
    read the lift coefficient see that of the step before, as JSBSim computes drag first.
    """

    sizes: tuple[tuple[str, float], ...] = ()
    settings: tuple[PropertySetting, ...] = ()
    functions: tuple[AxisFunction, ...] = ()
    masses: tuple[MassPoint, ...] = ()
    forces: tuple[BodyForce, ...] = ()
    winds: tuple[WindTerm, ...] = ()
    filters: tuple[str, ...] = ()  # further JSBSim components, as XML, run before the settings and winds
    temperature_offset: float = 0.0  # K

    def __add__(self, other: "Overlay") -> "Overlay":
        return Overlay(**{f.name: getattr(self, f.name) + getattr(other, f.name) for f in fields(self)})

    def is_empty(self) -> bool:
        """Whether nothing is added to the aircraft's files (a temperature is no part of them)."""
        return not any(getattr(self, f.name) for f in fields(self) if f.name != "temperature_offset")


@dataclass(frozen=True, slots=True)
class AeroFunction:
    """A named function of the aircraft's aerodynamics and the properties it reads."""

    axis: str
    name: str
    reads: frozenset[str]


@dataclass(frozen=True, slots=True)
class Engine:
    """An engine as loaded: where its propeller is [in], its fuel per indicated power [lb/(hp h)], 0 where unknown,
    and its constant friction [hp]."""

    location: Point
    fuel_per_power: float = 0.0
    friction: float = 0.0


@dataclass(frozen=True, slots=True)
class Baseline:
    """What an overlay must know of the untouched aircraft; `declared` are its own properties with their values."""

    aircraft: str
    center_of_gravity: Point  # in, of the empty aircraft
    functions: tuple[AeroFunction, ...] = ()
    engines: tuple[Engine, ...] = ()
    declared: Mapping[str, float] = field(default_factory=dict)

    def moving(self, axis: str, control: str) -> tuple[str, ...]:
        """Names of the functions of an axis that read a control."""
        return tuple(f.name for f in self.functions if f.axis == axis and control in f.reads)
