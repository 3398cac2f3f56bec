"""A maneuver as a regression on the aerodynamic terms of a model's file."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pitotbench import air
from pitotbench.effects.overlay import AeroFunction, Baseline
from pitotbench.records.aircraft import AeroTerms, Motion
from pitotbench.records.terms import CHANNELS, Maneuver
from pitotbench.units import FOOT, POUND_FORCE, Array, Booleans

# Equation error: the measured force and moment coefficients less those of the model in the measured
# state are a sum of terms, each a function of the file times its relative change (Klein and Morelli
# 2006, Aircraft System Identification, ch. 5). A constant of each coefficient is free in each
# maneuver: trim, loading and the zeros of the accelerometers. Where thrust was not measured, a
# constant force and one that grows with time are free too.

AXIS_CHANNEL = {
    "DRAG": "drag",
    "SIDE": "side force",
    "LIFT": "lift",
    "ROLL": "roll moment",
    "PITCH": "pitch moment",
    "YAW": "yaw moment",
}
NAMES = {
    ("LIFT", "alpha"): "lift slope",
    ("LIFT", ""): "zero lift",
    ("DRAG", ""): "parasite drag",
    ("DRAG", "lift"): "induced drag",
    ("SIDE", "sideslip"): "side force",
    ("ROLL", "sideslip"): "dihedral effect",
    ("ROLL", "p"): "roll damping",
    ("PITCH", "alpha"): "pitch stiffness",
    ("PITCH", "q"): "pitch damping",
    ("PITCH", ""): "zero pitch moment",
    ("YAW", "sideslip"): "weathercock stability",
    ("YAW", "r"): "yaw damping",
    ("PITCH", "elevator"): "elevator effectiveness",
    ("ROLL", "aileron"): "aileron effectiveness",
    ("YAW", "rudder"): "rudder effectiveness",
}
VARIABLES = {
    "p": "roll rate",
    "q": "pitch rate",
    "r": "yaw rate",
    "alpha": "angle of attack",
    "alpha_rate": "rate of the angle of attack",
    "setting": "flaps, gear or power",
    "lift": "lift",
}
LEAST_RATE = (
    1e-4  # rad/s of the angle of attack from which a function over its rate is a coefficient
)


@dataclass(frozen=True, slots=True)
class Term:
    """A term that may change: its function, the axis on which it is told, and its name in the
    field's words.
    """

    function: AeroFunction
    axis: str
    name: str


@dataclass(frozen=True, slots=True)
class Regression:
    """One maneuver as a regression: residual coefficients (n, 6) in the order of `CHANNELS`, and
    its columns.

    `columns` holds the change by one whole relative change of each term, (n, 6, k), `free` what is
    unknown in every maneuver, (n, 6, f). `model` holds the coefficient of each term, (n, k), and
    `regressors` what it multiplies.
    """

    name: str
    time: Array
    residual: Array
    columns: Array
    free: Array
    model: Array
    regressors: Array
    moves: Array
    scale: Array
    kept: Booleans
    pivots: Array
    errors: Array


Turn = Callable[[Array], Array]  # of coefficients in body axes, (n, 6)


def terms_of(baseline: Baseline) -> tuple[Term, ...]:
    """Return the terms of an aircraft's file: functions with a table or a number, on an axis or
    read by one.
    """
    found: dict[AeroFunction, str] = {}
    for axis in AXIS_CHANNEL:
        for function in baseline.functions:
            if function.axis == axis:
                if function.numbers:
                    found.setdefault(_in_lift(baseline, function), axis)
                for helper in baseline.behind(function):
                    if helper.numbers and helper.variable:
                        found.setdefault(helper, "LIFT" if axis in ("LIFT", "DRAG") else axis)
    named = [(function, axis, _name(axis, function)) for function, axis in found.items()]
    count = {name: sum(n == name for *_, n in named) for *_, name in named}
    return tuple(
        Term(f, axis, name if count[name] == 1 else f"{name} ({f.name.rsplit('/', 1)[-1]})")
        for f, axis, name in named
    )


def _in_lift(baseline: Baseline, function: AeroFunction) -> AeroFunction:
    """A function of drag that reads a lift coefficient is one of the lift."""
    lifts = any(helper.variable == "alpha" for helper in baseline.behind(function))
    if function.axis == "DRAG" and not function.variable and lifts:
        return replace(function, reads=function.reads | {"aero/cl-squared"})
    return function


def _name(axis: str, function: AeroFunction) -> str:
    variable = function.variable
    told = AXIS_CHANNEL[axis]
    return NAMES.get((axis, variable)) or (
        f"{told} by {VARIABLES.get(variable, variable)}" if variable else told
    )


def regression_of(
    maneuver: Maneuver, model: AeroTerms, terms: Sequence[Term], differences: Mapping[str, Array]
) -> Regression:
    """Return a maneuver as a regression on the terms of a model.

    `differences` holds, by function outside the axes, the change of the forces [lb, lb ft] by one
    whole relative change of it, (n, 6). A slope over the angle of attack turns about its mean: its
    zero is one of the constants that are free, and the drag that reads the lift is to see both.
    """
    motion = maneuver.motion
    area, span, chord = model.wing
    pressure = 0.7 * motion.static_pressure * motion.mach**2
    scale = np.stack([pressure * area * arm for arm in (1.0, 1.0, 1.0, span, chord, span)], axis=1)
    turn = _to_wind(motion.angle_of_attack)
    speed = motion.mach * 340.3 * np.sqrt(1.0 + motion.temperature_offset / 288.15)
    rate = np.gradient(np.unwrap(motion.angle_of_attack), motion.time)
    model_force = model.total * _SI
    columns = np.zeros((len(motion.time), 6, len(terms)))
    coefficients = np.zeros((len(motion.time), len(terms)))
    pivots = np.zeros(len(terms))
    for i, term in enumerate(terms):
        function = term.function
        if function.axis:
            value = model.values[function.name]
            if function.variable == "alpha_rate":
                # The model's own rate follows its own forces; that of the log is measured.
                moved = value * (_ratio(rate, model.alpha_rate) - 1.0)
                model_force = model_force + model.units[function.axis] * _SI * moved[:, None]
                value = value + moved
            if function.variable == "alpha":
                whole = (scale / _SI)[:, CHANNELS.index(AXIS_CHANNEL[function.axis])]  # lb, lb ft
                pivots[i] = np.mean(value / whole)
                value = value - pivots[i] * whole
            columns[:, :, i] = turn(model.units[function.axis] * _SI * value[:, None] / scale)
        else:
            pivots[i] = (
                np.mean(model.values[function.name]) if function.variable == "alpha" else 0.0
            )
            columns[:, :, i] = turn(differences[function.name] * _SI / scale)
        coefficients[:, i] = columns[:, CHANNELS.index(AXIS_CHANNEL[term.axis]), i]
    measured = _measured_force(maneuver, model)
    return Regression(
        maneuver.name,
        motion.time - motion.time[0],
        turn((measured - model_force) / scale),
        columns,
        _free_columns(maneuver, pressure * area, turn),
        coefficients,
        np.stack([_regressor(term, maneuver, rate, speed, span, chord) for term in terms], axis=1),
        np.array([_move(term, maneuver) for term in terms]),
        scale,
        np.array([name in maneuver.channels for name in CHANNELS]),
        pivots,
        np.stack(
            [_errors(term, columns[:, :, i], maneuver) for i, term in enumerate(terms)], axis=1
        ),
    )


_SI = np.array([POUND_FORCE] * 3 + [POUND_FORCE * FOOT] * 3)


def _ratio(rate: Array, model: Array) -> Array:
    """The measured rate of the angle of attack over the model's, where the model's is not nearly
    zero.
    """
    kept = np.where(np.abs(model) > LEAST_RATE, model, np.nan)
    ratio = np.asarray(rate / kept)
    ratio[~np.isfinite(ratio)] = 1.0
    return np.asarray(np.clip(ratio, -5.0, 5.0))


def _measured_force(maneuver: Maneuver, model: AeroTerms) -> Array:
    """The measured force [N] and moment [N m] of the air in body axes, (n, 6); without thrust where
    unmeasured.
    """
    motion, mass = maneuver.motion, model.mass if maneuver.mass is None else maneuver.mass
    force = np.reshape(mass, (-1, 1)) * maneuver.specific_force
    if maneuver.thrust is not None:
        force = force - np.stack(
            [maneuver.thrust, 0.0 * maneuver.thrust, 0.0 * maneuver.thrust], axis=1
        )
    ixx, iyy, izz, ixz = maneuver.inertia or model.inertia
    inertia = np.array([[ixx, 0.0, -ixz], [0.0, iyy, 0.0], [-ixz, 0.0, izz]])
    rates = np.stack([motion.roll_rate, motion.pitch_rate, motion.yaw_rate], axis=1)
    moment = maneuver.angular_acceleration @ inertia + np.cross(rates, rates @ inertia)
    return np.concatenate([force, moment], axis=1)


def _to_wind(alpha: Array) -> Turn:
    """Return the function that turns coefficients in body axes, (n, 6), into drag, side force, lift
    and moments.
    """
    cosine, sine = np.cos(alpha), np.sin(alpha)

    def turn(body: Array) -> Array:
        drag = -body[:, 0] * cosine - body[:, 2] * sine
        lift = -body[:, 2] * cosine + body[:, 0] * sine
        return np.column_stack([drag, body[:, 1], lift, body[:, 3:]])

    return turn


def _free_columns(maneuver: Maneuver, force: Array, turn: Turn) -> Array:
    """The columns that are free in every maneuver, (n, 6, f): constants, and a thrust that was not
    measured.
    """
    count = len(maneuver.motion.time)
    columns = [np.tile(np.eye(6)[i], (count, 1)) for i in range(6)]
    if maneuver.thrust is None:
        elapsed = np.linspace(-1.0, 1.0, count)
        for shape in (np.ones(count), elapsed):
            body = np.zeros((count, 6))
            body[:, 0] = shape * float(np.median(force)) / force
            columns.append(turn(body))
    return np.stack(columns, axis=2)


FIELDS = {
    "p": "roll_rate",
    "q": "pitch_rate",
    "r": "yaw_rate",
    "alpha": "angle_of_attack",
}  # of a Motion


def _variable(name: str, motion: Motion) -> Array | None:
    """A variable of the motion or of the controls, (n,); None for any other."""
    field = FIELDS.get(name, name)
    return getattr(motion, field) if field in Motion.__dataclass_fields__ else None


def _move(term: Term, maneuver: Maneuver) -> float:
    """The deviation of the variable of a term about a straight line."""
    motion, name = maneuver.motion, term.function.variable
    values = _variable("alpha" if name == "alpha_rate" else name, motion)
    if values is None:
        return np.inf
    return float(np.std(values - np.polyval(np.polyfit(motion.time, values, 1), motion.time)))


ERRING = ("alpha", "sideslip", "p", "q", "r", "elevator", "aileron", "rudder")


def _errors(term: Term, column: Array, maneuver: Maneuver) -> Array:
    """The deviations of a column, (n, 6), by the errors of the variables, (6, v): its slope times
    that error.
    """
    found = np.zeros((6, len(ERRING)))
    name = term.function.variable
    values = _variable(name, maneuver.motion)
    if name in ERRING and values is not None and np.ptp(values) > 0.0:
        moved = values - values.mean()
        error = maneuver.noise.get(FIELDS.get(name, name), 0.0)
        found[:, ERRING.index(name)] = error * (moved @ column) / (moved @ moved)
    return found


def _regressor(
    term: Term, maneuver: Maneuver, rate: Array, speed: Array, span: float, chord: float
) -> Array:
    """What a coefficient multiplies: an angle [rad], a rate times half a length over the speed, or
    1.
    """
    motion, variable = maneuver.motion, term.function.variable
    lengths = {"p": span, "q": chord, "r": span, "alpha_rate": chord}
    found = rate if variable == "alpha_rate" else _variable(variable, motion)
    value = np.ones(len(motion.time)) if found is None else found
    return np.asarray(value * lengths[variable] / (2.0 * speed)) if variable in lengths else value


def coefficient_of(
    term: Term, motion: Motion, values: Array, wing: Sequence[float]
) -> tuple[float, str]:
    """Return what the values of a term, (n,), are over a motion: a slope with its unit, else their
    mean.

    `wing` is area, span and chord [m].
    """
    variable = term.function.variable
    if variable not in UNITS and variable not in RATES:
        return float(np.mean(values)), ""
    still = np.zeros((len(motion.time), 3))
    rate = np.gradient(np.unwrap(motion.angle_of_attack), motion.time)
    temperature = air.standard_temperature(air.pressure_altitude(motion.static_pressure))
    speed = np.asarray(motion.mach * air.sound_speed(temperature + motion.temperature_offset))
    regressor = _regressor(term, Maneuver("", motion, still, still), rate, speed, *wing[1:])
    return float(np.polyfit(regressor, values, 1)[0]), UNITS.get(variable, RATES.get(variable, ""))


UNITS = {
    "alpha": "per rad",
    "sideslip": "per rad",
    "elevator": "per rad",
    "aileron": "per rad",
    "rudder": "per rad",
}
RATES = {"p": "per p b/2V", "q": "per q c/2V", "r": "per r b/2V", "alpha_rate": "per α̇ c/2V"}
