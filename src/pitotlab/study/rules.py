"""The rule for the verdict on each claim of Martos, Kiszely and Foster (2011).

A rule has the paper's words, the quantity that is measured, and the bands. The bands were chosen
from the paper's words before the flights that are judged by them.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np

from pitotlab.study.tables import Spread, rank_agreement

Verdict = Literal["reproduced", "in part", "not reproduced", "set by the cards", ""]
SET: Verdict = "set by the cards"
CLOSE = 1.0  # min: the paper's table has whole minutes
QUARTER = (0.20, 0.33)  # of the time
SAME = 5.0  # %: a smaller change is "not significant", "almost identical", "comparable"
TEN = (5.0, 15.0)  # %: "approximately 10 %"
MOST = 20.0  # %: twice that
DOUBLE = (1.7, 2.3)  # times
LARGER = 1.02  # times: a smaller ratio counts as none
SEEN = 1.0  # %: a smaller fall cannot be seen in the paper's charts
QUARTER_FALL = (15.0, 35.0)  # %: "as much as 25 %"
LIKE = 0.4  # Kendall's τ with an order of five
RATED = 0.6  # Kendall's τ with the ratings; no measure without ties can reach more than 0.8


def _some(whole: bool, part: bool) -> Verdict:
    return "reproduced" if whole else "in part" if part else "not reproduced"


def _within(value: float, band: tuple[float, float]) -> bool:
    return band[0] <= value <= band[1]


def _times(minutes_off: Sequence[float]) -> Verdict:
    return SET if all(abs(each) <= CLOSE for each in minutes_off) else "not reproduced"


def _order(two_sigma: Sequence[float]) -> Verdict:
    """Judge the mean 2σ of the five maneuvers, in the paper's order."""
    like = rank_agreement(np.array(two_sigma), np.arange(float(len(two_sigma))))
    rises = all(a < b for a, b in pairwise(two_sigma))
    return _some(rises, min(two_sigma) == two_sigma[0] and like >= LIKE)


def _alike(fewest: int) -> Callable[[Sequence[float]], Verdict]:
    """Return the judge of a change [%] of each maneuver that should be none."""

    def judge(changes: Sequence[float]) -> Verdict:
        small = sum(abs(each) < SAME for each in changes)
        return _some(small == len(changes), small >= fewest)

    return judge


def _slow(rises: Sequence[float]) -> Verdict:
    mean = sum(rises) / len(rises)
    return _some(_within(mean, TEN), all(each > 0.0 for each in rises) and mean <= MOST)


def _bias(ratios: Sequence[float]) -> Verdict:
    return _some(all(_within(r, DOUBLE) for r in ratios), all(r > LARGER for r in ratios))


def _down(falls: Mapping[str, Sequence[float]]) -> Verdict:
    """Judge the falls [%] by data system, slowest first; of a system by maneuver, 4-Leg first, Step
    Decrease second.
    """
    slow, *fast = falls.values()
    both = all(each > SEEN for system in fast for each in system[:2])
    most = all(system[0] == max(system) for system in fast)
    least = all(slow[place] < system[place] for system in fast for place in (0, 1))
    return _some(both and most and least, both and (most or least))


def _turns(changes: Sequence[float], falls: Sequence[float]) -> Verdict:
    same = all(abs(each) < SAME for each in changes)
    fall = _within(max(falls), QUARTER_FALL)
    return _some(same and fall, same or fall)


def _denser(six_speeds: Spread, long_steps: Spread) -> Verdict:
    smaller = six_speeds.mean + six_speeds.margin < 0.0
    larger = long_steps.mean - long_steps.margin > 0.0
    return _some(smaller and larger, smaller or larger)


def _fewer(change: Spread) -> Verdict:
    return _some(change.mean + change.margin < 0.0, change.mean < 0.0)


def _ratings(taus: Sequence[float]) -> Verdict:
    good = [tau >= RATED for tau in taus]
    return _some(all(good), any(good))


def _airplane(share: float, inside: bool) -> Verdict:
    """Judge the share [-] of seeds in the published order, and whether the points lie inside."""
    return _some(share > 0.5 and inside, share > 0.5 or inside)


def _quarter(share: float) -> Verdict:
    return SET if _within(share, QUARTER) else "not reproduced"


@dataclass(frozen=True, slots=True)
class Rule:
    """A statement of the paper, in short, and when it counts as reproduced and as reproduced in part.

    `judge` takes the quantities and returns the verdict.
    """

    number: str
    words: str
    where: str
    quantity: str
    reproduced: str
    in_part: str
    judge: Callable[..., Verdict]

    @property
    def criterion(self) -> str:
        """Both bands, as a sentence."""
        return f"{self.reproduced} (in part: {self.in_part})" if self.in_part else self.reproduced


