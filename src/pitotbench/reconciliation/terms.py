"""Judge the aerodynamic terms of a model's file by equation error: which are off, by how much, what they close."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import toeplitz

from pitotbench.effects.overlay import AeroFunction, Baseline
from pitotbench.records.aircraft import AeroTerms
from pitotbench.records.calibration import Estimate
from pitotbench.records.terms import CHANNELS, ChannelGap, Maneuver, ManeuverGap, TermEstimate, TermsAccount
from pitotbench.units import FOOT, POUND, STANDARD_GRAVITY, Array

# Equation error: the measured force and moment coefficients less those of the model in the measured state are a
# sum of terms, each a function of the file times its relative change (Klein and Morelli 2006, Aircraft System
# Identification, ch. 5). A constant of each coefficient is free in each maneuver: trim, loading and the zeros of
# the accelerometers. Where thrust was not measured, a constant force and one that grows with time are free too.

POUND_FORCE = POUND * STANDARD_GRAVITY
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
SIGNIFICANT = 3.0  # deviations from which a term enters
LEAST_GAIN = 0.005  # of the explainable gap that a term must close on what it was not fitted to
UNSEEN = 3.0  # times the noise that a change by half must move a channel, so that the maneuver can show the term
PLAUSIBLE = (-2.0, 4.0)  # relative change; beyond it the term stands for something else
ALIKE = 0.95  # correlation from which two terms cannot be told apart
LONGEST_MEMORY = 300  # samples of the residual's autocovariance
LEAST_RATE = 1e-4  # rad/s of the angle of attack from which a function over its rate is a coefficient


@dataclass(frozen=True, slots=True)
class Term:
    """A term that may change: its function, the axis on which it is told, and its name in the field's words."""

    function: AeroFunction
    axis: str
    name: str


@dataclass(frozen=True, slots=True)
class Regression:
    """One maneuver as a regression: residual coefficients (n, 6) in the order of `CHANNELS`, and its columns.

    `columns` holds the change by one whole relative change of each term, (n, 6, k), `free` what is unknown in every
    maneuver, (n, 6, f). `model` holds the coefficient of each term, (n, k), and `regressors` what it multiplies.
    """

    name: str
    time: Array
    residual: Array
    columns: Array
    free: Array
    model: Array
    regressors: Array


Turn = Callable[[Array], Array]  # of coefficients in body axes, (n, 6)


def terms_of(baseline: Baseline) -> tuple[Term, ...]:
    """Return the terms of an aircraft's file: functions with a table or a number, on an axis or read by one."""
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
    return NAMES.get((axis, variable)) or (f"{told} by {VARIABLES.get(variable, variable)}" if variable else told)


