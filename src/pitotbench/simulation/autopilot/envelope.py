"""Find the speeds between which an aircraft flies level, and its trim at each."""

import re
from collections.abc import Iterable
from dataclasses import dataclass, replace
from math import cos, isfinite, sin
from pathlib import Path

import numpy as np

from pitotbench.records.aircraft import ELECTRIC, TURBOPROP
from pitotbench.simulation.plant import INTEGRATORS, LATITUDE, RUNNING, SimulationError, load_fdm
from pitotbench.simulation.properties import parse_catalog
from pitotbench.units import DEGREE, FOOT, KNOT, STANDARD_GRAVITY, Array

# Hold a JSBSim aircraft still in a flight state, with its engines running, and read its
# accelerations there. JSBSim's own trim fails for piston aircraft in the air. With the integrators
# switched off the state stays where it was put, while engines, propellers and flight control system
# run on until they are steady.

RATE = 100.0  # Hz
SLOP = 0.3  # of a control's travel, from which its position is approached
CONTROL_STEPS = 15  # after which the flight control system follows a new command
START_SPEED = 60.0 * KNOT  # true, at which engines are started
STARTER_TIME = 12.0  # s
IDLE_STEP, MOST_IDLE, IDLE_TIME = 0.05, 0.3, 5.0  # of the lever's travel; s
STEADY, SPOOL_LIMIT = (
    0.002,
    25.0,
)  # share of the thrust a look of 0.5 s; s until an engine is steady
CONTROLS = ("elevator", "aileron", "rudder")
OWN_LEVER = "ap/throttle-command-norm"  # of the bench's own aircraft
SPOOL = re.compile(r"propulsion/engine(\[\d+\])?/n1")
BEST_POWER = 0.85  # of a rich mixture at the density of the air


@dataclass(frozen=True, slots=True)
class State:
    """A flight state: airspeed [m/s, true], angles [rad], rates [rad/s], controls [-1 to 1].

    `climb` is the angle of the path above the horizon.
    """

    speed: float
    alpha: float = 0.0
    beta: float = 0.0
    roll: float = 0.0
    roll_rate: float = 0.0
    pitch_rate: float = 0.0
    yaw_rate: float = 0.0
    elevator: float = 0.0
    aileron: float = 0.0
    rudder: float = 0.0
    climb: float = 0.0


@dataclass(frozen=True, slots=True)
class Accelerations:
    """Rates of the body velocities [m/s²] and of the body rates [rad/s²] in a state."""

    u: float
    v: float
    w: float
    p: float
    q: float
    r: float

    def along(self, alpha: float) -> float:
        """Return the rate of the airspeed [m/s²]."""
        return self.u * cos(alpha) + self.w * sin(alpha)

    def normal(self, alpha: float) -> float:
        """Return the rate of the velocity across the path in the plane of symmetry [m/s²], down
        positive.
        """
        return self.w * cos(alpha) - self.u * sin(alpha)


@dataclass(frozen=True, slots=True)
class Engines:
    """What an aircraft's files say of its engines: their kinds; the idle speed [rpm] of pistons, 0
    without one.
    """

    kind: str
    idle_speed: float = 0.0


