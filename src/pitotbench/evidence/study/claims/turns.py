"""C8: the data in turns, with and without V_down."""

import pandas as pd

from pitotbench.evidence.pages.chart_data import Bars, BarSeries
from pitotbench.evidence.study.charting import CUT
from pitotbench.evidence.study.claims.claim import Claim, Finding, Verdict
from pitotbench.evidence.study.claims.pooled import (
    TwoSigma,
    airspeed_fall,
    airspeed_two_sigma,
    pooled_fall,
    pooled_two_sigma,
)
from pitotbench.evidence.study.maneuver_names import PAPER_ORDER, named
from pitotbench.evidence.study.study_tables import Spread, StudyTables, percent_above, signed

_SAME = 2.0  # %
_UP_TO = (10.0, 40.0)  # %: our reading of "as much as 25 %"
_FLOWN = "step_decrease"  # the maneuver of Fig 8
_KINDS: dict[str, TwoSigma] = {"airspeed": airspeed_two_sigma, "pooled": pooled_two_sigma}


def _change(two_sigma: TwoSigma, evidence: StudyTables, maneuver: str, down: bool) -> Spread:
    """Return the 2σ of on-condition data relative to that of all data, minus one [%]."""
    one = two_sigma(evidence, maneuver, down=down, on_condition=True)
    return percent_above(one, two_sigma(evidence, maneuver, down=down))


def _verdict(same: dict[str, bool], falls: dict[str, bool]) -> Verdict:
    """Both parts in the 2σ of airspeed reproduce the claim; one of them, or both in the pooled 2σ, do in part."""
    if same["airspeed"] and falls["airspeed"]:
        return "reproduced"
    some = same["airspeed"] or falls["airspeed"] or (same["pooled"] and falls["pooled"])
    return "in part" if some else "not reproduced"


def _turns(evidence: StudyTables) -> Finding:
    change = {
        kind: [_change(two_sigma, evidence, _FLOWN, down) for down in (False, True)]
        for kind, two_sigma in _KINDS.items()
    }
    fall = {"airspeed": airspeed_fall(evidence, _FLOWN), "pooled": pooled_fall(evidence, _FLOWN)}
    same = {kind: all(abs(s.mean) < _SAME for s in both) for kind, both in change.items()}
    falls = {kind: _UP_TO[0] <= found.mean <= _UP_TO[1] for kind, found in fall.items()}
    straight = pooled_fall(evidence, _FLOWN, on_condition=True)
    others = [_change(airspeed_two_sigma, evidence, m, True).mean for m in PAPER_ORDER]
    decel = others[PAPER_ORDER.index("rapid_decel")]
    alike = {
        kind: f"{both[0].text(1)} % without and {both[1].text(1)} % with V_down" for kind, both in change.items()
    }
    return Finding(
        _verdict(same, falls),
        f"on-condition against full data, 2σ of the airspeed {alike['airspeed']}; pooled over the outputs "
        f"{alike['pooled']}. V_down lowers the first by {fall['airspeed'].text(1)} % and the second by "
        f"{fall['pooled'].text(1)} % (full data) and {straight.text(1)} % (on condition)",
        "Fit all data and on-condition data of Step Decrease, with and without V_down. Compute the 2σ of the "
        "airspeed, and pooled over the outputs as for C7.",
        f"{_words(same)} A fit of airspeed uses the size of the velocity through the air, and its direction may "
        "turn. The fall with V_down is that of C7: an output without residual lowers the mean over the outputs in "
        "turns and on straight legs alike. It cannot reach the published 25 %. On-condition data alone change the "
        f"2σ of the airspeed by {signed(min(others), 0)} to {signed(max(others), 0)} % over the five maneuvers. "
        f"Rapid Decel changes by {signed(decel, 0)} %: its turn is flown slowly, where a pascal of noise is more "
        "knots.",
        (_dots(evidence),),
        (_table(evidence),),
    )


def _words(same: dict[str, bool]) -> str:
    if all(same.values()):
        return f"Turns in or out change either 2σ by less than {_SAME:g} %."
    if not any(same.values()):
        return f"Turns in or out change both by {_SAME:g} % or more."
    unchanged, changed = ("airspeed", "pooled") if same["airspeed"] else ("pooled", "airspeed")
    return f"Turns in or out change the {changed} 2σ by {_SAME:g} % or more, the {unchanged} 2σ by less."


def _dots(evidence: StudyTables) -> Bars:
    """Draw Fig 8 for both kinds of 2σ of Step Decrease."""
    series = []
    for on, data in ((False, "full data"), (True, "on condition")):
        for down, label in ((False, "no V_down"), (True, "V_down")):
            found = [Spread.of(two(evidence, _FLOWN, down=down, on_condition=on)) for two in _KINDS.values()]
            series.append(BarSeries(f"{data}, {label}", [s.mean for s in found], [s.deviation for s in found]))
    return Bars(
        "Fig 8: turn data, with and without V_down",
        f"Step Decrease, 50/50 Hz, smooth air, a good pilot. {CUT}",
        "2σ of the residual [kt]",
        ["of the\nairspeed", "pooled over\nthe outputs"],
        series,
        "fig8-turns",
        dots=True,
    )


def _table(evidence: StudyTables) -> pd.DataFrame:
    rows: dict[str, dict[str, object]] = {}
    for m in PAPER_ORDER:
        rows[m] = {
            f"{kind}: on-condition against full data, {'V_down' if down else 'no V_down'} [%]": _change(
                two_sigma, evidence, m, down
            ).text(1)
            for kind, two_sigma in _KINDS.items()
            for down in (False, True)
        }
    return named(rows)


TURNS = Claim(
    "C8",
    "Full and on-condition data give the same; with V_down both are up to 25 % smaller and again the same",
    "Fig 8",
    f"on-condition and full data within {_SAME:g} % of each other, and a fall of {_UP_TO[0]:g} to {_UP_TO[1]:g} % "
    "with V_down, in the 2σ of the airspeed (in part: one of the two, or both in the 2σ pooled over the outputs "
    "alone)",
    _turns,
)
