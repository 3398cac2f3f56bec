"""Find the performance of an aircraft in steady flight: stall, climb, cruise, glide and ceiling."""

import csv
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import asin, cos, isfinite, sin, sqrt, tan
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from pitotbench import air
from pitotbench.pressure_error.published import is_published
from pitotbench.records import BadInputError
from pitotbench.records.aircraft import Performance, PerformanceFigure
from pitotbench.simulation.aircraft import original
from pitotbench.simulation.aircraft_files import SimulationError, parse_xml
from pitotbench.simulation.aircraft_import import aircraft_name, import_aircraft
from pitotbench.simulation.autopilot.attach import engines_of
from pitotbench.simulation.autopilot.envelope import balance, elevator_for
from pitotbench.simulation.autopilot.frozen_aircraft import Engines, FrozenAircraft, State
from pitotbench.units import DEGREE, FOOT, KNOT, POUND, STANDARD_GRAVITY

# The aircraft is frozen in a state while engines and controls run on, and its forces are balanced
# there: lift against weight, pitching moment, and along the path weight, thrust and drag. No
# autopilot flies, so no flight must settle. In a climb at a constant calibrated airspeed the true
# one grows; this takes its share of the excess thrust.

HEIGHT_STEP, HIGHEST = 5000.0 * FOOT, 60000.0 * FOOT
CRUISE_HEIGHTS = tuple(h * FOOT for h in (2000.0, 8000.0, 15000.0, 25000.0, 35000.0))
CRUISE_LEVERS = (0.6, 0.75, 1.0)
GLIDE_HEIGHT = 5000.0 * FOOT
SERVICE = 100.0 * FOOT / 60.0  # m/s, the rate of climb at the service ceiling
HIGHEST_MACH = 0.9  # beyond it steady flight is not looked for
FLOW_ANGLES = np.arange(-2.0, 30.1, 0.5) * DEGREE
ABOVE_STALL, GROWTH, MOST_SPEEDS = 1.06, 1.08, 40
FULLY_DOWN = 25.0  # s, in which flaps come down
MOVED = 0.005  # share of the stall speed that flaps must change
SAME_POWER, FINEST_LEVER = 0.005, 0.0005
BALLAST = "weight of the handbook"


@dataclass(frozen=True, slots=True)
class Steady:
    """Steady flight: the state, calibrated airspeed and rate of climb [m/s], thrust, lift, drag
    [N], power [hp].
    """

    state: State
    calibrated: float
    climb_rate: float
    thrust: float
    lift: float
    drag: float
    power: float


def find_performance(aircraft: str, handbook: Path | None = None) -> Performance:
    """Return the performance of an aircraft: a name of the hangar or of JSBSim's library, or a
    path.

    With `handbook`, a table that `read_handbook` describes, each of its rows becomes a figure with
    the published value next to it, before the figures at the weight of the file. What the model
    lacks or cannot do is skipped, with the reason. Raises UnknownNameError, BadInputError or
    SimulationError where the aircraft has no steady flight at all.
    """
    rows = read_handbook(handbook) if handbook is not None else []
    with TemporaryDirectory(prefix="pitotbench-") as scratch:
        model = _Model.load(aircraft, Path(scratch))
        found, skipped = [], []
        for name, of in (*((row.words, row.figures) for row in rows), *FAMILIES):
            try:
                if of in POWERED and model.no_engine:
                    raise SimulationError(model.no_engine)
                for each in of(model):
                    if isfinite(each.model):
                        found.append(each)
                    else:
                        reason = UNKNOWN.get(each.name, NOT_FOUND)
                        skipped.append((each.name, f"{each.condition}: {reason}"))
            except SimulationError as error:
                skipped.append((name, " ".join(str(error).split())))
            model.load_weight(None)
        return Performance(model.frozen.name, model.weight * POUND, tuple(found), tuple(skipped))


NOT_FOUND = "no steady flight found"
_ABOVE = f"it still climbs at {HIGHEST / FOOT:,.0f} ft, or never did"
UNKNOWN = {
    "cruise speed": f"no level flight up to Mach {HIGHEST_MACH:g}",
    "service ceiling": _ABOVE,
    "absolute ceiling": _ABOVE,
    "ceiling": _ABOVE,
}


