"""Unit factors and suffixes.

Inside the bench everything is SI and radians; units are converted at the edges only.

Annotations such as `Pascal` name the unit of an array in a signature. They are documentation, not a
run-time check. A column or flag must end in a suffix of the table `SUFFIXES`. Factors: B. N. Taylor
and A. Thompson, NIST Special Publication 811, 2008, appendix B.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Booleans = NDArray[np.bool_]
Seconds = Annotated[Array, "s"]
Pascal = Annotated[Array, "Pa"]
Kelvin = Annotated[Array, "K"]
MetersPerSecond = Annotated[Array, "m/s"]
Meters = Annotated[Array, "m"]
Radians = Annotated[Array, "rad"]
KNOT = 1852.0 / 3600.0  # m/s, exact by definition of the nautical mile
NAUTICAL_MILE = 1852.0  # m, exact by definition
FOOT = 0.3048  # m, exact
MILE = 1609.344  # m, exact: the international mile of 5280 ft
INCH_OF_MERCURY = 3386.389  # Pa, conventional at 0 °C
# Pa, conventional: 13595.1 kg/m³ × 9.80665 m/s² × 1 mm, exact
MILLIMETER_OF_MERCURY = 133.322387415
# Pa, conventional: 1000 kg/m³ × 9.80665 m/s² × 25.4 mm, exact to the digits given
INCH_OF_WATER = 249.08891
PSI = 6894.757293168  # Pa
PSF = PSI / 144.0  # Pa
POUND = 0.45359237  # kg, exact
DEGREE = float(np.pi / 180.0)  # rad
FULL_TURN = 2.0 * np.pi  # rad
MINUTE = 60.0  # s
STANDARD_GRAVITY = 9.80665  # m/s²
POUND_FORCE = POUND * STANDARD_GRAVITY  # N
SLUG = POUND_FORCE / FOOT  # kg


@dataclass(frozen=True, slots=True)
class Suffix:
    """A unit suffix: its symbol and its name in words.

    SI value = (written value + offset) * factor.
    """

    dimension: str
    factor: float
    symbol: str
    words: str = ""
    offset: float = 0.0


SUFFIXES: dict[str, Suffix] = {
    "s": Suffix("time", 1.0, "s", "seconds"),
    "ms": Suffix("time", 1e-3, "ms", "milliseconds"),
    "min": Suffix("time", 60.0, "min", "minutes"),
    "pa": Suffix("pressure", 1.0, "Pa", "pascals"),
    "hpa": Suffix("pressure", 100.0, "hPa", "hectopascals"),
    "kpa": Suffix("pressure", 1000.0, "kPa", "kilopascals"),
    "psi": Suffix("pressure", PSI, "psi", "pounds per square inch"),
    "inhg": Suffix("pressure", INCH_OF_MERCURY, "inHg", "inches of mercury"),
    "psf": Suffix("pressure", PSF, "psf", "pounds per square foot"),
    "mmhg": Suffix("pressure", MILLIMETER_OF_MERCURY, "mmHg", "millimeters of mercury"),
    "inh2o": Suffix("pressure", INCH_OF_WATER, "inH2O", "inches of water"),
    "k": Suffix("temperature", 1.0, "K", "kelvins"),
    "degc": Suffix("temperature", 1.0, "°C", "degrees Celsius", 273.15),
    "degr": Suffix("temperature", 5.0 / 9.0, "°R", "degrees Rankine"),
    "degf": Suffix("temperature", 5.0 / 9.0, "°F", "degrees Fahrenheit", 459.67),
    "mps": Suffix("speed", 1.0, "m/s", "meters per second"),
    "kt": Suffix("speed", KNOT, "kt", "knots"),
    "fps": Suffix("speed", FOOT, "ft/s", "feet per second"),
    "mph": Suffix("speed", MILE / 3600.0, "mph", "miles per hour"),
    "kmh": Suffix("speed", 1.0 / 3.6, "km/h", "kilometers per hour"),
    "fpm": Suffix("speed", FOOT / 60.0, "ft/min", "feet per minute"),
    "m": Suffix("length", 1.0, "m", "meters"),
    "ft": Suffix("length", FOOT, "ft", "feet"),
    "rad": Suffix("angle", 1.0, "rad", "radians"),
    "deg": Suffix("angle", DEGREE, "°", "degrees"),
    "radps": Suffix("angular rate", 1.0, "rad/s", "radians per second"),
    "degps": Suffix("angular rate", DEGREE, "°/s", "degrees per second"),
    "rpm": Suffix("angular rate", float(2.0 * np.pi / 60.0), "rpm", "revolutions per minute"),
    "mps2": Suffix("acceleration", 1.0, "m/s²"),
    "fps2": Suffix("acceleration", FOOT, "ft/s²"),
    "g": Suffix("acceleration", STANDARD_GRAVITY, "g"),
    "kg": Suffix("mass", 1.0, "kg", "kilograms"),
    "lb": Suffix("mass", POUND, "lb", "pounds"),
    "kgps": Suffix("mass flow", 1.0, "kg/s"),
    "pph": Suffix("mass flow", POUND / 3600.0, "lb/h"),
}

# The symbol of each suffix, and of those with which a number is named, but no column.
SYMBOLS = {name: unit.symbol for name, unit in SUFFIXES.items()}
SYMBOLS |= {"m2": "m²", "rad2": "rad²", "km": "km", "hz": "Hz"}


def percent_text(share: float, sign: str = "") -> str:
    """Return a share in whole percent, as text; `sign` is "+" where a plus is written as well."""
    return f"{100.0 * share:{sign}.0f} %"


def to_si(value: Array | float, suffix: str) -> Array:
    """Convert a written value to SI. For example, `to_si(100.0, "kt")` is 51.44 m/s.

    Parameters: value, any shape [unit of `suffix`]; suffix, a key of `SUFFIXES`.
    Raises KeyError for an unknown suffix.
    """
    unit = SUFFIXES[suffix]
    return (np.asarray(value, dtype=np.float64) + unit.offset) * unit.factor


def from_si(value: Array | float, suffix: str) -> Array:
    """Convert an SI value, of any shape, to the unit of `suffix`: the inverse of `to_si`.

    Raises KeyError as `to_si` does.
    """
    unit = SUFFIXES[suffix]
    return np.asarray(value, dtype=np.float64) / unit.factor - unit.offset