class HeldAircraft:
    """One aircraft, held in the air at a height [m] with its engines running.

    `idle` is the lowest position of the throttles, 0 to 1; a lever below it is set to it.

    Raises SimulationError where JSBSim refuses the files or an engine does not start.
    """

    def __init__(self, name: str, folder: Path, altitude: float, kind: Engines) -> None:
        self.name = name
        self.idle = 0.0
        self.rich = False  # whether the mixture lever stays full rich
        self._kind = kind
        self._fdm, self._transcript = load_fdm(name, folder, RATE)
        self.properties = parse_catalog(self._fdm.get_property_catalog())
        self._running = [path for path in self.properties if RUNNING.fullmatch(path)]
        self.engines = len(self._running)
        self._altitude = altitude
        self._spools: list[str] = []
        self._hold()
        self.place(State(START_SPEED))
        self.start_engines()
        if TURBOPROP in kind.kind:
            self._spools = [path for path in self.properties if SPOOL.fullmatch(path)]

    def read(self, path: str) -> float:
        """Return a property of JSBSim, in its unit."""
        return float(self._fdm[path])

    def serves(self, path: str) -> bool:
        """Return whether the aircraft has a property of this path."""
        return path in self.properties

    def write(self, path: str, value: float) -> None:
        """Set a property of JSBSim, in its unit, where the aircraft has it."""
        if path in self.properties:
            self._fdm[path] = value

    def climb_to(self, altitude: float, speed: float) -> None:
        """Hold the aircraft at another height [m] and a true airspeed [m/s], with its engines
        running.
        """
        if not self._turn():
            self.start_engines()  # at the height before, where they have started once
        self._altitude = altitude
        self.place(State(speed))
        self._lean()
        self.run(RATE)
        if not self._turn():
            self.start_engines()
            self._lean()  # a start leaves it rich

    def _write_each(self, path: str, value: float) -> None:
        """Set a lever of each engine."""
        for each in (path, *(f"{path}[{i}]" for i in range(1, self.engines))):
            self.write(each, value)

    def _hold(self) -> None:
        self.write("ic/lat-geod-deg", LATITUDE)
        self.write("ic/h-sl-ft", self._altitude / FOOT)
        self._run_ic()
        for path in INTEGRATORS:
            self._fdm[path] = 0
        # The autopilot of the bench's own aircraft leaves the controls alone.
        for path in ("gear/gear-cmd-norm", "gear/gear-pos-norm", "ap/guidance", "ap/throttle-mode"):
            self.write(path, 0.0)

    def start_engines(self) -> None:
        """Start the engines in the present state, or again where they have stopped.

        Raises SimulationError for an engine that does not start.
        """
        self._lean()
        self._write_each("fcs/advance-cmd-norm", 1.0)
        self.write("propulsion/magneto_cmd", 3)
        self.write("propulsion/cutoff_cmd", 0)
        self.write("propulsion/starter_cmd", 1)
        self.move_lever(0.5)
        self._fdm["propulsion/set-running"] = -1
        for _ in range(round(STARTER_TIME)):
            self.run(RATE)
            if self._turn():
                self.write("propulsion/starter_cmd", 0)
                return
        raise SimulationError(f"{self.name}: the engines do not start.{self._transcript.said()}")

    def _lean(self) -> None:
        """Set the mixture for the height."""
        ratio = self.read("atmosphere/P-psf") / 2116.2
        self._write_each("fcs/mixture-cmd-norm", 1.0 if self.rich else BEST_POWER * ratio)

    def _turn(self) -> bool:
        """Return whether all engines run. JSBSim never says so of an electric motor, which needs no
        start.
        """
        return ELECTRIC in self._kind.kind or all(map(self.read, self._running))

    def run(self, steps: float) -> None:
        """Let engines and controls run on for a number of steps of 0.01 s."""
        for _ in range(round(steps)):
            if not self._fdm.run():
                raise SimulationError(f"{self.name}: JSBSim stopped.{self._transcript.said()}")

    def set_lever(self, lever: float) -> float:
        """Set all throttles, 0 to 1, wait until the thrust is steady, and return it [lb]."""
        self.move_lever(lever)
        before = float("inf")
        for _ in range(round(SPOOL_LIMIT / 0.5)):
            self.run(0.5 * RATE)
            thrust = self.thrust()
            if abs(thrust - before) < STEADY * max(
                abs(thrust), 0.02 * self.read("inertia/weight-lbs")
            ):
                break
            before = thrust
        return self.thrust()

    def move_lever(self, lever: float) -> None:
        """Set all throttles, 0 to 1, at least to idle."""
        self._write_each("fcs/throttle-cmd-norm", max(lever, self.idle))
        self.write(OWN_LEVER, max(lever, self.idle))

    def find_idle(self, speeds: Iterable[float]) -> None:
        """Raise `idle` until a piston engine turns at its stated idle speed at all airspeeds [m/s,
        true].

        In the air a fixed-pitch propeller can drag an engine at closed throttle so far below it
        that it stops.
        """
        for speed in speeds if self._kind.idle_speed else ():
            self.place(State(speed))
            self.start_engines()
            while self.idle < MOST_IDLE:
                self.set_lever(self.idle)
                self.run(IDLE_TIME * RATE)
                if min(self._of_each("engine-rpm"), default=0.0) >= self._kind.idle_speed:
                    break
                self.idle += IDLE_STEP

    def thrust(self) -> float:
        """Return the thrust of all engines [lb]."""
        return sum(self._of_each("thrust-lbs"))

    def power(self) -> float:
        """Return the power of all engines [hp], 0 for jets."""
        return sum(self._of_each("power-hp"))

    def _of_each(self, reading: str) -> list[float]:
        paths = (path.replace("set-running", reading) for path in self._running)
        return [self.read(path) for path in paths if path in self.properties]

    def place(self, state: State) -> None:
        """Put the aircraft into a state, with its path in the plane of symmetry but for the roll."""
        fps = state.speed / FOOT
        for path, value in (
            ("ic/h-sl-ft", self._altitude / FOOT),
            ("ic/phi-rad", state.roll),
            ("ic/theta-rad", state.alpha + state.climb),
            ("ic/psi-true-rad", 0.0),
            ("ic/u-fps", fps * cos(state.alpha) * cos(state.beta)),
            ("ic/v-fps", fps * sin(state.beta)),
            ("ic/w-fps", fps * sin(state.alpha) * cos(state.beta)),
            ("ic/p-rad_sec", state.roll_rate),
            ("ic/q-rad_sec", state.pitch_rate),
            ("ic/r-rad_sec", state.yaw_rate),
        ):
            self._fdm[path] = value
        self._move(state)
        # JSBSim puts the gas generator of a turboprop back to idle with every initial condition.
        spools = {path: self.read(path) for path in self._spools}
        self._run_ic()
        if spools:
            self.run(1)
            for path, turning in spools.items():
                self._fdm[path] = turning

    def _run_ic(self) -> None:
        if not self._fdm.run_ic():
            raise SimulationError(
                f"{self.name}: JSBSim refuses the initial conditions.{self._transcript.said()}"
            )

    def accelerations(self, state: State) -> Accelerations:
        """Return the accelerations in a state, after its controls have taken their positions.

        Raises SimulationError where they are not numbers.
        """
        self.place(state)
        for before in (
            SLOP,
            0.0,
        ):  # some actuators have slop: every position is reached from the same side
            self._move(state, before)
            self.run(CONTROL_STEPS)
        path = "accelerations/{}dot-{}"
        found = Accelerations(
            *(self.read(path.format(axis, "ft_sec2")) * FOOT for axis in "uvw"),
            *(self.read(path.format(axis, "rad_sec2")) for axis in "pqr"),
        )
        if not all(isfinite(getattr(found, axis)) for axis in "uvwpqr"):
            raise SimulationError(
                f"{self.name}: its accelerations are not numbers at {state.speed / KNOT:.0f} kt"
            )
        return found

    def _move(self, state: State, before: float = 0.0) -> None:
        """Set the controls of a state, or a deflection before them."""
        for control in CONTROLS:
            self.write(f"fcs/{control}-cmd-norm", getattr(state, control) - before)

    def moves(self, control: str, position: str) -> bool:
        """Return whether a position of JSBSim follows a control."""
        if position not in self.properties:
            return False
        seen = []
        for deflection in (-SLOP, SLOP):
            self.write(f"fcs/{control}-cmd-norm", deflection)
            self.run(CONTROL_STEPS)
            seen.append(self.read(position))
        self.write(f"fcs/{control}-cmd-norm", 0.0)
        return abs(seen[1] - seen[0]) > 1e-4

    def calibrated(self, speed: float) -> float:
        """Return the calibrated airspeed [m/s] of a true airspeed [m/s] at the height of this
        aircraft.
        """
        self.place(State(speed))
        self.run(1)
        return self.read("velocities/vc-kts") * KNOT

    def mach(self) -> float:
        """Return the Mach number of the present state."""
        return self.read("velocities/mach")