@dataclass(slots=True)
class _Model:
    """An aircraft in its file's loading, `weight` [lb]; `ballast` is the property of the weight
    added to it.

    `no_engine` says that it has no engine that holds a level speed, as a glider; empty where it has
    one.
    """

    frozen: FrozenAircraft
    weight: float
    ballast: str
    no_engine: str = ""

    @classmethod
    def load(cls, aircraft: str, scratch: Path) -> "_Model":
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
        """Load a weight [lb] at the center of gravity of the empty aircraft; None for that of the
        file.
        """
        self.frozen.write(self.ballast, 0.0 if weight is None else weight - self.weight)


def _add_ballast(root: ET.Element) -> int:
    """Add a point mass of no weight at the center of gravity of the empty aircraft; return its
    number.
    """
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


# Steady states of flight.


def _true(calibrated: float, height: float) -> float:
    """Return the true airspeed [m/s] of a calibrated one [m/s] on a standard day."""
    pressure = float(air.standard_pressure(height))
    temperature = float(air.standard_temperature(height))
    return float(air.true_airspeed(air.impact_pressure(calibrated), pressure, temperature))


def _calibrated(true: float, height: float) -> float:
    pressure = float(air.standard_pressure(height))
    mach = true / float(air.sound_speed(air.standard_temperature(height)))
    return float(air.calibrated_airspeed(air.impact_pressure_from_mach(mach, pressure)))


