"""How much may the wind change, in time and with altitude?"""

from dataclasses import dataclass
from functools import partial

import numpy as np
import pandas as pd

from pitotbench.bench.truth_comparison import rms
from pitotbench.calibrate import CalibrationOptions
from pitotbench.evidence.pages.chart_data import Lines
from pitotbench.evidence.study.charting import maneuver_lines
from pitotbench.evidence.study.looks import COVERING, Look
from pitotbench.evidence.study.maneuver_names import NAMES, PAPER_ORDER, named
from pitotbench.evidence.study.study_tables import Spread, StudyTables
from pitotbench.evidence.study.sweeps.sweep import Reply, Sweep

RATES = (0.1, 0.3, 1.0, 3.0)  # kt a minute
SHEARS = (3.0, 10.0)  # kt a hundred feet
DRIFTING = CalibrationOptions(wind="drifting")
_NAMED = RATES[2]  # the change for which the answer and the table give numbers
_TOLERATED = 2.0  # times the rms error of a constant wind


@dataclass(frozen=True, slots=True)
class Trouble:
    """A kind of change, the wind of the fitted model, and the name of its picture."""

    change: str
    wind: str
    levels: tuple[float, ...]
    title: str
    note: str
    xlabel: str

    @property
    def name(self) -> str:
        """The name of its picture."""
        return f"sweep-{self.change}-{self.wind}".replace(" ", "-")


CHANGING = Trouble(
    "wind change",
    "constant",
    RATES,
    "A wind that changes",
    "Fitted with a constant wind, 50/50 Hz.",
    "change of the wind [kt/min]",
)
FOLLOWED = Trouble(
    "wind change",
    "drifting",
    RATES,
    "The same, and the model's wind may drift",
    "Fitted with wind='drifting'; no mark where no flight got an answer.",
    "change of the wind [kt/min]",
)
SHEARED = Trouble(
    "shear",
    "constant",
    SHEARS,
    "A wind that changes with altitude",
    "Fitted with a constant wind, 50/50 Hz.",
    "shear [kt/100 ft]",
)


def looks(maneuver: str) -> tuple[Look, ...]:
    """Return looks at every rate with a constant and with a drifting wind in the model, and at every shear."""
    changing = [Look("50/50", o, "wind change", rate) for rate in RATES for o in (COVERING, DRIFTING)]
    return (*changing, *(Look("50/50", COVERING, "shear", size) for size in SHEARS), Look("50/50", DRIFTING))


def _column(evidence: StudyTables, column: str, trouble: Trouble, maneuver: str, level: float) -> pd.Series:
    how: dict[str, object] = {"change": trouble.change, "level": level} if level else {}
    found = evidence.fit(column, maneuver, setting="light", method="covering", wind=trouble.wind, **how)
    few = evidence.fit(column, maneuver, setting="light", method="covering", wind="drifting").index
    return found[found.index.isin(few)]


def _error(evidence: StudyTables, trouble: Trouble, maneuver: str, level: float) -> pd.Series:
    return _column(evidence, "rms_error_kt", trouble, maneuver, level)


def tolerated(evidence: StudyTables, trouble: Trouble, maneuver: str) -> float:
    """Return the level at which the rms error over seeds is twice that of a constant wind; inf where none is."""
    still = rms(_error(evidence, trouble, maneuver, 0.0))
    errors = [rms(_error(evidence, trouble, maneuver, level)) / still for level in trouble.levels]
    for i, (level, error) in enumerate(zip(trouble.levels, errors, strict=True)):
        if error > _TOLERATED:
            before, below = (errors[i - 1], trouble.levels[i - 1]) if i else (1.0, 0.0)
            return below + (level - below) * (_TOLERATED - before) / (error - before)
    return float("inf")


def _said(value: float, trouble: Trouble) -> str:
    return f"more than {trouble.levels[-1]:g}" if np.isinf(value) else f"{value:.2f}"


def _row(evidence: StudyTables, maneuver: str) -> dict[str, object]:
    most = _NAMED
    inside = [_column(evidence, "coverage", t, maneuver, most) for t in (CHANGING, FOLLOWED)]
    errors = [f"{rms(_error(evidence, t, maneuver, most)):.2f}" for t in (CHANGING, FOLLOWED)]
    return {
        "tolerated change [kt/min]": _said(tolerated(evidence, CHANGING, maneuver), CHANGING),
        "tolerated shear [kt/100 ft]": _said(tolerated(evidence, SHEARED, maneuver), SHEARED),
        f"rms error at {most:g} kt/min, wind constant [kt]": errors[0],
        f"rms error at {most:g} kt/min, wind drifting [kt]": errors[1],
        "curve inside 2σ, constant [%]": f"{100.0 * Spread.of(inside[0]).mean:.0f}",
        "curve inside 2σ, drifting [%]": f"{100.0 * Spread.of(inside[1]).mean:.0f}",
        "drifting, answer refused": f"{int(inside[1].isna().sum())} of {len(inside[1])}",
    }


def _chart(evidence: StudyTables, trouble: Trouble) -> Lines:
    error = partial(_error, evidence, trouble)
    levels = (0.0, *trouble.levels)
    ylabel = "rms error of the curve [kt]"
    return maneuver_lines(trouble.name, trouble.title, trouble.note, trouble.xlabel, ylabel, levels, error)


def _answer(evidence: StudyTables) -> Reply:
    limit = {m: tolerated(evidence, CHANGING, m) for m in PAPER_ORDER}
    shear = {m: tolerated(evidence, SHEARED, m) for m in PAPER_ORDER}
    least, most = min(limit, key=lambda m: limit[m]), max(limit, key=lambda m: limit[m])
    first = min(shear, key=lambda m: shear[m])
    wander = Spread.of(evidence.flight("altitude_ft", first, "light")).mean
    inside = [
        np.mean([Spread.of(_column(evidence, "coverage", t, m, _NAMED)).mean for m in PAPER_ORDER])
        for t in (CHANGING, FOLLOWED)
    ]
    return Reply(
        f"The error of the curve doubles at {_said(limit[least], CHANGING)} kt/min of steady change for "
        f"{NAMES[least]} and at {_said(limit[most], CHANGING)} kt/min for {NAMES[most]}; at {_NAMED:g} kt/min a "
        f"constant wind in the model leaves {100.0 * inside[0]:.0f} % of the curve inside its 2σ over the five "
        f"maneuvers, a drifting one {100.0 * inside[1]:.0f} %. Of shear, at an altitude that wanders by "
        f"{wander:.0f} ft rms, the first to double is {NAMES[first]}, at {_said(shear[first], SHEARED)} kt/100 ft.",
        tuple(_chart(evidence, trouble) for trouble in (CHANGING, FOLLOWED, SHEARED)),
        (named({m: _row(evidence, m) for m in PAPER_ORDER}),),
    )


WIND = Sweep("variable wind", "How much may the wind change, in time and with altitude?", _answer, looks)
