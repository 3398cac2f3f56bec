"""The claims that rank maneuvers: by time, by residual, by the pilot's effort."""

from collections.abc import Iterator, Sequence
from functools import partial
from itertools import permutations

import numpy as np
import pandas as pd

from pitotbench.sensing.sampling import SYSTEMS
from pitotbench.units import Array
from pitotlab.study.claims.sampling import expected_noise
from pitotlab.study.questions import Claim, Finding
from pitotlab.study.reductions import (
    FIXED_POWER,
    NAMES,
    PAPER_ORDER,
    SETTINGS,
    SPECIFICATION,
    named,
)
from pitotlab.study.rules import RATED, RULES
from pitotlab.study.tables import (
    Spread,
    StudyTables,
    mean,
    order,
    rank_agreement,
    ratio,
    signed,
    text,
)

# Table 2 of the paper [min].
SIMULATOR_MINUTES = {
    "rapid_decel": 5.0,
    "step_decrease": 6.0,
    "circle": 6.0,
    "race_track": 15.0,
    "four_leg": 21.0,
}
AIRPLANE_MINUTES = {"rapid_decel": 4.0, "step_decrease": 6.0, "race_track": 16.5, "four_leg": 28.0}

_TWO_TIMES = (
    "Table 2 has 28 minutes of 4-Leg in the airplane against 21 in the simulator, and no reason "
    "for it. Both are four circuits of the 5 to 7 minutes that section III.A states; only the "
    "simulator's are held here. Section III.E calls Step Decrease the shortest maneuver, where "
    "Table 2 has Rapid Decel, with 4 and 5 minutes against 6 and 6."
)


@partial(Claim, RULES["C1"])
def times(evidence: StudyTables) -> Finding:
    ours = {m: Spread.of(evidence.flight("minutes", m)) for m in PAPER_ORDER}
    off = {m: ours[m].mean - SIMULATOR_MINUTES[m] for m in PAPER_ORDER}
    worst = max(PAPER_ORDER, key=lambda m: abs(off[m]))
    table = named(
        lambda m: {
            "paper's simulator [min]": SIMULATOR_MINUTES[m],
            "paper's airplane [min]": AIRPLANE_MINUTES.get(m, "not flown"),
            "ours [min]": ours[m].text(1),
        }
    )
    return Finding(
        RULES["C1"].judge([*off.values()]),
        ", ".join(f"{NAMES[m]} {ours[m].text(1)}" for m in SIMULATOR_MINUTES) + " min",
        "Fly every maneuver in smooth air with the good pilot and time what is recorded: turns "
        "count, the set-up between speeds does not.",
        f"The largest difference is {signed(off[worst])} min ({NAMES[worst]}). The paper does not "
        "state the dwell, the settling time or the turn rate. Our cards choose them so that the "
        f"times agree. This checks the cards and is no finding. {_TWO_TIMES}",
        (table,),
    )


@partial(Claim, RULES["C13"])
def quarter(evidence: StudyTables) -> Finding:
    pair = ("step_decrease", "four_leg")
    share = ratio(*(evidence.flight("minutes", m) for m in pair))
    step, four = (SIMULATOR_MINUTES[m] for m in pair)
    airplane = AIRPLANE_MINUTES["step_decrease"] / AIRPLANE_MINUTES["four_leg"]
    return Finding(
        RULES["C13"].judge(share.mean),
        f"{share.text(2)} of the time of 4-Leg",
        "Compare the times of the two maneuvers in the flights of C1.",
        f"The paper's own simulator took {step:g} and {four:g} minutes, a ratio of "
        f"{step / four:.2f}. Its airplane has a ratio of {airplane:.2f}.",
    )


_TAU = "Kendall's τ with the paper"


def _residuals(evidence: StudyTables, **how: object) -> dict[str, float]:
    return {m: mean(evidence.residual(m, **how)) for m in PAPER_ORDER}


def _agreement_with_order(values: Sequence[float]) -> float:
    return rank_agreement(np.array(values), np.arange(len(values), dtype=np.float64))


