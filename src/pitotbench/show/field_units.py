"""Residual channels and flight variables in the field's words and units: kt, ft, lb, inHg, degrees."""

from dataclasses import dataclass

from pitotbench.units import DEGREE, FOOT, INCH_OF_MERCURY, KNOT, POUND, STANDARD_GRAVITY

HOUR = 3600.0  # s
REVOLUTION_A_MINUTE = 6.0 * DEGREE  # rad/s
MINUTE = 60.0  # s


@dataclass(frozen=True, slots=True)
class FieldUnit:
    """A quantity as a flight-test engineer writes it: its name, its unit, and that unit in SI."""

    name: str
    unit: str
    factor: float

    @property
    def title(self) -> str:
        """The name as it begins a heading."""
        return f"{self.name[0].upper()}{self.name[1:]}"


_FORCE = POUND * STANDARD_GRAVITY  # N, for a specific force times the mass of the airplane
CHANNELS = {
    "airspeed_along": FieldUnit("speed along the flight", "kt", KNOT),
    "airspeed_across": FieldUnit("speed across the flight", "kt", KNOT),
    "airspeed_down": FieldUnit("vertical speed, down", "kt", KNOT),
    "pressure_height": FieldUnit("pressure altitude", "ft", FOOT),
    "temperature": FieldUnit("total temperature", "K", 1.0),
    "acceleration_forward": FieldUnit("acceleration along the flight", "g", STANDARD_GRAVITY),
    "acceleration_right": FieldUnit("acceleration to the right", "g", STANDARD_GRAVITY),
    "acceleration_down": FieldUnit("acceleration down", "g", STANDARD_GRAVITY),
    "specific_force_x": FieldUnit("thrust less drag", "lb", _FORCE),
    "specific_force_y": FieldUnit("side force", "lb", _FORCE),
    "specific_force_z": FieldUnit("force down", "lb", _FORCE),
    "roll_acceleration": FieldUnit("roll acceleration", "°/s²", DEGREE),
    "pitch_acceleration": FieldUnit("pitch acceleration", "°/s²", DEGREE),
    "yaw_acceleration": FieldUnit("yaw acceleration", "°/s²", DEGREE),
    "manifold_pressure_left": FieldUnit("manifold pressure, left", "inHg", INCH_OF_MERCURY),
    "manifold_pressure_right": FieldUnit("manifold pressure, right", "inHg", INCH_OF_MERCURY),
    "propeller_speed_left": FieldUnit("propeller speed, left", "rpm", REVOLUTION_A_MINUTE),
    "propeller_speed_right": FieldUnit("propeller speed, right", "rpm", REVOLUTION_A_MINUTE),
    "fuel_flow_left": FieldUnit("fuel flow, left", "lb/h", POUND / HOUR),
    "fuel_flow_right": FieldUnit("fuel flow, right", "lb/h", POUND / HOUR),
    "throttle_split": FieldUnit("throttle, left less right", "%", 0.01),
}
WITHOUT_MASS = FieldUnit("", "g", STANDARD_GRAVITY)  # a specific force where the mass is not recorded
VARIABLES = {
    "airspeed": FieldUnit("true airspeed", "kt", KNOT),
    "bank": FieldUnit("bank", "°", DEGREE),
    "altitude": FieldUnit("altitude", "ft", FOOT),
    "power": FieldUnit("manifold pressure", "inHg", INCH_OF_MERCURY),
    "time": FieldUnit("time", "min", MINUTE),
}


def unit_without_mass(channel: str) -> FieldUnit:
    """Return the unit of a residual channel where no mass turns a specific force into a force."""
    unit = CHANNELS[channel]
    return FieldUnit(unit.name, WITHOUT_MASS.unit, WITHOUT_MASS.factor) if is_force(channel) else unit


def is_force(channel: str) -> bool:
    """Whether a channel is a force a mass, which the mass turns into pounds."""
    return channel.startswith("specific_force")
