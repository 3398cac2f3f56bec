"""C11: the pilot's workload."""

import numpy as np
import pandas as pd

from pitotbench.evidence.study.claims.claim import Claim, Finding, verdict
from pitotbench.evidence.study.maneuver_names import NAMES, PAPER_ORDER, named
from pitotbench.evidence.study.study_tables import Spread, StudyTables, rank_agreement, signed
from pitotbench.units import Array

AIRPLANE = {"step_decrease": 4, "race_track": 2, "four_leg": 4, "rapid_decel": 2}  # Table 1
SIMULATOR = {"step_decrease": 3, "race_track": 2, "four_leg": 3, "circle": 4, "rapid_decel": 2}
MEASURES = {
    "reversals_a_minute": "control reversals [1/min]",
    "duty_percent": "seconds with a control moving [%]",
    "out_of_tolerance_percent": "out of tolerance [%]",
}

CONTROLS = {
    "reversals_elevator": "elevator reversals [1/min]",
    "reversals_aileron": "aileron reversals [1/min]",
    "reversals_throttle_left": "throttle reversals [1/min]",
}
PILOTS = {"autopilot": "autopilot alone", "smooth": "good pilot", "busy": "busy pilot"}
_AGREES = 0.5
_RATINGS = np.array([SIMULATOR[m] for m in PAPER_ORDER], dtype=np.float64)
AIRS = {"smooth": "smooth air", "light": "light turbulence"}


def _row(evidence: StudyTables, maneuver: str) -> dict[str, object]:
    row: dict[str, object] = {
        "Cooper-Harper, airplane": AIRPLANE.get(maneuver, "not flown"),
        "Cooper-Harper, simulator": SIMULATOR[maneuver],
    }
    for setting, air in AIRS.items():
        for measure, label in MEASURES.items():
            row[f"{label}, {air}"] = Spread.of(evidence.flight(measure, maneuver, setting)).text(1)
    return row


def _means(evidence: StudyTables, measure: str, setting: str = "smooth") -> Array:
    return np.array([Spread.of(evidence.flight(measure, m, setting)).mean for m in PAPER_ORDER])


def _experiment(evidence: StudyTables) -> pd.DataFrame:
    """Return Kendall's τ with the simulator's ratings, a row a measure and control, a column a pilot."""
    rows: list[dict[str, object]] = []
    for measure, label in {**MEASURES, **CONTROLS}.items():
        taus = {
            air: rank_agreement(_means(evidence, measure, setting), _RATINGS) for setting, air in PILOTS.items()
        }
        rows.append({"measure": label, **{f"τ, {air}": signed(tau) for air, tau in taus.items()}})
    return pd.DataFrame(rows)


def _lost(evidence: StudyTables) -> Array:
    """Return the time out of tolerance, busy pilot minus good pilot [%]: the cost of divided attention."""
    measure = "out_of_tolerance_percent"
    found = [evidence.flight(measure, m, "busy") - evidence.flight(measure, m) for m in PAPER_ORDER]
    return np.array([Spread.of(one).mean for one in found])


def _ratings(evidence: StudyTables) -> Finding:
    means = {k: _means(evidence, k) for k in MEASURES}
    taus = {measure: rank_agreement(values, _RATINGS) for measure, values in means.items()}
    busiest = {measure: NAMES[PAPER_ORDER[int(np.argmax(values))]] for measure, values in means.items()}
    agree = "; ".join(f"{label}: τ {signed(taus[k])}, highest in {busiest[k]}" for k, label in MEASURES.items())
    return Finding(
        verdict(*(tau > _AGREES for tau in taus.values())),
        f"measured, not rated, against the simulator's ratings: {agree}",
        _because(evidence),
        tables=(named({m: _row(evidence, m) for m in PAPER_ORDER}), _experiment(evidence)),
    )


def _because(evidence: StudyTables) -> str:
    """Explain the experiment: the same maneuvers without the person, and with other tasks for the pilot."""
    table = _experiment(evidence)
    taus = table.drop(columns="measure").apply(lambda c: c.str.replace("−", "-").astype(float)).to_numpy()
    none, good, busy = (_means(evidence, "reversals_a_minute", setting) for setting in PILOTS)
    lost = _lost(evidence)
    return (
        "The experiment takes the person out, and gives the person other things to do. Over the maneuvers the "
        f"controls reverse {min(none):.0f} to {max(none):.0f} times a minute with the autopilot alone, "
        f"{min(good):.0f} to {max(good):.0f} with the good pilot and {min(busy):.0f} to {max(busy):.0f} with the "
        f"busy one: on average the pilot changes the number by a factor of {np.mean(busy) / np.mean(none):.0f}, "
        f"the maneuver by {max(good) / min(good):.0f}. Over every measure, control and pilot τ runs from "
        f"{signed(float(taus.min()))} to {signed(float(taus.max()))} (ties among the ratings leave 0.8 as the "
        f"most), above {_AGREES:g} in {int((taus > _AGREES).sum())} of {taus.size}. What the busy pilot adds to "
        f"the time out of tolerance is most in {NAMES[PAPER_ORDER[int(np.argmax(lost))]]} ({max(lost):.1f} %), τ "
        f"{signed(rank_agreement(lost, _RATINGS))}. A rating is one person's opinion of a task in a cockpit (the "
        "paper's are of one pilot each, and turn on where the manifold-pressure gauges sit); the measures are not "
        "ratings. Stick and rudder are the autopilot's here, only their targets are a person's, and the throttle "
        "holds the speed of Circle, which the paper's pilot held by pitch at a fixed power."
    )


RATINGS = Claim(
    "C11",
    "Cooper-Harper, airplane/simulator: Step Decrease 4/3, Race Track 2/2, 4-Leg 4/3, Circle –/4, Rapid Decel 2/2",
    "Table 1",
    "each measure orders the maneuvers as the simulator's ratings do, τ above 0.5 (in part: one of them)",
    _ratings,
)
