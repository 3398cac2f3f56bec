"""The open questions about the air and the airplane in it: a changing wind, sideslip."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
import pandas as pd

from pitotbench.calibration.options import CalibrationOptions
from pitotbench.campaigns.flights import rms
from pitotlab.study.questions import Reply, Sweep
from pitotlab.study.reductions import (
    BOTH_METHODS,
    COVERING,
    NAMES,
    PAPER_ORDER,
    Reduction,
    named,
    reductions,
)
from pitotlab.study.tables import (
    StudyTables,
    mean,
    percent_above,
    signed,
    span,
)

RATES = (0.1, 0.3, 1.0, 3.0)  # kt a minute
SHEARS = (3.0, 10.0)  # kt a hundred feet
DRIFTING = CalibrationOptions(wind="drifting")
_NAMED = RATES[2]  # the change for which the answer and the table give numbers
_TOLERATED = 2.0  # times the rms error of a constant wind


@dataclass(frozen=True, slots=True)
class Trouble:
    """A kind of change with its levels, and the wind of the fitted model."""

    change: str
    wind: str
    levels: tuple[float, ...]


CHANGING = Trouble("wind change", "constant", RATES)
FOLLOWED = Trouble("wind change", "drifting", RATES)
SHEARED = Trouble("shear", "constant", SHEARS)


def wind_reductions(maneuver: str) -> Iterator[Reduction]:
    """Yield reductions of every rate, with both winds in the model, and of every shear."""
    for rate in RATES:
        yield from reductions((COVERING, DRIFTING), change="wind change", level=rate)
    for size in SHEARS:
        yield from reductions((COVERING,), change="shear", level=size)
    yield from reductions((DRIFTING,))


def _wind_column(
    evidence: StudyTables, column: str, trouble: Trouble, maneuver: str, level: float
) -> pd.Series:
    how: dict[str, object] = {"change": trouble.change, "level": level} if level else {}
    covering = partial(evidence.fit, column, maneuver, setting="light", method="covering")
    found = covering(wind=trouble.wind, **how)
    return found[found.index.isin(covering(wind="drifting").index)]


def _inside(evidence: StudyTables, trouble: Trouble, maneuver: str) -> pd.Series:
    return _wind_column(evidence, "coverage", trouble, maneuver, _NAMED)


def _error(evidence: StudyTables, trouble: Trouble, maneuver: str, level: float) -> pd.Series:
    return _wind_column(evidence, "rms_error_kt", trouble, maneuver, level)


def tolerated(evidence: StudyTables, trouble: Trouble, maneuver: str) -> float:
    """Return the level at which the rms error is twice that of a constant wind, or inf."""
    still = rms(_error(evidence, trouble, maneuver, 0.0))
    before, below = 1.0, 0.0
    for level in trouble.levels:
        error = rms(_error(evidence, trouble, maneuver, level)) / still
        if error > _TOLERATED:
            return below + (level - below) * (_TOLERATED - before) / (error - before)
        before, below = error, level
    return float("inf")


def _said(value: float, trouble: Trouble) -> str:
    return f"more than {trouble.levels[-1]:g}" if np.isinf(value) else f"{value:.2f}"


def _wind_row(evidence: StudyTables, maneuver: str) -> dict[str, object]:
    row: dict[str, object] = {
        "tolerated change [kt/min]": _said(tolerated(evidence, CHANGING, maneuver), CHANGING),
        "tolerated shear [kt/100 ft]": _said(tolerated(evidence, SHEARED, maneuver), SHEARED),
    }
    for trouble in (CHANGING, FOLLOWED):
        error = rms(_error(evidence, trouble, maneuver, _NAMED))
        row[f"rms error at {_NAMED:g} kt/min, wind {trouble.wind} [kt]"] = f"{error:.2f}"
    for trouble in (CHANGING, FOLLOWED):
        inside = _inside(evidence, trouble, maneuver)
        row[f"curve inside 2σ, {trouble.wind} [%]"] = f"{100.0 * mean(inside):.0f}"
    return row | {"drifting, answer refused": f"{int(inside.isna().sum())} of {len(inside)}"}


@partial(
    Sweep,
    "variable wind",
    "How much may the wind change, in time and with altitude?",
    reductions=wind_reductions,
)
def variable_wind(evidence: StudyTables) -> Reply:
    limit = {m: tolerated(evidence, CHANGING, m) for m in PAPER_ORDER}
    shear = {m: tolerated(evidence, SHEARED, m) for m in PAPER_ORDER}
    least, most = (pick(limit, key=lambda m: limit[m]) for pick in (min, max))
    first = min(shear, key=lambda m: shear[m])
    wander = mean(evidence.flight("altitude_ft", first, "light"))
    inside = [
        pd.concat([_inside(evidence, trouble, m) for m in PAPER_ORDER])
        for trouble in (CHANGING, FOLLOWED)
    ]
    constant, drifting = (100.0 * mean(each) for each in inside)
    return Reply(
        f"The error of the curve doubles at {_said(limit[least], CHANGING)} kt/min of steady "
        f"change for {NAMES[least]} and at {_said(limit[most], CHANGING)} kt/min for "
        f"{NAMES[most]}; at {_NAMED:g} kt/min a constant wind in the model leaves {constant:.0f} % "
        f"of the curve inside its 2σ over the five maneuvers ({int(inside[0].isna().sum())} of "
        f"{len(inside[0])} flights refused), a drifting one {drifting:.0f} %. Of shear, at an "
        f"altitude that wanders by {wander:.0f} ft rms, the first to double is {NAMES[first]}, at "
        f"{_said(shear[first], SHEARED)} kt/100 ft.",
        (named(partial(_wind_row, evidence)),),
    )


ANGLES = (2.0, 4.0, 8.0)  # degrees
KINDS = {"steady sideslip": "held throughout", "sideslip in turns": "in turns only"}
_SAID = ANGLES[1]  # the angle for which the answer gives numbers


def sideslip_reductions(maneuver: str) -> Iterator[Reduction]:
    """Yield reductions of every angle, in the whole flight and in turns only."""
    for kind in KINDS:
        for angle in ANGLES:
            yield from reductions(BOTH_METHODS, change=kind, level=angle)


def _sideslip_column(
    evidence: StudyTables,
    kind: str,
    maneuver: str,
    angle: float,
    column: str = "rms_error_kt",
    method: str = "covering",
) -> pd.Series:
    how: dict[str, object] = {"change": kind, "level": angle} if angle else {}
    fitted = partial(evidence.fit, column, maneuver, setting="light", method=method)
    found = fitted(**how)
    return found[found.index.isin(fitted(change=kind, level=ANGLES[0]).index)]


def _residual_change(evidence: StudyTables, maneuver: str) -> float:
    """Return the change of the residual by a steady sideslip [%]."""
    with_it, without = (
        _sideslip_column(
            evidence, "steady sideslip", maneuver, angle, "residual_two_sigma_kt", "paper"
        )
        for angle in (_SAID, 0.0)
    )
    return percent_above(with_it, without).mean


@partial(
    Sweep,
    "sideslip",
    "What does sideslip do, held throughout and in turns only?",
    reductions=sideslip_reductions,
)
def sideslip(evidence: StudyTables) -> Reply:
    steady, turning = (
        {m: rms(_sideslip_column(evidence, kind, m, _SAID)) for m in PAPER_ORDER} for kind in KINDS
    )
    residual = max((_residual_change(evidence, m) for m in PAPER_ORDER), key=abs)
    worst, least = (pick(turning, key=lambda m: turning[m]) for pick in (max, min))
    share = {m: mean(evidence.flight("turning_percent", m, "light")) for m in (worst, least)}
    return Reply(
        f"A steady {_SAID:g}° is a different pressure error, not a disturbance: the curve is "
        f"{span([*steady.values()], 1)} kt wrong over the five maneuvers while the residual "
        f"changes by {signed(residual)} % at most. In turns only, it is worst in {NAMES[worst]} "
        f"({turning[worst]:.2f} kt; {share[worst]:.0f} % of the data are turns) and least in "
        f"{NAMES[least]} ({turning[least]:.2f} kt; {share[least]:.0f} %).",
    )
