"""Shape the loops of the autopilot on linear models of an aircraft, check their steps, and write
them as a file.
"""

import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from math import cos
from pathlib import Path

import numpy as np
from scipy.linalg import block_diag, expm

from pitotbench.records.aircraft import StepResponse
from pitotbench.simulation.autopilot.envelope import Envelope, HeldAircraft, State, Trim, strict
from pitotbench.simulation.plant import Plant, SimulationError
from pitotbench.units import DEGREE, FOOT, KNOT, STANDARD_GRAVITY, Array

# Linearize an aircraft about a trim point by finite differences of its accelerations in held
# flight.

# Half widths of the central differences.
DIFFERENCES = {
    "alpha": 0.5 * DEGREE,
    "beta": 1.0 * DEGREE,
    "roll_rate": 0.05,
    "pitch_rate": 0.03,
    "yaw_rate": 0.03,
    "elevator": 0.1,
    "aileron": 0.1,
    "rudder": 0.1,
}
STEP_TIME, LARGEST_TIME = 0.1, 8.0  # s
ENGINE_STEP = 0.1  # of the lever


@dataclass(frozen=True, slots=True)
class Linear:
    """The linear models of an aircraft at a trim point.

    `pitch` is (2, 3): the rates of angle of attack [rad/s] and of pitch rate [rad/s²] by angle of
    attack, pitch rate and elevator. `lateral` is (3, 5): those of sideslip, roll rate and yaw rate
    by sideslip, roll rate, yaw rate, aileron and rudder. `gravity` [1/s] is the rate of sideslip a
    radian of bank. Controls go from -1 to 1.
    """

    trim: Trim
    pitch: Array
    lateral: Array
    gravity: float


def linearize(aircraft: HeldAircraft, trim: Trim) -> Linear:
    """Return the linear models at a trim point. The flight control system of the aircraft is part
    of them.
    """
    base = State(trim.speed, trim.alpha, elevator=trim.elevator)
    aircraft.place(base)
    aircraft.set_lever(trim.lever)

    def by(name: str) -> Array:
        sides = []
        for sign in (1.0, -1.0):
            state = replace(base, **{name: getattr(base, name) + sign * DIFFERENCES[name]})
            found = aircraft.accelerations(state)
            sides.append(
                (
                    found.normal(state.alpha) / trim.speed,
                    found.q,
                    found.v / trim.speed,
                    found.p,
                    found.r,
                )
            )
        slopes: Array = (np.array(sides[0]) - np.array(sides[1])) / (2.0 * DIFFERENCES[name])
        return slopes

    pitch = np.stack([by(name)[:2] for name in ("alpha", "pitch_rate", "elevator")], axis=1)
    names = ("beta", "roll_rate", "yaw_rate", "aileron", "rudder")
    lateral = np.stack([by(name)[2:] for name in names], axis=1)
    return Linear(trim, pitch, lateral, STANDARD_GRAVITY * cos(trim.alpha) / trim.speed)


# What a model with a slope of the wrong sign does, in the order of `wrong_slopes`.
WRONG = (
    "the pitching moment rises with the angle of attack",
    "the yawing moment falls with sideslip",
    "the rolling moment rises with sideslip",
    "the pitching moment rises with the pitch rate",
    "the rolling moment rises with the roll rate",
    "the yawing moment rises with the yaw rate",
)
SLIGHT = 0.001  # rad/s² a radian or a rad/s: a smaller slope is none


def wrong_slopes(aircraft: HeldAircraft, models: Sequence[Linear]) -> list[str]:
    """Return a sentence for each slope of a moment about the body axes whose sign makes the
    airplane unstable, with the calibrated airspeeds. Sideslip is positive with wind from the right.
    """
    ixx, izz, ixz = (aircraft.read(f"inertia/{part}-slugs_ft2") for part in ("ixx", "izz", "ixz"))
    stable = []
    for model in models:
        # Moments over moments of inertia; JSBSim's ixz is the negative of the product of inertia.
        roll = model.lateral[1] + ixz / ixx * model.lateral[2]
        yaw = model.lateral[2] + ixz / izz * model.lateral[1]
        alpha, rate = model.pitch[1, :2]
        stable.append([-alpha, yaw[0], -roll[0], -rate, -roll[1], -yaw[2]])
    wrong = np.array(stable) < -SLIGHT
    speeds = np.array([f"{model.trim.calibrated / KNOT:.0f}" for model in models])
    return [
        f"{words} at {', '.join(speeds[at])} KCAS"
        for words, at in zip(WRONG, wrong.T, strict=True)
        if at.any()
    ]