def stall(model: _Model, height: float, flaps: float) -> Steady:
    """Return the slowest level flight at 1 g: engines idle, elevator in trim, `flaps` from 0 to 1.

    It is the speed that a deceleration too slow to change the load factor reaches. Raises
    SimulationError where no angle of attack up to 30° carries the weight.
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
            f"{frozen.name}: no angle of attack up to 30° carries the weight with a "
            "trimmed elevator"
        )
    if best.alpha >= FLOW_ANGLES[-1]:
        raise SimulationError(
            f"{frozen.name}: the lift still grows at 30°, so there is no stall below it"
        )
    return Steady(best, _calibrated(best.speed, height), 0.0, 0.0, 0.0, 0.0, 0.0)


def _one_g(frozen: FrozenAircraft, alpha: float, speed: float) -> State | None:
    """Return level flight at 1 g and an angle of attack [rad], the elevator in trim; None where
    there is none.
    """
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


def _steady(
    model: _Model, height: float, speed: float, lever: float, guess: State
) -> Steady | None:
    """Return steady flight at a true airspeed and a lever, climbing or sinking; None where nothing
    balances.
    """
    frozen = model.frozen
    gradient = (_true(_calibrated(speed, height), height + 100.0) - speed) / 100.0
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
        _calibrated(state.speed, height),
        state.speed * sin(state.climb),
        thrust,
        mass * STANDARD_GRAVITY * cos(state.climb) - thrust * sin(state.alpha),
        thrust * cos(state.alpha) - mass * along,
        frozen.power(),
    )


def _speeds(model: _Model, height: float, lever: float, slow: float) -> list[Steady]:
    """Return steady flight at true airspeeds from slow to fast, until the aircraft sinks or is far
    above stall.
    """
    limit = HIGHEST_MACH * float(air.sound_speed(air.standard_temperature(height)))
    found: list[Steady] = []
    state = State(slow, alpha=8.0 * DEGREE)
    model.frozen.climb_to(height, 1.3 * slow)
    for k in range(MOST_SPEEDS):
        speed = ABOVE_STALL * slow * GROWTH**k
        if speed > limit:
            break
        each = _steady(model, height, speed, lever, state)
        if each is None:
            continue
        state = each.state
        found.append(each)
        if lever > 0.0 and each.climb_rate < -2.0 and k > 3:
            break
        if lever == 0.0 and speed > 2.2 * slow:
            break
    return found


def _refined(
    model: _Model,
    height: float,
    lever: float,
    several: Sequence[Steady],
    value: Callable[[Steady], float],
) -> Steady | None:
    """Return the steady flight at which a value is largest, by the parabola through the three best
    speeds.
    """
    if not several:
        return None
    k = int(np.argmax([value(each) for each in several]))
    if 0 < k < len(several) - 1:
        near = several[k - 1 : k + 2]
        a, b, _ = np.polyfit([e.state.speed for e in near], [value(e) for e in near], 2)
        finer = (
            _steady(model, height, float(-b / (2.0 * a)), lever, several[k].state)
            if a < 0.0
            else None
        )
        if finer is not None and value(finer) >= value(several[k]):
            return finer
    return several[k]


def _level(model: _Model, height: float, lever: float, several: Sequence[Steady]) -> Steady | None:
    """Return the fastest level flight at a lever: where the climb of several speeds ends."""
    pairs = [(a, b) for a, b in pairwise(several) if a.climb_rate >= 0.0 > b.climb_rate]
    if not pairs:
        return None
    low, high = pairs[-1]
    for _ in range(6):
        share = low.climb_rate / (low.climb_rate - high.climb_rate)
        speed = low.state.speed + share * (high.state.speed - low.state.speed)
        middle = _steady(model, height, speed, lever, low.state)
        if middle is None or abs(middle.climb_rate) < 0.02:
            return middle
        low, high = (middle, high) if middle.climb_rate >= 0.0 else (low, middle)
    return low


def _slow(model: _Model, height: float) -> float:
    """Return the true stall speed [m/s] at a height, flaps up: the calibrated one is that of sea
    level.
    """
    return _true(stall(model, 0.0, 0.0).calibrated, height)


def _best_climb(model: _Model, height: float, slow: float) -> tuple[Steady | None, list[Steady]]:
    several = _speeds(model, height, 1.0, slow)
    return _refined(model, height, 1.0, several, lambda each: each.climb_rate), several


def _ceiling(model: _Model) -> tuple[float, float, list[tuple[float, Steady, list[Steady]]]]:
    """Return the service and the absolute ceiling [m], NaN where none is found, and the climbs at
    each height.
    """
    slow = stall(model, 0.0, 0.0).calibrated
    climbs = []
    for height in np.arange(0.0, HIGHEST + 1.0, HEIGHT_STEP):
        best, several = _best_climb(model, float(height), _true(slow, float(height)))
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


# The families of figures, in the units of handbooks.

Figures = Iterator[PerformanceFigure]


def _height_words(height: float) -> str:
    return f"{height / FOOT:,.0f} ft" if height else "sea level"


def _stalls(model: _Model) -> Figures:
    clean = stall(model, 0.0, 0.0)
    yield PerformanceFigure("stall speed", "flaps up, idle, 1 g", clean.calibrated / KNOT, "KCAS")
    if not model.frozen.serves("fcs/flap-cmd-norm"):
        raise SimulationError("the model has no flaps")
    down = stall(model, 0.0, 1.0)
    if abs(down.calibrated / clean.calibrated - 1.0) < MOVED:
        raise SimulationError("the flaps of the model change no lift")
    yield PerformanceFigure("stall speed", "flaps down, idle, 1 g", down.calibrated / KNOT, "KCAS")


def _climbs(model: _Model) -> Figures:
    service, absolute, climbs = _ceiling(model)
    for height, best, several in climbs:
        if best.climb_rate <= 0.0:
            continue
        place = f"{_height_words(height)}, full throttle"
        steep = _refined(model, height, 1.0, several, lambda each: each.state.climb) or best
        yield PerformanceFigure(
            "best rate of climb", place, best.climb_rate / FOOT * 60.0, "ft/min"
        )
        yield PerformanceFigure("speed of the best rate", place, best.calibrated / KNOT, "KCAS")
        yield PerformanceFigure("best angle of climb", place, steep.state.climb / DEGREE, "°")
        yield PerformanceFigure("speed of the best angle", place, steep.calibrated / KNOT, "KCAS")
    yield PerformanceFigure("service ceiling", "100 ft/min, full throttle", service / FOOT, "ft")
    yield PerformanceFigure("absolute ceiling", "full throttle", absolute / FOOT, "ft")


def _cruises(model: _Model) -> Figures:
    slow = stall(model, 0.0, 0.0).calibrated
    for height in CRUISE_HEIGHTS:
        for lever in CRUISE_LEVERS:
            place = f"{_height_words(height)}, {100.0 * lever:.0f} % throttle"
            level = _level(model, height, lever, _speeds(model, height, lever, _true(slow, height)))
            if level is None:
                yield PerformanceFigure("cruise speed", place, float("nan"), "KTAS")
                continue
            yield PerformanceFigure("cruise speed", place, level.state.speed / KNOT, "KTAS")
            thrust = level.thrust / POUND / STANDARD_GRAVITY
            power = (
                ("cruise power", level.power, "hp")
                if level.power
                else ("cruise thrust", thrust, "lb")
            )
            yield PerformanceFigure(power[0], place, power[1], power[2])


def _glides(model: _Model) -> Figures:
    several = _speeds(model, GLIDE_HEIGHT, 0.0, _slow(model, GLIDE_HEIGHT))
    flat = _refined(model, GLIDE_HEIGHT, 0.0, several, lambda each: each.state.climb)
    slender = max(several, key=_lift_to_drag, default=None)
    place = f"{_height_words(GLIDE_HEIGHT)}, flaps up"
    if flat is None or slender is None:
        raise SimulationError(NOT_FOUND)
    ratio = -1.0 / tan(flat.state.climb) if flat.state.climb < 0.0 else float("nan")
    yield PerformanceFigure("glide ratio", f"{place}, idle", ratio, "")
    yield PerformanceFigure(
        "speed of the best glide", f"{place}, idle", flat.calibrated / KNOT, "KCAS"
    )
    yield PerformanceFigure(
        "best lift-to-drag ratio", f"{place}, without thrust", _lift_to_drag(slender), ""
    )
    yield PerformanceFigure(
        "its speed", f"{place}, without thrust", slender.calibrated / KNOT, "KCAS"
    )


def _lift_to_drag(each: Steady) -> float:
    return each.lift / each.drag


FAMILIES: tuple[tuple[str, Callable[[_Model], Figures]], ...] = (
    ("stall speed", _stalls),
    ("climb and ceiling", _climbs),
    ("cruise", _cruises),
    ("glide", _glides),
)
POWERED = (_climbs, _cruises)


# The table of a handbook.

_PUBLISHED = {  # figure: the column of its value, its unit, and the scale of the unit [SI]
    "stall": ("calibrated_airspeed_kt", "KCAS", KNOT),
    "climb": ("climb_rate_fpm", "ft/min", FOOT / 60.0),
    "cruise": ("true_airspeed_kt", "KTAS", KNOT),
    "glide": ("glide_ratio", "", 1.0),
    "ceiling": ("ceiling_ft", "ft", FOOT),
}
_CONDITIONS = {
    "stall": ("weight_lb", "altitude_ft", "flaps_percent"),
    "climb": ("weight_lb", "altitude_ft", "calibrated_airspeed_kt"),
    "cruise": ("weight_lb", "altitude_ft", "throttle_percent", "power_hp"),
    "glide": ("weight_lb", "altitude_ft", "calibrated_airspeed_kt"),
    "ceiling": ("weight_lb",),
}
COLUMNS = (
    "figure",
    *dict.fromkeys(c for k in _PUBLISHED for c in (*_CONDITIONS[k], _PUBLISHED[k][0])),
)


@dataclass(frozen=True, slots=True)
class HandbookRow:
    """One published figure; `published` and the entries of `given` are in the units of the columns."""

    figure: str
    published: float
    given: dict[str, float]

    @property
    def words(self) -> str:
        """The condition in words."""
        stated = [
            f"{name.replace('_', ' ')} {value:,.4g}"
            if value < 1000.0
            else f"{name.replace('_', ' ')} {value:,.0f}"
            for name, value in self.given.items()
        ]
        return f"handbook: {self.figure}, {', '.join(stated)}"

    def figures(self, model: _Model) -> Figures:
        """Yield the model's figure in the condition of the row, with the published one."""
        model.load_weight(self.given.get("weight_lb"))
        _, unit, scale = _PUBLISHED[self.figure]
        value = _AT[self.figure](model, self.given)
        yield PerformanceFigure(
            self.figure, self.words.split(", ", 1)[-1], value / scale, unit, self.published
        )