# All of it is flown in held flight (`held.py`): nothing is typed in. The stall speed is the lowest
# at which the lift with trimmed elevator, engines idle, carries the weight. The maximum level speed
# is the highest at which full power is at least the drag.

SLOWEST, FASTEST = 8.0 * KNOT, 500.0 * KNOT  # true; where a stall speed is looked for
HIGHEST_MACH = 0.7  # above it the drag rise begins, and position errors are another matter
ALPHAS = np.arange(-2.0, 25.0, 1.5) * DEGREE
MOST_ELEVATOR = 0.95  # of its travel: the rest is left for control
LEVERS = np.array([0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.65, 0.8, 1.0])
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
    """The speeds of an aircraft at one height [m/s calibrated], and its trim points from slow to
    fast.

    `limited` says that the fastest speed is a Mach number of 0.7, not the maximum level speed.
    """

    stall: float
    fastest: float
    limited: bool
    points: tuple[Trim, ...]


def explore(aircraft: HeldAircraft) -> Envelope:
    """Return the envelope of an aircraft. Raises SimulationError where it does not fly level at any
    speed.
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
            f"{fastest / KNOT:.0f} kt (true): "
            "too little for a calibration"
        )
    speeds = np.geomspace(SLOWEST_TRIM * stall, fastest, SPEEDS)
    points = tuple(trim(aircraft, float(speed)) for speed in speeds)
    return Envelope(aircraft.calibrated(stall), points[-1].calibrated, limited, points)


def trim(aircraft: HeldAircraft, speed: float) -> Trim:
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
    """Return gains (k,) that rise everywhere, with their levers (k,): the highest of each run of
    equal gains.
    """
    keep = np.append(np.diff(gains) > 1e-6, True)
    return gains[keep], levers[keep]


def balance(aircraft: HeldAircraft, state: State) -> tuple[State, float]:
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


def _newton(aircraft: HeldAircraft, state: State, now: Array) -> Array:
    """Return the change of angle of attack [rad] and elevator that balances a state, by the slopes
    there.
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


