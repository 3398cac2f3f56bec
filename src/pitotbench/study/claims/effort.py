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


def _ratings(evidence: Evidence) -> Finding:
    rows: dict[str, dict[str, object]] = {}
    means: dict[str, list[float]] = {measure: [] for measure in MEASURES}
    for maneuver in PAPER_ORDER:
        row: dict[str, object] = {
            "Cooper-Harper, airplane": AIRPLANE.get(maneuver, "not flown"),
            "Cooper-Harper, simulator": SIMULATOR[maneuver],
        }
        for setting, air in (("smooth", "smooth air"), ("light", "light turbulence")):
            for measure, label in MEASURES.items():
                found = Spread.of(evidence.flight(measure, maneuver, setting))
                row[f"{label}, {air}"] = found.text(1)
                if setting == "smooth":
                    means[measure].append(found.mean)
        rows[maneuver] = row
    ratings = np.array([SIMULATOR[m] for m in PAPER_ORDER], dtype=np.float64)
    taus = {measure: rank_agreement(np.array(values), ratings) for measure, values in means.items()}
    busiest = [NAMES[PAPER_ORDER[int(np.argmax(means[measure]))]] for measure in MEASURES]
    return Finding(
        verdict(*(tau > 0.5 for tau in taus.values())),
        "measured, not rated: "
        + "; ".join(
            f"{label} agree with the simulator's ratings at τ {taus[m]:+.1f}" for m, label in MEASURES.items()
        ),
        "A rating is one person's opinion of a task and a cockpit (the paper's is of one pilot each, and turns on "
        "where the manifold-pressure gauges sit); a pilot model has none. What can be measured is busiest in "
        f"{busiest[0]} (reversals), {busiest[1]} (moving controls) and {busiest[2]} (tolerances). Stick and rudder "
        "are the autopilot's here, only their targets are a person's, so the pitch and roll effort of Circle, which "
        "earned its 4, is not in these numbers.",
        tables=(named(rows),),
    )


RATINGS = Claim(
    "C11",
    "Cooper-Harper, airplane/simulator: Step Decrease 4/3, Race Track 2/2, 4-Leg 4/3, Circle –/4, Rapid Decel 2/2",
    "Table 1",
    "each measure orders the maneuvers as the simulator's ratings do, τ above 0.5 (in part: one of them)",
    _ratings,
)