def _asked() -> Iterator[tuple[str, dict[str, object]]]:
    """Yield the reductions for the order: every air, pilot, data system, part of the data, noise."""
    for setting, air in SETTINGS.items():
        if set(air.flown) == set(PAPER_ORDER):
            for das in SYSTEMS:
                yield f"{air.what}, {das}", {"setting": setting, "das": das}
    for setting in ("smooth", "light"):
        how = {"setting": setting, "on_condition": True}
        yield f"{SETTINGS[setting].what}, 50/50, on-condition", how
    for das in SYSTEMS:
        yield f"smooth air, {das}, a tenth of the noise", {"das": das, "noise": SPECIFICATION}


def _experiments(evidence: StudyTables) -> pd.DataFrame:
    """Return each maneuver's 2σ, their order and its agreement with the paper's, by reduction."""
    rows = []
    for label, how in _asked():
        found = _residuals(evidence, **how)
        if np.all(np.isfinite([*found.values()])):
            numbers = {NAMES[m]: f"{value:.3f}" for m, value in found.items()}
            row = {"flown and sensed": label, **numbers, "order": order(found)}
            rows.append({**row, _TAU: signed(_agreement_with_order([*found.values()]))})
    return pd.DataFrame(rows)


@partial(Claim, RULES["C2"])
def ranking(evidence: StudyTables) -> Finding:
    smooth = {das: _residuals(evidence, das=das) for das in SYSTEMS}
    first = [min(found, key=lambda m: found[m]) for found in smooth.values()]
    usual, table = smooth["50/50"], _experiments(evidence)
    values = [*usual.values()]
    spreads = (Spread.of(evidence.residual(m)) for m in PAPER_ORDER)
    told = ", ".join(s.text(3) for s in sorted(spreads, key=lambda s: s.mean))
    taus = table[_TAU].str.replace("−", "-").astype(float)
    noise = {m: expected_noise(evidence, m) for m in PAPER_ORDER}
    alike = rank_agreement(np.array([*noise.values()]), np.array(values))
    quiet = _residuals(evidence, noise=SPECIFICATION).values()
    held = mean(evidence.residual("rapid_decel", das="20/1"))
    how = {"das": "20/1", "method": "covering"}
    spline = mean(evidence.fit("smooth_two_sigma_kt", "rapid_decel", **how))
    slowing = mean(evidence.flight("slowing_kt_a_second", "rapid_decel"))
    return Finding(
        RULES["C2"].judge(values),
        f"50/50 Hz: {order(usual)} ({told} kt); Kendall's τ with the paper "
        f"{signed(_agreement_with_order(values))}",
        f"Fit all five maneuvers in {len(table)} combinations of air, pilot, data rate, noise, and "
        "turns in or out. Compute also, without any fit, what the injected pressure noise is in "
        "knots at the speeds flown.",
        f"Step Decrease has the smallest residual at {first.count('step_decrease')} of "
        f"{len(SYSTEMS)} data rates. Over the combinations τ with the paper's order runs from "
        f"{signed(taus.min())} to {signed(taus.max())}. The injected noise makes the order: it is "
        "the same in pascals for all, and so more knots where a maneuver flies slowly. Without any "
        f"fit it gives {order(noise)} ({', '.join(f'{v:.2f}' for v in sorted(noise.values()))} kt), "
        f"which agrees with the order found at 50/50 Hz at τ {signed(alike)}. With a tenth of the "
        f"noise all five lie between {min(quiet):.3f} and {max(quiet):.3f} kt. Rapid Decel has "
        f"{usual['rapid_decel']:.2f} kt at 50/50 Hz and {held:.2f} kt at 20/1 Hz. There a velocity "
        f"is held for a second while it falls by up to {slowing:.1f} kt/s; with the fixes "
        f"interpolated it has {spline:.2f} kt.",
        tables=(table,),
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
AIRS = {"smooth": "smooth air", "light": "light turbulence"}
_RATINGS = np.array([SIMULATOR_RATINGS[m] for m in PAPER_ORDER], dtype=np.float64)
_SCATTERS = (0.5, 1.0)  # ratings
_ABOVE = RATED - 0.1  # τ of five without ties goes by steps of 0.2
_DRAWS, _SEED = 20_000, 83


def _by_seed(
    evidence: StudyTables, measure: str, maneuver: str, setting: str, circle: str
) -> pd.Series:
    """Return a measure by seed; `circle` is the card of Circle."""
    card = circle if maneuver == "circle" else "standard"
    return evidence.flight(measure, maneuver, setting, card)


def _workloads(
    evidence: StudyTables, measure: str, setting: str = "smooth", circle: str = FIXED_POWER
) -> Array:
    """Return the mean of a measure for each maneuver."""
    return np.array([mean(_by_seed(evidence, measure, m, setting, circle)) for m in PAPER_ORDER])


def _measures(evidence: StudyTables) -> pd.DataFrame:
    """Return the ratings and the measures, a row for each maneuver, and Circle by both cards."""
    flown = [(NAMES[m], m, "standard") for m in PAPER_ORDER if m != "circle"]
    flown += [("Circle, fixed power", "circle", FIXED_POWER)]
    flown += [("Circle, speed by throttle", "circle", BY_THROTTLE)]
    rows = []
    for name, m, circle in flown:
        row: dict[str, object] = {
            "maneuver": name,
            "Cooper-Harper, airplane": AIRPLANE_RATINGS.get(m, "not flown"),
            "Cooper-Harper, simulator": SIMULATOR_RATINGS[m],
        }
        for setting, air in AIRS.items():
            for measure, label in MEASURES.items():
                found = _by_seed(evidence, measure, m, setting, circle)
                row[f"{label}, {air}"] = text(found, 1)
        rows.append(row)
    return pd.DataFrame(rows)


def _agreements(evidence: StudyTables) -> pd.DataFrame:
    """Return τ with the ratings: a row a measure, a column a pilot and card of Circle."""
    columns = {f"τ, {pilot}": (setting, FIXED_POWER) for setting, pilot in PILOTS.items()}
    columns["τ, good pilot, Circle by throttle"] = ("smooth", BY_THROTTLE)
    rows = {
        label: [
            rank_agreement(_workloads(evidence, key, *how), _RATINGS) for how in columns.values()
        ]
        for key, label in {**MEASURES, **CONTROLS}.items()
    }
    return pd.DataFrame.from_dict(rows, orient="index", columns=[*columns])


@partial(Claim, RULES["C11"])
def ratings(evidence: StudyTables) -> Finding:
    means = {k: _workloads(evidence, k) for k in MEASURES}
    taus = {k: rank_agreement(values, _RATINGS) for k, values in means.items()}
    busiest = {k: NAMES[PAPER_ORDER[int(np.argmax(values))]] for k, values in means.items()}
    agree = "; ".join(
        f"{label}: τ {signed(taus[k])}, highest in {busiest[k]}" for k, label in MEASURES.items()
    )
    found = _agreements(evidence)
    table = found.map(signed).rename_axis("measure").reset_index()
    return Finding(
        RULES["C11"].judge([*taus.values()]),
        f"measured, not rated, against the simulator's ratings: {agree}",
        "Fly Circle as the paper's pilot did: set the power in the turn before the circle begins, "
        "leave it there, and hold airspeed and altitude together by pitch. Fly it also with the "
        "throttle on airspeed. Fly every maneuver with the autopilot alone, the good pilot and the "
        "busy pilot.",
        f"{_fixed_power(evidence)} {_pilots(evidence, found.to_numpy())} {_test_power()} "
        f"{_CONTRADICTION} {_NO_RULE} A rating is one person's opinion of a task in a cockpit, and "
        "the paper's depend on where the manifold-pressure gauges are. The measures are not "
        "ratings. The autopilot moves stick and rudder here; only their targets are a person's.",
        tables=(_measures(evidence), table),
    )


_CONTRADICTION = (
    "The paper contradicts itself here. Its section IV says that Step Decrease and Circle had more "
    "workload than 4-Leg; its Table 1 rates Step Decrease and 4-Leg alike, 4 in the airplane and 3 "
    "in the simulator; its section III.A calls the workload of 4-Leg the highest in general. Only "
    "Circle, in the simulator, is rated above 4-Leg."
)
_NO_RULE = (
    "No published rule that makes a rating from a structural pilot is added. Those of Anderson "
    "(1970), Neal and Smith (1970) and Hess (1980s on) rate one tracking task from the loop of "
    "airplane and stick. All five maneuvers have the same loop; they differ in their scan, length "
    "and gauges, for which the rules have no term. Weights fitted to five ratings of three values "
    "could not fail."
)


def _fixed_power(evidence: StudyTables) -> str:
    """Explain what fixed power changes in Circle."""

    def change(measure: str) -> str:
        cards = (BY_THROTTLE, FIXED_POWER)
        found = [text(_by_seed(evidence, measure, "circle", "smooth", c), 1) for c in cards]
        return f"from {found[0]} to {found[1]}"

    return (
        "Fixed power makes Circle harder to hold, with fewer hand movements: the good pilot's time "
        f"out of tolerance goes {change('out_of_tolerance_percent')} %, the elevator's reversals "
        f"{change('reversals_elevator')} a minute and the throttle's "
        f"{change('reversals_throttle_left')}."
    )


def _pilots(evidence: StudyTables, taus: Array) -> str:
    """Explain how the measures depend on the pilot and on the maneuver."""
    none, good, busy = (_workloads(evidence, "reversals_a_minute", setting) for setting in PILOTS)
    return (
        f"The pilot matters more than the maneuver: the controls reverse {min(none):.0f} to "
        f"{max(none):.0f} times a minute with the autopilot alone, {min(good):.0f} to "
        f"{max(good):.0f} with the good pilot and {min(busy):.0f} to {max(busy):.0f} with the busy "
        "one. Over every measure, control, pilot and card τ runs from "
        f"{signed(float(taus.min()))} to {signed(float(taus.max()))}, at least {RATED:g} in "
        f"{int((taus >= RATED).sum())} of {taus.size}."
    )


def _test_power() -> str:
    """State the power of the rank test."""
    best = best_agreement(_RATINGS)
    chances = " and ".join(f"{power(_RATINGS, _ABOVE, scatter):.0f} %" for scatter in _SCATTERS)
    return (
        "The test is weak: five maneuvers have three different ratings, and τ cannot exceed "
        f"{best:.1f}. A measure without any relation to workload exceeds {_ABOVE:g} in "
        f"{by_chance(_RATINGS, _ABOVE):.0f} % of cases, and reaches {best:.1f} in "
        f"{by_chance(_RATINGS, best - 0.01):.1f} %. A measure that is the workload exceeds "
        f"{_ABOVE:g} in {chances} of cases, where one pilot's ratings scatter by "
        f"{_SCATTERS[0]:g} and by {_SCATTERS[1]:g}."
    )


def by_chance(ratings: Array, above: float) -> float:
    """Return the share [%] of all orders whose τ with the ratings is above a limit."""
    orders = permutations(np.arange(float(len(ratings))))
    agreements = np.array([rank_agreement(np.array(each), ratings) for each in orders])
    return 100.0 * float(np.mean(agreements > above))


def best_agreement(ratings: Array) -> float:
    """Return the largest τ that a measure without ties can have with the ratings."""
    return rank_agreement(np.asarray(ratings) + 1e-3 * np.arange(len(ratings)), ratings)


def power(ratings: Array, above: float, scatter: float) -> float:
    """Return how often [%] τ is above a limit where the measure is the workload itself.

    The ratings are the workload with a normal error of standard deviation `scatter` [ratings]: the
    opinion of one pilot on one day.
    """
    values = np.asarray(ratings, dtype=np.float64)
    drawn = values + scatter * np.random.default_rng(_SEED).standard_normal((_DRAWS, len(values)))
    first, second = np.triu_indices(len(values), 1)
    signs = np.sign(drawn[:, first] - drawn[:, second]) * np.sign(values[first] - values[second])
    return 100.0 * float(np.mean(np.mean(signs, axis=1) > above))