def read_handbook(file: Path) -> list[HandbookRow]:
    """Read a handbook's table (CSV): one published figure a row.

    The column `figure` names it: `stall` (published in `calibrated_airspeed_kt`), `climb`
    (`climb_rate_fpm`), `cruise` (`true_airspeed_kt`), `glide` (`glide_ratio`) or `ceiling`
    (`ceiling_ft`). The other columns are conditions, blank where they do not apply: `weight_lb`,
    `altitude_ft`, `flaps_percent`, `throttle_percent`, `power_hp` of all engines, and
    `calibrated_airspeed_kt` of a climb or a glide (blank: the best). Raises BadInputError for
    another column or figure, for text in place of a number, and for a missing value.
    """
    if file.exists() and not file.is_file():
        raise BadInputError(f"{file}: not a regular file; a handbook's table is a CSV file")
    with file.open(encoding="utf-8-sig", newline="") as opened:
        table = csv.DictReader(opened)
        names = [name.strip() for name in table.fieldnames or ()]
        unknown = [name for name in names if name not in COLUMNS]
        if "figure" not in names and is_published(file):
            raise BadInputError(
                f"{file}: a handbook's table of airspeeds, not of performance; give it to "
                "`pitotbench calibrate LOG --handbook` or `pitotbench aircraft indicator`"
            )
        if unknown or "figure" not in names:
            raise BadInputError(
                f"{file}: {'no column `figure`' if 'figure' not in names else f'unknown column {unknown[0]!r}'}; "
                f"the columns of a handbook are {', '.join(COLUMNS)}"
            )
        table.fieldnames = names
        rows = [_row(f"{file}, line {table.line_num}", entry) for entry in table]
    if not rows:
        raise BadInputError(f"{file}: no row; give one published figure a row")
    return rows


