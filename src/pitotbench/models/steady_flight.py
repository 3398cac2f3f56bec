"""Steady flight of an airplane: stall, climb and level flight.

The aircraft is frozen in a state while engines and controls run on, and its forces are balanced
there: lift against weight, pitching moment, and along the path weight, thrust and drag. No
autopilot flies, so no flight must settle. In a climb at a constant calibrated airspeed the true one
grows; this takes its share of the excess thrust.
"""

import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import asin, cos, sin, sqrt
from pathlib import Path

import numpy as np

from pitotbench import air
from pitotbench.records import BadInputError
from pitotbench.records.performance import PerformanceFigure
from pitotbench.simulation.aircraft import original
from pitotbench.simulation.aircraft_files import SimulationError, parse_xml
from pitotbench.simulation.aircraft_import import aircraft_name, import_aircraft
from pitotbench.simulation.autopilot.attach import engines_of
from pitotbench.simulation.autopilot.envelope import balance, elevator_for
from pitotbench.simulation.autopilot.frozen_aircraft import Engines, FrozenAircraft, State
from pitotbench.units import DEGREE, FOOT, POUND, STANDARD_GRAVITY

HEIGHT_STEP, HIGHEST = 5000.0 * FOOT, 60000.0 * FOOT  # at which the ceiling is looked for


GLIDE_HEIGHT = 5000.0 * FOOT  # at which the best glide is given
SERVICE = 100.0 * FOOT / 60.0  # m/s, the rate of climb at the service ceiling
HIGHEST_MACH = 0.9  # beyond it steady flight is not looked for
FLOW_ANGLES = np.arange(-2.0, 30.1, 0.5) * DEGREE  # of attack, up to beyond any stall
ABOVE_STALL, GROWTH, MOST_SPEEDS = 1.06, 1.08, 40  # times the stall, times the one before; count
FULLY_DOWN = 25.0  # s, in which flaps come down


SAME_POWER, FINEST_LEVER = 0.005, 0.0005  # shares of the power, and of the throttle
BALLAST = "weight of the handbook"


@dataclass(frozen=True, slots=True)
class Steady:
    """A steady flight: state, calibrated airspeed and climb [m/s], forces [N] and power [hp].

    The forces are thrust, lift and drag.
    """

    state: State
    calibrated: float
    climb_rate: float
    thrust: float
    lift: float
    drag: float
    power: float


NOT_FOUND = "no steady flight found"


@dataclass(slots=True)
class PerformanceModel:
    """An aircraft in its file's loading, `weight` [lb].

    `ballast` is the property of the weight added to it.

    `no_engine` says that it has no engine that holds a level speed, as a glider; empty where it has
    one.
    """

    frozen: FrozenAircraft
    weight: float
    ballast: str
    no_engine: str = ""

    @classmethod
    def load(cls, aircraft: str, scratch: Path) -> "PerformanceModel":
        """Return the model of an aircraft, copied below a scratch folder. Raises BadInputError."""
        source = original(aircraft)
        if not source.exists():
            raise BadInputError(f"{source}: no such aircraft file or folder")
        folder = scratch / aircraft_name(source)
        folder.mkdir()
        file = import_aircraft(source, folder)
        tree = parse_xml(file)
        number = _add_ballast(tree.getroot())
        tree.write(file, encoding="utf-8", xml_declaration=True)
        kind, no_engine = Engines("none"), ""
        try:
            kind = engines_of(folder, tree.getroot())
        except BadInputError as error:
            no_engine = str(error)
        frozen = FrozenAircraft(folder.name, folder, GLIDE_HEIGHT, kind)
        frozen.write("propulsion/fuel_freeze", 1.0)
        frozen.write("position/terrain-elevation-asl-ft", -5000.0)
        ballast = "inertia/pointmass-weight-lbs" + (f"[{number}]" if number else "")
        model = cls(frozen, frozen.read("inertia/weight-lbs"), ballast, no_engine)
        slow = stall(model, 0.0, 0.0).state.speed
        frozen.climb_to(GLIDE_HEIGHT, 1.5 * slow)
        lever, valve = (f"fcs/mixture-{kind}-norm" for kind in ("cmd", "pos"))
        if frozen.serves(lever) and frozen.read(valve) < 0.99 * frozen.read(lever):
            frozen.rich = True  # systems of the aircraft lean the mixture themselves
        frozen.find_idle(np.geomspace(1.12 * slow, 2.0 * slow, 4))
        return model

    def load_weight(self, weight: float | None) -> None:
        """Load a weight [lb] at the empty aircraft's center of gravity, for None the file's."""
        self.frozen.write(self.ballast, 0.0 if weight is None else weight - self.weight)


