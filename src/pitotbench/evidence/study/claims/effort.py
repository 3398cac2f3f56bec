"""C11: the pilot's workload."""

import numpy as np
import pandas as pd

from pitotbench.evidence.study.claims.claim import Claim, Finding, verdict
from pitotbench.evidence.study.claims.rank_power import best_agreement, by_chance, power
from pitotbench.evidence.study.maneuver_names import NAMES, PAPER_ORDER
from pitotbench.evidence.study.settings import FIXED_POWER
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
BY_THROTTLE = "standard"  # the card of Circle whose airspeed the throttle holds
_AGREES = 0.5
_RATINGS = np.array([SIMULATOR[m] for m in PAPER_ORDER], dtype=np.float64)
AIRS = {"smooth": "smooth air", "light": "light turbulence"}
_SCATTERS = (0.5, 1.0)  # ratings


def _by_seed(evidence: StudyTables, measure: str, maneuver: str, setting: str, circle: str) -> pd.Series:
    """Return a measure by seed; `circle` is the card of Circle."""
    return evidence.flight(measure, maneuver, setting, circle if maneuver == "circle" else "standard")


def _means(evidence: StudyTables, measure: str, setting: str = "smooth", circle: str = FIXED_POWER) -> Array:
    found = [_by_seed(evidence, measure, m, setting, circle) for m in PAPER_ORDER]
    return np.array([Spread.of(one).mean for one in found])


def _agreement(evidence: StudyTables, measure: str, setting: str = "smooth", circle: str = FIXED_POWER) -> float:
    return rank_agreement(_means(evidence, measure, setting, circle), _RATINGS)


def _measures(evidence: StudyTables) -> pd.DataFrame:
    """Return the ratings and the measures, a row for each maneuver, and Circle by both cards."""
    flown = [(NAMES[m], m, "standard") for m in PAPER_ORDER if m != "circle"]
    circles = [("Circle, fixed power", "circle", FIXED_POWER), ("Circle, speed by throttle", "circle", BY_THROTTLE)]
    rows = []
    for name, m, circle in (*flown, *circles):
        row: dict[str, object] = {
            "maneuver": name,
            "Cooper-Harper, airplane": AIRPLANE.get(m, "not flown"),
            "Cooper-Harper, simulator": SIMULATOR[m],
        }
        for setting, air in AIRS.items():
            for measure, label in MEASURES.items():
                row[f"{label}, {air}"] = Spread.of(_by_seed(evidence, measure, m, setting, circle)).text(1)
        rows.append(row)
    return pd.DataFrame(rows)


def _agreements(evidence: StudyTables) -> dict[str, dict[str, float]]:
    """Return Kendall's τ with the simulator's ratings, by measure or control, and by pilot and card of Circle."""
    columns = {f"τ, {pilot}": (setting, FIXED_POWER) for setting, pilot in PILOTS.items()}
    columns["τ, good pilot, Circle by throttle"] = ("smooth", BY_THROTTLE)
    return {
        label: {name: _agreement(evidence, measure, *how) for name, how in columns.items()}
        for measure, label in {**MEASURES, **CONTROLS}.items()
    }


def _ratings(evidence: StudyTables) -> Finding:
    means = {k: _means(evidence, k) for k in MEASURES}
    taus = {measure: rank_agreement(values, _RATINGS) for measure, values in means.items()}
    busiest = {measure: NAMES[PAPER_ORDER[int(np.argmax(values))]] for measure, values in means.items()}
    agree = "; ".join(f"{label}: τ {signed(taus[k])}, highest in {busiest[k]}" for k, label in MEASURES.items())
    found = _agreements(evidence)
    table = pd.DataFrame([{"measure": k, **{c: signed(t) for c, t in row.items()}} for k, row in found.items()])
    return Finding(
        verdict(*(tau > _AGREES for tau in taus.values())),
        f"measured, not rated, against the simulator's ratings: {agree}",
        "Fly Circle as the paper's pilot did: set the power in the turn before the circle begins, leave it there, "
        "and hold airspeed and altitude together by pitch. Fly it also with the throttle on airspeed. Fly every "
        "maneuver with the autopilot alone, the good pilot and the busy pilot.",
        f"{_fixed_power(evidence)} {_pilots(evidence, found)} {_test_power()} A rating is one person's opinion of "
        "a task in a cockpit, and the paper's depend on where the manifold-pressure gauges are. The measures are "
        "not ratings. The autopilot moves stick and rudder here; only their targets are a person's.",
        tables=(_measures(evidence), table),
    )


def _fixed_power(evidence: StudyTables) -> str:
    """Explain what fixed power changes in Circle."""
    text = {
        (measure, card): Spread.of(_by_seed(evidence, measure, "circle", "smooth", card)).text(1)
        for measure in ("out_of_tolerance_percent", "reversals_elevator", "reversals_throttle_left")
        for card in (BY_THROTTLE, FIXED_POWER)
    }

    def change(measure: str) -> str:
        return f"from {text[measure, BY_THROTTLE]} to {text[measure, FIXED_POWER]}"

    return (
        "Fixed power makes Circle harder to hold, with fewer hand movements: the good pilot's time out of "
        f"tolerance goes {change('out_of_tolerance_percent')} %, the elevator's reversals "
        f"{change('reversals_elevator')} a minute and the throttle's {change('reversals_throttle_left')}."
    )


def _pilots(evidence: StudyTables, found: dict[str, dict[str, float]]) -> str:
    """Explain how the measures depend on the pilot and on the maneuver."""
    taus = np.array([list(row.values()) for row in found.values()])
    none, good, busy = (_means(evidence, "reversals_a_minute", setting) for setting in PILOTS)
    return (
        f"The pilot matters more than the maneuver: the controls reverse {min(none):.0f} to {max(none):.0f} times "
        f"a minute with the autopilot alone, {min(good):.0f} to {max(good):.0f} with the good pilot and "
        f"{min(busy):.0f} to {max(busy):.0f} with the busy one. Over every measure, control, pilot and card τ "
        f"runs from {signed(float(taus.min()))} to {signed(float(taus.max()))}, above {_AGREES:g} in "
        f"{int((taus > _AGREES).sum())} of {taus.size}."
    )


def _test_power() -> str:
    """State the power of the rank test."""
    best = best_agreement(_RATINGS)
    chances = " and ".join(f"{power(_RATINGS, _AGREES, scatter):.0f} %" for scatter in _SCATTERS)
    return (
        f"The test is weak: five maneuvers have three different ratings, and τ cannot exceed {best:.1f}. A "
        f"measure without any relation to workload exceeds {_AGREES:g} in {by_chance(_RATINGS, _AGREES):.0f} % of "
        f"cases, and reaches {best:.1f} in {by_chance(_RATINGS, best - 0.01):.1f} %. A measure that is the "
        f"workload exceeds {_AGREES:g} in {chances} of cases, where one pilot's ratings scatter by "
        f"{_SCATTERS[0]:g} and by {_SCATTERS[1]:g}."
    )


RATINGS = Claim(
    "C11",
    "Cooper-Harper, airplane/simulator: Step Decrease 4/3, Race Track 2/2, 4-Leg 4/3, Circle –/4, Rapid Decel 2/2",
    "Table 1",
    f"each measure orders the maneuvers as the simulator's ratings do, τ above {_AGREES:g} (in part: one of them)",
    _ratings,
)
