"""Hold a JSBSim aircraft still in a flight state, with its engines running, and read its accelerations there.

JSBSim's own trim fails for piston aircraft in the air. With the integrators switched off the state stays where it
was put, while engines, propellers and flight control system run on until they are steady.
"""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from math import cos, isfinite, sin
from pathlib import Path

from pitotbench.records.attached import ELECTRIC, TURBOPROP
from pitotbench.simulate.fdm import SimulationError, load_fdm
from pitotbench.simulate.properties import parse_catalog
from pitotbench.units import FOOT, KNOT

RATE = 100.0  # Hz
SLOP = 0.3  # of a control's travel, from which its position is approached
CONTROL_STEPS = 15  # after which the flight control system follows a new command
START_SPEED = 60.0 * KNOT  # true, at which engines are started
STARTER_TIME = 12.0  # s
IDLE_STEP, MOST_IDLE, IDLE_TIME = 0.05, 0.3, 5.0  # of the lever's travel; s
STEADY, SPOOL_LIMIT = 0.002, 25.0  # share of the thrust a look of 0.5 s; s until an engine is steady
LATITUDE = 35.4  # deg
CONTROLS = ("elevator", "aileron", "rudder")
ENGINE = re.compile(r"propulsion/engine(\[\d+\])?/set-running")
SPOOL = re.compile(r"propulsion/engine(\[\d+\])?/n1")
BEST_POWER = 0.85  # of a rich mixture at the density of the air


@dataclass(frozen=True, slots=True)
class State:
    """A flight state: airspeed [m/s, true], angles [rad], rates [rad/s], controls and lever [-1 to 1, 0 to 1]."""

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
        """Return the rate of the velocity across the path in the plane of symmetry [m/s²], down positive."""
        return self.w * cos(alpha) - self.u * sin(alpha)


