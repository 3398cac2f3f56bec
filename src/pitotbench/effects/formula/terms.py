"""The terms of a formula: what a missing force or a wrong reading may follow.

A term is one expression over JSBSim's properties. Values for a log come from the same expression, with the
properties computed from its channels, so that a term means the same on the airplane and in a sensor.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from pitotbench import air
from pitotbench.effects.air.recorded_time import ELAPSED, RECORDING_START
from pitotbench.effects.expression import Expression, evaluate, operation, product, properties_in, total
from pitotbench.effects.signals import Signals
from pitotbench.units import FOOT, INCH_OF_MERCURY, PSF, STANDARD_GRAVITY, SUFFIXES, Array

ALPHA, BETA = "aero/alpha-rad", "aero/beta-rad"
ROLL, HEADING = "attitude/phi-rad", "attitude/psi-rad"
MACH, PRESSURE = "velocities/mach", "aero/qbar-psf"
RATED_PRESSURE, RATED_SPEED = 40.0, 2575.0  # inHg, rpm: rated power of the class, as for the propwash error


@dataclass(frozen=True, slots=True)
class Term:
    """A term: its name, the symbol that a report prints, its expression, and a usual value of it."""

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


_SPEEDS = [(f"propulsion/engine[{i}]/map-inhg", f"propulsion/engine[{i}]/propeller-rpm") for i in (0, 1)]
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
    Term("bank", "sin φ", _sine(ROLL), 0.3),
    Term("bank_squared", "sin²φ", _squared(_sine(ROLL)), 0.1),
    Term("height", "h", product("position/h-sl-ft", 1e-4), 0.5),
    Term("heading_north", "cos ψ", _cosine(HEADING), 1.0),
    Term("heading_east", "sin ψ", _sine(HEADING), 1.0),
    Term("heading_north_twice", "cos 2ψ", _cosine(HEADING, 2.0), 1.0),
    Term("heading_east_twice", "sin 2ψ", _sine(HEADING, 2.0), 1.0),
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
    return air.mach_from_impact_pressure(signals["impact_pressure"].clip(min=1.0), signals["static_pressure"])


def _dynamic_pressure(signals: Signals) -> Array:
    return np.asarray(0.5 * air.HEAT_RATIO * signals["static_pressure"] * _mach(signals) ** 2 / PSF)


_AIR_DATA = ("impact_pressure", "static_pressure")
_Reading = tuple[tuple[str, ...], Callable[[Signals], Array]]


def _channel(name: str, factor: float = 1.0) -> _Reading:
    """A channel of a log; a property of JSBSim times `factor` is SI."""
    return (name,), lambda signals: np.asarray(signals[name] / factor)


# The properties that terms read: the channels of a log that each needs, and its value from them.
_FROM_LOG: Mapping[str, _Reading] = {
    ALPHA: _channel("angle_of_attack"),
    BETA: _channel("sideslip"),
    ROLL: _channel("roll"),
    HEADING: _channel("heading"),
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
    PRESSURE: (_AIR_DATA, _dynamic_pressure),
    "position/h-sl-ft": (
        ("static_pressure",),
        lambda signals: air.pressure_altitude(signals["static_pressure"]) / FOOT,
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
    return tuple(dict.fromkeys(name for path in sorted(properties_in(term.value)) for name in _FROM_LOG[path][0]))


def values_of(term: Term, signals: Signals) -> Array:
    """Return the values of a term over a log, (n,)."""
    properties = {path: _FROM_LOG[path][1](signals) for path in properties_in(term.value)}
    return np.asarray(np.broadcast_to(evaluate(term.value, properties), signals.time.shape))
