"""Which sampling rates are enough, from 0.2 to 200 Hz on both sides?"""

from functools import partial

import pandas as pd

from pitotbench.evidence.pages.chart_data import Lines
from pitotbench.evidence.study.charting import maneuver_lines
from pitotbench.evidence.study.looks import COVERING, PAPER, Look
from pitotbench.evidence.study.maneuver_names import NAMES
from pitotbench.evidence.study.study_tables import Spread, StudyTables
from pitotbench.evidence.study.sweeps.sweep import Reply, Sweep

FLOWN = ("step_decrease", "circle", "rapid_decel")
RATES = (0.2, 0.5, 1.0, 2.0, 5.0, 20.0, 50.0, 200.0)  # Hz
FASTEST = "200/200"
SIDES = {
    "both": ("air data and GPS alike", "air data and GPS [Hz]"),
    "air": ("air data, with the GPS at 1 Hz at most", "air data [Hz]"),
    "gps": ("GPS, with the air data at 200 Hz", "GPS [Hz]"),
}
KINDS = {
    "bound": ("two_sigma_kt", "covering", "Knowledge", "covering 2σ of the curve [kt]"),
    "residual": ("residual_two_sigma_kt", "paper", "Residual", "2σ of the residual [kt]"),
}


def system(side: str, rate: float) -> str:
    """Return the data system with a rate on one side. Its GPS is never faster than its air data."""
    return {"both": f"{rate:g}/{rate:g}", "air": f"{rate:g}/{min(rate, 1.0):g}", "gps": f"200/{rate:g}"}[side]


def looks(maneuver: str) -> tuple[Look, ...]:
    """Return looks at every rate of both sides, once. The claims already have the usual systems."""
    if maneuver not in FLOWN:
        return ()
    systems = dict.fromkeys(system(side, rate) for side in SIDES for rate in RATES)
    return tuple(Look(das, o) for das in systems for o in (COVERING, PAPER) if das not in ("20/1", "50/50"))


def _column(evidence: StudyTables, kind: str, maneuver: str, das: str) -> pd.Series:
    name, method, *_ = KINDS[kind]
    found = evidence.fit(name, maneuver, setting="light", method=method, das=das)
    few = evidence.fit(name, maneuver, setting="light", method=method, das=FASTEST).index
    return found[found.index.isin(few)]


def _at(evidence: StudyTables, kind: str, side: str, maneuver: str, rate: float) -> pd.Series:
    return _column(evidence, kind, maneuver, system(side, rate))


def _chart(evidence: StudyTables, kind: str, side: str) -> Lines:
    (*_, title, ylabel), (words, xlabel) = KINDS[kind], SIDES[side]
    name, number = f"sweep-rates-{side}-{kind}", partial(_at, evidence, kind, side)
    note = "Light turbulence, the same flights; noise a sample does not depend on the rate."
    return maneuver_lines(name, f"{title}: {words}", note, xlabel, ylabel, RATES, number, FLOWN, log_x=True)


def _answer(evidence: StudyTables) -> Reply:
    def mean(kind: str, maneuver: str, das: str) -> float:
        return Spread.of(_column(evidence, kind, maneuver, das)).mean

    def change(das: str) -> str:
        found = [mean("bound", m, das) / mean("bound", m, FASTEST) for m in FLOWN]
        return f"{das} Hz {min(found):.2f} to {max(found):.2f}"

    held, fast = mean("residual", "rapid_decel", "200/0.2"), mean("residual", "rapid_decel", FASTEST)
    return Reply(
        f"Against {FASTEST} Hz the covering 2σ in light turbulence is larger by a factor of "
        + ", at ".join(change(das) for das in ("0.2/0.2", "1/1", "5/5", "20/1"))
        + f" ({', '.join(NAMES[m] for m in FLOWN)}). The residual of the published method is another matter: in "
        f"Rapid Decel it goes from {fast:.2f} kt to {held:.2f} kt at 200/0.2 Hz, where each fix is held for five "
        "seconds.",
        tuple(_chart(evidence, kind, side) for kind in KINDS for side in SIDES),
    )


RATES_SWEEP = Sweep("sampling rates", "Which rates are enough, 0.2 to 200 Hz on both sides?", _answer, looks)