def engine_time(aircraft: HeldAircraft, trim: Trim) -> float:
    """Return the time [s] in which the thrust makes 63 % of its change after a step of the lever."""
    aircraft.place(State(trim.speed, trim.alpha, elevator=trim.elevator))
    lever = min(trim.lever, 1.0 - ENGINE_STEP)
    before = aircraft.set_lever(lever)
    after = aircraft.set_lever(lever + ENGINE_STEP)
    aircraft.set_lever(lever)
    aircraft.move_lever(lever + ENGINE_STEP)
    for look in range(1, round(LARGEST_TIME / STEP_TIME)):
        aircraft.run(STEP_TIME * 100.0)
        if abs(aircraft.thrust() - before) >= 0.63 * abs(after - before):
            return look * STEP_TIME
    return LARGEST_TIME


# Shape the loops of the autopilot on the linear models of an aircraft, and check them by their step
# responses. Inner loops come first: pitch rate (proportional and integral, elevator), bank
# (aileron), yaw damper (rudder). Each asks for an angular acceleration, which the control
# effectiveness at the present airspeed turns into a control position. The outer loops (altitude,
# heading, airspeed) are kinematic and the same for all airplanes, and are slowed down where the
# inner ones cannot follow. (Stevens, Lewis and Johnson, Aircraft Control and Simulation, 2016, ch.
# 4.)

ACTUATOR = 0.08  # s: lag of actuator, control system and sampling that every loop must bear
PITCH_RATES, PITCH_INTEGRALS = (0.5, 1.0, 2.0, 3.0, 5.0, 8.0, 12.0), (0.5, 1.0, 2.0, 4.0)  # 1/s
MOST_ELEVATOR_GAIN = 3.0  # of the travel a rad/s: more would work the elevator hard in turbulence
DISTURBANCE, UPSET_WEIGHT = 0.05, 20.0  # of the elevator's travel; a radian
LEAST_DAMPING = 0.35  # of any oscillation in a closed loop
FASTEST_BANK, LEAST_ROLL_DAMPING = 1.3, 3.0  # 1/s
YAW_DAMPING, MOST_YAW_GAIN = 0.6, 4.0  # of the Dutch roll; 1/s
CLIMB_GAIN, ALTITUDE_GAIN = 0.7, 0.2  # 1/s
SPEED_GAIN, SPEED_PHASE, SPEED_LAGS = (
    0.14,
    0.4,
    1.7,
)  # 1/s; rad and s of lag at the gain: airspeed filter and hand
LEAST_EFFECT = 0.02  # rad/s² for full travel: below it a control does nothing
SLOWER = 0.8


@dataclass(frozen=True, slots=True)
class Gains:
    """The gains of an aircraft: one value a trim point for inner loops, one for all speeds for
    outer ones.
    """

    pitch_rate: Array  # 1/s
    pitch_integral: Array  # 1/s
    bank: Array  # 1/s
    roll_rate: Array  # 1/s, added to the roll damping
    yaw_rate: Array  # 1/s, added to the yaw damping
    climb: float  # 1/s
    altitude: float  # 1/s
    speed: float  # 1/s


def shape(name: str, models: Sequence[Linear], engine_time: float) -> Gains:
    """Return the gains for the linear models of an aircraft, from slow to fast, and its engine's
    lag [s].

    Raises SimulationError, which names the loop and the speed, where a loop cannot be made stable.
    """
    pitch = np.array([_pitch(name, model) for model in models])
    lateral = np.array([_lateral(name, model) for model in models])
    scale = min(
        _altitude_scale(name, model, *gains) for model, gains in zip(models, pitch, strict=True)
    )
    return Gains(
        pitch_rate=pitch[:, 0],
        pitch_integral=pitch[:, 1],
        bank=lateral[:, 0],
        roll_rate=lateral[:, 1],
        yaw_rate=lateral[:, 2],
        climb=scale * CLIMB_GAIN,
        altitude=scale * ALTITUDE_GAIN,
        speed=min(SPEED_GAIN, SPEED_PHASE / (engine_time + SPEED_LAGS)),
    )


