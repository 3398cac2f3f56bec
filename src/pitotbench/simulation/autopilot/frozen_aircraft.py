"""Freeze an aircraft in a flight state, with its engines running, and read its accelerations.

JSBSim's own trim fails for piston aircraft in the air. With the integrators switched off the state
stays where it was put, while engines, propellers and flight control system run on until they are
steady.
"""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from math import cos, isfinite, sin
from pathlib import Path
from typing import TYPE_CHECKING

from pitotbench.records.aircraft import ELECTRIC, TURBOPROP
from pitotbench.simulation.aircraft_files import (
    INTEGRATORS,
    LATITUDE,
    RUNNING,
    SimulationError,
    load_fdm,
    parse_catalog,
)
from pitotbench.units import FOOT, KNOT

if TYPE_CHECKING:
    from jsbsim import FGLinearization

RATE = 100.0  # Hz
SLOP = 0.3  # of a control's travel, from which its position is approached
CONTROL_STEPS = 15  # after which the flight control system follows a new command
START_SPEED = 60.0 * KNOT  # true, at which engines are started
STARTER_TIME = 12.0  # s
IDLE_STEP, MOST_IDLE, IDLE_TIME = 0.05, 0.3, 5.0  # of the lever's travel; s
# Share of the thrust a sample of 0.5 s; s until an engine is steady.
STEADY, SPOOL_LIMIT = 0.002, 25.0
CONTROLS = ("elevator", "aileron", "rudder")
OWN_LEVER = "ap/throttle-command-norm"  # of the bench's own aircraft
SPOOL = re.compile(r"propulsion/engine(\[\d+\])?/n1")
SAME_THRUST = 0.05  # share of the thrust that a linear model's may be off by; 0 to 0.02 is usual
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
        """Return the rate of the velocity across the path [m/s²], down positive.

        Across the path is within the plane of symmetry.
        """
        return self.w * cos(alpha) - self.u * sin(alpha)


@dataclass(frozen=True, slots=True)
class Engines:
    """The engines of an aircraft by its files: kind, and idle speed [rpm] of pistons, else 0."""

    kind: str
    idle_speed: float = 0.0


class FrozenAircraft:
    """One aircraft, frozen in the air at a height [m] with its engines running.

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
        """Hold the aircraft at another height [m] and a true airspeed [m/s], engines running."""
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
        """Return whether all engines run.

        JSBSim never says so of an electric motor, which needs no start.
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
        """Raise `idle` until piston engines turn at their stated idle speed at all airspeeds.

        `speeds` are true [m/s]. In the air a fixed-pitch propeller can drag an engine at closed
        throttle so far below it that it stops.
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
        """Put the aircraft into a state, its path in the plane of symmetry but for the roll."""
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
        # Some actuators have slop: every position is reached from the same side.
        for before in (SLOP, 0.0):
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

    def linearize(self, state: State) -> "FGLinearization":
        """Return JSBSim's own linear model in a state, at the present lever (J. Goppert, 2011).

        While it moves one state, it keeps engines, propellers and flight controls in their steady
        state. Raises SimulationError where the engines do not keep their thrust there.
        """
        import jsbsim

        self.accelerations(state)
        thrust = self.set_lever(self.read("fcs/throttle-cmd-norm"))
        # FGLinearization waits for a steady state many times, which takes minutes in vain where the
        # engines stop, race or hunt.
        propulsion = self._fdm.get_propulsion()
        for engine in range(self.engines):
            propulsion.get_engine(engine).init_running()
        for _ in range(CONTROL_STEPS):
            before = self.thrust()
            propulsion.get_steady_state()
            self.run(1)
        if before != self.thrust() or abs(before - thrust) > SAME_THRUST * abs(thrust):
            raise SimulationError(
                f"{self.name}: JSBSim's linearization does not keep the engines running as in "
                f"level flight (thrust {thrust:,.0f} lb; there {self.thrust():,.0f} lb), so that "
                "there is no linear model"
            )
        return jsbsim.FGLinearization(self._fdm)

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
        """Return the calibrated airspeed [m/s] of a true one [m/s] at this aircraft's height."""
        self.place(State(speed))
        self.run(1)
        return self.read("velocities/vc-kts") * KNOT

    def mach(self) -> float:
        """Return the Mach number of the present state."""
        return self.read("velocities/mach")
