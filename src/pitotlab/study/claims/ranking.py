"""The claims that rank maneuvers: by time, by residual, by the pilot's effort."""

import numpy as np
import pandas as pd

from pitotbench.sensing.sampling import SYSTEMS
from pitotbench.units import Array
from pitotlab.study.claims.sampling import expected_noise
from pitotlab.study.questions import Claim, Finding, best_agreement, by_chance, power, verdict
from pitotlab.study.reductions import (
    FIXED_POWER,
    NAMES,
    PAPER_ORDER,
    SETTINGS,
    SPECIFICATION,
    named,
)
from pitotlab.study.tables import Spread, StudyTables, maneuver_bars, rank_agreement, ratio, signed

SIMULATOR_MINUTES = {
    "rapid_decel": 5.0,
    "step_decrease": 6.0,
    "circle": 6.0,
    "race_track": 15.0,
    "four_leg": 21.0,
}
AIRPLANE_MINUTES = {
    "rapid_decel": 4.0,
    "step_decrease": 6.0,
    "race_track": 16.5,
    "four_leg": 28.0,
}  # Table 2
_CLOSE = 1.0  # min: the table has whole minutes
_QUARTER = (0.20, 0.33)

_TWO_TIMES = (
    "Table 2 has 28 minutes of 4-Leg in the airplane against 21 in the simulator, and no reason "
    "for it. Both are four circuits of the 5 to 7 minutes that section III.A states; only the "
    "simulator's are held here. Section III.E calls Step Decrease the shortest maneuver, where "
    "Table 2 has Rapid Decel, with 4 and 5 minutes against 6 and 6."
)


def _times(evidence: StudyTables) -> Finding:
    ours = {m: Spread.of(evidence.flight("minutes", m)) for m in PAPER_ORDER}
    off = {m: ours[m].mean - SIMULATOR_MINUTES[m] for m in PAPER_ORDER}
    table = named(
        lambda m: {
            "paper's simulator [min]": SIMULATOR_MINUTES[m],
            "paper's airplane [min]": AIRPLANE_MINUTES.get(m, "not flown"),
            "ours [min]": ours[m].text(1),
        }
    )
    worst = max(PAPER_ORDER, key=lambda m: abs(off[m]))
    chart = maneuver_bars(
        "table2-times", "Table 2: flight times", "Turns included, set-up between speeds "
                                                 "not.", "time [min]",
        [("smooth", "ours")], lambda m, s: evidence.flight("minutes", m, s),
    )  # fmt: skip
    return Finding(
        verdict(all(abs(d) <= _CLOSE for d in off.values())),
        ", ".join(f"{NAMES[m]} {ours[m].text(1)}" for m in SIMULATOR_MINUTES) + " min",
        "Fly every maneuver in smooth air with the good pilot and time what is recorded: turns "
        "count, the set-up "
        "between speeds does not.",
        f"The largest difference is {signed(off[worst])} min ({NAMES[worst]}). The paper does not "
        "state the dwell, "
        "the settling time or the turn rate. Our cards choose them so that the times agree. This "
        f"checks the cards and is no finding. {_TWO_TIMES}",
        (chart,),
        (table,),
    )


def _quarter(evidence: StudyTables) -> Finding:
    share = ratio(
        evidence.flight("minutes", "step_decrease"), evidence.flight("minutes", "four_leg")
    )
    step, four = SIMULATOR_MINUTES["step_decrease"], SIMULATOR_MINUTES["four_leg"]
    return Finding(
        verdict(_QUARTER[0] <= share.mean <= _QUARTER[1]),
        f"{share.text(2)} of the time of 4-Leg",
        "Compare the times of the two maneuvers in the flights of C1.",
        f"The paper's own simulator took {step:g} and {four:g} minutes, a ratio of "
        f"{step / four:.2f}. "
        "Its airplane has a ratio of "
        f"{AIRPLANE_MINUTES['step_decrease'] / AIRPLANE_MINUTES['four_leg']:.2f}.",
    )


TIMES = Claim(
    "C1",
    "Flight times in the simulator, minutes: Rapid Decel 5, Step Decrease 6, Circle 6, Race Track "
    "15, 4-Leg 21",
    "Table 2",
    "every time within one minute",
    _times,
)
QUARTER = Claim(
    "C13",
    "Step Decrease takes about one fourth of the time of 4-Leg",
    "§IV",
    "the ratio of the times lies between 0.20 and 0.33",
    _quarter,
)