def pitch_loop(model: Linear, gain: float, integral: float) -> tuple[Array, Array]:
    """Return the closed pitch-rate loop: its matrix over (alpha, q, elevator, integral), and its
    input column.
    """
    effect = model.pitch[1, 2]
    a = np.zeros((4, 4))
    a[:2, :2], a[:2, 2] = model.pitch[:, :2], model.pitch[:, 2]
    a[2] = np.array([0.0, -gain / effect, -1.0, gain * integral / effect])
    a[2] /= ACTUATOR
    a[3, 1] = -1.0
    return a, np.array([0.0, 0.0, (gain + pull(model)) / effect / ACTUATOR, 1.0])


def pull(model: Linear) -> float:
    """Return the pitching acceleration [1/s] of the elevator that a unit of steady pitch rate
    needs.
    """
    (lift, _, _), (stiffness, rate, _) = model.pitch
    return max(0.0, float(stiffness / lift - rate)) if lift < 0.0 else 0.0


def bank_loop(model: Linear, bank: float, roll: float, yaw: float) -> tuple[Array, Array]:
    """Return the closed bank loop over (beta, p, r, bank, aileron, rudder), and its input column."""
    aileron, rudder = model.lateral[1, 3], model.lateral[2, 4]
    damping = abs(model.lateral[1, 1]) + roll
    alpha, turn = model.trim.alpha, model.gravity
    a = block_diag(np.zeros((4, 4)), -np.eye(2) / ACTUATOR)
    a[:3, :3], a[:3, 4:] = model.lateral[:, :3], model.lateral[:, 3:]
    a[0, 3], a[3, 1] = turn, 1.0
    a[4, [1, 3]] = np.array([-roll, -damping * bank]) / aileron / ACTUATOR
    if has_effect(rudder):
        a[5, [1, 2, 3]] = yaw * np.array([alpha, -1.0, turn]) / rudder / ACTUATOR
    return a, np.array([0.0, 0.0, 0.0, 0.0, damping * bank / aileron / ACTUATOR, 0.0])


def has_effect(effect: float) -> bool:
    """Return whether a control of this effectiveness [rad/s² a full travel] moves the aircraft."""
    return abs(effect) > LEAST_EFFECT


def step_response(a: Array, column: Array, output: int, time: Array) -> Array:
    """Return the response of one state to a unit step, (n,), at equally spaced times [s] from zero."""
    size = len(a)
    joined = np.zeros((size + 1, size + 1))
    joined[:size, :size], joined[:size, size] = a, column
    transition = expm(joined * (time[1] - time[0]))
    state = np.append(np.zeros(size), 1.0)
    found = np.empty(len(time))
    for k in range(len(time)):
        found[k] = state[output]
        state = transition @ state
    return found


def damping(a: Array) -> float:
    """Return the least damping ratio of the poles above 0.05 rad/s; -1 where a pole grows faster
    than that.
    """
    poles = np.linalg.eigvals(a)
    if poles.real.max() > 0.05:  # a slow spiral is held by the outer loops
        return -1.0
    fast = poles[np.abs(poles) > 0.05]
    return float((-fast.real / np.abs(fast)).min(initial=1.0))


_TIME = np.linspace(0.0, 6.0, 121)


def _pitch(name: str, model: Linear) -> tuple[float, float]:
    if not has_effect(model.pitch[1, 2]):
        raise SimulationError(f"{name}: the elevator does nothing at {_knots(model)}")
    best, chosen = np.inf, None
    for gain, integral in product(PITCH_RATES, PITCH_INTEGRALS):
        a, column = pitch_loop(model, gain, integral)
        if gain > MOST_ELEVATOR_GAIN * abs(model.pitch[1, 2]) or damping(a) < LEAST_DAMPING:
            continue
        response = step_response(a, column, 1, _TIME)
        # The attitude lost [rad] to a disturbance counts as well: an airplane out of trim drifts
        # off its height.
        upset = step_response(
            a, np.array([0.0, DISTURBANCE * model.pitch[1, 2], 0.0, 0.0]), 3, _TIME
        )
        cost = float(np.abs(1.0 - response).mean() + max(0.0, response.max() - 1.15))
        cost += UPSET_WEIGHT * float(np.abs(upset).mean())
        if cost < best:
            best, chosen = cost, (gain, integral)
    if chosen is None:
        raise SimulationError(f"{name}: no pitch-rate loop is stable at {_knots(model)}")
    return chosen


