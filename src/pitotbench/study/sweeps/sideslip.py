"""What does sideslip do, held throughout and in turns only?"""

import pandas as pd

from pitotbench.study.changes import SIDESLIP_ERROR
from pitotbench.study.charting import maneuver_lines
from pitotbench.study.evidence import Evidence, percent
from pitotbench.study.look import COVERING, PAPER, Look
from pitotbench.study.names import NAMES, PAPER_ORDER
from pitotbench.study.sweeps.sweep import Reply, Sweep, rms

ANGLES = (2.0, 4.0, 6.0, 8.0)  # degrees
KINDS = {"steady sideslip": "held throughout", "sideslip in turns": "in turns only"}


def looks(maneuver: str) -> tuple[Look, ...]:
    """Every angle, throughout and in turns."""
    return tuple(Look("50/50", o, kind, angle) for kind in KINDS for angle in ANGLES for o in (COVERING, PAPER))


def _column(evidence: Evidence, column: str, maneuver: str, kind: str, angle: float, method: str) -> pd.Series:
    how: dict[str, object] = {"change": kind, "level": angle} if angle else {}
    found = evidence.fit(column, maneuver, setting="light", method=method, **how)
    few = evidence.fit(column, maneuver, setting="light", method=method, change=kind, level=ANGLES[0]).index
    return found[found.index.isin(few)]


def _answer(evidence: Evidence) -> Reply:
    charts = tuple(
        maneuver_lines(
            f"sweep-{kind.replace(' ', '-')}", f"Sideslip {words}",
            f"A probe that loses {100.0 * SIDESLIP_ERROR:g} % of q_c a degree squared (our estimate); light turbulence.",
            "sideslip [°]", "rms error of the curve [kt]", (0.0, *ANGLES),
            lambda m, angle, kind=kind: _column(evidence, "rms_error_kt", m, kind, angle, "covering"),
        )
        for kind, words in KINDS.items()
    )  # fmt: skip
    angle = ANGLES[1]
    steady = [rms(_column(evidence, "rms_error_kt", m, "steady sideslip", angle, "covering")) for m in PAPER_ORDER]
    residual = [
        percent(
            *(_column(evidence, "residual_two_sigma_kt", m, "steady sideslip", a, "paper") for a in (angle, 0.0))
        ).mean
        for m in PAPER_ORDER
    ]
    turning = {
        m: rms(_column(evidence, "rms_error_kt", m, "sideslip in turns", angle, "covering")) for m in PAPER_ORDER
    }
    worst = max(turning, key=lambda m: turning[m])
    return Reply(
        f"A steady {angle:g}° is a different pressure error, not a disturbance: the curve moves by {min(steady):.1f} to "
        f"{max(steady):.1f} kt in every maneuver while the residual changes by {max(residual, key=abs):+.1f} % at most, so "
        f"nothing in the data tells. In turns only, it spoils {NAMES[worst]} most ({turning[worst]:.2f} kt), whose curve is "
        "made of turn data; the others should be fitted on condition.",
        charts,
    )


SIDESLIP = Sweep("sideslip", "What does sideslip do, held throughout and in turns only?", _answer, looks)