def regression_of(
    maneuver: Maneuver, model: AeroTerms, terms: Sequence[Term], differences: Mapping[str, Array]
) -> Regression:
    """Return a maneuver as a regression on the terms of a model.

    `differences` holds, by function outside the axes, the change of the forces [lb, lb ft] by one whole relative
    change of it, (n, 6).
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
    for i, term in enumerate(terms):
        function = term.function
        if function.axis:
            value = model.values[function.name]
            if function.variable == "alpha_rate":
                # The model's own rate follows its own forces; that of the log is measured.
                moved = value * (_ratio(rate, model.alpha_rate) - 1.0)
                model_force = model_force + model.units[function.axis] * _SI * moved[:, None]
                value = value + moved
            columns[:, :, i] = turn(model.units[function.axis] * _SI * value[:, None] / scale)
        else:
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
    )


_SI = np.array([POUND_FORCE] * 3 + [POUND_FORCE * FOOT] * 3)


def _ratio(rate: Array, model: Array) -> Array:
    """The measured rate of the angle of attack over the model's, where the model's is not nearly zero."""
    kept = np.where(np.abs(model) > LEAST_RATE, model, np.nan)
    ratio = np.asarray(rate / kept)
    ratio[~np.isfinite(ratio)] = 1.0
    return np.asarray(np.clip(ratio, -5.0, 5.0))


def _measured_force(maneuver: Maneuver, model: AeroTerms) -> Array:
    """The measured force [N] and moment [N m] of the air in body axes, (n, 6); without thrust where unmeasured."""
    motion, mass = maneuver.motion, model.mass if maneuver.mass is None else maneuver.mass
    force = np.reshape(mass, (-1, 1)) * maneuver.specific_force
    if maneuver.thrust is not None:
        force = force - np.stack([maneuver.thrust, 0.0 * maneuver.thrust, 0.0 * maneuver.thrust], axis=1)
    ixx, iyy, izz, ixz = maneuver.inertia or model.inertia
    inertia = np.array([[ixx, 0.0, -ixz], [0.0, iyy, 0.0], [-ixz, 0.0, izz]])
    rates = np.stack([motion.roll_rate, motion.pitch_rate, motion.yaw_rate], axis=1)
    moment = maneuver.angular_acceleration @ inertia + np.cross(rates, rates @ inertia)
    return np.concatenate([force, moment], axis=1)


def _to_wind(alpha: Array) -> Turn:
    """Return the function that turns coefficients in body axes, (n, 6), into drag, side force, lift and moments."""
    cosine, sine = np.cos(alpha), np.sin(alpha)

    def turn(body: Array) -> Array:
        drag = -body[:, 0] * cosine - body[:, 2] * sine
        lift = -body[:, 2] * cosine + body[:, 0] * sine
        return np.column_stack([drag, body[:, 1], lift, body[:, 3:]])

    return turn


def _free_columns(maneuver: Maneuver, force: Array, turn: Turn) -> Array:
    """The columns that are free in every maneuver, (n, 6, f): constants, and a thrust that was not measured."""
    count = len(maneuver.motion.time)
    columns = [np.tile(np.eye(6)[i], (count, 1)) for i in range(6)]
    if maneuver.thrust is None:
        elapsed = np.linspace(-1.0, 1.0, count)
        for shape in (np.ones(count), elapsed):
            body = np.zeros((count, 6))
            body[:, 0] = shape * float(np.median(force)) / force
            columns.append(turn(body))
    return np.stack(columns, axis=2)


def _regressor(term: Term, maneuver: Maneuver, rate: Array, speed: Array, span: float, chord: float) -> Array:
    """What a coefficient multiplies: an angle [rad], a rate times half a length over the speed, or 1."""
    motion, variable = maneuver.motion, term.function.variable
    lengths = {"p": span, "q": chord, "r": span, "alpha_rate": chord}
    values = {
        "p": motion.roll_rate,
        "q": motion.pitch_rate,
        "r": motion.yaw_rate,
        "alpha_rate": rate,
        "alpha": motion.angle_of_attack,
        "sideslip": motion.sideslip,
        "elevator": motion.elevator,
        "aileron": motion.aileron,
        "rudder": motion.rudder,
    }
    value = values.get(variable, np.ones(len(motion.time)))
    return np.asarray(value * lengths[variable] / (2.0 * speed)) if variable in lengths else value


UNITS = {
    "alpha": "per rad",
    "sideslip": "per rad",
    "elevator": "per rad",
    "aileron": "per rad",
    "rudder": "per rad",
}
RATES = {"p": "per p b/2V", "q": "per q c/2V", "r": "per r b/2V", "alpha_rate": "per α̇ c/2V"}


# The least squares: what is free in each maneuver is taken out first, so that sizes alone are left.


@dataclass(frozen=True, slots=True)
class _Bare:
    """A regression without its free columns, in the unit of the noise: residual (n, 6) and columns (n, 6, k)."""

    name: str
    time: Array
    residual: Array
    columns: Array

    def part(self, rows: slice) -> "_Bare":
        """Some rows."""
        return _Bare(self.name, self.time[rows], self.residual[rows], self.columns[rows])

    def left(self, sizes: Array) -> Array:
        """The residual with terms of some sizes, (n, 6)."""
        return np.asarray(self.residual - self.columns @ sizes)


def _bare(each: Regression, noise: Array) -> _Bare:
    count = len(each.time)
    free = (each.free / noise[:, None]).reshape(6 * count, -1)
    both = np.concatenate([each.residual[:, :, None], each.columns], axis=2) / noise[:, None]
    flat = both.reshape(6 * count, -1)
    flat = flat - free @ np.linalg.lstsq(free, flat, rcond=None)[0]
    back = flat.reshape(count, 6, -1)
    return _Bare(each.name, each.time, back[:, :, 0], back[:, :, 1:])


def _products(several: Sequence[_Bare]) -> tuple[Array, Array, float]:
    """Normal matrix, right side and sum of squares of several maneuvers."""
    columns = np.concatenate([each.columns.reshape(-1, each.columns.shape[2]) for each in several])
    right = np.concatenate([each.residual.ravel() for each in several])
    return columns.T @ columns, columns.T @ right, float(right @ right)


def _sizes(several: Sequence[_Bare], chosen: Sequence[int]) -> Array:
    normal, right, _ = _products(several)
    sizes, own = np.zeros(len(right)), list(chosen)
    if own:
        sizes[own] = np.linalg.lstsq(normal[np.ix_(own, own)], right[own], rcond=1e-10)[0]
    return sizes


def _squares(several: Sequence[_Bare], sizes: Array) -> float:
    return float(sum(np.sum(each.left(sizes) ** 2) for each in several))


def _noise(several: Sequence[Regression]) -> Array:
    """The deviation of each channel that all terms together leave, (6,): fitted channel by channel."""
    left = []
    for each in several:
        for i in range(6):
            design = np.concatenate([each.free[:, i], each.columns[:, i]], axis=1)
            target = each.residual[:, i]
            left.append(target - design @ np.linalg.lstsq(design, target, rcond=1e-8)[0])
    squares = [np.concatenate(left[i::6]) for i in range(6)]
    return np.array([max(float(np.sqrt(np.mean(each**2))), 1e-9) for each in squares])


def _covariance(several: Sequence[_Bare], sizes: Array, chosen: Sequence[int]) -> Array:
    """The covariance of sizes under residuals that are not white (Morelli and Klein 1997, eq. 15)."""
    own = list(chosen)
    normal = _products(several)[0][np.ix_(own, own)]
    middle = np.zeros_like(normal)
    for each in several:
        left = each.left(sizes)
        for i in range(6):
            design = each.columns[:, i][:, own]
            if np.any(design):
                middle += design.T @ _autocovariance(left[:, i]) @ design
    inverse = np.linalg.pinv(normal, rcond=1e-10, hermitian=True)
    return np.asarray(inverse @ middle @ inverse)


def _autocovariance(left: Array) -> Array:
    count = len(left)
    lags = min(LONGEST_MEMORY, max(2, count // 3))
    centered = left - left.mean()
    full = np.correlate(centered, centered, "full")[count - 1 :][:lags] / count
    tapered = np.zeros(count)
    tapered[:lags] = full * (1.0 - np.arange(lags) / lags)
    return np.asarray(toeplitz(tapered))


def judge_terms(
    aircraft: str,
    terms: Sequence[Term],
    fitted: Sequence[Regression],
    held_out: Sequence[Regression],
    remarks: tuple[str, ...] = (),
) -> TermsAccount:
    """Choose the terms that are off, in the order of what they close, and return them with their bounds.

    A term enters while its size is significant and it closes some of the gap that it was not fitted to: of the
    maneuvers held out, else of each half of a maneuver with sizes of the other half.
    """
    noise = _noise([*fitted, *held_out])
    fit, held = [_bare(each, noise) for each in fitted], [_bare(each, noise) for each in held_out]
    seen = _seen(fit)
    chosen: list[int] = []
    closes: dict[int, float] = {}
    tests = _tests(fit, held)
    explainable = _explainable(tests, seen)
    while True:
        gains = {i: _gain(tests, chosen, i) for i in seen if i not in chosen and _enters(fit, [*chosen, i])}
        best = max(gains, key=lambda i: gains[i], default=None)
        if best is None or gains[best] < LEAST_GAIN * explainable:
            break
        chosen.append(best)
        closes[best] = gains[best] / explainable
    sizes = _sizes(fit, chosen)
    deviations = _deviations(fit, sizes, chosen)
    gaps = [_gap(each, bare, sizes, seen, False) for each, bare in zip(fitted, fit, strict=True)]
    gaps += [_gap(each, bare, sizes, seen, True) for each, bare in zip(held_out, held, strict=True)]
    estimates = tuple(
        _estimate(terms, i, fitted, float(sizes[i]), float(deviations[k]), closes[i], _alike(terms, fit, seen, i))
        for k, i in enumerate(chosen)
    )
    silent = tuple(term.name for i, term in enumerate(terms) if i not in seen)
    return TermsAccount(aircraft, estimates, tuple(gaps), silent, _zeros(terms, chosen, fitted, sizes), remarks)


def _seen(fit: Sequence[_Bare]) -> list[int]:
    """The terms that the maneuvers can show: half of them stands clear of the noise."""
    power = np.sqrt(np.diag(_products(fit)[0]))
    return [int(i) for i in np.flatnonzero(0.5 * power > UNSEEN)]


Tests = Sequence[tuple[Sequence[_Bare], Sequence[_Bare]]]


def _tests(fit: Sequence[_Bare], held: Sequence[_Bare]) -> Tests:
    """Pairs of what sizes are fitted to and what they are tested on."""
    if held:
        return [(fit, held)]
    if len(fit) > 1:
        return [([e for e in fit if e is not each], [each]) for each in fit]
    half = len(fit[0].time) // 2
    parts = [fit[0].part(slice(None, half)), fit[0].part(slice(half, None))]
    return [([parts[0]], [parts[1]]), ([parts[1]], [parts[0]])]


def _gain(tests: Tests, chosen: Sequence[int], new: int) -> float:
    """The fall of the sum of squares by a further term on what it was not fitted to."""
    with_new = [*chosen, new]
    return sum(_squares(test, _sizes(on, chosen)) - _squares(test, _sizes(on, with_new)) for on, test in tests)


def _explainable(tests: Tests, seen: Sequence[int]) -> float:
    """The gap that all terms together close on what is tested."""
    return sum(_squares(test, _sizes(test, ())) - _squares(test, _sizes(test, seen)) for _, test in tests)


def _enters(fit: Sequence[_Bare], with_new: Sequence[int]) -> bool:
    sizes = _sizes(fit, with_new)
    new = with_new[-1]
    deviation = float(np.sqrt(np.diag(_covariance(fit, sizes, with_new))[-1]))
    return bool(abs(sizes[new]) > SIGNIFICANT * deviation and PLAUSIBLE[0] < sizes[new] < PLAUSIBLE[1])


def _deviations(fit: Sequence[_Bare], sizes: Array, chosen: Sequence[int]) -> Array:
    """The deviations of the sizes: of the noise, and of what the parts of the data say each for itself."""
    if not chosen:
        return np.empty(0)
    own = np.diag(_covariance(fit, sizes, chosen))
    parts = list(fit)
    if len(parts) == 1:
        half = len(fit[0].time) // 2
        parts = [fit[0].part(slice(None, half)), fit[0].part(slice(half, None))]
    # What a part hardly shows says nothing about the spread: each counts by its information.
    several = np.stack([_sizes([part], chosen)[list(chosen)] for part in parts])
    weights = np.stack([np.diag(_products([part])[0])[list(chosen)] for part in parts])
    weights = weights / weights.sum(axis=0)
    mean = np.sum(weights * several, axis=0)
    spread = np.sum(weights**2 * (several - mean) ** 2, axis=0) * len(parts) / max(1, len(parts) - 1)
    return np.asarray(np.sqrt(own + spread))


def _gap(each: Regression, bare: _Bare, sizes: Array, seen: Sequence[int], held_out: bool) -> ManeuverGap:
    best = _sizes([bare], seen)
    parts = [np.mean(bare.left(s) ** 2, axis=0) for s in (np.zeros(len(sizes)), sizes, best)]
    channels = {
        name: ChannelGap(float(parts[0][i]), float(parts[1][i]), float(parts[2][i]))
        for i, name in enumerate(CHANNELS)
    }
    raw = _bare(each, np.ones(6))
    return ManeuverGap(each.name, held_out, channels, each.time, raw.residual, raw.left(sizes))


def _alike(terms: Sequence[Term], fit: Sequence[_Bare], seen: Sequence[int], own: int) -> Iterator[str]:
    """Terms whose columns are nearly that of a term."""
    normal = _products(fit)[0]
    for i in seen:
        if i != own and abs(normal[i, own]) > ALIKE * np.sqrt(normal[i, i] * normal[own, own]):
            yield terms[i].name


def _estimate(
    terms: Sequence[Term],
    i: int,
    fitted: Sequence[Regression],
    size: float,
    deviation: float,
    closes: float,
    like: Iterator[str],
) -> TermEstimate:
    term = terms[i]
    variable = term.function.variable
    values = np.concatenate([each.model[:, i] for each in fitted])
    regressor = np.concatenate([each.regressors[:, i] for each in fitted])
    constant = variable not in UNITS and variable not in RATES
    model = float(values.mean()) if constant else float(np.polyfit(regressor, values, 1)[0])
    bound = 2.0 * deviation
    return TermEstimate(
        term.name,
        term.function.name,
        term.axis,
        AXIS_CHANNEL[term.axis],
        UNITS.get(variable, RATES.get(variable, "")),
        model,
        Estimate(term.name, model * (1.0 + size), abs(model) * bound),
        Estimate("change", size, bound),
        closes,
        tuple(like),
    )


def _zeros(
    terms: Sequence[Term], chosen: Sequence[int], fitted: Sequence[Regression], sizes: Array
) -> dict[str, float]:
    """The added coefficients that let the changed slopes turn about the flown angle of attack, by axis."""
    zeros = {}
    for axis in ("LIFT", "PITCH"):
        if any(terms[i].axis == axis and terms[i].function.variable == "alpha" for i in chosen):
            place = CHANNELS.index(AXIS_CHANNEL[axis])
            left = [each.residual[:, place] - each.columns[:, place] @ sizes for each in fitted]
            zeros[axis] = float(np.mean(np.concatenate(left)))
    return zeros
