"""The records of an overlay: what effects add to an aircraft, as data. Package `simulate` writes it into a copy."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, is_dataclass, replace
from typing import Any

from pitotbench.effects.expression import Expression

Point = tuple[float, float, float]  # inches, structural axes: x aft, y right, z up


@dataclass(frozen=True, slots=True)
class PropertySetting:
    """A property of the aircraft that is set at every step."""

    path: str
    value: Expression


@dataclass(frozen=True, slots=True)
class AxisFunction:
    """A force [lb] or moment [lb ft] added to an aerodynamic axis: LIFT, DRAG, SIDE, ROLL, PITCH or YAW."""

    axis: str
    value: Expression


@dataclass(frozen=True, slots=True)
class MassPoint:
    """A mass [lb] at a point of the structure; negative where something was removed."""

    weight: Expression
    location: Point


@dataclass(frozen=True, slots=True)
class BodyForce:
    """A force [lb] forward along the body's x axis at a point of the structure."""

    value: Expression
    location: Point


@dataclass(frozen=True, slots=True)
class WindTerm:
    """A wind [ft/s] toward `north`, `east` or `down`, added to the steady wind."""

    toward: str
    value: Expression


@dataclass(frozen=True, slots=True)
class Overlay:
    """Everything that effects add to an aircraft and its air. The sum of two overlays holds both.

    In the sum of two overlays of one effect the sizes add up, and what reads them stands once. Shapes would add up
    as well: an effect that has any is never put on an aircraft that has it already.

    `sizes` are new properties, path and value, that the expressions read. In a loaded aircraft they may be set at
    any time. A function of drag that reads the lift coefficient gets that of the step before, because JSBSim
    computes drag first.
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
        sizes = dict(self.sizes)
        shared = any(path in sizes for path, _ in other.sizes)
        sizes |= {path: sizes.get(path, 0.0) + value for path, value in other.sizes}

        def both(name: str) -> Any:
            mine, more = getattr(self, name), getattr(other, name)
            return (*mine, *(part for part in more if part not in mine)) if shared else mine + more

        parts = {f.name: both(f.name) for f in fields(self) if f.name not in ("sizes", "temperature_offset")}
        warmer = self.temperature_offset + other.temperature_offset
        return Overlay(sizes=tuple(sizes.items()), temperature_offset=warmer, **parts)

    def renamed(self, new: Callable[[str], str]) -> "Overlay":
        """Return the overlay with a function applied to every path and expression in it."""
        return Overlay(**{f.name: _renamed(getattr(self, f.name), new) for f in fields(self)})

    def is_empty(self) -> bool:
        """Return whether nothing is added to the aircraft's files. A temperature is not part of them."""
        return not any(getattr(self, f.name) for f in fields(self) if f.name != "temperature_offset")


def _renamed(part: Any, new: Callable[[str], str]) -> Any:
    if isinstance(part, str):
        return new(part)
    if isinstance(part, tuple):
        return tuple(_renamed(each, new) for each in part)
    if is_dataclass(part) and not isinstance(part, type):
        return replace(part, **{f.name: _renamed(getattr(part, f.name), new) for f in fields(part)})
    return part


@dataclass(frozen=True, slots=True)
class AeroFunction:
    """A named function of the aircraft's aerodynamics and the properties that it reads."""

    axis: str
    name: str
    reads: frozenset[str]


@dataclass(frozen=True, slots=True)
class Engine:
    """An engine of an aircraft's file.

    `location` is that of its propeller [in], `fuel_per_power` its fuel flow over indicated power [lb/(hp h)], 0
    where unknown, and `friction` its constant friction [hp].
    """

    location: Point
    fuel_per_power: float = 0.0
    friction: float = 0.0


@dataclass(frozen=True, slots=True)
class Baseline:
    """The data of an unchanged aircraft that overlays need; `declared` holds the properties of its files."""

    aircraft: str
    center_of_gravity: Point  # in, of the empty aircraft
    functions: tuple[AeroFunction, ...] = ()
    engines: tuple[Engine, ...] = ()
    declared: Mapping[str, float] = field(default_factory=dict)

    def moving(self, axis: str, control: str) -> tuple[str, ...]:
        """Return the names of the functions of an axis that read a control."""
        return tuple(f.name for f in self.functions if f.axis == axis and control in f.reads)
