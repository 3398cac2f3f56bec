"""Hide every effect of the table alone, at both ends of its range, and count the logs that get no
answer.

    python -m tests.lab.both_ends [NAME …]

flies one short card for each effect and end, records it, and reconciles the log without null
flights. The log is cut to two minutes, so that it costs seconds. A log counts as failed where
anything raises, where the verdict is none of the four, or where the patch cannot be read as a case.
A flight that the simulator refuses is counted apart.
"""

import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import product, starmap
from typing import get_args

import numpy as np

from pitotbench import Case, fly
from pitotbench.bench.workflow import NamedLog, reconcile_fully
from pitotbench.effects import EFFECTS
from pitotbench.records import BadInputError
from pitotbench.records.case import EffectSpec
from pitotbench.records.case_file import read_case
from pitotbench.records.flight import Flight
from pitotbench.records.log import FlightLog
from pitotbench.records.verdict import Kind
from pitotbench.sensing.recorder import record

CARD = Case(maneuver="rapid_decel", turbulence="light", truth_seed=40_011, sensor_seed=40_011)
SECONDS = 120.0  # of the log
ENDS = ("low", "high")


@dataclass(frozen=True, slots=True)
class Outcome:
    """What came of one effect at one end: verdict and causes, or the error, or the refusal."""

    effect: str
    end: str
    verdict: str = ""
    causes: tuple[str, ...] = ()
    error: str = ""
    refused: str = ""


def at_end(name: str, end: str) -> EffectSpec:
    """Return an effect with every size at an end of its range; shapes are typical."""
    sizes = EFFECTS[name].parameters
    return EffectSpec(name, {p.name: p.typical if p.shape else getattr(p, end) for p in sizes})


@cache
def plain_flight() -> Flight:
    """The flight without an effect, which all effects on the sensors share."""
    return fly(CARD)


def log_with(spec: EffectSpec) -> FlightLog:
    """Return the first minutes of a log with an effect in it, without a header: no null flights."""
    case = replace(CARD, effects=(spec,))
    on_sensors = EFFECTS[spec.name].acts_on == "sensors"
    flight = replace(plain_flight(), case=case) if on_sensors else fly(case)
    log = record(flight, case.das, case.sensor_seed)
    return replace(log.select(np.flatnonzero(log.time < log.time[0] + SECONDS)), header={})


@cache
def judged(name: str, end: str, aircraft: str = "navajo") -> Outcome:
    """Return what comes of one effect at one end."""
    spec = at_end(name, end)
    try:
        log = log_with(spec)
    except BadInputError as refusal:
        return Outcome(name, end, refused=str(refusal))
    except Exception as problem:
        return Outcome(name, end, error=f"in flight: {problem!r}")
    try:
        found = reconcile_fully(NamedLog("log", log), aircraft, refly=False)
        read_case(found.patch.text)
    except Exception as problem:
        return Outcome(name, end, error=repr(problem))
    kind, causes = found.verdict.kind, tuple(cause.name for cause in found.verdict.effects)
    return Outcome(name, end, kind, causes, "" if kind in get_args(Kind) else f"verdict {kind!r}")


def main(names: Sequence[str]) -> int:
    """Print every outcome and the count; return 1 where any log has no answer."""
    done = []
    for each in starmap(judged, product(names or EFFECTS, ENDS)):
        done.append(each)
        came = each.verdict or each.error or f"refused: {each.refused}"
        print(f"{each.effect} {each.end}: {came}", flush=True)
    failed, refused = sum(bool(o.error) for o in done), sum(bool(o.refused) for o in done)
    print(f"{failed} of {len(done)} without an answer; {refused} not flown, refused with a reason")
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