def _row(place: str, entry: dict[str, str | None]) -> HandbookRow:
    figure = (entry.pop("figure") or "").strip()
    if figure not in _PUBLISHED:
        raise BadInputError(
            f"{place}: figure {figure!r} is not known; it is one of {', '.join(_PUBLISHED)}"
        )
    values: dict[str, float] = {}
    for name, text in entry.items():
        if text is None or not text.strip():
            continue
        try:
            values[name] = float(text)
        except ValueError:
            values[name] = float("nan")
        if not isfinite(values[name]):
            raise BadInputError(f"{place}: {name} is {text.strip()!r}; give a number")
    column = _PUBLISHED[figure][0]
    if column not in values:
        raise BadInputError(f"{place}: {figure} is published in {column}, which is blank")
    foreign = [name for name in values if name not in (*_CONDITIONS[figure], column)]
    if foreign:
        raise BadInputError(f"{place}: {foreign[0]} is no condition of {figure}; leave it blank")
    return HandbookRow(figure, values.pop(column), values)


def _stall_at(model: _Model, given: dict[str, float]) -> float:
    height = given.get("altitude_ft", 0.0) * FOOT
    return stall(model, height, given.get("flaps_percent", 0.0) / 100.0).calibrated


def _climb_at(model: _Model, given: dict[str, float]) -> float:
    height = given.get("altitude_ft", 0.0) * FOOT
    if "calibrated_airspeed_kt" in given:
        found = _at_speed(model, height, 1.0, given)
    else:
        found = _best_climb(model, height, _slow(model, height))[0]
    return found.climb_rate if found else float("nan")


def _at_speed(model: _Model, height: float, lever: float, given: dict[str, float]) -> Steady | None:
    speed = _true(given["calibrated_airspeed_kt"] * KNOT, height)
    model.frozen.climb_to(height, speed)
    return _steady(model, height, speed, lever, State(speed, alpha=4.0 * DEGREE))


def _cruise_at(model: _Model, given: dict[str, float]) -> float:
    height = given.get("altitude_ft", 0.0) * FOOT
    slow = _slow(model, height)

    def at(lever: float) -> Steady | None:
        return _level(model, height, lever, _speeds(model, height, lever, slow))

    if "power_hp" not in given:
        found = at(given.get("throttle_percent", 100.0) / 100.0)
        return found.state.speed if found else float("nan")
    # Power grows with the lever; a lever that holds no level flight gives too little.
    low, high, found = 0.0, 1.0, at(1.0)
    while (
        found
        and abs(found.power / given["power_hp"] - 1.0) > SAME_POWER
        and high - low > FINEST_LEVER
    ):
        middle = 0.5 * (low + high)
        level = at(middle)
        strong = level is not None and level.power >= given["power_hp"]
        low, high = (low, middle) if strong else (middle, high)
        found = level or found
    same = found is not None and abs(found.power / given["power_hp"] - 1.0) <= 3.0 * SAME_POWER
    return found.state.speed if found and same else float("nan")


def _glide_at(model: _Model, given: dict[str, float]) -> float:
    height = given.get("altitude_ft", GLIDE_HEIGHT / FOOT) * FOOT
    if "calibrated_airspeed_kt" in given:
        found = _at_speed(model, height, 0.0, given)
    else:
        several = _speeds(model, height, 0.0, _slow(model, height))
        found = _refined(model, height, 0.0, several, lambda each: each.state.climb)
    return -1.0 / tan(found.state.climb) if found and found.state.climb < 0.0 else float("nan")


_AT: dict[str, Callable[[_Model, dict[str, float]], float]] = {
    "stall": _stall_at,
    "climb": _climb_at,
    "cruise": _cruise_at,
    "glide": _glide_at,
    "ceiling": lambda model, given: _ceiling(model)[0],
}
