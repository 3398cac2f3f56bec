"""Load an aircraft in JSBSim, start it in the air of a flight and run it.

JSBSim's silent failures become errors here.
"""

import re
from collections.abc import Callable, Iterable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from math import cos, degrees, isfinite, pi, sin
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from pitotbench.catalog import Catalog, UnknownNameError, explain
from pitotbench.effects.overlay import Overlay
from pitotbench.records.aircraft import ELECTRIC, Attached
from pitotbench.records.case import TURBULENCE_SEVERITY, USUAL_RATE, Case
from pitotbench.simulation.aircraft import find_aircraft
from pitotbench.simulation.aircraft_files import (
    INTEGRATORS,
    LATITUDE,
    RUNNING,
    SimulationError,
    Transcript,
    load_fdm,
    parse_catalog,
    parse_xml,
    read_record,
)
from pitotbench.simulation.properties import (
    CHANNELS,
    COMMON_CONTROLS,
    OWN_CONTROLS,
    PROPERTIES,
    Property,
)
from pitotbench.simulation.variant import (
    ROOT,
    free_branch,
    ground_rates,
    lagging_actuators,
    throttle_settings,
    write_variant,
)
from pitotbench.units import DEGREE, FOOT, KNOT, POUND

MILSPEC_TUSTIN = 4  # JSBSim's turb-type: MIL-F-8785C spectra, filters discretized by Tustin's rule
# Wind at 20 ft that MIL-F-8785C ties to light, moderate and severe turbulence; used below 2,000 ft
# only.
LOW_WIND = (0.0, 15.0 * KNOT, 30.0 * KNOT, 45.0 * KNOT)
LARGEST_SEED = 2**31 - 1  # JSBSim keeps its seed in a signed word

SEVERITY = Catalog("turbulence", TURBULENCE_SEVERITY)


@dataclass(frozen=True, slots=True)
class Air:
    """The air of a flight: mean wind, temperature and turbulence.

    `north`, `east` and `down` are the mean wind [m/s], the direction in which the air moves.
    `temperature_offset` is the temperature above standard [K]. `severity` is the Milspec index of
    the turbulence (0 none, 1 light, 2 moderate) and `seed` starts its random numbers (1 to 2³¹−1).
    """

    north: float = 0.0
    east: float = 0.0
    down: float = 0.0
    temperature_offset: float = 0.0
    severity: int = 0
    seed: int = 1

    @classmethod
    def of(cls, case: Case, temperature_change: float = 0.0) -> "Air":
        """Return the air of a case, warmer by `temperature_change` [K], which its effects make.

        Raises UnknownNameError for an unknown turbulence name.
        """
        # A case says where the wind comes from, JSBSim where the air goes: hence the minus signs.
        wind = case.wind
        return cls(
            north=-wind.speed * cos(wind.from_direction),
            east=-wind.speed * sin(wind.from_direction),
            down=-wind.up,
            temperature_offset=case.temperature_offset + temperature_change,
            severity=SEVERITY[case.turbulence],
            seed=turbulence_seed(case.truth_seed),
        )


def turbulence_seed(truth_seed: int) -> int:
    """Return JSBSim's seed, 1 to 2³¹−1, for a truth seed."""
    # JSBSim makes the same turbulence of the seeds 0 and 1. Hashing also keeps neighboring seeds
    # independent.
    word = int(np.random.SeedSequence(truth_seed).generate_state(1, np.uint64)[0])
    return 1 + word % LARGEST_SEED


LONGITUDE = -86.2  # deg
STARTER_TIME = 10.0  # s, until both engines must run; 1.3 s is usual
TRIM_SPOOL_TIME = 12.0  # s, in which any engine comes to its power
# Share and s: 2 s bring an engine from idle to its governor's speed.
SPOOL_UP_THROTTLE, SPOOL_UP_TIME = 0.5, 5.0
SETTLE_FIRST = 30.0  # s, before the first check that level flight is held
SETTLE_LOOK = 5.0  # s
TURBULENCE_RUN_IN = 20.0  # s, some three time constants of the slowest gust filter at 100 kt