def _residual(aircraft: HeldAircraft, state: State) -> Array:
    found = aircraft.accelerations(state)
    return np.array([found.normal(state.alpha), found.q, found.along(state.alpha)])


def _carries(aircraft: HeldAircraft, speed: float) -> bool:
    """Return whether the wing carries the weight at a true airspeed [m/s], at any angle that the
    elevator holds.
    """
    for alpha in ALPHAS.tolist():
        elevator = held_by(aircraft, speed, alpha)
        if elevator is None:
            continue
        if aircraft.accelerations(State(speed, alpha, elevator=elevator)).normal(alpha) <= 0.0:
            return True
    return False


def held_by(aircraft: HeldAircraft, speed: float, alpha: float) -> float | None:
    """Return the elevator at which the pitching moment is zero; None where its travel does not
    suffice.
    """
    low, high = (
        aircraft.accelerations(State(speed, alpha, elevator=e)).q
        for e in (-MOST_ELEVATOR, MOST_ELEVATOR)
    )
    if low * high > 0.0:
        return None
    return MOST_ELEVATOR * (low + high) / (low - high) if low != high else None


def _fastest(aircraft: HeldAircraft, stall: float) -> tuple[float, bool]:
    """Return the highest true airspeed [m/s] of level flight at full power, and whether Mach 0.7
    came first.
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
