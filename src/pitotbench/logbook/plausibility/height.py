"""Static pressure against the geometric height, where the log holds it."""

import numpy as np

from pitotbench import air
from pitotbench.logbook.draft import Draft
from pitotbench.logbook.plausibility.limits import LIMITS, some
from pitotbench.logbook.plausibility.slopes import block_slope
from pitotbench.logbook.plausibility.weather import warmth
from pitotbench.logbook.quantities import QUANTITIES
from pitotbench.records.errors import BadInputError
from pitotbench.units import SUFFIXES, Array, from_si, to_si


def check_height(draft: Draft) -> None:
    """Refuse a static pressure that another unit, or a pressure reduced to sea level, would bring to the height.

    A static pressure that nothing explains is warned of; a height in another unit is not used.
    Raises BadInputError, which names the column to write.
    """
    if "altitude" not in draft.channels:
        return
    static, height = some(draft, "static_pressure"), some(draft, "altitude")
    _refuse_total(draft, static, height)
    if _fits(draft, static, height):
        return
    column, pressure_height = draft.columns["static_pressure"], float(np.median(air.pressure_altitude(static)))
    words = (
        f"the static pressure of column {column!r} is that of {pressure_height:.0f} m, column "
        f"{draft.columns['altitude']!r} says {float(np.median(height)):.0f} m"
    )
    other_static = [
        s for s in _others(draft, "static_pressure") if _fits(draft, _read_as(draft, "static_pressure", s), height)
    ]
    other_height = [s for s in _others(draft, "altitude") if _fits(draft, static, _read_as(draft, "altitude", s))]
    if other_static:
        names = " or ".join(f"static_pressure_{s}" for s in other_static)
        raise BadInputError(f"{words}; the pressure would fit {names}: name the column so")
    if _at_sea_level(static, height):
        raise BadInputError(
            f"{words}; it looks reduced to sea level (QNH) or constant: record the pressure at the airplane"
        )
    if other_height:
        names = " or ".join(f"altitude_{s}" for s in other_height)
        draft.leave_out("altitude", f"{words}; the height would fit {names}: name the column so")
        return
    draft.warnings.append(f"{words}: no weather explains that; check the unit and the zero of both")


def _fits(draft: Draft, static: Array, height: Array) -> bool:
    # A column of warm air is taller than its pressure altitude says, in the ratio of the temperatures.
    expected = air.pressure_altitude(np.maximum(static, 100.0)) * warmth(draft, static)
    distance = abs(float(np.median(expected - height)))
    return distance <= LIMITS.height_doubted + LIMITS.height_share * abs(float(np.median(height)))


def _others(draft: Draft, name: str) -> list[str]:
    return [s for s in QUANTITIES[name].suffixes if SUFFIXES[s] != SUFFIXES[draft.suffixes[name]]]


def _read_as(draft: Draft, name: str, suffix: str) -> Array:
    return to_si(from_si(some(draft, name), draft.suffixes[name]), suffix)


def _at_sea_level(static: Array, height: Array) -> bool:
    near = abs(float(np.median(static)) - air.SEA_LEVEL_PRESSURE) < LIMITS.sea_level_band
    return near and float(np.median(height)) > LIMITS.sea_level_height


def _refuse_total(draft: Draft, static: Array, height: Array) -> None:
    """A static pressure that rises with the impact pressure at one height is a total pressure."""
    impact, time = some(draft, "impact_pressure"), some(draft, "time")
    excess = static - air.standard_pressure(height)
    design = np.stack([np.ones_like(time), impact, height - np.mean(height)])
    slope, error = block_slope(time, design, excess)
    if slope - LIMITS.sigmas * error > LIMITS.total_slope:
        raise BadInputError(
            f"column {draft.columns['static_pressure']!r}: the pressure rises with the impact pressure at one "
            f"height ({slope:.2f} times as much): it looks like total pressure; name the column total_pressure_"
            f"{draft.suffixes['static_pressure']} and give the static pressure"
        )