def _lateral(name: str, model: Linear) -> tuple[float, float, float]:
    if not has_effect(model.lateral[1, 3]):
        raise SimulationError(f"{name}: the ailerons do nothing at {_knots(model)}")
    side, roll_damping, yaw_damping = (abs(model.lateral[i, i]) for i in range(3))
    roll = max(0.2 * roll_damping, LEAST_ROLL_DAMPING - roll_damping)
    stiffness = max(model.lateral[2, 0], 0.0)
    yaw = float(
        np.clip(2.0 * YAW_DAMPING * stiffness**0.5 - yaw_damping - side, 0.3, MOST_YAW_GAIN)
    )
    bank = FASTEST_BANK
    while bank > 0.2:
        for damper in (yaw, 0.5 * yaw, 0.0):
            a, column = bank_loop(model, bank, roll, damper)
            if damping(a) >= 0.6 * LEAST_DAMPING and step_response(a, column, 3, _TIME).max() < 1.3:
                return bank, roll, damper
        bank *= SLOWER
    raise SimulationError(f"{name}: no bank loop is stable at {_knots(model)}")


def _altitude_scale(name: str, model: Linear, gain: float, integral: float) -> float:
    """Return the factor on the climb and altitude gains with which the altitude loop is well
    damped.
    """
    inner, column = pitch_loop(model, gain, integral)
    speed, scale = model.trim.speed, 1.0
    while scale > 0.1:
        a = np.zeros((6, 6))
        a[:4, :4] = inner
        a[4, 1] = 1.0
        a[5, 4], a[5, 0] = speed, -speed
        wanted = np.zeros(6)  # pitch rate wanted, by the states
        wanted[4], wanted[0] = -scale * CLIMB_GAIN, scale * CLIMB_GAIN
        wanted[5] = -(scale**2) * CLIMB_GAIN * ALTITUDE_GAIN / speed
        a[:4] += np.outer(column, wanted)
        if damping(a) >= LEAST_DAMPING:
            return scale
        scale *= SLOWER
    raise SimulationError(f"{name}: no altitude loop is stable at {_knots(model)}")


def _knots(model: Linear) -> str:
    return f"{model.trim.calibrated / KNOT:.0f} KCAS"


INTERVAL = 0.1  # s between samples
BAND = 0.1  # of the step, within which a response has settled


@dataclass(frozen=True, slots=True)
class StepCommand:
    """A step of a quantity: the target to set, its mode, the change [SI], its unit, how long to
    look [s].
    """

    quantity: str
    target: str
    mode: tuple[str, float]
    change: float
    unit: str
    factor: float
    seconds: float


STEPS = (
    StepCommand("roll", "bank_target", ("lateral_mode", 2.0), 20.0 * DEGREE, "°", DEGREE, 15.0),
    StepCommand("altitude", "altitude_target", ("pitch_mode", 1.0), 100.0 * FOOT, "ft", FOOT, 60.0),
    StepCommand(
        "calibrated_airspeed",
        "airspeed_target",
        ("throttle_mode", 1.0),
        5.0 * KNOT,
        "kt",
        KNOT,
        60.0,
    ),
)


def step_responses(aircraft: str, airspeed: float, altitude: float) -> list[StepResponse]:
    """Return the responses of an aircraft at a calibrated airspeed [m/s], each from level flight.

    The airspeed step goes down, so that it needs no power to spare.
    Raises SimulationError where the aircraft does not fly level there.
    """
    return [_flown(aircraft, airspeed, altitude, step) for step in STEPS]


def _flown(aircraft: str, airspeed: float, altitude: float, step: StepCommand) -> StepResponse:
    plant = Plant.load(aircraft)
    plant.start(altitude, airspeed)
    start = {"altitude": altitude, "calibrated_airspeed": airspeed}.get(step.quantity, 0.0)
    before = plant.get(step.quantity)
    change = -step.change if step.quantity == "calibrated_airspeed" else step.change
    plant.set(step.target, start + change)
    plant.set(*step.mode)
    values = [before]
    for _ in range(round(step.seconds / INTERVAL)):
        plant.run(INTERVAL)
        values.append(plant.get(step.quantity))
    moved = np.array(values) - before
    wanted = start + change - before
    outside = np.flatnonzero(np.abs((moved / wanted) - 1.0) > BAND)
    return StepResponse(
        step.quantity,
        step.unit,
        airspeed / KNOT,
        change / step.factor,
        np.linspace(0.0, step.seconds, len(values)),
        moved / step.factor,
        max(0.0, float((moved / wanted).max()) - 1.0),
        float((outside[-1] + 1) * INTERVAL) if len(outside) else 0.0,
    )


