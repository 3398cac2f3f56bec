"""The score by part: which part of the airplane or the world a case hides, which one was told, and
how surely.

A told probability of a part is the sum of those of its causes.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pitotbench.effects import EFFECTS
from pitotbench.units import Array, Booleans
from pitotlab.blind.case import NO_ANSWER, SURE, JudgedCase

# What a mechanic would look at where a fault of the generator is none of the table.
_FAULTS = {
    "pitot head & pitot line": "loose_tube insect_in_tube open_drain",
    "static ports and line": "icing_port rain_in_port",
    "impact transducer & static ports and line": "climb_crosstalk",
    "impact transducer": "heavy_membrane kinked_transducer heated_transducer",
    "static transducer": "strobe_light",
    "flow vanes": "bending_boom twisting_boom late_vane crossed_vanes vane_in_wake",
    "attitude and inertial unit": (
        "crossed_gyros warming_accelerometer stretched_accelerometer shaken_accelerometer "
        "leaning_gyro erected_pitch late_attitude"
    ),
    "GPS receiver and its clock": "swinging_altitude multipath_bursts leaping_altitude stale_fixes",
    "recorder": "stamp_jitter sagging_supply",
    "thermometer, or the day": "sun_on_probe slow_probe exhaust_on_probe heated_probe",
    "engine instruments": "fuel_meter slipping_tachometer long_manifold_line",
    "controls and trim": "bent_elevator_pickup floating_rudder",
    "air": "pressure_slope wake_encounter",
    "air & thermometer, or the day": "warm_patches",
    "drag": "cowl_flap_cycling fluttering_door baggage_door",
    "loading": "fuel_slosh rolling_tanks",
    "lift, stability and damping": "bending_wing",
    "lift, stability and damping & drag": "icing_wing rain_on_wing",
    "engine or propeller, a side": "surging_engine",
}
PARTS_OUTSIDE: Mapping[str, tuple[str, ...]] = {
    fault: tuple(parts.split(" & "))
    for parts, faults in _FAULTS.items()
    for fault in faults.split()
}
LEAST = 5e-4  # probability of a cause that was not written down: half of the least that was
NAMED = 0.9
Told = Callable[[JudgedCase], Mapping[str, float]]


def part_of(cause: str) -> str:
    """The part of a cause of the table."""
    return str(EFFECTS[cause].part)


def hidden_parts(case: JudgedCase) -> set[str]:
    """The parts at which a mechanic finds what was hidden."""
    if case.kind == "outside":
        return {part for effect in case.truth["effects"] for part in PARTS_OUTSIDE[effect["name"]]}
    return set(map(part_of, case.wanted))


def summed(case: JudgedCase) -> dict[str, float]:
    """The probability of each part: the sum of those of its causes, at most 1."""
    found: dict[str, float] = {}
    for cause, p in case.probabilities.items():
        found[part_of(cause)] = min(1.0, found.get(part_of(cause), 0.0) + p)
    return found


def with_a_gap(cases: Sequence[JudgedCase]) -> list[JudgedCase]:
    """The cases with something hidden that has a part to be found, of which the answer tells a gap."""
    told = [c for c in cases if c.verdict not in ("no_gap", *NO_ANSWER)]
    return [c for c in told if c.is_single or c.kind in ("two", "outside")]


def _pairs(
    cases: Sequence[JudgedCase], told: Told, hidden: Callable[[JudgedCase], set[str]]
) -> tuple[Array, Booleans]:
    """Told probabilities, (n,), and whether they are right, (n,); what was not told has 0."""
    pairs = []
    for case in cases:
        found, truth = told(case), hidden(case)
        pairs += [(p, name in truth) for name, p in found.items()]
        # An outsider may have two parts, and one of them suffices.
        enough = case.kind == "outside" and truth & set(found)
        pairs += [(0.0, True)] * (0 if enough else len(truth - set(found)))
    p, right = np.array(pairs, dtype=float).reshape(-1, 2).T
    return p, right > 0.5


def proper_scores(
    cases: Sequence[JudgedCase], told: Told, hidden: Callable[[JudgedCase], set[str]] = hidden_parts
) -> tuple[float, float]:
    """Return the log score and the Brier score a case, summed over causes or parts."""
    p, right = _pairs(cases, told, hidden)
    p = np.clip(p, LEAST, 1.0 - LEAST)
    logs = -np.log(np.where(right, p, 1.0 - p))
    return float(logs.sum()) / len(cases), float(np.sum((p - right) ** 2)) / len(cases)


@dataclass(frozen=True, slots=True)
class NamedParts:
    """Cases with a part named above 0.9, right and wrong; `first`: the right one is the likeliest."""

    cases: int
    first: int
    right: int
    wrong: int

    def __str__(self) -> str:
        counts = (self.first, self.right, self.wrong)
        first, right, wrong = (f"{each} ({each / max(1, self.cases):.1%})" for each in counts)
        return f"first {first}, named above 0.9 right {right}, wrong {wrong}, of {self.cases}"


def named_parts(cases: Sequence[JudgedCase], told: Told) -> NamedParts:
    """Count the cases with a right part named and those with a wrong one."""
    first = right = wrong = 0
    for case in cases:
        found, truth = told(case), hidden_parts(case)
        first += bool(found) and max(found, key=lambda part: found[part]) in truth
        named = {part for part, p in found.items() if p > NAMED and case.verdict in SURE}
        right += bool(named & truth)
        wrong += bool(named - truth)
    return NamedParts(len(cases), first, right, wrong)


def strong_causes(cases: Sequence[JudgedCase]) -> list[JudgedCase]:
    """The cases of one flight with a single cause above 7σ."""
    return [c for c in cases if c.is_single and c.flights == 1 and c.band == "above 7"]


def lines(cases: Sequence[JudgedCase]) -> list[str]:
    """The score by part as lines: named parts, and the proper scores over causes and parts."""
    outside = [c for c in cases if c.kind == "outside"]
    gap = with_a_gap(cases)
    asked = {"the table": [c for c in gap if c.kind != "outside"], "the table and outside": gap}
    asked = {what: some for what, some in asked.items() if some}
    found = [
        f"part, one flight above 7: {named_parts(strong_causes(cases), summed)}",
        f"part, outside the table: {named_parts(outside, summed)}",
    ]
    for what, some in asked.items():
        log, brier = proper_scores(some, summed)
        found.append(f"parts of {what}: log score {log:.3f}, Brier {brier:.4f}, {len(some)}")
    for what, some in asked.items():
        log, brier = proper_scores(some, lambda c: c.probabilities, lambda c: c.wanted)
        found.append(f"causes of {what}: log score {log:.3f}, Brier {brier:.4f}, {len(some)} cases")
    return found
