"""The rules that the numbers and names of a case must satisfy beyond their types."""

import re
from collections.abc import Callable, Iterator
from math import isfinite
from typing import Any

from pitotbench.catalog import explain
from pitotbench.records.case import ERROR_LOCATIONS, PILOTS, TURBULENCE_SEVERITY, VERTICAL_VELOCITIES
from pitotbench.records.integration import USUAL_RATE, rate_problem

Place = tuple[str, ...]

# Path of the field (a regular expression), the test of its value [SI], and the rule in words.
_RULES: tuple[tuple[str, Callable[[Any], bool], str], ...] = (
    (r"das\.(air|gps)_rate|das\.\w+_(range|time)|das\.recovery_factor", lambda v: v > 0, "must be above 0"),
    (r"pressure_error\.reference_pressure", lambda v: v > 0, "must be above 0"),
    (r"das\.\w+_(noise|resolution|latency|drift)|wind\.speed", lambda v: v >= 0, "must not be negative"),
    (r"(truth|sensor)_seed", lambda v: v >= 0, "must not be negative"),
    (r"fuel", lambda v: 0 < v <= 1, "must be above 0 and at most 1, the whole of the fuel that the aircraft loads"),
    (r"ballast", lambda v: abs(v) <= 1000.0, "must be within -1000 and 1000 kg"),
    (r"das\.air_rate", lambda v: v <= 100.0, "must not exceed the simulator's 100 Hz"),
)
_NAMES = {
    "turbulence": list(TURBULENCE_SEVERITY),
    "pilot": list(PILOTS),
    "pressure_error.location": list(ERROR_LOCATIONS),
    "das.vertical_velocity": list(VERTICAL_VELOCITIES),
}


def broken_rules(tree: Any, written: Callable[[Place], str]) -> Iterator[str]:
    """Yield each rule that a tree of fields [SI] breaks; the line begins with the key as the file spells it."""
    leaves = dict(_leaves(tree, ()))
    for place, value in leaves.items():
        if isinstance(value, float) and not isfinite(value):
            yield f"{written(place)}: must be a finite number, not {value}"
            continue
        yield from _broken(place, value, written)
    air, gps = leaves.get(("das", "air_rate"), 50.0), leaves.get(("das", "gps_rate"), 50.0)
    if _is_number(air) and _is_number(gps) and gps > air > 0:
        yield f"das: the GPS rate ({gps:g} Hz) must not exceed the air-data rate ({air:g} Hz); lower gps_rate_hz"
    rate = leaves.get(("integration_rate",), USUAL_RATE)
    if _is_number(rate) and _is_number(air) and air > 0 and (problem := rate_problem(rate, air)):
        yield f"{written(('integration_rate',))}: {problem}"


def _broken(place: Place, value: Any, written: Callable[[Place], str]) -> Iterator[str]:
    path = ".".join(place)
    if path in _NAMES and isinstance(value, str) and value not in _NAMES[path]:
        yield f"{written(place)}: {explain(path, value, _NAMES[path])}"
    if _is_number(value):
        for pattern, holds, rule in _RULES:
            if re.fullmatch(pattern, path) and not holds(value):
                yield f"{written(place)}: {rule}, not {value:g} (SI)"


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _leaves(value: Any, place: Place) -> Iterator[tuple[Place, Any]]:
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from _leaves(inner, (*place, str(key)))
    elif isinstance(value, list):
        for i, inner in enumerate(value):
            yield from _leaves(inner, (*place, str(i)))
    else:
        yield place, value