# Write the autopilot of an aircraft from its linear models and gains.

TEMPLATE = Path(__file__).with_name("autopilot.xml")
COLUMNS = 25  # of the table of lever positions
LEAST_LIFT = 0.15  # 1/s, so that an angle of attack for a load factor stays finite
INTEGRAL_SHARE = 0.06  # 1/s, of the altitude gain
SPEED_INTEGRAL_SHARE = 0.3  # of the speed gain
CLIMB_ANGLE = 0.08  # rad at the stall speed: the fastest climb asked for
LEAD = 0.1  # of the speed range: how far the speed command may run ahead


def write_autopilot(
    file: Path, envelope: Envelope, models: Sequence[Linear], gains: Gains, aircraft: HeldAircraft
) -> None:
    """Write the autopilot as a JSBSim system file of its own."""
    speeds = [point.calibrated / KNOT for point in envelope.points]
    accelerations = np.concatenate([point.gains for point in envelope.points]) / KNOT
    entries = {
        "climb_limit": envelope.stall * CLIMB_ANGLE / FOOT * 60.0,
        "speed_lead": max(1.5, min(6.0, LEAD * (speeds[-1] - speeds[0]))),
        "altitude_gain": gains.altitude,
        "altitude_integral": INTEGRAL_SHARE * gains.altitude,
        "climb_gain": gains.climb,
        "speed_gain": gains.speed,
        "speed_integral": SPEED_INTEGRAL_SHARE * gains.speed**2,
        "most_trim": 0.5 * float(np.abs(accelerations).max()),
    }
    text = TEMPLATE.read_text(encoding="utf-8")
    for key, value in entries.items():
        text = text.replace("{{" + key + "}}", f"{value:.6g}")
    tables = "\n".join(
        _table(name, speeds, values) for name, values in _model(envelope, models, gains).items()
    )
    text = text.replace("{{tables}}", tables).replace(
        "{{levers}}", _levers(envelope, accelerations)
    )
    file.write_text(text.replace("{{engines}}", _throttles(aircraft)), "utf-8")


def write_levers(root: ET.Element, engines: int, taken: str) -> None:
    """Add to an aircraft a system that sets mixture and propeller levers, which the bench does not
    move.

    `taken` is the text of all files of the aircraft: a lever that they move is left to them.
    """
    system = ET.Element("system", name="attached levers")
    channel = ET.SubElement(system, "channel", name="attached levers")
    # The ratio of the densities, near enough, and the best power of a rich mixture.
    ratio = (
        "<product> <value> 0.85 </value> <quotient> <property> atmosphere/P-psf </property>"
        " <value> 2116.2 </value> </quotient> </product>"
    )
    for lever, value in (
        ("mixture", ratio),
        ("advance", "<sum> <value> 1 </value> <value> 0 </value> </sum>"),
    ):
        if (
            any(f"fcs/{lever}-{kind}-norm" in _outputs(taken) for kind in ("cmd", "pos"))
            and lever == "mixture"
        ):
            continue
        component = ET.SubElement(channel, "fcs_function", name=f"ap/{lever}-lever-norm")
        ET.SubElement(component, "function").append(ET.fromstring(value))
        for i in range(engines):
            ET.SubElement(component, "output").text = f"fcs/{lever}-cmd-norm[{i}]"
    place = (
        max((i for i, e in enumerate(root) if e.tag in ("system", "propulsion")), default=-1) + 1
    )
    root.insert(place, system)
    root.insert(place + 1, ET.Element("system", file="attached-autopilot"))


def open_all_tanks(root: ET.Element) -> None:
    """Let the engines of an aircraft draw from tanks that no engine names, as a pilot selects them
    in flight.
    """
    engines = list(root.iter("engine"))
    named = {(feed.text or "").strip() for engine in engines for feed in engine.findall("feed")}
    for number, tank in enumerate(root.iter("tank")):
        if tank.get("type") == "FUEL" and str(number) not in named:
            for engine in engines:
                ET.SubElement(engine, "feed").text = str(number)


def _outputs(text: str) -> set[str]:
    """Return the properties that components write, without the numbers of engines."""
    found = text.split("<output>")[1:]
    return {part.split("</output>")[0].strip().split("[")[0] for part in found}


