"""JSBSim as a force meter: put the aircraft into each measured state, and read the forces there.

At each state the initial conditions are set anew. The model therefore cannot drift, and no
autopilot can hide a force. Between two states the engines, governors and turbochargers run on at
the measured throttles, because their power depends on the seconds before. The result is the
right-hand side of the equation-error method (Klein and Morelli, Aircraft System Identification,
2006, ch. 5).
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from pitotbench import air
from pitotbench.axes import flow_direction
from pitotbench.records.motion import Motion, Reaction
from pitotbench.simulation.aircraft_files import SimulationError
from pitotbench.simulation.modified import tanks
from pitotbench.simulation.plant import Air, Plant
from pitotbench.simulation.properties import PROPERTIES
from pitotbench.timeline import gaps
from pitotbench.units import DEGREE, FOOT, POUND, Array

TENTH = 0.1  # s
INSTANT = 1e-6  # s, of a step in which nothing moves
RUN_IN = 12.0  # s, for the engines at the first state and after every gap
# s between states up to which the airplane flies on between them; over longer ones it is frozen
FREE = 0.2
FULL = ("specific_force_x", "specific_force_y", "specific_force_z")
ENGINE = ("manifold_pressure", "propeller_speed", "fuel_flow")
# Control, the command that moves it, and the position it takes.
CONTROLS = (
    ("elevator", "fcs/elevator-cmd-norm", "elevator"),
    ("aileron", "fcs/aileron-cmd-norm", "aileron"),
    ("rudder", "fcs/rudder-cmd-norm", "rudder"),
    ("throttle_left", "throttle_bias_left", "throttle_left"),
    ("throttle_right", "throttle_bias_right", "throttle_right"),
)
GUIDANCE = "ap/guidance"  # of the bench's own autopilot: whether it computes its modes
LARGEST_OFF = 0.5 * DEGREE  # of a surface from where it was put: the end of a travel is no more
# Of JSBSim after a change: the rate of the angle of attack follows the forces of the call before.
CALLS = 2
PROBE = 0.1  # of a command: the step by which the gain from command to position is measured


def measure(plant: Plant, motion: Motion, loaded_mass: float, engines_run: bool = True) -> Reaction:
    """Return forces, angular accelerations and engine readings along a measured motion.

    Parameters: plant, freshly loaded, which cannot be used again; motion, the measured states;
    loaded_mass [kg], the mass of the loaded aircraft without any effect. Fuel is taken out of the
    tanks at every state until the mass is the logged one.

    With `engines_run` false, time stands still after the first state. The thrust is then not that
    of the motion: use only the difference of two such reactions, and only for effects that change
    aerodynamic forces.

    At ten states a second, one state takes about 100 µs. Raises SimulationError where JSBSim
    refuses a state or the engines do not start.
    """
    rig = Rig.set_up(plant, motion, loaded_mass)
    rows = np.empty((len(motion.time), len(rig.reads)))
    # The first call moves the state, which systems of the aircraft and functions of the lift read:
    # only after the second one are the controls where they were measured.
    for k in visit_states(rig, motion, 2, engines_run):
        rows[k] = rig.row()
    names = [*FULL, *(f"{axis}_acceleration" for axis in ("roll", "pitch", "yaw"))]
    names += [f"{name}_{side}" for name in ENGINE for side in ("left", "right")]
    return Reaction(**{name: rows[:, i].copy() for i, name in enumerate(names)})


def visit_states(rig: "Rig", motion: Motion, calls: int, engines_run: bool = True) -> Iterator[int]:
    """Put the aircraft into each state with some calls, and yield the state's number.

    Between two states the engines run on, unless `engines_run` is false.
    """
    count, plant = len(motion.time), rig.plant
    steps = np.maximum(1, np.round(np.diff(motion.time) / plant.time_step)).astype(int)
    starts = np.isin(np.arange(count), [0, *gaps(motion.time)])
    for k in range(count):
        if starts[k] and (engines_run or k == 0):
            rig.run_in(k)
        for _ in range(calls):
            rig.place(k)
        if engines_run:
            rig.keep_turning()
        yield k
        # Before a gap the engines do not run on: the run-in after it starts them anew.
        if engines_run and k + 1 < count and not starts[k + 1]:
            plant.advance(int(steps[k]))


def _hold(plant: Plant, motion: Motion) -> None:
    """Start the engines while the airplane is frozen in flight."""
    height = float(air.pressure_altitude(motion.static_pressure[0]))
    speed = float(
        air.calibrated_airspeed(
            air.impact_pressure_from_mach(motion.mach[0], motion.static_pressure[0])
        )
    )
    # The controls are moved from here: without its modes the autopilot has no output, but a cost.
    if plant.serves(GUIDANCE):
        plant.set(GUIDANCE, 0.0)
    plant.start_frozen(
        height, speed, float(motion.heading[0]), Air(temperature_offset=motion.temperature_offset)
    )
    if float(np.median(np.diff(motion.time))) <= FREE:
        plant.release()


def _levels(plant: Plant, motion: Motion) -> tuple[Array, Array]:
    """Return geometric height [m] and speed of sound [m/s] at each state's pressure, (n,).

    They come from a table of the plant's atmosphere, which may be warmer than standard.
    """
    low, high = (
        float(air.pressure_altitude(p))
        for p in (motion.static_pressure.max(), motion.static_pressure.min())
    )
    levels = np.linspace(low - 600.0, high + 600.0, 25)
    table = np.empty((len(levels), 2))
    for i, level in enumerate(levels):
        plant.set("ic/h-sl-ft", float(level) / FOOT)
        plant.run_initial_conditions()
        table[i] = plant.get("static_pressure"), plant.get("atmosphere/a-fps") * FOOT
    # The logarithm of pressure is nearly linear in height, so 25 levels interpolate well.
    heights = np.interp(-np.log(motion.static_pressure), -np.log(table[:, 0]), levels)
    return heights, np.interp(heights, levels, table[:, 1])


def _initial_conditions(motion: Motion, heights: Array, sound: Array) -> Array:
    """Return the states as JSBSim's initial conditions in still air, (n, 10), ordered as `_IC`."""
    speed = motion.mach * sound / FOOT
    flow = flow_direction(motion.angle_of_attack, motion.sideslip)
    return np.stack(
        [
            heights / FOOT,
            motion.roll,
            motion.pitch,
            np.mod(motion.heading, 2.0 * np.pi),
            *(speed * flow),
            motion.roll_rate,
            motion.pitch_rate,
            motion.yaw_rate,
        ],
        axis=1,
    )


