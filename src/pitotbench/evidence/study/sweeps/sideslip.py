"""How does sideslip change the answer, in the whole flight and in turns only?"""

from functools import partial

import pandas as pd

from pitotbench.bench.truth_comparison import rms
from pitotbench.evidence.pages.chart_data import Lines
from pitotbench.evidence.study.changes import SIDESLIP_ERROR
from pitotbench.evidence.study.charting import maneuver_lines
from pitotbench.evidence.study.looks import COVERING, PAPER, Look
from pitotbench.evidence.study.maneuver_names import NAMES, PAPER_ORDER
from pitotbench.evidence.study.study_tables import Spread, StudyTables, percent_above, signed
from pitotbench.evidence.study.sweeps.sweep import Reply, Sweep

ANGLES = (2.0, 4.0, 8.0)  # degrees
KINDS = {"steady sideslip": "held throughout", "sideslip in turns": "in turns only"}
_SAID = ANGLES[1]  # the angle for which the answer gives numbers


def looks(maneuver: str) -> tuple[Look, ...]:
    """Return looks at every angle, in the whole flight and in turns only."""
    return tuple(Look("50/50", o, kind, angle) for kind in KINDS for angle in ANGLES for o in (COVERING, PAPER))


def _column(
    evidence: StudyTables,
    kind: str,
    maneuver: str,
    angle: float,
    column: str = "rms_error_kt",
    method: str = "covering",
) -> pd.Series:
    how: dict[str, object] = {"change": kind, "level": angle} if angle else {}
    found = evidence.fit(column, maneuver, setting="light", method=method, **how)
    few = evidence.fit(column, maneuver, setting="light", method=method, change=kind, level=ANGLES[0]).index
    return found[found.index.isin(few)]


def _chart(evidence: StudyTables, kind: str) -> Lines:
    note = (
        f"A probe that loses {100.0 * SIDESLIP_ERROR:g} % of q_c a degree squared (our estimate); light turbulence."
    )
    name, title = f"sweep-{kind.replace(' ', '-')}", f"Sideslip {KINDS[kind]}"
    error = partial(_column, evidence, kind)
    return maneuver_lines(name, title, note, "sideslip [°]", "rms error of the curve [kt]", (0.0, *ANGLES), error)


def _residual_change(evidence: StudyTables, maneuver: str) -> float:
    """Return the change of the residual by a steady sideslip [%]."""
    column = partial(_column, evidence, "steady sideslip", maneuver, column="residual_two_sigma_kt", method="paper")
    return percent_above(column(_SAID), column(0.0)).mean


def _answer(evidence: StudyTables) -> Reply:
    steady = [rms(_column(evidence, "steady sideslip", m, _SAID)) for m in PAPER_ORDER]
    residual = max((_residual_change(evidence, m) for m in PAPER_ORDER), key=abs)
    turning = {m: rms(_column(evidence, "sideslip in turns", m, _SAID)) for m in PAPER_ORDER}
    worst = max(turning, key=lambda m: turning[m])
    least = min(turning, key=lambda m: turning[m])
    share = {m: Spread.of(evidence.flight("turning_percent", m, "light")).mean for m in (worst, least)}
    return Reply(
        f"A steady {_SAID:g}° is a different pressure error, not a disturbance: the curve is {min(steady):.1f} "
        f"to {max(steady):.1f} kt wrong over the five maneuvers while the residual changes by "
        f"{signed(residual)} % at most. In turns only, it is worst in {NAMES[worst]} ({turning[worst]:.2f} kt; "
        f"{share[worst]:.0f} % of the data are turns) and least in {NAMES[least]} ({turning[least]:.2f} kt; "
        f"{share[least]:.0f} %).",
        tuple(_chart(evidence, kind) for kind in KINDS),
    )


SIDESLIP = Sweep("sideslip", "What does sideslip do, held throughout and in turns only?", _answer, looks)
