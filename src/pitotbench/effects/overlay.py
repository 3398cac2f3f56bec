"""What effects add to an aircraft, as data: JSBSim expressions and the places where they act."""

import re
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, fields, is_dataclass, replace
from functools import partial, reduce
from typing import Any, Literal

import numpy as np

from pitotbench.units import Array

Expression = str
Term = str | float

# The axes along which a further force simply adds. Not LIFT: functions of drag may read the lift.
ADDING = ("DRAG", "SIDE", "ROLL", "PITCH", "YAW")


def operation(kind: str, *terms: Term) -> Expression:
    """Return an operation of JSBSim's functions (`product`, `sum`, `quotient`, `max` …) on terms.

    A term is a number, the path of a property, or another expression.
    """
    inner = ""
    for term in terms:
        if isinstance(term, str):
            inner += term if term.startswith("<") else f"<property>{term}</property>"
        else:
            inner += f"<value>{term!r}</value>"
    return f"<{kind}>{inner}</{kind}>"


product, total = partial(operation, "product"), partial(operation, "sum")
difference = partial(operation, "difference")  # the first term minus the others
quotient = partial(operation, "quotient")


def size(effect: str, parameter: str) -> str:
    """Return the path of the property of an effect's size, in the unit of the parameter."""
    return f"effects/{effect}/{parameter}".replace("_", "-")


# What JSBSim's functions do, applied to all states at once.
_OPERATIONS: Mapping[str, Callable[..., Array]] = {
    "product": lambda *terms: reduce(np.multiply, terms),
    "sum": lambda *terms: reduce(np.add, terms),
    "difference": lambda *terms: reduce(np.subtract, terms),
    "quotient": np.divide,
    "max": lambda *terms: reduce(np.maximum, terms),
    "min": lambda *terms: reduce(np.minimum, terms),
    "abs": np.abs,
    "sqrt": np.sqrt,
    "sin": np.sin,
    "cos": np.cos,
}


def properties_in(expression: Expression) -> frozenset[str]:
    """Return the paths of the properties that an expression reads."""
    return frozenset(
        (node.text or "").strip() for node in ET.fromstring(expression).iter("property")
    )


def evaluate(expression: Expression, properties: Mapping[str, Array | float]) -> Array:
    """Return an expression's values, (n,) or one, for those of its properties [JSBSim's units].

    Raises KeyError for an operation that is not listed here, and for a property without values.
    """
    return _evaluated(ET.fromstring(expression), properties)


def _evaluated(node: ET.Element, properties: Mapping[str, Array | float]) -> Array:
    text = (node.text or "").strip()
    if node.tag == "value":
        return np.asarray(float(text))
    if node.tag == "property":
        return np.asarray(properties[text])
    return np.asarray(_OPERATIONS[node.tag](*(_evaluated(term, properties) for term in node)))


Point = tuple[float, float, float]  # inches, structural axes: x aft, y right, z up
Dimension = Literal["empty mass", "wing area", "chord"]


@dataclass(frozen=True, slots=True)
class PropertySetting:
    """A property of the aircraft that is set at every step."""

    path: str
    value: Expression


@dataclass(frozen=True, slots=True)
class AxisFunction:
    """A force [lb] or moment [lb ft] added to LIFT, DRAG, SIDE, ROLL, PITCH or YAW."""

    axis: str
    value: Expression


@dataclass(frozen=True, slots=True)
class FunctionScaling:
    """A function of the aircraft's file that becomes `factor` times itself plus `added`."""

    function: str
    factor: Expression
    added: Expression


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

    Where both are of one effect, their sizes add up, and what reads them stands once. Shapes would
    add up as well: an effect that has any is never put on an aircraft that has it already.

    `sizes` are new properties, path and value, that the expressions read. In a loaded aircraft they
    may be set at any time. A function of drag that reads the lift coefficient gets that of the step
    before, because JSBSim computes drag first.
    """

    sizes: tuple[tuple[str, float], ...] = ()
    settings: tuple[PropertySetting, ...] = ()
    functions: tuple[AxisFunction, ...] = ()
    scalings: tuple[FunctionScaling, ...] = ()
    masses: tuple[MassPoint, ...] = ()
    forces: tuple[BodyForce, ...] = ()
    winds: tuple[WindTerm, ...] = ()
    filters: tuple[
        str, ...
    ] = ()  # further JSBSim components, as XML, run before the settings and winds
    temperature_offset: float = 0.0  # K

    def __add__(self, other: "Overlay") -> "Overlay":
        sizes = dict(self.sizes)
        shared = any(path in sizes for path, _ in other.sizes)
        sizes |= {path: sizes.get(path, 0.0) + value for path, value in other.sizes}

        def both(name: str) -> Any:
            mine, more = getattr(self, name), getattr(other, name)
            return (*mine, *(part for part in more if part not in mine)) if shared else mine + more

        parts = {
            f.name: both(f.name)
            for f in fields(self)
            if f.name not in ("sizes", "temperature_offset")
        }
        change = self.temperature_offset + other.temperature_offset
        return Overlay(sizes=tuple(sizes.items()), temperature_offset=change, **parts)

    def renamed(self, new: Callable[[str], str]) -> "Overlay":
        """Return the overlay with a function applied to every path and expression in it."""
        return Overlay(**{f.name: _renamed(getattr(self, f.name), new) for f in fields(self)})

    def functions_changed(self) -> frozenset[str]:
        """Return the functions of the aircraft's file that are scaled, or read to be added."""
        scaled = frozenset(scaling.function for scaling in self.scalings)
        return scaled.union(*(properties_in(added.value) for added in self.functions))

    def is_empty(self) -> bool:
        """Return whether nothing is added to the aircraft's files; a temperature does not count."""
        return not any(
            getattr(self, f.name) for f in fields(self) if f.name != "temperature_offset"
        )