_IC = (
    *(
        "ic/h-sl-ft",
        "ic/phi-rad",
        "ic/theta-rad",
        "ic/psi-true-rad",
        "ic/u-fps",
        "ic/v-fps",
        "ic/w-fps",
    ),
    *("ic/p-rad_sec", "ic/q-rad_sec", "ic/r-rad_sec"),
)


@dataclass(slots=True)
class _Servo:
    """A control that is moved to measured positions, even where systems add to its command."""

    write: Callable[[float], object]
    read: Callable[[], float]
    factor: float  # SI value of the position a unit of its property
    # Position a unit of a negative and of a positive command: an elevator moves further up.
    slopes: tuple[float, float]
    command: float = 0.0

    @classmethod
    def probe(cls, plant: Plant, name: str, command: str, position: str) -> "_Servo":
        """Measure how far the command moves the control.

        Raises SimulationError where it does not move it.
        """
        read, factor = plant.getter(position)

        def position_at(value: float) -> float:
            plant.set(command, value)
            plant.run_initial_conditions()
            return read()

        before = read()
        slopes = [(position_at(probe) - before) / probe for probe in (-PROBE, PROBE)]
        if max(map(abs, slopes)) < 1e-6:  # a throttle that stands at its stop up to there
            slopes = [(position_at(0.5 + PROBE) - position_at(0.5)) / PROBE] * 2
        plant.set(command, 0.0)
        plant.run_initial_conditions()
        if max(map(abs, slopes)) < 1e-6:
            raise SimulationError(f"{plant.aircraft}: {name} does not follow {command}")
        # What moves one way only, as a throttle at idle does, moves the other way alike as far as
        # anyone can tell.
        below, above = (
            slope if abs(slope) >= 1e-6 else slopes[1 - i] for i, slope in enumerate(slopes)
        )
        return cls(plant.writer(command), read, factor, (below, above))

    def move(self, position: float) -> None:
        """Move the control to a position [SI], with what aircraft systems add to the command."""
        below, above = self.slopes
        added = self.read() - self.command * (above if self.command > 0.0 else below)
        wanted = position / self.factor - added
        self.command = wanted / (above if wanted * above > 0.0 else below)
        self.write(self.command)