LOWEST_HEIGHT = 10.0  # ft above ground
LARGEST_FLOW_ANGLE = 30.0 * DEGREE  # well past the stall, far beyond any gust
LARGEST_ROLL = 85.0 * DEGREE  # beyond it no maneuver banks, and the airplane is lost
# the branch of an overlay, its effect, the parameter
EFFECT_SIZE = re.compile(rf"{ROOT}(-\d+)?/[^/]+/[^/]+")


class Plant:
    """One aircraft in JSBSim.

    Load a new plant for each flight: JSBSim's integrators keep their state at a reset.

    `get` and `set` take a name of the property table, in SI units, or a property path of JSBSim,
    which holds a slash and is in JSBSim's units. `branch` is that of the sizes of the overlay with
    which it was loaded: a patched aircraft has others of its own. Methods raise SimulationError
    where JSBSim fails.
    """

    def __init__(
        self,
        fdm: Any,
        aircraft: str,
        transcript: Transcript,
        record: Attached | None = None,
        branch: str = ROOT,
    ) -> None:
        self.aircraft, self.branch = aircraft, branch
        self.fdm = fdm
        self.time_step = float(fdm.get_delta_t())
        self._transcript = transcript
        self._access = parse_catalog(fdm.get_property_catalog())
        self._tree = fdm.get_property_manager()
        self._getters: dict[str, tuple[Callable[[], float], float]] = {}
        self._setters: dict[str, tuple[Callable[[float], bool], float]] = {}
        self.attached = record is not None  # the bench made the autopilot for this aircraft
        missing = record.missing if record else ()
        # An aircraft of the bench serves the whole table; any other what it has.
        self.channels = tuple(line for line in CHANNELS if line.name not in missing)
        own = () if self.attached else OWN_CONTROLS
        check_table(aircraft, self._access, (*self.channels, *COMMON_CONTROLS, *own))
        # The property of each engine that says whether it runs.
        self.engines = tuple(path for path in self._access if RUNNING.fullmatch(path))
        self._electric = record is not None and record.engine_kind == ELECTRIC
        self._integrators = {path: self.get(path) for path in INTEGRATORS}
        watched = ("position/h-agl-ft", "angle_of_attack", "sideslip", "roll")
        self._watched = [self.getter(name)[0] for name in watched]  # ft, rad

    @classmethod
    def load(
        cls,
        aircraft: str = "navajo",
        rate: float = USUAL_RATE,
        overlay: Overlay | None = None,
        at_once: bool = False,
    ) -> "Plant":
        """Load an aircraft of the hangar, with the overlay of its effects, to run at a rate [Hz].

        With `at_once` its actuators have no lag: for a force meter, which puts the surfaces where a
        log has them.

        Raises UnknownNameError for an unknown aircraft or a property that it lacks, SimulationError
        where JSBSim refuses the file.
        """
        return cls.load_folder(aircraft, find_aircraft(aircraft), rate, overlay, at_once)

    @classmethod
    def load_folder(
        cls,
        aircraft: str,
        folder: Path,
        rate: float = USUAL_RATE,
        overlay: Overlay | None = None,
        at_once: bool = False,
    ) -> "Plant":
        """Load an aircraft from its folder, which holds its autopilot; otherwise as `load`."""
        with ExitStack() as stack:
            added, file = overlay or Overlay(), parse_xml(folder / f"{folder.name}.xml").getroot()
            branch = ROOT if added.is_empty() else free_branch(file)
            at_once = at_once and bool(lagging_actuators(file) or throttle_settings(file))
            if at_once or ground_rates(file) or not added.is_empty():
                shelf = stack.enter_context(TemporaryDirectory(prefix="pitotbench-"))
                folder = write_variant(
                    folder, Path(shelf), folder.name, added, at_once, air_rates=True
                )
            fdm, transcript = load_fdm(aircraft, folder, rate)
            return cls(fdm, aircraft, transcript, read_record(folder), branch)

    def getter(self, name: str) -> tuple[Callable[[], float], float]:
        """Return a property's read function and its SI factor, for loops that read every step."""
        if name not in self._getters:
            line = self._line(name)
            self._getters[name] = (self._tree.get_node(line.path).get_double_value, line.factor)
        return self._getters[name]

    def get(self, name: str) -> float:
        """Return the present value of a property [SI by table name, JSBSim's unit by path]."""
        read, factor = self.getter(name)
        return read() * factor

    def set(self, name: str, value: float) -> None:
        """Set a writable property [SI by table name, JSBSim's unit by path].

        Raises UnknownNameError for a property that is unknown or read-only, SimulationError for a
        value that is not finite or that JSBSim does not accept.
        """
        if not isfinite(value):
            raise SimulationError(f"{name} must be a finite number, not {value}")
        if name not in self._setters:
            line = self._line(name)
            if "W" not in self._access[line.path]:
                raise UnknownNameError(f"property {line.path!r} is read-only")
            self._setters[name] = (self._tree.get_node(line.path).set_double_value, line.factor)
        write, factor = self._setters[name]
        if not write(value / factor):
            raise SimulationError(f"JSBSim did not take {name} = {value}.{self._transcript.said()}")

    def writer(self, name: str) -> Callable[[float], bool]:
        """Return the write function of a property, in JSBSim's unit, for loops that write often.

        Such loops write at every step.
        """
        write: Callable[[float], bool] = self._tree.get_node(self._line(name).path).set_double_value
        return write

    def run_initial_conditions(self) -> None:
        """Put the aircraft into its initial conditions; engines and systems keep their state.

        Raises SimulationError where JSBSim refuses them.
        """
        import jsbsim

        try:
            taken = self.fdm.run_ic()
        except jsbsim.BaseError as error:  # such as a property that nothing defines
            raise SimulationError(
                f"{self.aircraft}: JSBSim stopped: {' '.join(str(error).split())}"
            ) from error
        if not taken:
            raise SimulationError(
                f"JSBSim refuses the initial conditions.{self._transcript.said()}"
            )

    def serves(self, path: str) -> bool:
        """Return whether the aircraft has a property of this path."""
        return path in self._access

    def _line(self, name: str) -> Property:
        if "/" not in name:
            return PROPERTIES[name]
        if name not in self._access:
            raise UnknownNameError(
                explain("property", name, list(self._access)).split(" Known:")[0]
            )
        return Property(name, name)

    def run(self, seconds: float) -> None:
        """Run for a time [s] and check the flight ten times a second."""
        steps = round(seconds / self.time_step)
        batch = max(1, round(0.1 / self.time_step))
        for done in range(0, steps, batch):
            self.advance(min(batch, steps - done))
            self.check()

    def advance(self, steps: int) -> None:
        """Run a number of steps. Raises SimulationError where JSBSim stops."""
        run = self.fdm.run
        for _ in range(steps):
            if not run():
                raise self.failure("JSBSim stopped")

    def check(self) -> None:
        """Raise SimulationError where the flight is at an end: on the ground, departed, or NaN."""
        height, alpha, beta, roll = [read() for read in self._watched]
        # The sum is finite only where all four are: one test instead of four.
        if not isfinite(height + alpha + beta + roll):
            raise self.failure("the state is not a number")
        if height < LOWEST_HEIGHT:
            raise self.failure("the aircraft met the ground")
        if (
            abs(alpha) > LARGEST_FLOW_ANGLE
            or abs(beta) > LARGEST_FLOW_ANGLE
            or abs(roll) > LARGEST_ROLL
        ):
            raise self.failure(
                "the aircraft departed from controlled flight; fly faster or bank less"
            )

    def failure(self, what: str) -> SimulationError:
        """Return an error with what happened, when, where, how fast, and what JSBSim reported."""
        state = (
            f"{self.get('time'):.1f} s, {self.get('calibrated_airspeed') / KNOT:.1f} KCAS, "
            f"{self.get('altitude') / FOOT:.0f} ft, roll {degrees(self.get('roll')):.1f}°, "
            f"angle of attack {degrees(self.get('angle_of_attack')):.1f}°"
        )
        return SimulationError(
            f"{self.aircraft}: {what} (at {state}{self._stopped()}).{self._transcript.said()}"
        )

    def _stopped(self) -> str:
        """Return that an engine does not run, and the fuel left; nothing where all run."""
        if self._electric or all(self.fdm[path] for path in self.engines):
            return ""
        return (
            "; an engine does not run, fuel on board "
            f"{self.fdm['propulsion/total-fuel-lbs'] * POUND:.0f} kg"
        )

    def start(
        self,
        altitude: float,
        airspeed: float,
        heading: float = 0.0,
        air: Air | None = None,
        settle_limit: float = 120.0,
    ) -> None:
        """Put the aircraft in the air, start it, and let the autopilot settle it in level flight.

        Parameters: altitude, geometric [m]; airspeed, calibrated [m/s]; heading, true [rad]; air,
        by default still and standard; settle_limit [s], the longest time to reach level flight.

        JSBSim's trim does not work for a piston twin in the air. The autopilot therefore flies the
        aircraft into level flight, unrecorded: first in smooth air, then for a time with the
        turbulence. Raises SimulationError where the engines do not start or level flight is not
        reached.
        """
        air = air or Air()
        if self.attached:
            self._start_in_trim(altitude, airspeed, heading, air)
        else:
            self._place(altitude, airspeed, heading, air)
        self._engage(altitude, airspeed, heading)
        if self.attached:
            self.release()
        else:
            self._start_engines()
        self._settle(altitude, airspeed, heading, settle_limit)
        if air.severity:
            # The type comes last: it switches the turbulence on, with seed and severity in place.
            self.set("turbulence_seed", air.seed)
            self.set("turbulence_low_wind", LOW_WIND[air.severity])
            self.set("turbulence_severity", air.severity)
            self.set("turbulence_type", MILSPEC_TUSTIN)
            self.run(TURBULENCE_RUN_IN)

    def start_frozen(
        self, altitude: float, airspeed: float, heading: float = 0.0, air: Air | None = None
    ) -> None:
        """Freeze the aircraft at a place in the air and start its engines; `release` lets it fly.

        This serves the force meter, which needs running engines but no level flight. An effect may
        be more than the autopilot can hold, or more than the starter can turn. Every effect
        therefore has size zero until the engines run at their governed speed. Parameters are those
        of `start`; the air is smooth. Raises SimulationError where the engines do not start.
        """
        self._place(altitude, airspeed, heading, air or Air())
        for path in INTEGRATORS:
            self.set(path, 0)  # 0 is no integration: only engines and systems go on
        sizes = {path: self.get(path) for path in self._access if EFFECT_SIZE.fullmatch(path)}
        for path in sizes:
            self.set(path, 0.0)
        self._start_engines()
        self.set("throttle_command", SPOOL_UP_THROTTLE)
        self.run(SPOOL_UP_TIME)
        self.set("throttle_command", 0.0)
        for path, size in sizes.items():
            self.set(path, size)

    def _start_in_trim(self, altitude: float, airspeed: float, heading: float, air: Air) -> None:
        """Hold an aircraft with an attached autopilot in level flight, at the power for it."""
        self.start_frozen(altitude, airspeed, heading, air)
        self.set("throttle_command", self.get("ap/model/lever-level"))
        self.run(TRIM_SPOOL_TIME)
        self._place(altitude, airspeed, heading, air, self.get("ap/model/alpha-level-rad"))
        self.run(0.1)

    def release(self) -> None:
        """Let the aircraft move again, with the integrators that it was loaded with."""
        for path, integrator in self._integrators.items():
            self.set(path, integrator)

    def _place(
        self, altitude: float, airspeed: float, heading: float, air: Air, alpha: float = 0.0
    ) -> None:
        """Set the initial conditions: position, airspeed, and wind on top of ground velocity."""
        # Position before speed: a latitude set after the airspeed turns 160 KCAS into 172.
        self.set("temperature_offset", air.temperature_offset)
        for path, value in (
            ("ic/lat-geod-deg", LATITUDE),
            ("ic/long-gc-deg", LONGITUDE),
            ("ic/h-sl-ft", altitude / FOOT),
            ("ic/psi-true-rad", heading % (2.0 * pi)),
            ("ic/vc-kts", airspeed / KNOT),
        ):
            self.set(path, value)
        if alpha:
            # After the speed; the pitch follows, so that the path is level.
            self.set("ic/alpha-rad", alpha)
        self.run_initial_conditions()
        # The airplane flies with the air: the ground velocity grows by the wind, so that the
        # airspeed stays.
        ground = [self.get(f"velocity_{axis}") for axis in ("north", "east", "down")]
        for path, speed, wind in zip(
            ("vn", "ve", "vd"), ground, (air.north, air.east, air.down), strict=True
        ):
            self.set(f"ic/{path}-fps", (speed + wind) / FOOT)
        self.run_initial_conditions()
        # JSBSim can also set a wind with the initial conditions, but then it changes the airspeed
        # asked for.
        self.set("mean_wind_north", air.north)
        self.set("mean_wind_east", air.east)
        self.set("mean_wind_down", air.down)

    def _engage(self, altitude: float, airspeed: float, heading: float) -> None:
        """Switch the autopilot on: hold heading, altitude, and airspeed by throttle."""
        self.set("lateral_mode", 1)
        self.set("heading_target", heading % (2.0 * pi))
        self.set("pitch_mode", 1)
        self.set("altitude_target", altitude)
        self.set("throttle_mode", 1)
        self.set("airspeed_target", airspeed)

    def _start_engines(self) -> None:
        """Turn the engines with starter and magnetos until both run.

        Raises SimulationError where they do not.
        """
        # Setting `set-running` alone is simpler, but fails in a quarter of the heights and speeds.
        # Gear up and mixture rich: the aircraft starts in the air, and JSBSim's defaults are those
        # of a parked one.
        self.set("gear/gear-cmd-norm", 0.0)
        self.set("gear/gear-pos-norm", 0.0)
        for number in range(len(self.engines)):
            self.set("fcs/mixture-cmd-norm" + (f"[{number}]" if number else ""), 1.0)
        # A turbine has no magnetos and needs no starter in the air; a piston engine has no fuel
        # cutoff.
        starters = [("active_engine", -1.0), ("magneto_cmd", 3.0), ("starter_cmd", 1.0)]
        if self.attached:
            starters += [("cutoff_cmd", 0.0), ("set-running", -1.0)]
        for path, value in starters:
            if self.serves(f"propulsion/{path}") or not self.attached:
                self.set(f"propulsion/{path}", value)
        for _ in range(round(STARTER_TIME / 0.1)):
            self.run(0.1)
            if self._electric or all(self.get(engine) for engine in self.engines):
                if self.serves("propulsion/starter_cmd"):
                    self.set("propulsion/starter_cmd", 0)
                return
        raise self.failure("the engines do not start")

    def _settle(self, altitude: float, airspeed: float, heading: float, limit: float) -> None:
        """Fly on until level flight is held, or `limit` [s] is over.

        After the first transient it is checked every few seconds. Raises SimulationError at the
        limit.
        """
        self.run(min(SETTLE_FIRST, limit))
        while True:
            speed = (self.get("calibrated_airspeed") - airspeed) / KNOT
            height = (self.get("altitude") - altitude) / FOOT
            # Tighter than any card, so that a maneuver does not begin with the autopilot's
            # transient.
            turned = degrees((self.get("heading") - heading + pi) % (2.0 * pi) - pi)
            if abs(speed) < 0.5 and abs(height) < 15.0 and abs(turned) < 1.0:
                return
            if self.get("time") >= limit:
                raise self.failure(
                    f"level flight at {airspeed / KNOT:.0f} KCAS and {altitude / FOOT:.0f} ft was "
                    f"not reached: {speed:+.1f} kt, {height:+.0f} ft and {turned:+.1f}° off after "
                    f"{limit:.0f} s; choose a speed and height that the aircraft holds"
                )
            self.run(SETTLE_LOOK)


def check_table(
    aircraft: str, catalog: Mapping[str, str], table: Iterable[Property] | None = None
) -> None:
    """Check that an aircraft has every property of the table, and that those we write are writable.

    Raises UnknownNameError that names the first missing property and the nearest existing one.
    """
    for line in PROPERTIES.values() if table is None else table:
        access = catalog.get(line.path)
        if access is None:
            folder = line.path.rsplit("/", 1)[0]
            near = [known for known in catalog if known.startswith(folder + "/")]
            nearest = explain("property", line.path, near[:30])
            raise UnknownNameError(f"aircraft {aircraft!r} does not serve {line.name!r}: {nearest}")
        if line.writable and "W" not in access:
            raise UnknownNameError(
                f"property {line.path!r} ({line.name!r}) of {aircraft!r} is read-only"
            )