_TAU = "Kendall's τ with the paper"


def _mean_residuals(evidence: StudyTables, **how: object) -> list[float]:
    return [Spread.of(evidence.residual(m, **how)).mean for m in PAPER_ORDER]


def _order(values: list[float]) -> str:
    return " < ".join(NAMES[PAPER_ORDER[i]] for i in np.argsort(values))


def _agreement_with_order(values: list[float]) -> float:
    return rank_agreement(np.array(values), np.arange(len(values), dtype=np.float64))


def _asked() -> list[tuple[str, dict[str, object]]]:
    """Return the reductions for the order: every air, pilot, data system, part of the data and noise."""
    asked: list[tuple[str, dict[str, object]]] = []
    for setting, air in SETTINGS.items():
        if set(air.flown) == set(PAPER_ORDER):
            asked += [(f"{air.what}, {das}", {"setting": setting, "das": das}) for das in SYSTEMS]
    for setting in ("smooth", "light"):
        label = f"{SETTINGS[setting].what}, 50/50, on-condition"
        asked.append((label, {"setting": setting, "on_condition": True}))
    asked += [
        (f"smooth air, {das}, a tenth of the noise", {"das": das, "noise": SPECIFICATION})
        for das in SYSTEMS
    ]
    return asked


def _experiments(evidence: StudyTables) -> pd.DataFrame:
    """Return the 2σ of each maneuver, their order and its agreement with the paper's, a row for
    each reduction.
    """
    rows = []
    for label, how in _asked():
        values = _mean_residuals(evidence, **how)
        if np.all(np.isfinite(values)):
            numbers = dict(
                zip([NAMES[m] for m in PAPER_ORDER], [f"{v:.3f}" for v in values], strict=True)
            )
            row = {"flown and sensed": label, **numbers, "order": _order(values)}
            rows.append({**row, _TAU: signed(_agreement_with_order(values))})
    return pd.DataFrame(rows)


def _ranking(evidence: StudyTables) -> Finding:
    smooth = {das: _mean_residuals(evidence, das=das) for das in SYSTEMS}
    first = {das: PAPER_ORDER[int(np.argmin(values))] for das, values in smooth.items()}
    usual, table = smooth["50/50"], _experiments(evidence)
    held = bool(np.all(np.diff(usual) > 0.0))
    return Finding(
        verdict(held, first["50/50"] == "step_decrease"),
        f"50/50 Hz: {_order(usual)} ({_values(evidence)} kt); "
        f"Kendall's τ with the paper {signed(_agreement_with_order(usual))}",
        f"Fit all five maneuvers in {len(table)} combinations of air, pilot, data rate, noise, and "
        "turns in or "
        "out. Compute also, without any fit, what the injected pressure noise is in knots at the "
        "speeds flown.",
        "Step Decrease has the smallest residual at "
        f"{sum(m == 'step_decrease' for m in first.values())} of "
        f"{len(SYSTEMS)} data rates. {_because(evidence, usual, table)}",
        tables=(table,),
    )


def _values(evidence: StudyTables) -> str:
    """Return the 2σ at 50/50 Hz in words, the smallest first."""
    found = sorted((Spread.of(evidence.residual(m)) for m in PAPER_ORDER), key=lambda s: s.mean)
    return ", ".join(spread.text(3) for spread in found)


def _because(evidence: StudyTables, usual: list[float], table: pd.DataFrame) -> str:
    taus = table[_TAU].str.replace("−", "-").astype(float)
    noise = [expected_noise(evidence, m, "standard") for m in PAPER_ORDER]
    quiet = _mean_residuals(evidence, noise=SPECIFICATION)
    held, quick = (
        Spread.of(evidence.residual("rapid_decel", das=das)).mean for das in ("20/1", "50/50")
    )
    spline = Spread.of(
        evidence.fit("smooth_two_sigma_kt", "rapid_decel", das="20/1", method="covering")
    ).mean
    slowing = Spread.of(evidence.flight("slowing_kt_a_second", "rapid_decel")).mean
    return (
        f"Over the combinations τ with the paper's order runs from {signed(taus.min())} to "
        f"{signed(taus.max())}. "
        "The injected noise makes the order: it is the same in pascals for all, and so more knots "
        "where a maneuver "
        f"flies slowly. Without any fit it gives {_order(noise)} "
        f"({', '.join(f'{v:.2f}' for v in sorted(noise))} kt), which agrees with the order found "
        "at 50/50 Hz at τ "
        f"{signed(rank_agreement(np.array(noise), np.array(usual)))}. With a tenth of the noise "
        "all five lie "
        f"between {min(quiet):.3f} and {max(quiet):.3f} kt. Rapid Decel has {quick:.2f} kt at "
        "50/50 Hz and "
        f"{held:.2f} kt at 20/1 Hz. There a velocity is held for a second while it falls by up to "
        f"{slowing:.1f} "
        f"kt/s; with the fixes interpolated it has {spline:.2f} kt."
    )