def _model(envelope: Envelope, models: Sequence[Linear], gains: Gains) -> Mapping[str, Array]:
    pitch = np.stack([model.pitch for model in models])
    lateral = np.stack([model.lateral for model in models])
    rudder = lateral[:, 2, 4]
    share = np.array([1.0 / effect if has_effect(effect) else 0.0 for effect in rudder])
    points = envelope.points
    return {
        "elevator-level": np.array([p.elevator for p in points]),
        "alpha-level-rad": np.array([p.alpha for p in points]),
        "lever-level": np.array([p.lever for p in points]),
        "lever-idle": np.array([strict(p.gains, p.levers)[1][0] for p in points]),
        "induced-ktps": _induced(envelope) / KNOT,
        "elevator-effect": pitch[:, 1, 2],
        "pitch-stiffness": pitch[:, 1, 0],
        "pitch-damping": pitch[:, 1, 1],
        "lift": np.maximum(-pitch[:, 0, 0], LEAST_LIFT),
        "pull": np.array([pull(model) for model in models]),
        "pitch-gain": gains.pitch_rate,
        "pitch-integral-gain": gains.pitch_integral,
        "bank-gain": gains.bank,
        "roll-damping-added": gains.roll_rate,
        "roll-damping-total": gains.roll_rate + np.abs(lateral[:, 1, 1]),
        "roll-by-yaw": lateral[:, 1, 2],
        "aileron-effect": lateral[:, 1, 3],
        "rudder-share": share,
        "yaw-stiffness": np.maximum(lateral[:, 2, 0], 0.0),
        "yaw-damping-added": gains.yaw_rate,
        "yaw-by-roll": lateral[:, 2, 1],
        "yaw-by-yaw": lateral[:, 2, 2],
        "yaw-by-aileron": lateral[:, 2, 3],
    }


def _induced(envelope: Envelope) -> Array:
    """Return the deceleration [m/s²] by the induced drag of level flight at each trim point.

    Drag over mass is fitted as a V² + b/V² to the thrust of level flight; only b, the induced part,
    is used.
    """
    speed = np.array([point.speed for point in envelope.points])
    drag = np.array([point.drag for point in envelope.points])
    scale = np.array([point.calibrated / point.speed for point in envelope.points])
    (_, induced), *_ = np.linalg.lstsq(np.stack([speed**2, speed**-2], axis=1), drag, rcond=None)
    found: Array = scale * np.clip(induced / speed**2, 0.0, 0.1 * STANDARD_GRAVITY)
    return found


def _table(name: str, speeds: Sequence[float], values: Array) -> str:
    rows = "\n".join(f"        {v:.2f} {x:.7g}" for v, x in zip(speeds, values, strict=True))
    return (
        f'    <fcs_function name="ap/model/{name}"> <function> <table>\n'
        '      <independentVar lookup="row"> ap/kcas-smooth-kt </independentVar>\n'
        f"      <tableData>\n{rows}\n      </tableData> </table> </function> </fcs_function>"
    )


def _levers(envelope: Envelope, accelerations: Array) -> str:
    columns = np.linspace(accelerations.min(), accelerations.max(), COLUMNS)
    lines = [" ".join(f"{value:.4f}" for value in columns)]
    for point in envelope.points:
        gains, levers = strict(point.gains / KNOT, point.levers)
        row = np.interp(columns, gains, levers)
        lines.append(f"{point.calibrated / KNOT:.2f} " + " ".join(f"{value:.4f}" for value in row))
    return "\n".join(f"            {line}" for line in lines)


def _throttles(aircraft: HeldAircraft) -> str:
    return "\n".join(_engine(i, aircraft.engines, aircraft.idle) for i in range(aircraft.engines))


def _engine(number: int, engines: int, idle: float) -> str:
    side = "left" if 2 * number < engines else "right"
    return (
        f'    <fcs_function name="ap/throttle-{number}-norm">\n'
        "      <function> <sum> <property> ap/lever-norm </property> <property> "
        f"ap/throttle-bias-{side}-norm "
        "</property> </sum> </function>\n"
        f"      <clipto> <min> {idle:g} </min> <max> 1 </max> </clipto>\n"
        f"      <output> fcs/throttle-cmd-norm[{number}] </output>\n"
        "    </fcs_function>"
    )
