"""The table of a handbook, and the figures of a model in its conditions."""

import csv
from collections.abc import Callable
from dataclasses import dataclass
from math import isfinite, tan
from pathlib import Path

from pitotbench.logbook.handbook_table import is_published
from pitotbench.models.steady_flight import (
    FINEST_LEVER,
    GLIDE_HEIGHT,
    SAME_POWER,
    Figures,
    PerformanceModel,
    Steady,
    best_climb,
    find_ceiling,
    level_flight,
    refine,
    slowest_speed,
    stall,
    steady_flight,
    steady_speeds,
    true_airspeed,
)
from pitotbench.records import BadInputError
from pitotbench.records.performance import PerformanceFigure
from pitotbench.simulation.autopilot.frozen_aircraft import State
from pitotbench.units import DEGREE, FOOT, KNOT


def lift_to_drag(each: Steady) -> float:
    """Return the lift-to-drag ratio of a steady state."""
    return each.lift / each.drag


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
    """One published figure; `published` and `given` are in the units of the columns."""

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

    def figures(self, model: PerformanceModel) -> Figures:
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


def _stall_at(model: PerformanceModel, given: dict[str, float]) -> float:
    height = given.get("altitude_ft", 0.0) * FOOT
    return stall(model, height, given.get("flaps_percent", 0.0) / 100.0).calibrated


def _climb_at(model: PerformanceModel, given: dict[str, float]) -> float:
    height = given.get("altitude_ft", 0.0) * FOOT
    if "calibrated_airspeed_kt" in given:
        found = _at_speed(model, height, 1.0, given)
    else:
        found = best_climb(model, height, slowest_speed(model, height))[0]
    return found.climb_rate if found else float("nan")


def _at_speed(
    model: PerformanceModel, height: float, lever: float, given: dict[str, float]
) -> Steady | None:
    speed = true_airspeed(given["calibrated_airspeed_kt"] * KNOT, height)
    model.frozen.climb_to(height, speed)
    return steady_flight(model, height, speed, lever, State(speed, alpha=4.0 * DEGREE))


def _cruise_at(model: PerformanceModel, given: dict[str, float]) -> float:
    height = given.get("altitude_ft", 0.0) * FOOT
    slow = slowest_speed(model, height)

    def at(lever: float) -> Steady | None:
        return level_flight(model, height, lever, steady_speeds(model, height, lever, slow))

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


def _glide_at(model: PerformanceModel, given: dict[str, float]) -> float:
    height = given.get("altitude_ft", GLIDE_HEIGHT / FOOT) * FOOT
    if "calibrated_airspeed_kt" in given:
        found = _at_speed(model, height, 0.0, given)
    else:
        several = steady_speeds(model, height, 0.0, slowest_speed(model, height))
        found = refine(model, height, 0.0, several, lambda each: each.state.climb)
    return -1.0 / tan(found.state.climb) if found and found.state.climb < 0.0 else float("nan")


_AT: dict[str, Callable[[PerformanceModel, dict[str, float]], float]] = {
    "stall": _stall_at,
    "climb": _climb_at,
    "cruise": _cruise_at,
    "glide": _glide_at,
    "ceiling": lambda model, given: find_ceiling(model)[0],
}