RANKING = Claim(
    "C2",
    "2σ of the residual: Step Decrease < Circle < Rapid Decel < Race Track < 4-Leg",
    "Figs 9, 10",
    "the same order at 50/50 Hz (in part: Step Decrease first)",
    _ranking,
)


AIRPLANE_RATINGS = {"step_decrease": 4, "race_track": 2, "four_leg": 4, "rapid_decel": 2}  # Table 1
SIMULATOR_RATINGS = {
    "step_decrease": 3,
    "race_track": 2,
    "four_leg": 3,
    "circle": 4,
    "rapid_decel": 2,
}
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
_RATINGS = np.array([SIMULATOR_RATINGS[m] for m in PAPER_ORDER], dtype=np.float64)
AIRS = {"smooth": "smooth air", "light": "light turbulence"}
_SCATTERS = (0.5, 1.0)  # ratings


def _by_seed(
    evidence: StudyTables, measure: str, maneuver: str, setting: str, circle: str
) -> pd.Series:
    """Return a measure by seed; `circle` is the card of Circle."""
    return evidence.flight(
        measure, maneuver, setting, circle if maneuver == "circle" else "standard"
    )


def _mean_workloads(
    evidence: StudyTables, measure: str, setting: str = "smooth", circle: str = FIXED_POWER
) -> Array:
    found = [_by_seed(evidence, measure, m, setting, circle) for m in PAPER_ORDER]
    return np.array([Spread.of(one).mean for one in found])


def _agreement_with_ratings(
    evidence: StudyTables, measure: str, setting: str = "smooth", circle: str = FIXED_POWER
) -> float:
    return rank_agreement(_mean_workloads(evidence, measure, setting, circle), _RATINGS)


def _measures(evidence: StudyTables) -> pd.DataFrame:
    """Return the ratings and the measures, a row for each maneuver, and Circle by both cards."""
    flown = [(NAMES[m], m, "standard") for m in PAPER_ORDER if m != "circle"]
    circles = [
        ("Circle, fixed power", "circle", FIXED_POWER),
        ("Circle, speed by throttle", "circle", BY_THROTTLE),
    ]
    rows = []
    for name, m, circle in (*flown, *circles):
        row: dict[str, object] = {
            "maneuver": name,
            "Cooper-Harper, airplane": AIRPLANE_RATINGS.get(m, "not flown"),
            "Cooper-Harper, simulator": SIMULATOR_RATINGS[m],
        }
        for setting, air in AIRS.items():
            for measure, label in MEASURES.items():
                row[f"{label}, {air}"] = Spread.of(
                    _by_seed(evidence, measure, m, setting, circle)
                ).text(1)
        rows.append(row)
    return pd.DataFrame(rows)


def _agreements(evidence: StudyTables) -> dict[str, dict[str, float]]:
    """Return Kendall's τ with the simulator's ratings, by measure or control, and by pilot and card
    of Circle.
    """
    columns = {f"τ, {pilot}": (setting, FIXED_POWER) for setting, pilot in PILOTS.items()}
    columns["τ, good pilot, Circle by throttle"] = ("smooth", BY_THROTTLE)
    return {
        label: {
            name: _agreement_with_ratings(evidence, measure, *how) for name, how in columns.items()
        }
        for measure, label in {**MEASURES, **CONTROLS}.items()
    }


