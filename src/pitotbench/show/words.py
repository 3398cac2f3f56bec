"""Names of the code in the field's words and units: kt, ft, lb, inHg, degrees."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import floor, log10

from pitotbench.units import DEGREE, KNOT, POUND_FORCE, SUFFIXES, SYMBOLS

_DIGITS = 3  # of a size, significant
_PLAIN_BELOW = 1e7  # a number is written without a power of ten


_INITIALS = {"gps": "GPS"}  # words that are written in capitals


def words(name: str) -> str:
    """A name of the code, or a sentence with such names, as words."""
    return " ".join(_INITIALS.get(word, word) for word in name.replace("_", " ").split(" "))


def heading(name: str) -> str:
    """A name of the code as words, with a capital at its start: `GPS latency`, `Drag area`."""
    return capital(words(name))


def capital(text: str) -> str:
    """A text with a capital at its start; its other letters stay."""
    return text[:1].upper() + text[1:]


def name_and_unit(name: str) -> tuple[str, str]:
    """Return a name without its suffix as words, and the suffix's unit, "" for a bare number.

    The unit of a rate such as `shift_pa_per_k` is `Pa per K`.
    """
    first, _, last = name.rpartition("_per_")
    if first and last in SYMBOLS:
        noun, unit = name_and_unit(first)
        return noun, f"{unit} per {SYMBOLS[last]}".lstrip()
    suffix = max((s for s in SYMBOLS if name.endswith(f"_{s}")), key=len, default="")
    return words(name.removesuffix(f"_{suffix}")), SYMBOLS.get(suffix, "")


def size_words(name: str, value: float, bound: float | None = None) -> str:
    """A size with its ±2σ bound and its unit: `drag area 0.12 ± 0.01 m²`."""
    noun, unit = name_and_unit(name)
    if bound is None:
        return f"{noun} {with_unit(_number(value, _DIGITS), unit)}"
    digits = _DIGITS
    if 0.0 < bound < abs(value):  # all digits that the bound leaves
        digits = max(digits, floor(log10(abs(value))) - floor(log10(bound)) + 1)
    return f"{noun} {with_unit(f'{_number(value, digits)} ± {_number(bound, 2)}', unit)}"


def _number(value: float, digits: int) -> str:
    """A number with significant digits, and no power of ten below `_PLAIN_BELOW`."""
    text = f"{value:.{digits}g}"
    return f"{float(text):.0f}" if "e+" in text and abs(value) < _PLAIN_BELOW else text


def listed(items: Sequence[str], word: str = "and") -> str:
    """One item, or several with commas between them and a word before the last."""
    return items[0] if len(items) == 1 else f"{', '.join(items[:-1])} {word} {items[-1]}"


def with_unit(number: str, unit: str) -> str:
    """A number with its unit; the degree sign of an angle follows without a space."""
    return f"{number}{unit}" if unit == "°" else f"{number} {unit}".rstrip()


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


def _in(suffix: str, name: str) -> FieldUnit:
    return FieldUnit(name, SYMBOLS[suffix], SUFFIXES[suffix].factor)


# A specific force times the mass of the airplane is in pounds.
CHANNELS = {
    "airspeed_along": _in("kt", "speed along the flight"),
    "airspeed_across": _in("kt", "speed across the flight"),
    "airspeed_down": _in("kt", "vertical speed, down"),
    "pressure_height": _in("ft", "pressure altitude"),
    "temperature": _in("k", "total temperature"),
    "acceleration_forward": _in("g", "acceleration along the flight"),
    "acceleration_right": _in("g", "acceleration to the right"),
    "acceleration_down": _in("g", "acceleration down"),
    "attitude_roll_rate": _in("degps", "roll gyro against the attitude"),
    "attitude_pitch_rate": _in("degps", "pitch gyro against the attitude"),
    "attitude_yaw_rate": _in("degps", "yaw gyro against the attitude"),
    "climb_rate": _in("fpm", "change of the altitude against the vertical speed"),
    "specific_force_x": FieldUnit("thrust less drag", "lb", POUND_FORCE),
    "specific_force_y": FieldUnit("side force", "lb", POUND_FORCE),
    "specific_force_z": FieldUnit("force down", "lb", POUND_FORCE),
    "roll_acceleration": FieldUnit("roll acceleration", "°/s²", DEGREE),
    "pitch_acceleration": FieldUnit("pitch acceleration", "°/s²", DEGREE),
    "yaw_acceleration": FieldUnit("yaw acceleration", "°/s²", DEGREE),
    "manifold_pressure_left": _in("inhg", "manifold pressure, left"),
    "manifold_pressure_right": _in("inhg", "manifold pressure, right"),
    "propeller_speed_left": _in("rpm", "propeller speed, left"),
    "propeller_speed_right": _in("rpm", "propeller speed, right"),
    "fuel_flow_left": _in("pph", "fuel flow, left"),
    "fuel_flow_right": _in("pph", "fuel flow, right"),
    "throttle_split": FieldUnit("throttle, left less right", "%", 0.01),
}

WITHOUT_MASS = _in("g", "")  # a specific force where the mass is not recorded

VARIABLES = {
    "airspeed": _in("kt", "true airspeed"),
    "bank": _in("deg", "bank"),
    "altitude": _in("ft", "altitude"),
    "power": _in("inhg", "manifold pressure"),
    "time": _in("min", "time"),
    "acceleration": FieldUnit("change of airspeed", "kt/s", KNOT),
}


def unit_without_mass(channel: str) -> FieldUnit:
    """Return the unit of a residual channel where no mass turns a specific force into a force."""
    unit = CHANNELS[channel]
    return (
        FieldUnit(unit.name, WITHOUT_MASS.unit, WITHOUT_MASS.factor) if is_force(channel) else unit
    )


def is_force(channel: str) -> bool:
    """Whether a channel is a force a mass, which the mass turns into pounds."""
    return channel.startswith("specific_force")