_CARDS = "the cards were chosen so: no finding"
_RESIDUAL = "2σ of the residual of the airspeed, smooth air, Inverse+"
_TABLE = (
    Rule(
        "C1",
        "Flight times in the simulator, minutes: Rapid Decel 5, Step Decrease 6, Circle 6, Race Track "
        "15, 4-Leg 21",
        "Table 2",
        "mean time of each maneuver, turns included, set-up not",
        f"set by the cards where each is within {CLOSE:g} min; {_CARDS}",
        "",
        _times,
    ),
    Rule(
        "C2",
        "2σ of the residual: Step Decrease lowest; Circle, Rapid Decel, Race Track and 4-Leg follow",
        "§III.E, Figs 9, 10",
        f"{_RESIDUAL}, 50/50 Hz: the order of the five means",
        "the paper's order",
        f"Step Decrease lowest, and Kendall's τ at least {LIKE:g}",
        _order,
    ),
    Rule(
        "C3",
        "“No significant variation between the 50/50 Hz and 100/100 Hz data”",
        "§III.E, Fig 10",
        f"{_RESIDUAL}: change from 50/50 to 100/100 Hz",
        f"less than {SAME:g} % for all five maneuvers",
        "for four",
        _alike(4),
    ),
    Rule(
        "C4",
        "20/1 Hz “on average increased the 2σ values by approximately 10 %”",
        "§III.E, Fig 10",
        f"{_RESIDUAL}: rise from 50/50 to 20/1 Hz, the fixes held, as the paper has them",
        f"a mean of {TEN[0]:g} to {TEN[1]:g} %",
        f"a rise for each maneuver, and a mean of at most {MOST:g} %",
        _slow,
    ),
    Rule(
        "C5",
        "With Bias the 2σ were “double that of the other three” models",
        "§III.D, Fig 9",
        "2σ of Bias over the mean 2σ of the other three, smooth air, 50/50 Hz: each maneuver, with each "
        "of six injected errors that were not chosen for the claim",
        f"{DOUBLE[0]:g} to {DOUBLE[1]:g} in all",
        f"above {LARGER:g} in all",
        _bias,
    ),
    Rule(
        "C6",
        "Quadratic and Inverse+ are “almost identical for the five maneuver types”",
        "§III.D, Fig 9",
        "2σ of the residual of the airspeed, smooth air, 50/50 Hz: change from Inverse+ to Quadratic",
        f"less than {SAME:g} % for all five maneuvers",
        "for three",
        _alike(3),
    ),
    Rule(
        "C7",
        "With V_down the 2σ of 4-Leg and Step Decrease falls, that of 4-Leg most; “the smallest 2σ "
        "reduction occurs for the lowest sample rates”",
        "§III.C, Fig 7",
        f"{_RESIDUAL}: fall with V_down at each data rate",
        f"both fall by more than {SEEN:g} % at 50/50 and 100/100 Hz, 4-Leg most of all five, and both "
        "least at 20/1 Hz",
        "both fall, and one of the other two",
        _down,
    ),
    Rule(
        "C8",
        "Step Decrease: full and on-condition data are “comparable” without V_down and “virtually "
        "identical” with it; with V_down the 2σ fell “by as much as 25 %”",
        "§III.C, Fig 8",
        f"{_RESIDUAL}, Step Decrease, each data rate: change from full to on-condition data, and the "
        "largest fall with V_down",
        f"less than {SAME:g} % in all, and a largest fall of {QUARTER_FALL[0]:g} to "
        f"{QUARTER_FALL[1]:g} %",
        "one of the two",
        _turns,
    ),
    Rule(
        "C9",
        "4-Leg with six speeds: “a modest decrease”; Step Decrease with longer power steps: “a slight "
        "increase”",
        "§III.C, Figs 5, 6",
        f"{_RESIDUAL}, 50/50 Hz: both changes, seed by seed",
        "both signs, with 95 % intervals of the means clear of zero",
        "one of the two",
        _denser,
    ),
    Rule(
        "C10",
        "The 2σ of Step Decrease is smaller, although it has about a third of the data points of 4-Leg",
        "§III.C, Fig 6",
        f"{_RESIDUAL}, 50/50 Hz: change from 4-Leg to Step Decrease, seed by seed; the third is set by "
        "the cards",
        "a 95 % interval of the mean below zero",
        "a mean below zero",
        _fewer,
    ),
    Rule(
        "C11",
        "Cooper-Harper, airplane/simulator: Step Decrease 4/3, Race Track 2/2, 4-Leg 4/3, Circle –/4, "
        "Rapid Decel 2/2",
        "Table 1",
        "Kendall's τ of three measures of the controls with the simulator's ratings",
        f"at least {RATED:g} for all three",
        "for one",
        _ratings,
    ),
    Rule(
        "C12",
        "Airplane, average 2σ in KCAS: Step Decrease 0.75, Race Track 1.2, 4-Leg 1.5, Rapid Decel 2.1; "
        "4-Leg agrees with the fixed-speed method",
        "§III.F, Figs 11–14, Table III",
        "2σ of the residual of the airspeed on straight legs, Quadratic, 20/1 Hz, light turbulence, the "
        "airplane's effects, and a wind that walks by 1 m/s in ten minutes: the order of the four, seed "
        "by seed; the fixed-speed points of the first seed",
        "the published order in more than half of the seeds, and all points inside the ±2σ of the curve",
        "one of the two",
        _airplane,
    ),
    Rule(
        "C13",
        "Step Decrease takes about one fourth of the time of 4-Leg",
        "§IV",
        "time of Step Decrease over that of 4-Leg",
        f"set by the cards where it is {QUARTER[0]:g} to {QUARTER[1]:g}; {_CARDS}",
        "",
        _quarter,
    ),
)
RULES: Mapping[str, Rule] = {rule.number: rule for rule in _TABLE}
