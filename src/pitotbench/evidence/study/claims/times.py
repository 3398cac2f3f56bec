"""C1 and C13: the times of the maneuvers."""

from pitotbench.evidence.study.charting import maneuver_bars
from pitotbench.evidence.study.claims.claim import Claim, Finding, verdict
from pitotbench.evidence.study.maneuver_names import NAMES, PAPER_ORDER, named
from pitotbench.evidence.study.study_tables import Spread, StudyTables, ratio, signed

SIMULATOR = {"rapid_decel": 5.0, "step_decrease": 6.0, "circle": 6.0, "race_track": 15.0, "four_leg": 21.0}
AIRPLANE = {"rapid_decel": 4.0, "step_decrease": 6.0, "race_track": 16.5, "four_leg": 28.0}  # Table 2, minutes
_CLOSE = 1.0  # min: the table has whole minutes
_QUARTER = (0.20, 0.33)


def _times(evidence: StudyTables) -> Finding:
    ours = {m: Spread.of(evidence.flight("minutes", m)) for m in PAPER_ORDER}
    off = {m: ours[m].mean - SIMULATOR[m] for m in PAPER_ORDER}
    rows: dict[str, dict[str, object]] = {
        m: {
            "paper's simulator [min]": SIMULATOR[m],
            "paper's airplane [min]": AIRPLANE.get(m, "not flown"),
            "ours [min]": ours[m].text(1),
        }
        for m in PAPER_ORDER
    }
    worst = max(PAPER_ORDER, key=lambda m: abs(off[m]))
    chart = maneuver_bars(
        "table2-times", "Table 2: flight times", "Turns included, set-up between speeds not.", "time [min]",
        [("smooth", "ours")], lambda m, s: evidence.flight("minutes", m, s),
    )  # fmt: skip
    return Finding(
        verdict(all(abs(d) <= _CLOSE for d in off.values())),
        ", ".join(f"{NAMES[m]} {ours[m].text(1)}" for m in SIMULATOR) + " min",
        "Fly every maneuver in smooth air with the good pilot and time what is recorded: turns count, the set-up "
        "between speeds does not.",
        f"The largest difference is {signed(off[worst])} min ({NAMES[worst]}). The paper does not state the dwell, "
        "the settling time or the turn rate. Our cards choose them so that the times agree. This checks the cards "
        "and is no finding.",
        (chart,),
        (named(rows),),
    )


def _quarter(evidence: StudyTables) -> Finding:
    share = ratio(evidence.flight("minutes", "step_decrease"), evidence.flight("minutes", "four_leg"))
    return Finding(
        verdict(_QUARTER[0] <= share.mean <= _QUARTER[1]),
        f"{share.text(2)} of the time of 4-Leg",
        "Compare the times of the two maneuvers in the flights of C1.",
        f"The paper's own simulator took {SIMULATOR['step_decrease']:g} and {SIMULATOR['four_leg']:g} minutes, a "
        f"ratio of {SIMULATOR['step_decrease'] / SIMULATOR['four_leg']:.2f}. Its airplane has a ratio of "
        f"{AIRPLANE['step_decrease'] / AIRPLANE['four_leg']:.2f}.",
    )


TIMES = Claim(
    "C1",
    "Flight times in the simulator, minutes: Rapid Decel 5, Step Decrease 6, Circle 6, Race Track 15, 4-Leg 21",
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