def _renamed(part: Any, new: Callable[[str], str]) -> Any:
    if isinstance(part, str):
        return new(part)
    if isinstance(part, tuple):
        return tuple(_renamed(each, new) for each in part)
    if is_dataclass(part) and not isinstance(part, type):
        return replace(part, **{f.name: _renamed(getattr(part, f.name), new) for f in fields(part)})
    return part


_RATE = re.compile(r"velocities/([pqr])(-aero)?-rad_sec")
_SURFACE = re.compile(r"fcs/.*(elevator|aileron|rudder)")
_SETTING = ("fcs/", "gear/", "systems/", "propulsion/")


@dataclass(frozen=True, slots=True)
class AeroFunction:
    """A named function of the aircraft's aerodynamics.

    `axis` is empty for a function outside the axes, which others read. `reads` are the properties
    that it multiplies or adds, `looks_up` those by which its tables are read. `numbers` says that
    it holds a table or a number of its own: a mere product of properties is no term.
    """

    axis: str
    name: str
    reads: frozenset[str]
    looks_up: frozenset[str] = frozenset()
    numbers: bool = True

    @property
    def variable(self) -> str:
        """The variable of the motion or the controls that the function stands for, if any.

        A body rate p, q or r, else a surface, else lift, alpha_rate, sideslip or alpha; "" for a
        constant. A function of flaps, gear, engines or another control is a `setting`. A damping
        that fades with the angle of attack is one of the rate.
        """
        factors, inputs = sorted(self.reads), sorted(self.reads | self.looks_up)
        for pattern, paths in ((_RATE, factors), (_SURFACE, inputs)):
            found = [
                match[1]
                for path in paths
                if (match := pattern.fullmatch(path) or pattern.match(path))
            ]
            if found:
                return found[0]
        if any(path.startswith(_SETTING) for path in factors):
            return "setting"
        if "aero/cl-squared" in factors:
            return "lift"
        angles = [
            ("alpha_rate", "aero/alphadot"),
            ("sideslip", "aero/beta"),
            ("alpha", "aero/alpha"),
        ]
        # A slope that also depends on the sideslip is one over the angle of attack.
        if self.axis in ("LIFT", "PITCH"):
            angles = [angles[0], angles[2], angles[1]]
        for name, start in angles:
            if any(path.replace("mag-", "").startswith(start) for path in inputs):
                return name
        return "setting" if any(path.startswith(_SETTING) for path in inputs) else ""


@dataclass(frozen=True, slots=True)
class Engine:
    """An engine of an aircraft's file.

    `location` is that of its propeller [in], `fuel_per_power` its fuel flow over indicated power
    [lb/(hp h)], 0 where unknown, and `friction` its constant friction [hp].
    """

    location: Point
    fuel_per_power: float = 0.0
    friction: float = 0.0


@dataclass(frozen=True, slots=True)
class Baseline:
    """The data of an unchanged aircraft that overlays need.

    `declared` holds the properties of its files, `dimensions` its empty mass [kg], wing area [m²]
    and chord [m] by these names, as far as the file tells them.
    """

    aircraft: str
    center_of_gravity: Point  # in, of the empty aircraft
    functions: tuple[AeroFunction, ...] = ()
    engines: tuple[Engine, ...] = ()
    declared: Mapping[str, float] = field(default_factory=dict)
    dimensions: Mapping[Dimension, float] = field(default_factory=dict)

    def terms(self, axis: str, variable: str) -> tuple[AeroFunction, ...]:
        """Return the aerodynamic functions of an axis in a variable.

        Where a function of the axis only passes on one outside the axes, such as a lift coefficient
        that lift and drag read, the term is the function outside.
        """
        direct = tuple(f for f in self.functions if f.axis == axis and f.variable == variable)
        if direct:
            return direct
        passed = (f for f in self.functions if f.axis == axis and not f.variable)
        found = (h for f in passed for h in self.behind(f) if h.variable == variable)
        return tuple(dict.fromkeys(found))

    def behind(self, function: AeroFunction) -> Iterator[AeroFunction]:
        """Return the functions outside the axes that a function reads, and those that they read."""
        for helper in self.functions:
            if not helper.axis and helper.name in function.reads:
                yield helper
                yield from self.behind(helper)
