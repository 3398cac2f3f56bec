"""Formulas of sensors: by how much a sensor reads wrong, as a sum of terms."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

from pitotbench.effects.effect import SensorEffect
from pitotbench.effects.excitation import RANGE_OF_AIRSPEED
from pitotbench.effects.formula.coefficients import formula_value, parameters_of
from pitotbench.effects.signals import Signals
from pitotbench.effects.static_source import displaced
from pitotbench.units import SUFFIXES

SOURCE = "Haering 1995, NASA TM-104316: corrections of air-data sensors as functions of the measured state"
AIR_STATE = ("alpha", "alpha_squared", "sideslip", "sideslip_squared")
TURNING = ("roll_rate", "pitch_rate", "yaw_rate")
CONTROLS = ("elevator", "aileron", "rudder")
POWER = ("power", "power_squared")
ATTITUDE = ("bank", "bank_squared")
SPEED = ("mach", "mach_squared", "pressure", "pressure_squared")
HEADING = ("heading_north", "heading_east", "heading_north_twice", "heading_east_twice")
LOADS = ("load_forward", "load_right", "load_down")
PLACE = ("height", "time")
PRODUCTS = ("power_alpha", "power_sideslip")
FLOW_TERMS = ("constant", *AIR_STATE, *TURNING, *CONTROLS, *POWER, *ATTITUDE, *PLACE, *PRODUCTS)


@dataclass(frozen=True, slots=True)
class Reading:
    """A quantity that a sensor reads: in words, its symbol, the unit of its error, the channels, and the terms.

    `typical` is an error, in this unit, that a report would mention.
    """

    quantity: str
    symbol: str
    unit: str
    typical: float
    channels: tuple[str, ...]
    terms: tuple[str, ...]


def _each(
    name: str, quantity: str, symbol: str, unit: str, typical: float, terms: tuple[str, ...]
) -> dict[str, Reading]:
    """A gauge of both engines, and that of each of them."""
    sides = {"": ("left", "right"), "left ": ("left",), "right ": ("right",)}
    return {
        f"{side.replace(' ', '_')}{name}_formula": Reading(
            side + quantity, symbol, unit, typical, tuple(f"{name}_{s}" for s in engines), terms
        )
        for side, engines in sides.items()
    }


def _inertial(axes: Mapping[str, tuple[str, str]], unit: str, typical: float) -> dict[str, Reading]:
    """The accelerometers or the gyros: names of their channels with the quantity in words and its symbol."""
    terms = (*LOADS, *TURNING, "sideslip", "alpha", *POWER, *ATTITUDE, "pressure", *PLACE)
    return {
        f"{channel}_formula": Reading(quantity, symbol, unit, typical, (channel,), terms)
        for channel, (quantity, symbol) in axes.items()
    }


STATIC_PRESSURE, TOTAL_PRESSURE = "static_pressure_formula", "total_pressure_formula"
READINGS: Mapping[str, Reading] = {
    STATIC_PRESSURE: Reading(
        "static pressure", "Δp_s/q_c", "", 0.01, ("impact_pressure", "static_pressure"), FLOW_TERMS
    ),
    TOTAL_PRESSURE: Reading("total pressure", "Δp_t/q_c", "", 0.01, ("impact_pressure",), FLOW_TERMS),
    "temperature_formula": Reading(
        "temperature", "ΔT", "k", 1.0, ("total_temperature",), (*SPEED, *AIR_STATE, *POWER, *ATTITUDE, *PLACE)
    ),
    "heading_formula": Reading(
        "heading", "Δψ", "deg", 1.0, ("heading",), (*HEADING, *ATTITUDE, *TURNING, *LOADS[:2], *POWER, *PLACE)
    ),
    "roll_formula": Reading("roll", "Δφ", "deg", 0.5, ("roll",), (*ATTITUDE, *TURNING, *LOADS, *HEADING, *PLACE)),
    "pitch_formula": Reading(
        "pitch", "Δθ", "deg", 0.5, ("pitch",), (*ATTITUDE, *TURNING, *LOADS, *HEADING, *PLACE)
    ),
    "angle_of_attack_formula": Reading(
        "angle of attack", "Δα", "deg", 0.5, ("angle_of_attack",), (*FLOW_TERMS, "pressure")
    ),
    "sideslip_formula": Reading("sideslip", "Δβ", "deg", 0.5, ("sideslip",), (*FLOW_TERMS, "pressure")),
    **_inertial(
        {
            "specific_force_x": ("longitudinal acceleration", "Δa_x"),
            "specific_force_y": ("lateral acceleration", "Δa_y"),
            "specific_force_z": ("normal acceleration", "Δa_z"),
        },
        "mps2",
        0.1,
    ),
    **_inertial(
        {
            "roll_rate": ("roll rate", "Δp"),
            "pitch_rate": ("pitch rate", "Δq"),
            "yaw_rate": ("yaw rate", "Δr"),
        },
        "degps",
        0.2,
    ),
    **{
        f"velocity_{way}_formula": Reading(
            f"velocity {way}",
            f"ΔV_{way[0].upper()}",
            "mps",
            0.3,
            (f"velocity_{way}",),
            (*HEADING, *ATTITUDE, *PLACE),
        )
        for way in ("north", "east", "down")
    },
    "altitude_formula": Reading(
        "GPS altitude", "Δh", "m", 3.0, ("altitude",), (*HEADING, *ATTITUDE, "pressure", *PLACE)
    ),
    **_each(
        "manifold_pressure",
        "manifold pressure",
        "ΔMP",
        "inhg",
        0.5,
        (*POWER, "pressure", *PLACE),
    ),
    **_each("propeller_speed", "propeller speed", "Δn", "rpm", 20.0, (*POWER, "pressure", *PLACE)),
    **_each("fuel_flow", "fuel flow", "Δw_f", "pph", 3.0, (*POWER, "pressure", *PLACE)),
}


def _apply(name: str, signals: Signals, sizes: Mapping[str, float]) -> Signals:
    reading = READINGS[name]
    value = formula_value(name, signals, sizes, reading.unit)
    if name == STATIC_PRESSURE:
        return displaced(signals, value * signals["impact_pressure"])
    if name == TOTAL_PRESSURE:
        return signals.with_channels(impact_pressure=signals["impact_pressure"] * (1.0 + value))
    error = value * (SUFFIXES[reading.unit].factor if reading.unit else 1.0)
    return signals.with_channels(**{channel: signals[channel] + error for channel in reading.channels})


SENSOR_FORMULAS: Mapping[str, SensorEffect] = {
    name: SensorEffect(
        name=name,
        family="das",
        acts_on="sensors",
        parameters=parameters_of(reading.terms, reading.unit, reading.typical, reading.symbol),
        source=SOURCE,
        what=f"The {reading.quantity} is read with an error that follows a formula.",
        shows_in=RANGE_OF_AIRSPEED,
        changes=reading.channels,
        function=partial(_apply, name),
    )
    for name, reading in READINGS.items()
}
