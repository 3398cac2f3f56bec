"""C11: the pilot's workload."""

import numpy as np

from pitotbench.study.claims.claim import Claim, Finding, verdict
from pitotbench.study.evidence import Evidence, Spread, rank_agreement
from pitotbench.study.names import NAMES, PAPER_ORDER, named

AIRPLANE = {"step_decrease": 4, "race_track": 2, "four_leg": 4, "rapid_decel": 2}  # Table 1
SIMULATOR = {"step_decrease": 3, "race_track": 2, "four_leg": 3, "circle": 4, "rapid_decel": 2}
MEASURES = {
    "reversals_a_minute": "control reversals [1/min]",
    "duty_percent": "seconds with a control moving [%]",
    "out_of_tolerance_percent": "out of tolerance [%]",
}

_AGREES = 0.5
AIRS = {"smooth": "smooth air", "light": "light turbulence"}


def _row(evidence: Evidence, maneuver: str) -> dict[str, object]:
    row: dict[str, object] = {
        "Cooper-Harper, airplane": AIRPLANE.get(maneuver, "not flown"),
        "Cooper-Harper, simulator": SIMULATOR[maneuver],
    }
    for setting, air in AIRS.items():
        for measure, label in MEASURES.items():
            row[f"{label}, {air}"] = Spread.of(evidence.flight(measure, maneuver, setting)).text(1)
    return row


def _ratings(evidence: Evidence) -> Finding:
    ratings = np.array([SIMULATOR[m] for m in PAPER_ORDER], dtype=np.float64)
    means = {k: np.array([Spread.of(evidence.flight(k, m)).mean for m in PAPER_ORDER]) for k in MEASURES}
    taus = {measure: rank_agreement(values, ratings) for measure, values in means.items()}
    busiest = {measure: NAMES[PAPER_ORDER[int(np.argmax(values))]] for measure, values in means.items()}
    agree = "; ".join(f"{label}: τ {taus[k]:+.1f}, highest in {busiest[k]}" for k, label in MEASURES.items())
    return Finding(
        verdict(*(tau > _AGREES for tau in taus.values())),
        f"measured, not rated, against the simulator's ratings: {agree}",
        "A rating is one person's opinion of a task and a cockpit (the paper's are of one pilot each, and turn "
        "on where the manifold-pressure gauges sit); a pilot model has none, and the measures below are not "
        "ratings. Stick and rudder are the autopilot's here, only their targets are a person's, so the pitch "
        "and roll effort of Circle, which earned its 4, and the attention that the gauges of Step Decrease "
        "take, are not in these numbers.",
        tables=(named({m: _row(evidence, m) for m in PAPER_ORDER}),),
    )


RATINGS = Claim(
    "C11",
    "Cooper-Harper, airplane/simulator: Step Decrease 4/3, Race Track 2/2, 4-Leg 4/3, Circle –/4, Rapid Decel 2/2",
    "Table 1",
    "each measure orders the maneuvers as the simulator's ratings do, τ above 0.5 (in part: one of them)",
    _ratings,
)
