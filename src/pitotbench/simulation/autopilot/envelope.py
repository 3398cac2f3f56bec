"""Find the speeds between which an aircraft flies level, and its trim at each.

All of it is flown in frozen flight (`frozen_aircraft.py`): nothing is typed in. The stall speed is
the lowest at which the lift with trimmed elevator, engines idle, carries the weight. The maximum
level speed is the highest at which full power is at least the drag.
"""

from dataclasses import dataclass, replace

import numpy as np

from pitotbench.simulation.aircraft_files import SimulationError
from pitotbench.simulation.autopilot.frozen_aircraft import FrozenAircraft, State
from pitotbench.units import DEGREE, KNOT, STANDARD_GRAVITY, Array

SLOWEST, FASTEST = 8.0 * KNOT, 500.0 * KNOT  # true; where a stall speed is looked for
HIGHEST_MACH = 0.7  # above it the drag rise begins, and position errors are another matter
ALPHAS = np.arange(-2.0, 25.0, 1.5) * DEGREE  # of attack, up to the stall of most wings
MOST_ELEVATOR = 0.95  # of its travel: the rest is left for control
LEVERS = np.array([0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.65, 0.8, 1.0])  # throttle: finer when low
LEAST_THROTTLE = 0.02  # m/s² from idle to full: below it the throttle does nothing
SPEEDS = 7  # trim points
SLOWEST_TRIM, START, IDLE_UP_TO = 1.12, 1.5, 2.0  # times the stall speed


@dataclass(frozen=True, slots=True)
class Trim:
    """Level flight at one speed [m/s true; calibrated]: angle of attack [rad], elevator [-1 to 1].

    `levers` and `gains` are throttle positions and the rate of the calibrated airspeed [m/s²] that
    each gives in level flight; `lever` is the position at which it is zero. `drag` is the drag over
    mass there [m/s²].
    """

    speed: float
    calibrated: float
    alpha: float
    elevator: float
    lever: float
    levers: Array
    gains: Array
    drag: float


@dataclass(frozen=True, slots=True)
class Envelope:
    """The calibrated airspeeds [m/s] of an aircraft at a height, and trim points, slow to fast.

    `limited` says that the fastest speed is a Mach number of 0.7, not the maximum level speed.
    """

    stall: float
    fastest: float
    limited: bool
    points: tuple[Trim, ...]


def explore(aircraft: FrozenAircraft) -> Envelope:
    """Return the envelope of an aircraft.

    Raises SimulationError where it does not fly level at any speed.
    """
    aircraft.set_lever(0.0)
    low, stall = SLOWEST, FASTEST
    if _carries(aircraft, low) or not _carries(aircraft, stall):
        raise SimulationError(
            f"{aircraft.name}: no stall speed between 8 and 500 kt: is it a fixed-wing aircraft?"
        )
    while stall / low > 1.01:
        middle = (low * stall) ** 0.5
        low, stall = (low, middle) if _carries(aircraft, middle) else (middle, stall)
    # At idle below the stall speed an engine may have stopped.
    aircraft.place(State(START * stall))
    aircraft.start_engines()
    aircraft.find_idle(np.geomspace(SLOWEST_TRIM * stall, IDLE_UP_TO * stall, 4))
    fastest, limited = _fastest(aircraft, stall)
    if fastest < 1.35 * stall:
        raise SimulationError(
            f"{aircraft.name}: level flight reaches from {stall / KNOT:.0f} to "
            f"{fastest / KNOT:.0f} kt (true): too little for a calibration"
        )
    speeds = np.geomspace(SLOWEST_TRIM * stall, fastest, SPEEDS)
    points = tuple(trim(aircraft, float(speed)) for speed in speeds)
    return Envelope(aircraft.calibrated(stall), points[-1].calibrated, limited, points)


def trim(aircraft: FrozenAircraft, speed: float) -> Trim:
    """Return the trim in level flight at a true airspeed [m/s].

    Raises SimulationError where neither idle nor full power holds the speed.
    """
    factor = aircraft.calibrated(speed) / speed
    rows = []
    state = State(speed, alpha=3.0 * DEGREE)
    for lever in LEVERS:
        aircraft.place(state)
        aircraft.set_lever(float(lever))
        state, gain = balance(aircraft, state)
        drag = aircraft.thrust() / aircraft.read("inertia/weight-lbs") * STANDARD_GRAVITY - gain
        rows.append((float(lever), gain, state.alpha, state.elevator, drag))
    levers, gains, alphas, elevators, drags = np.array(rows).T
    # Where more throttle gives less thrust, as some engines near idle, the higher position serves
    # no purpose.
    rising = np.maximum.accumulate(gains)
    if rising[-1] - rising[0] < LEAST_THROTTLE:
        raise SimulationError(
            f"{aircraft.name}: the throttle does nothing: its systems move it themselves"
        )
    if rising[-1] < -0.05 * abs(rising[0]) or rising[0] > 0.0:
        raise SimulationError(
            f"{aircraft.name}: no throttle holds {speed / KNOT:.0f} kt (true) in level flight"
        )
    lever = float(np.interp(0.0, *strict(rising, levers)))
    return Trim(
        speed,
        speed * factor,
        float(np.interp(lever, levers, alphas)),
        float(np.interp(lever, levers, elevators)),
        lever,
        levers,
        rising * factor,
        float(np.interp(lever, levers, drags)),
    )