@dataclass(frozen=True, slots=True)
class Rig:
    """A plant with running engines, ready to be put into each state of a motion.

    `states` are the initial conditions and the fuel of each state, (n, 10 + tanks), and `wanted`
    the positions of the controls, (n, k). `reads` and `factors` give a reaction in SI units; its
    forces are not yet per mass.
    """

    plant: Plant
    states: Array
    wanted: Array
    servos: list[_Servo]
    writers: Sequence[Callable[[float], bool]]
    reads: Sequence[Callable[[], float]]
    factors: Array
    mass: tuple[Callable[[], float], float]
    spools: Sequence[str]

    @classmethod
    def set_up(cls, plant: Plant, motion: Motion, loaded_mass: float) -> "Rig":
        """Start the engines of a plant. Parameters and errors are those of `measure`."""
        full = np.array([plant.get(tank) for tank in tanks(plant)])
        burnt = (loaded_mass - motion.mass) / POUND / max(1, len(full))  # in equal shares
        fuel = np.clip(full - burnt[:, None], 0.0, full)  # a tank holds no more than its full load
        _hold(plant, motion)
        heights, sound = _levels(plant, motion)
        servos = [_Servo.probe(plant, *control) for control in _controls(plant)]
        rig = cls(
            plant,
            states=np.concatenate([_initial_conditions(motion, heights, sound), fuel], axis=1),
            wanted=np.stack([getattr(motion, name) for name, *_ in _controls(plant)], axis=1),
            servos=servos,
            writers=[plant.writer(path) for path in (*_IC, *tanks(plant))],
            reads=[
                plant.getter(path)[0] if plant.serves(path) else read_zero for path, _ in _outputs()
            ],
            factors=np.array([factor for _, factor in _outputs()]),
            mass=plant.getter("mass"),
            spools=[
                path
                for path in (each.replace("set-running", "n1") for each in plant.engines)
                if plant.serves(path)
            ],
        )
        rig.check_surfaces()
        return rig

    def check_surfaces(self) -> None:
        """Raise SimulationError where the aircraft moves a surface away from where it is put."""
        for _ in range(CALLS + 1):
            self.place(0)
        for (name, *_), servo, wanted in zip(
            _controls(self.plant), self.servos, self.wanted[0], strict=True
        ):
            off = abs(servo.read() * servo.factor - wanted)
            if off > LARGEST_OFF and not name.startswith("throttle"):
                raise SimulationError(
                    f"{self.plant.aircraft}: its flight controls move the {name} by themselves, "
                    f"{off / DEGREE:.1f}° from where the log has it; use --aircraft none to judge "
                    "the sensors alone"
                )

    def place(self, k: int) -> None:
        """Put the aircraft into a state, its controls first.

        The controls move first: their systems may read the state, so a second call corrects what
        the first one changed.
        """
        for servo, position in zip(self.servos, self.wanted[k].tolist(), strict=True):
            servo.move(position)
        for write, value in zip(self.writers, self.states[k].tolist(), strict=True):
            write(value)
        self.plant.run_initial_conditions()

    def keep_turning(self) -> None:
        """Give each gas generator the speed back that it had before the initial conditions.

        JSBSim puts it to idle in the first step after them. Two steps of no time pass: that one,
        and one in which its power reaches the propeller.
        """
        turning = [(spool, self.plant.get(spool)) for spool in self.spools]
        if turning:
            self.plant.fdm.set_dt(INSTANT)
            self.plant.advance(1)
            for spool, speed in turning:
                self.plant.set(spool, speed)
            self.plant.advance(1)
            self.plant.fdm.set_dt(self.plant.time_step)

    def run_in(self, k: int) -> None:
        """Bring the engines to the power of a state, the airplane held in it each tenth [s]."""
        for _ in range(round(RUN_IN / TENTH)):
            self.place(k)
            self.keep_turning()
            self.plant.advance(round(TENTH / self.plant.time_step))

    def row(self) -> Array:
        """Return the present reaction, (12,), in the order and units of a Reaction's fields."""
        row = np.array([read() for read in self.reads]) * self.factors
        row[:3] /= self.mass[0]() * self.mass[1]
        return row


def _controls(plant: Plant) -> list[tuple[str, str, str]]:
    """Return each control, the command that moves it, and its position.

    With an attached autopilot the commands are sticks.
    """
    sticks = {
        name: f"ap/stick-{name}-norm" if plant.attached else ""
        for name in ("elevator", "aileron", "rudder")
    }
    served = {line.name for line in plant.channels}
    controls = [
        (n, sticks.get(n) or command, position)
        for n, command, position in CONTROLS
        if position in served
    ]
    if len(plant.engines) == 2:
        return controls
    # One lever, or a lever for all engines: that of the first.
    both = (("throttle_left", "throttle_command", "throttle_left"),)
    return [*(each for each in controls if not each[0].startswith("throttle")), *both]


def read_zero() -> float:
    """The reading of a gauge that the aircraft does not have."""
    return 0.0


def _outputs() -> list[tuple[str, float]]:
    forces = [(PROPERTIES[name].path, PROPERTIES[name].factor) for name in FULL]
    turning = [(f"accelerations/{axis}dot-rad_sec2", 1.0) for axis in "pqr"]
    engines = [PROPERTIES[f"{name}_{side}"] for name in ENGINE for side in ("left", "right")]
    return forces + turning + [(line.path, line.factor) for line in engines]
