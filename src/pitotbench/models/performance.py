"""Find the performance of an aircraft in steady flight: stall, climb, cruise, glide and ceiling."""

from collections.abc import Callable, Iterable
from math import isfinite, tan
from pathlib import Path
from tempfile import TemporaryDirectory

from pitotbench.models.handbook import lift_to_drag, read_handbook
from pitotbench.models.steady_flight import (
    GLIDE_HEIGHT,
    HIGHEST,
    HIGHEST_MACH,
    NOT_FOUND,
    Figures,
    PerformanceModel,
    best_climb,
    find_ceiling,
    level_flight,
    refine,
    slowest_speed,
    stall,
    steady_speeds,
    true_airspeed,
)
from pitotbench.records.performance import Performance, PerformanceFigure
from pitotbench.simulation.aircraft_files import SimulationError
from pitotbench.units import DEGREE, FOOT, KNOT, POUND, STANDARD_GRAVITY, percent_text

CRUISE_HEIGHTS = tuple(h * FOOT for h in (2000.0, 8000.0, 15000.0, 25000.0, 35000.0))
CRUISE_LEVERS = (0.6, 0.75, 1.0)  # throttle: economy, normal and full power
MOVED = 0.005  # share of the stall speed that flaps must change
Family = tuple[str, Callable[[PerformanceModel], Figures]]


def find_performance(aircraft: str, handbook: Path | None = None) -> Performance:
    """Return the performance of an aircraft.

    The aircraft is a name of the hangar or of JSBSim's library, or a path.

    With `handbook`, a table that `read_handbook` describes, each of its rows becomes a figure with
    the published value next to it, before the figures at the weight of the file. What the model
    lacks or cannot do is skipped, with the reason. Raises UnknownNameError, BadInputError or
    SimulationError where the aircraft has no steady flight at all.
    """
    rows = read_handbook(handbook) if handbook is not None else []
    return _performance(aircraft, (*((row.words, row.figures) for row in rows), *FAMILIES))


def find_main_figures(aircraft: str) -> Performance:
    """Return stall, glide, climb and top speed of an aircraft, some two seconds of work.

    Names and errors are those of `find_performance`.
    """
    return _performance(aircraft, MAIN_FAMILIES)


def _performance(aircraft: str, families: Iterable[Family]) -> Performance:
    with TemporaryDirectory(prefix="pitotbench-") as scratch:
        model = PerformanceModel.load(aircraft, Path(scratch))
        found, skipped = [], []
        for name, of in families:
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


_ABOVE = f"it still climbs at {HIGHEST / FOOT:,.0f} ft, or never did"
UNKNOWN = {
    "cruise speed": f"no level flight up to Mach {HIGHEST_MACH:g}",
    "service ceiling": _ABOVE,
    "absolute ceiling": _ABOVE,
    "ceiling": _ABOVE,
}


def _height_words(height: float) -> str:
    return f"{height / FOOT:,.0f} ft" if height else "sea level"


def _stalls(model: PerformanceModel) -> Figures:
    clean = stall(model, 0.0, 0.0)
    yield PerformanceFigure("stall speed", "flaps up, idle, 1 g", clean.calibrated / KNOT, "KCAS")
    if not model.frozen.serves("fcs/flap-cmd-norm"):
        raise SimulationError("the model has no flaps")
    down = stall(model, 0.0, 1.0)
    if abs(down.calibrated / clean.calibrated - 1.0) < MOVED:
        raise SimulationError("the flaps of the model change no lift")
    yield PerformanceFigure("stall speed", "flaps down, idle, 1 g", down.calibrated / KNOT, "KCAS")


def _climbs(model: PerformanceModel) -> Figures:
    service, absolute, climbs = find_ceiling(model)
    for height, best, several in climbs:
        if best.climb_rate <= 0.0:
            continue
        place = f"{_height_words(height)}, full throttle"
        steep = refine(model, height, 1.0, several, lambda each: each.state.climb) or best
        yield from (
            PerformanceFigure(
                "best rate of climb",
                place,
                best.climb_rate / FOOT * 60.0,
                "ft/min",
                altitude=height,
            ),
            PerformanceFigure("speed of the best rate", place, best.calibrated / KNOT, "KCAS"),
            PerformanceFigure("best angle of climb", place, steep.state.climb / DEGREE, "°"),
            PerformanceFigure("speed of the best angle", place, steep.calibrated / KNOT, "KCAS"),
        )
    yield from (
        PerformanceFigure("service ceiling", "100 ft/min, full throttle", service / FOOT, "ft"),
        PerformanceFigure("absolute ceiling", "full throttle", absolute / FOOT, "ft"),
    )


def _cruises(model: PerformanceModel) -> Figures:
    slow = stall(model, 0.0, 0.0).calibrated
    for height in CRUISE_HEIGHTS:
        for lever in CRUISE_LEVERS:
            place = f"{_height_words(height)}, {percent_text(lever)} throttle"
            level = level_flight(
                model,
                height,
                lever,
                steady_speeds(model, height, lever, true_airspeed(slow, height)),
            )
            if level is None:
                yield PerformanceFigure("cruise speed", place, float("nan"), "KTAS")
                continue
            thrust = level.thrust / POUND / STANDARD_GRAVITY
            yield from (
                PerformanceFigure("cruise speed", place, level.state.speed / KNOT, "KTAS"),
                PerformanceFigure("cruise power", place, level.power, "hp")
                if level.power
                else PerformanceFigure("cruise thrust", place, thrust, "lb"),
            )


def _glides(model: PerformanceModel) -> Figures:
    several = steady_speeds(model, GLIDE_HEIGHT, 0.0, slowest_speed(model, GLIDE_HEIGHT))
    flat = refine(model, GLIDE_HEIGHT, 0.0, several, lambda each: each.state.climb)
    slender = max(several, key=lift_to_drag, default=None)
    place = f"{_height_words(GLIDE_HEIGHT)}, flaps up"
    if flat is None or slender is None:
        raise SimulationError(NOT_FOUND)
    ratio = -1.0 / tan(flat.state.climb) if flat.state.climb < 0.0 else float("nan")
    idle, free = f"{place}, idle", f"{place}, without thrust"
    yield from (
        PerformanceFigure("glide ratio", idle, ratio, ""),
        PerformanceFigure("speed of the best glide", idle, flat.calibrated / KNOT, "KCAS"),
        PerformanceFigure("best lift-to-drag ratio", free, lift_to_drag(slender), ""),
        PerformanceFigure(
            "speed of the best lift-to-drag ratio", free, slender.calibrated / KNOT, "KCAS"
        ),
    )


def _full_throttle(model: PerformanceModel) -> Figures:
    place = f"{_height_words(GLIDE_HEIGHT)}, full throttle"
    best, several = best_climb(model, GLIDE_HEIGHT, slowest_speed(model, GLIDE_HEIGHT))
    level = level_flight(model, GLIDE_HEIGHT, 1.0, several)
    rate = best.climb_rate / FOOT * 60.0 if best else float("nan")
    speed = level.state.speed / KNOT if level else float("nan")
    yield PerformanceFigure("best rate of climb", place, rate, "ft/min")
    yield PerformanceFigure("cruise speed", place, speed, "KTAS")


FAMILIES: tuple[Family, ...] = (
    ("stall speed", _stalls),
    ("climb and ceiling", _climbs),
    ("cruise", _cruises),
    ("glide", _glides),
)
MAIN_FAMILIES: tuple[Family, ...] = (
    ("stall speed", _stalls),
    ("glide", _glides),
    ("climb and cruise", _full_throttle),
)
POWERED = (_climbs, _cruises, _full_throttle)