def _add_ballast(root: ET.Element) -> int:
    """Add a weightless point mass at the empty aircraft's center of gravity; return its number."""
    mass = root.find("mass_balance")
    place = None if mass is None else mass.find("location[@name='CG']")
    if mass is None or place is None:
        raise BadInputError(
            'the aircraft\'s file has no center of gravity: add <location name="CG"> to '
            "<mass_balance>"
        )
    number = len(mass.findall("pointmass"))
    point = ET.SubElement(mass, "pointmass", name=BALLAST)
    ET.SubElement(point, "weight", unit="LBS").text = "0"
    location = ET.SubElement(point, "location", unit=place.get("unit", "IN"))
    for axis in "xyz":
        ET.SubElement(location, axis).text = place.findtext(axis) or "0"
    return number


def true_airspeed(calibrated: float, height: float) -> float:
    """Return the true airspeed [m/s] of a calibrated one [m/s] on a standard day."""
    pressure = float(air.standard_pressure(height))
    temperature = float(air.standard_temperature(height))
    return float(air.true_airspeed(air.impact_pressure(calibrated), pressure, temperature))


def calibrated_airspeed(true: float, height: float) -> float:
    """Return the calibrated airspeed [m/s] of a true one at a height [m] on a standard day."""
    pressure = float(air.standard_pressure(height))
    mach = true / float(air.sound_speed(air.standard_temperature(height)))
    return float(air.calibrated_airspeed(air.impact_pressure_from_mach(mach, pressure)))


def stall(model: PerformanceModel, height: float, flaps: float) -> Steady:
    """Return the slowest level flight at 1 g: engines idle, elevator in trim, `flaps` from 0 to 1.

    A deceleration too slow to change the load factor reaches its speed. Raises SimulationError
    where no angle of attack up to 30° carries the weight.
    """
    frozen = model.frozen
    frozen.climb_to(height, 80.0)
    frozen.write("fcs/flap-cmd-norm", flaps)
    frozen.run(100.0 * FULLY_DOWN)
    frozen.set_lever(0.0)
    best: State | None = None
    speed = 80.0
    for alpha in FLOW_ANGLES:
        if found := _one_g(frozen, float(alpha), speed):
            speed = found.speed
            best = found if best is None or speed < best.speed else best
    frozen.write("fcs/flap-cmd-norm", 0.0)
    frozen.run(100.0 * FULLY_DOWN)
    if best is None:
        raise SimulationError(
            f"{frozen.name}: no angle of attack up to 30° carries the weight with a trimmed "
            "elevator"
        )
    if best.alpha >= FLOW_ANGLES[-1]:
        raise SimulationError(
            f"{frozen.name}: the lift still grows at 30°, so there is no stall below it"
        )
    return Steady(best, calibrated_airspeed(best.speed, height), 0.0, 0.0, 0.0, 0.0, 0.0)


def _one_g(frozen: FrozenAircraft, alpha: float, speed: float) -> State | None:
    """Return trimmed level flight at 1 g and an angle of attack [rad], None where there is none."""
    for _ in range(12):
        elevator = elevator_for(frozen, speed, alpha)
        if elevator is None:
            return None
        state = State(speed, alpha, elevator=elevator)
        lift = STANDARD_GRAVITY - frozen.accelerations(state).normal(alpha)
        if lift <= 0.05 * STANDARD_GRAVITY:
            return None
        ratio = float(np.clip(sqrt(STANDARD_GRAVITY / lift), 0.5, 2.0))
        if abs(ratio - 1.0) < 2e-4:
            return state
        speed *= ratio
        if not 2.0 < speed < 300.0:
            return None
    return None


def steady_flight(
    model: PerformanceModel, height: float, speed: float, lever: float, guess: State
) -> Steady | None:
    """Return steady flight, climbing or sinking, at a true airspeed [m/s] and a lever.

    None where nothing balances.
    """
    frozen = model.frozen
    gradient = (true_airspeed(calibrated_airspeed(speed, height), height + 100.0) - speed) / 100.0
    state = replace(guess, speed=speed)
    try:
        for _ in range(8):
            frozen.place(state)
            frozen.set_lever(lever)
            state, gain = balance(frozen, state)
            along = gain + STANDARD_GRAVITY * sin(state.climb)
            slope = along / (STANDARD_GRAVITY + gradient * speed)
            if abs(slope) > 0.9:
                return None
            change = asin(slope) - state.climb
            if abs(change) < 2e-4:
                return _account(frozen, state, height, along)
            state = replace(state, climb=asin(slope))
    except SimulationError:
        frozen.climb_to(height, speed)  # an engine may have stopped
    return None


