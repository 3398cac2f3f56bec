"""Formulas: effects whose sizes are coefficients of terms, for causes that the table lacks."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np

from pitotbench import air
from pitotbench.catalog import Catalog
from pitotbench.effects.airframe import LENGTHS, coefficient_function
from pitotbench.effects.effect import (
    ELAPSED,
    RANGE_OF_AIRSPEED,
    RECORDING_START,
    AircraftEffect,
    Build,
    Effect,
    Parameter,
    SensorEffect,
)
from pitotbench.effects.overlay import (
    Baseline,
    Expression,
    Overlay,
    evaluate,
    operation,
    product,
    properties_in,
    size,
    total,
)
from pitotbench.effects.response import Signals, displaced
from pitotbench.units import FOOT, INCH_OF_MERCURY, PSF, STANDARD_GRAVITY, SUFFIXES, Array

ALPHA, BETA = "aero/alpha-rad", "aero/beta-rad"
BANK, YAW = "attitude/phi-rad", "attitude/psi-rad"
MACH, PRESSURE = "velocities/mach", "aero/qbar-psf"
# inHg and rpm: rated power of the class, as for the propwash error.
RATED_PRESSURE, RATED_SPEED = 40.0, 2575.0


@dataclass(frozen=True, slots=True)
class Term:
    """A term: its name, the symbol that a report prints, its expression, and a usual value of it.

    Values for a log come from the same expression, with the properties computed from its channels,
    so that a term means the same on the airplane and in a sensor.
    """

    name: str
    symbol: str
    value: Expression
    usual: float


def _same(value: str) -> Expression:
    return product(value, 1.0)


def _sine(path: str, times: float = 1.0) -> Expression:
    return operation("sin", product(path, times))


def _cosine(path: str, times: float = 1.0) -> Expression:
    return operation("cos", product(path, times))


def _squared(value: str) -> Expression:
    return product(value, value)


_SPEEDS = [
    (f"propulsion/engine[{i}]/map-inhg", f"propulsion/engine[{i}]/propeller-rpm") for i in (0, 1)
]
_POWER = product(total(*(product(*each) for each in _SPEEDS)), 0.5 / (RATED_PRESSURE * RATED_SPEED))
_KILOPASCALS = product(PRESSURE, PSF / 1000.0)

_ALL = (
    Term("constant", "1", product(1.0, 1.0), 1.0),
    Term("alpha", "α", _same(ALPHA), 0.05),
    Term("alpha_squared", "α²", _squared(ALPHA), 0.0025),
    Term("sideslip", "β", _same(BETA), 0.05),
    Term("sideslip_squared", "sin²β", _squared(_sine(BETA)), 0.0025),
    Term("roll_rate", "p", _same("velocities/p-rad_sec"), 0.05),
    Term("pitch_rate", "q", _same("velocities/q-rad_sec"), 0.05),
    Term("yaw_rate", "r", _same("velocities/r-rad_sec"), 0.05),
    Term("elevator", "δe", _same("fcs/elevator-pos-rad"), 0.05),
    Term("aileron", "δa", _same("fcs/left-aileron-pos-rad"), 0.05),
    Term("rudder", "δr", _same("fcs/rudder-pos-rad"), 0.05),
    Term("mach", "M", _same(MACH), 0.2),
    Term("mach_squared", "M²", _squared(MACH), 0.04),
    Term("pressure", "q̄", _KILOPASCALS, 3.0),
    Term("pressure_squared", "q̄²", _squared(_KILOPASCALS), 9.0),
    Term("power", "P", _POWER, 0.5),
    Term("power_squared", "P²", _squared(_POWER), 0.25),
    Term("bank", "sin φ", _sine(BANK), 0.3),
    Term("bank_squared", "sin²φ", _squared(_sine(BANK)), 0.1),
    Term("height", "h", product("position/h-sl-ft", 1e-4), 0.5),
    Term("heading_north", "cos ψ", _cosine(YAW), 1.0),
    Term("heading_east", "sin ψ", _sine(YAW), 1.0),
    Term("heading_north_twice", "cos 2ψ", _cosine(YAW, 2.0), 1.0),
    Term("heading_east_twice", "sin 2ψ", _sine(YAW, 2.0), 1.0),
    Term("time", "t", product(ELAPSED, 1.0 / 600.0), 0.5),
    Term("load_forward", "n_x", _same("accelerations/Nx"), 0.1),
    Term("load_right", "n_y", _same("accelerations/Ny"), 0.1),
    Term("load_down", "n_z", _same("accelerations/Nz"), 1.0),
    Term("pressure_alpha", "q̄ α", product(_KILOPASCALS, ALPHA), 0.15),
    Term("power_alpha", "P α", product(_POWER, ALPHA), 0.025),
    Term("power_sideslip", "P β", product(_POWER, BETA), 0.025),
)
TERMS: Mapping[str, Term] = {term.name: term for term in _ALL}


def _mach(signals: Signals) -> Array:
    return air.mach_from_impact_pressure(
        signals["impact_pressure"].clip(min=1.0), signals["static_pressure"]
    )


_AIR_DATA = ("impact_pressure", "static_pressure")
_Reading = tuple[tuple[str, ...], Callable[[Signals], Array]]


def _channel(name: str, factor: float = 1.0) -> _Reading:
    """A channel of a log; a property of JSBSim times `factor` is SI."""
    return (name,), lambda signals: np.asarray(signals[name] / factor)


# The properties that terms read: the channels of a log that each needs, and its value from them.
_FROM_LOG: Mapping[str, _Reading] = {
    ALPHA: _channel("angle_of_attack"),
    BETA: _channel("sideslip"),
    BANK: _channel("roll"),
    YAW: _channel("heading"),
    "velocities/p-rad_sec": _channel("roll_rate"),
    "velocities/q-rad_sec": _channel("pitch_rate"),
    "velocities/r-rad_sec": _channel("yaw_rate"),
    "fcs/elevator-pos-rad": _channel("elevator"),
    "fcs/left-aileron-pos-rad": _channel("aileron"),
    "fcs/rudder-pos-rad": _channel("rudder"),
    "accelerations/Nx": _channel("specific_force_x", STANDARD_GRAVITY),
    "accelerations/Ny": _channel("specific_force_y", STANDARD_GRAVITY),
    "accelerations/Nz": _channel("specific_force_z", STANDARD_GRAVITY),
    MACH: (_AIR_DATA, _mach),
    PRESSURE: (
        _AIR_DATA,
        lambda log: np.asarray(
            0.5 * air.HEAT_RATIO * log["static_pressure"] * _mach(log) ** 2 / PSF
        ),
    ),
    "position/h-sl-ft": (
        ("static_pressure",),
        lambda log: air.pressure_altitude(log["static_pressure"]) / FOOT,
    ),
    "simulation/sim-time-sec": ((), lambda signals: signals.time - signals.time[0]),
    RECORDING_START: ((), lambda signals: np.zeros(len(signals))),
    **{
        path: _channel(f"manifold_pressure_{s}", INCH_OF_MERCURY)
        for s, (path, _) in zip(("left", "right"), _SPEEDS, strict=True)
    },
    **{
        path: _channel(f"propeller_speed_{s}", SUFFIXES["rpm"].factor)
        for s, (_, path) in zip(("left", "right"), _SPEEDS, strict=True)
    },
}


def channels_of(term: Term) -> tuple[str, ...]:
    """Return the channels of a log that a term reads."""
    return tuple(
        dict.fromkeys(
            name for path in sorted(properties_in(term.value)) for name in _FROM_LOG[path][0]
        )
    )


def values_of(term: Term, signals: Signals) -> Array:
    """Return the values of a term over a log, (n,), in the unit of the term."""
    properties = {path: _FROM_LOG[path][1](signals) for path in properties_in(term.value)}
    return np.asarray(np.broadcast_to(evaluate(term.value, properties), signals.time.shape))


MOST = 50.0  # times the typical coefficient: no table bounds it, but a formula is no license for nonsense


def term_of(parameter: str, unit: str) -> Term:
    """Return the term of a coefficient, in a unit suffix that may be empty."""
    return TERMS[parameter.removesuffix(f"_{unit}") if unit else parameter]


def parameters_of(
    terms: Iterable[str], unit: str, typical: float, symbol: str
) -> tuple[Parameter, ...]:
    """Return the coefficients of some terms; at its usual value each term then gives `typical`."""
    found = []
    for name in terms:
        size, what = typical / TERMS[name].usual, f"coefficient of {TERMS[name].symbol} in {symbol}"
        written = f"{name}_{unit}" if unit else name
        found.append(Parameter(written, size, -MOST * size, MOST * size, what, may_be_missing=True))
    return tuple(found)


def formula_value(effect: str, signals: Signals, sizes: Mapping[str, float], unit: str) -> Array:
    """Return the value of a formula over a log, (n,), in its unit.

    Raises BadInputError that names a channel which a term needs and the log lacks.
    """
    value = np.zeros(len(signals))
    for parameter, coefficient in sizes.items():
        if coefficient:
            term = term_of(parameter, unit)
            signals.require(effect, channels_of(term))
            value = value + coefficient * values_of(term, signals)
    return value


STATES = (
    "alpha",
    "alpha_squared",
    "sideslip",
    "sideslip_squared",
    "roll_rate",
    "pitch_rate",
    "yaw_rate",
)
CONTROLS = ("elevator", "aileron", "rudder")
AROUND = (
    "pressure",
    "pressure_squared",
    "power",
    "power_squared",
    "bank",
    "bank_squared",
    "height",
)
FORCE_PRODUCTS = ("pressure_alpha", "power_alpha", "power_sideslip")
FORCE_TERMS = ("constant", *STATES, *CONTROLS, *AROUND, *FORCE_PRODUCTS)


@dataclass(frozen=True, slots=True)
class Axis:
    """An aerodynamic axis: its coefficient, a typical change of it, and its reference length.

    A force has no reference length.
    """

    quantity: str
    symbol: str
    typical: float
    length: str = ""


AXES: Mapping[str, Axis] = {
    "DRAG": Axis("drag", "ΔC_D", 0.005),
    "SIDE": Axis("side force", "ΔC_Y", 0.01),
    "LIFT": Axis("lift", "ΔC_L", 0.02),
    "ROLL": Axis("roll moment", "ΔC_l", 0.002, LENGTHS["ROLL"]),
    "PITCH": Axis("pitch moment", "ΔC_m", 0.01, LENGTHS["PITCH"]),
    "YAW": Axis("yaw moment", "ΔC_n", 0.002, LENGTHS["YAW"]),
}


def _force(axis: str) -> Build:
    """The build of a force or a moment that is the sum of the terms with a coefficient."""

    def build(effect: AircraftEffect, sizes: Mapping[str, float], _: Baseline) -> Overlay:
        used = {term: value for term, value in sizes.items() if value}
        parts = [product(size(effect.name, term), TERMS[term].value) for term in used]
        force = coefficient_function(axis, total(*parts) if len(parts) > 1 else parts[0])
        return Overlay(sizes=effect.properties(used), functions=(force,))

    return build


FORCE_AXES: Mapping[str, str] = {
    f"{each.quantity.replace(' ', '_')}_formula": axis for axis, each in AXES.items()
}
FORCE_FORMULAS: Mapping[str, AircraftEffect] = {
    name: AircraftEffect(
        name=name,
        parameters=parameters_of(FORCE_TERMS, "", AXES[axis].typical, AXES[axis].symbol),
        source="Klein and Morelli 2006, Aircraft System Identification, ch. 5: coefficients as "
        "sums of regressors",
        what=f"The airplane has a further {AXES[axis].quantity} that follows a formula.",
        shows_in=RANGE_OF_AIRSPEED,
        build=_force(axis),
    )
    for name, axis in FORCE_AXES.items()
}


AIR_STATE = ("alpha", "alpha_squared", "sideslip", "sideslip_squared")
TURNING = ("roll_rate", "pitch_rate", "yaw_rate")
POWER = ("power", "power_squared")
ATTITUDE = ("bank", "bank_squared")
SPEED = ("mach", "mach_squared", "pressure", "pressure_squared")
HEADING = ("heading_north", "heading_east", "heading_north_twice", "heading_east_twice")
LOADS = ("load_forward", "load_right", "load_down")
PLACE = ("height", "time")
SENSOR_PRODUCTS = ("power_alpha", "power_sideslip")
FLOW_TERMS = (
    "constant",
    *AIR_STATE,
    *TURNING,
    *CONTROLS,
    *POWER,
    *ATTITUDE,
    *PLACE,
    *SENSOR_PRODUCTS,
)


@dataclass(frozen=True, slots=True)
class Reading:
    """A quantity that a sensor reads, its channels, and the terms that its error may have.

    `typical` is an error, in `unit`, that a report would mention.
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
    """The readings of the accelerometers or the gyros, by the names of their effects.

    `axes` are the quantity in words and its symbol by channel.
    """
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
    TOTAL_PRESSURE: Reading(
        "total pressure", "Δp_t/q_c", "", 0.01, ("impact_pressure",), FLOW_TERMS
    ),
    "temperature_formula": Reading(
        "temperature",
        "ΔT",
        "k",
        1.0,
        ("total_temperature",),
        (*SPEED, *AIR_STATE, *POWER, *ATTITUDE, *PLACE),
    ),
    "heading_formula": Reading(
        "heading",
        "Δψ",
        "deg",
        1.0,
        ("heading",),
        (*HEADING, *ATTITUDE, *TURNING, *LOADS[:2], *POWER, *PLACE),
    ),
    "roll_formula": Reading(
        "roll", "Δφ", "deg", 0.5, ("roll",), (*ATTITUDE, *TURNING, *LOADS, *HEADING, *PLACE)
    ),
    "pitch_formula": Reading(
        "pitch", "Δθ", "deg", 0.5, ("pitch",), (*ATTITUDE, *TURNING, *LOADS, *HEADING, *PLACE)
    ),
    "angle_of_attack_formula": Reading(
        "angle of attack", "Δα", "deg", 0.5, ("angle_of_attack",), (*FLOW_TERMS, "pressure")
    ),
    "sideslip_formula": Reading(
        "sideslip", "Δβ", "deg", 0.5, ("sideslip",), (*FLOW_TERMS, "pressure")
    ),
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
        "manifold_pressure", "manifold pressure", "ΔMP", "inhg", 0.5, (*POWER, "pressure", *PLACE)
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
    return signals.with_channels(
        **{channel: signals[channel] + error for channel in reading.channels}
    )


SENSOR_FORMULAS: Mapping[str, SensorEffect] = {
    name: SensorEffect(
        name=name,
        parameters=parameters_of(reading.terms, reading.unit, reading.typical, reading.symbol),
        source="Haering 1995, NASA TM-104316: corrections of air-data sensors as functions of "
        "the measured state",
        what=f"The {reading.quantity} is read with an error that follows a formula.",
        shows_in=RANGE_OF_AIRSPEED,
        changes=reading.channels,
        function=partial(_apply, name),
    )
    for name, reading in READINGS.items()
}


FORMULAS: Catalog[Effect] = Catalog("formula", {**FORCE_FORMULAS, **SENSOR_FORMULAS})