def _ratings(evidence: StudyTables) -> Finding:
    means = {k: _mean_workloads(evidence, k) for k in MEASURES}
    taus = {measure: rank_agreement(values, _RATINGS) for measure, values in means.items()}
    busiest = {
        measure: NAMES[PAPER_ORDER[int(np.argmax(values))]] for measure, values in means.items()
    }
    agree = "; ".join(
        f"{label}: τ {signed(taus[k])}, highest in {busiest[k]}" for k, label in MEASURES.items()
    )
    found = _agreements(evidence)
    table = pd.DataFrame(
        [{"measure": k, **{c: signed(t) for c, t in row.items()}} for k, row in found.items()]
    )
    return Finding(
        verdict(*(tau > _AGREES for tau in taus.values())),
        f"measured, not rated, against the simulator's ratings: {agree}",
        "Fly Circle as the paper's pilot did: set the power in the turn before the circle begins, "
        "leave it there, "
        "and hold airspeed and altitude together by pitch. Fly it also with the throttle on "
        "airspeed. Fly every "
        "maneuver with the autopilot alone, the good pilot and the busy pilot.",
        f"{_fixed_power(evidence)} {_pilots(evidence, found)} {_test_power()} {_CONTRADICTION} "
        f"{_NO_RULE} A rating "
        "is one person's opinion of "
        "a task in a cockpit, and the paper's depend on where the manifold-pressure gauges are. "
        "The measures are "
        "not ratings. The autopilot moves stick and rudder here; only their targets are a "
        "person's.",
        tables=(_measures(evidence), table),
    )


_CONTRADICTION = (
    "The paper contradicts itself here. Its section IV says that Step Decrease and Circle had more "
    "workload than "
    "4-Leg; its Table 1 rates Step Decrease and 4-Leg alike, 4 in the airplane and 3 in the "
    "simulator; its section "
    "III.A calls the workload of 4-Leg the highest in general. Only Circle, in the simulator, is "
    "rated above 4-Leg."
)
_NO_RULE = (
    "No published rule that makes a rating from a structural pilot is added. Those of Anderson "
    "(1970), Neal and "
    "Smith (1970) and Hess (1980s on) rate one tracking task from the loop of airplane and stick. "
    "All five "
    "maneuvers have the same loop; they differ in their scan, length and gauges, for which the "
    "rules have no "
    "term. Weights fitted to five ratings of three values could not fail."
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
        "Fixed power makes Circle harder to hold, with fewer hand movements: the good pilot's time "
        "out of "
        f"tolerance goes {change('out_of_tolerance_percent')} %, the elevator's reversals "
        f"{change('reversals_elevator')} a minute and the throttle's "
        f"{change('reversals_throttle_left')}."
    )


def _pilots(evidence: StudyTables, found: dict[str, dict[str, float]]) -> str:
    """Explain how the measures depend on the pilot and on the maneuver."""
    taus = np.array([list(row.values()) for row in found.values()])
    none, good, busy = (
        _mean_workloads(evidence, "reversals_a_minute", setting) for setting in PILOTS
    )
    return (
        f"The pilot matters more than the maneuver: the controls reverse {min(none):.0f} to "
        f"{max(none):.0f} times "
        f"a minute with the autopilot alone, {min(good):.0f} to {max(good):.0f} with the good "
        "pilot and "
        f"{min(busy):.0f} to {max(busy):.0f} with the busy one. Over every measure, control, pilot "
        "and card τ "
        f"runs from {signed(float(taus.min()))} to {signed(float(taus.max()))}, above {_AGREES:g} "
        "in "
        f"{int((taus > _AGREES).sum())} of {taus.size}."
    )


def _test_power() -> str:
    """State the power of the rank test."""
    best = best_agreement(_RATINGS)
    chances = " and ".join(f"{power(_RATINGS, _AGREES, scatter):.0f} %" for scatter in _SCATTERS)
    return (
        "The test is weak: five maneuvers have three different ratings, and τ cannot exceed "
        f"{best:.1f}. A "
        f"measure without any relation to workload exceeds {_AGREES:g} in "
        f"{by_chance(_RATINGS, _AGREES):.0f} % of "
        f"cases, and reaches {best:.1f} in {by_chance(_RATINGS, best - 0.01):.1f} %. A measure "
        "that is the "
        f"workload exceeds {_AGREES:g} in {chances} of cases, where one pilot's ratings scatter by "
        f"{_SCATTERS[0]:g} and by {_SCATTERS[1]:g}."
    )


RATINGS = Claim(
    "C11",
    "Cooper-Harper, airplane/simulator: Step Decrease 4/3, Race Track 2/2, 4-Leg 4/3, Circle –/4, "
    "Rapid Decel 2/2",
    "Table 1",
    f"each measure orders the maneuvers as the simulator's ratings do, τ above {_AGREES:g} (in "
    "part: one of them)",
    _ratings,
)