def _account(frozen: FrozenAircraft, state: State, height: float, along: float) -> Steady:
    mass = frozen.read("inertia/weight-lbs") * POUND
    thrust = frozen.thrust() * POUND * STANDARD_GRAVITY
    return Steady(
        state,
        calibrated_airspeed(state.speed, height),
        state.speed * sin(state.climb),
        thrust,
        mass * STANDARD_GRAVITY * cos(state.climb) - thrust * sin(state.alpha),
        thrust * cos(state.alpha) - mass * along,
        frozen.power(),
    )


def steady_speeds(
    model: PerformanceModel, height: float, lever: float, slow: float
) -> list[Steady]:
    """Return steady flight at true airspeeds from slow up to sinking, or to far above stall."""
    limit = HIGHEST_MACH * float(air.sound_speed(air.standard_temperature(height)))
    found: list[Steady] = []
    state = State(slow, alpha=8.0 * DEGREE)
    model.frozen.climb_to(height, 1.3 * slow)
    for k in range(MOST_SPEEDS):
        speed = ABOVE_STALL * slow * GROWTH**k
        if speed > limit:
            break
        each = steady_flight(model, height, speed, lever, state)
        if each is None:
            continue
        state = each.state
        found.append(each)
        if lever > 0.0 and each.climb_rate < -2.0 and k > 3:
            break
        if lever == 0.0 and speed > 2.2 * slow:
            break
    return found


def refine(
    model: PerformanceModel,
    height: float,
    lever: float,
    several: Sequence[Steady],
    value: Callable[[Steady], float],
) -> Steady | None:
    """Return the steady flight of the largest value, by a parabola through the best speeds.

    Three speeds define it. None without speeds.
    """
    if not several:
        return None
    k = int(np.argmax([value(each) for each in several]))
    if 0 < k < len(several) - 1:
        near = several[k - 1 : k + 2]
        a, b, _ = np.polyfit([e.state.speed for e in near], [value(e) for e in near], 2)
        finer = (
            steady_flight(model, height, float(-b / (2.0 * a)), lever, several[k].state)
            if a < 0.0
            else None
        )
        if finer is not None and value(finer) >= value(several[k]):
            return finer
    return several[k]


def level_flight(
    model: PerformanceModel, height: float, lever: float, several: Sequence[Steady]
) -> Steady | None:
    """Return the fastest level flight at a lever: where the climb of several speeds ends."""
    pairs = [(a, b) for a, b in pairwise(several) if a.climb_rate >= 0.0 > b.climb_rate]
    if not pairs:
        return None
    low, high = pairs[-1]
    for _ in range(6):
        share = low.climb_rate / (low.climb_rate - high.climb_rate)
        speed = low.state.speed + share * (high.state.speed - low.state.speed)
        middle = steady_flight(model, height, speed, lever, low.state)
        if middle is None or abs(middle.climb_rate) < 0.02:
            return middle
        low, high = (middle, high) if middle.climb_rate >= 0.0 else (low, middle)
    return low


def slowest_speed(model: PerformanceModel, height: float) -> float:
    """Return the true stall speed [m/s] at a height, flaps up.

    The calibrated one is that of sea level.
    """
    return true_airspeed(stall(model, 0.0, 0.0).calibrated, height)


def best_climb(
    model: PerformanceModel, height: float, slow: float
) -> tuple[Steady | None, list[Steady]]:
    """Return the steady climb of the highest rate at a height [m], and the climbs that were tried.

    `slow` [m/s] is the slowest airspeed tried.
    """
    several = steady_speeds(model, height, 1.0, slow)
    return refine(model, height, 1.0, several, lambda each: each.climb_rate), several


def find_ceiling(
    model: PerformanceModel,
) -> tuple[float, float, list[tuple[float, Steady, list[Steady]]]]:
    """Return service and absolute ceiling [m], NaN for none, and the climbs at each height."""
    slow = stall(model, 0.0, 0.0).calibrated
    climbs = []
    for height in np.arange(0.0, HIGHEST + 1.0, HEIGHT_STEP):
        best, several = best_climb(model, float(height), true_airspeed(slow, float(height)))
        if best is None:
            break
        climbs.append((float(height), best, several))
        if best.climb_rate <= 0.0:
            break
    return _crossing(climbs, SERVICE), _crossing(climbs, 0.0), climbs


def _crossing(climbs: Sequence[tuple[float, Steady, list[Steady]]], rate: float) -> float:
    rates = np.array([best.climb_rate for _, best, _ in climbs])
    heights = np.array([height for height, *_ in climbs])
    if len(rates) < 2 or rates[-1] > rate or rates[0] < rate:
        return float("nan")
    k = int(np.flatnonzero(rates >= rate)[-1])
    share = (rates[k] - rate) / (rates[k] - rates[k + 1])
    return float(heights[k] + share * (heights[k + 1] - heights[k]))


Figures = Iterator[PerformanceFigure]