@dataclass(frozen=True, slots=True)
class Engines:
    """What an aircraft's files say of its engines: their kinds; the idle speed [rpm] of pistons, 0 without one."""

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
        self._kind = kind
        self._fdm, self._transcript = load_fdm(name, folder, RATE)
        self.properties = parse_catalog(self._fdm.get_property_catalog())
        self.engines = sum(bool(ENGINE.fullmatch(path)) for path in self.properties)
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

    def _write(self, paths: Iterable[str], value: float) -> None:
        for path in paths:
            if path in self.properties:
                self._fdm[path] = value

    def _each(self, path: str) -> list[str]:
        """Return the paths of a lever of each engine."""
        return [path, *(f"{path}[{i}]" for i in range(1, self.engines))]

    def _hold(self) -> None:
        self._write(("ic/lat-geod-deg",), LATITUDE)
        self._write(("ic/h-sl-ft",), self._altitude / FOOT)
        self._run_ic()
        for what in ("rate", "position"):
            for part in ("translational", "rotational"):
                self._fdm[f"simulation/integrator/{what}/{part}"] = 0
        self._write(("gear/gear-cmd-norm", "gear/gear-pos-norm"), 0.0)

    def start_engines(self) -> None:
        """Start the engines in the present state, or again where they have stopped.

        Raises SimulationError for an engine that does not start.
        """
        ratio = self.read("atmosphere/P-psf") / 2116.2
        self._write(self._each("fcs/mixture-cmd-norm"), BEST_POWER * ratio)
        self._write(self._each("fcs/advance-cmd-norm"), 1.0)
        self._write(("propulsion/magneto_cmd",), 3)
        self._write(("propulsion/cutoff_cmd",), 0)
        self._write(("propulsion/starter_cmd",), 1)
        self._write(self._each("fcs/throttle-cmd-norm"), 0.5)
        self._fdm["propulsion/set-running"] = -1
        # An electric motor needs no start, and JSBSim never says that it runs.
        running = [path for path in self.properties if ENGINE.fullmatch(path) and ELECTRIC not in self._kind.kind]
        for _ in range(round(STARTER_TIME)):
            self.run(RATE)
            if all(self.read(path) for path in running):
                self._write(("propulsion/starter_cmd",), 0)
                return
        raise SimulationError(f"{self.name}: the engines do not start.{self._transcript.said()}")

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
            if abs(thrust - before) < STEADY * max(abs(thrust), 0.02 * self.read("inertia/weight-lbs")):
                break
            before = thrust
        return self.thrust()

    def move_lever(self, lever: float) -> None:
        """Set all throttles, 0 to 1, at least to idle."""
        self._write(self._each("fcs/throttle-cmd-norm"), max(lever, self.idle))

    def find_idle(self, speeds: Iterable[float]) -> None:
        """Raise `idle` until a piston engine turns at its stated idle speed at all airspeeds [m/s, true].

        In the air a fixed-pitch propeller can drag an engine at closed throttle so far below it that it stops.
        """
        for speed in speeds if self._kind.idle_speed else ():
            self.place(State(speed))
            self.start_engines()
            while self.idle < MOST_IDLE and self._turning() < self._kind.idle_speed:
                self.idle += IDLE_STEP

    def _turning(self) -> float:
        """Return the speed [rpm] of the slowest engine at idle."""
        self.set_lever(self.idle)
        self.run(IDLE_TIME * RATE)
        paths = [path.replace("set-running", "engine-rpm") for path in self.properties if ENGINE.fullmatch(path)]
        return min(self.read(path) for path in paths)

    def thrust(self) -> float:
        """Return the thrust of all engines [lb]."""
        paths = [path.replace("set-running", "thrust-lbs") for path in self.properties if ENGINE.fullmatch(path)]
        return sum(self.read(path) for path in paths)

    def place(self, state: State) -> None:
        """Put the aircraft into a state, in level flight but for the roll."""
        fps = state.speed / FOOT
        for path, value in (
            ("ic/h-sl-ft", self._altitude / FOOT),
            ("ic/phi-rad", state.roll),
            ("ic/theta-rad", state.alpha),
            ("ic/psi-true-rad", 0.0),
            ("ic/u-fps", fps * cos(state.alpha) * cos(state.beta)),
            ("ic/v-fps", fps * sin(state.beta)),
            ("ic/w-fps", fps * sin(state.alpha) * cos(state.beta)),
            ("ic/p-rad_sec", state.roll_rate),
            ("ic/q-rad_sec", state.pitch_rate),
            ("ic/r-rad_sec", state.yaw_rate),
        ):
            self._fdm[path] = value
        for control in CONTROLS:
            self._write((f"fcs/{control}-cmd-norm",), getattr(state, control))
        # JSBSim puts the gas generator of a turboprop back to idle with every initial condition.
        spools = {path: self.read(path) for path in self._spools}
        self._run_ic()
        if spools:
            self.run(1)
            for path, turning in spools.items():
                self._fdm[path] = turning

    def _run_ic(self) -> None:
        if not self._fdm.run_ic():
            raise SimulationError(f"{self.name}: JSBSim refuses the initial conditions.{self._transcript.said()}")

    def accelerations(self, state: State) -> Accelerations:
        """Return the accelerations in a state, after its controls have taken their positions.

        Raises SimulationError where they are not numbers.
        """
        self.place(state)
        # Some actuators have slop: every position is reached from the same side.
        for control in CONTROLS:
            self._write((f"fcs/{control}-cmd-norm",), getattr(state, control) - SLOP)
        self.run(CONTROL_STEPS)
        for control in CONTROLS:
            self._write((f"fcs/{control}-cmd-norm",), getattr(state, control))
        self.run(CONTROL_STEPS)
        path = "accelerations/{}dot-{}"
        found = Accelerations(
            *(self.read(path.format(axis, "ft_sec2")) * FOOT for axis in "uvw"),
            *(self.read(path.format(axis, "rad_sec2")) for axis in "pqr"),
        )
        if not all(isfinite(getattr(found, axis)) for axis in "uvwpqr"):
            raise SimulationError(f"{self.name}: its accelerations are not numbers at {state.speed / KNOT:.0f} kt")
        return found

    def moves(self, control: str, position: str) -> bool:
        """Return whether a position of JSBSim follows a control."""
        if position not in self.properties:
            return False
        seen = []
        for deflection in (-SLOP, SLOP):
            self._write((f"fcs/{control}-cmd-norm",), deflection)
            self.run(CONTROL_STEPS)
            seen.append(self.read(position))
        self._write((f"fcs/{control}-cmd-norm",), 0.0)
        return abs(seen[1] - seen[0]) > 1e-4

    def calibrated(self, speed: float) -> float:
        """Return the calibrated airspeed [m/s] of a true airspeed [m/s] at the height of this aircraft."""
        self.place(State(speed))
        self.run(1)
        return self.read("velocities/vc-kts") * KNOT

    def mach(self) -> float:
        """Return the Mach number of the present state."""
        return self.read("velocities/mach")