def strict(gains: Array, levers: Array) -> tuple[Array, Array]:
    """Return gains (k,) that rise everywhere, the highest of equal ones, and levers (k,)."""
    keep = np.append(np.diff(gains) > 1e-6, True)
    return gains[keep], levers[keep]


def balance(aircraft: FrozenAircraft, state: State) -> tuple[State, float]:
    """Return the state with lift and pitching moment balanced, and the rate of its airspeed [m/s²].

    Newton's method in angle of attack and elevator; the lever stays. Raises SimulationError where
    it fails.
    """
    now = _residual(aircraft, state)
    for _ in range(15):
        if abs(now[0]) < 0.01 and abs(now[1]) < 0.002:
            return state, float(now[2])
        change = _newton(aircraft, state, now)
        # Control systems have kinks: a step that does not help is halved.
        for _ in range(5):
            tried = replace(
                state,
                alpha=state.alpha + float(change[0]),
                elevator=float(np.clip(state.elevator + change[1], -1.0, 1.0)),
            )
            found = _residual(aircraft, tried)
            if np.hypot(found[0], 3.0 * found[1]) < np.hypot(now[0], 3.0 * now[1]):
                break
            change *= 0.5
        state, now = tried, found
    raise SimulationError(f"{aircraft.name}: no trim at {state.speed / KNOT:.0f} kt (true)")


def _newton(aircraft: FrozenAircraft, state: State, now: Array) -> Array:
    """Return the Newton step in angle of attack [rad] and elevator [-] that balances a state, (2,).

    Raises SimulationError where the elevator has no effect.
    """
    steps = (0.3 * DEGREE, 0.02)
    changed = (
        replace(state, alpha=state.alpha + steps[0]),
        replace(state, elevator=state.elevator + steps[1]),
    )
    slopes = np.stack(
        [
            (_residual(aircraft, each)[:2] - now[:2]) / step
            for each, step in zip(changed, steps, strict=True)
        ],
        axis=1,
    )
    if abs(np.linalg.det(slopes)) < 1e-9:
        raise SimulationError(
            f"{aircraft.name}: the elevator does nothing at {state.speed / KNOT:.0f} kt (true)"
        )
    change = -np.linalg.solve(slopes, now[:2])
    return np.clip(change, (-3.0 * DEGREE, -0.3), (3.0 * DEGREE, 0.3))


def _residual(aircraft: FrozenAircraft, state: State) -> Array:
    found = aircraft.accelerations(state)
    return np.array([found.normal(state.alpha), found.q, found.along(state.alpha)])


def _carries(aircraft: FrozenAircraft, speed: float) -> bool:
    """Return whether the wing carries the weight at a true airspeed [m/s].

    Any angle of attack at which the elevator can trim will do.
    """
    for alpha in ALPHAS.tolist():
        elevator = elevator_for(aircraft, speed, alpha)
        if elevator is None:
            continue
        if aircraft.accelerations(State(speed, alpha, elevator=elevator)).normal(alpha) <= 0.0:
            return True
    return False


def elevator_for(aircraft: FrozenAircraft, speed: float, alpha: float) -> float | None:
    """Return the elevator at which the pitching moment is zero, None where it lacks the travel."""
    low, high = (
        aircraft.accelerations(State(speed, alpha, elevator=e)).q
        for e in (-MOST_ELEVATOR, MOST_ELEVATOR)
    )
    if low * high > 0.0:
        return None
    return MOST_ELEVATOR * (low + high) / (low - high) if low != high else None


def _fastest(aircraft: FrozenAircraft, stall: float) -> tuple[float, bool]:
    """Return the highest true airspeed [m/s] of level flight, and whether Mach 0.7 limits it.

    Else full power does. Raises SimulationError where full power does not hold level flight at 1.2
    times the stall speed.
    """
    speed, step = 1.2 * stall, 1.1
    state, best = State(speed, alpha=6.0 * DEGREE), 0.0
    while step > 1.005:
        state = replace(state, speed=speed)
        aircraft.place(state)
        if aircraft.mach() > HIGHEST_MACH:
            return best or speed, True
        aircraft.set_lever(1.0)
        try:
            state, gain = balance(aircraft, state)
        except SimulationError:
            gain = -1.0
        if gain >= 0.0:
            best = speed
        else:
            speed /= step
            step = step**0.5
        speed *= step
    if not best:
        raise SimulationError(
            f"{aircraft.name}: full power does not hold level flight at 1.2 times the stall speed"
        )
    return best, False
