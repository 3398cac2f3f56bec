"""What the steps after the posterior were worth on the kept sets, by their told answers alone.

The map from a posterior to what is told can be inverted, so that its powers and doubts are tried
without a judgment. What a check withdrew stands in the answer, with the truth beside it.
"""

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.special import expit, logit

from pitotlab.blind.case import SURE, JudgedCase, model_of
from pitotlab.blind.parts import NAMED, proper_scores, with_a_gap

MOST = 0.999999  # probability up to which a told one is inverted


@dataclass(frozen=True, slots=True)
class Telling:
    """A map from the probability of a cause to the one that is told.

    Powers of the odds above and below even; odds from `trusted` on are held there until their power
    exceeds them (infinite: never held). Shares of doubt: the least, the most from some share of the
    gap left on, and those beside where a check leaves a name probable or takes it back.
    """

    above: float = 0.5
    below: float = 0.8
    trusted: float = np.inf
    least: float = 0.04
    most: float = 0.38
    most_left: float = 0.15
    probable: float = 0.38
    taken_back: float = 0.58

    def share(self, case: JudgedCase) -> float:
        """The share that is left for the causes of a case."""
        closure = case.answer.get("closure")
        left = 0.0 if closure is None else 1.0 - float(closure)
        of_gap = self.least + (self.most - self.least) * float(
            np.clip(left / self.most_left, 0.0, 1.0)
        )
        beside = self.taken_back if case.answer["kind"] == "unknown" else self.probable
        return (1.0 - of_gap) * (1.0 - (beside if case.answer.get("doubts") else 0.0))

    def told(self, case: JudgedCase, posterior: Mapping[str, float]) -> dict[str, float]:
        """The probabilities that are told."""
        return {cause: self.share(case) * self._nearer_even(p) for cause, p in posterior.items()}

    def _nearer_even(self, p: float) -> float:
        odds = float(logit(np.clip(p, 1.0 - MOST, MOST)))
        held = self.above * odds
        if np.isfinite(self.trusted):
            held = min(odds, max(float(np.log(self.trusted)), held))
        return float(expit(held if odds > 0.0 else self.below * odds))

    def posterior(self, case: JudgedCase) -> dict[str, float]:
        """The probabilities before they were told so; those that were held are taken for the middle
        of the hold.
        """
        return {
            cause: self._inverted(p / self.share(case)) for cause, p in case.probabilities.items()
        }

    def _inverted(self, p: float) -> float:
        odds = float(logit(np.clip(p, 1.0 - MOST, MOST)))
        if odds < 0.0:
            return float(expit(odds / self.below))
        limit = float(np.log(self.trusted)) if np.isfinite(self.trusted) else 0.0
        if odds > limit + HELD:
            return float(expit(odds / self.above))
        return float(expit(1.5 * limit if odds > limit - HELD else odds))


HELD = (
    0.015  # of the logarithm of odds that count as held: probabilities are written with five digits
)
# How the answers of a set were told; the two sets before them had no such map.
TELLINGS = {
    **dict.fromkeys(("seventh", "eighth", "ninth", "tenth"), Telling()),
    "eleventh": Telling(trusted=4.0),
}
OFF: Mapping[str, Mapping[str, float]] = {
    "hold and power of odds above even": {"above": 1.0, "trusted": np.inf},
    "hold: a power of 0.8": {"above": 0.8, "trusted": np.inf},
    "power of odds below even": {"below": 1.0},
    "powers and hold of the odds": {"above": 1.0, "below": 1.0, "trusted": np.inf},
    "doubt by what is left": {"most": 0.04},
    "doubt by objections": {"probable": 0.0, "taken_back": 0.0},
    "doubt by objections: one share": {"probable": 0.45, "taken_back": 0.45},
    "all doubt": {"least": 0.0, "most": 0.0, "probable": 0.0, "taken_back": 0.0},
}


def rows_of_tellings(sets: Mapping[str, Sequence[JudgedCase]]) -> Iterator[dict[str, Any]]:
    """Yield for each step off what the scores over causes change by, on the newest set and on those
    before it.
    """
    groups = {
        "seventh to tenth": [n for n in sets if n in TELLINGS and n != "eleventh"],
        "eleventh": ["eleventh"],
    }
    for group, names in groups.items():
        cases = [(case, TELLINGS[name]) for name in names for case in with_a_gap(sets[name])]
        for step, values in OFF.items():
            yield {
                "step off": step,
                "measured on": f"told answers, {group}",
                **_changes(cases, values),
            }


def _changes(
    cases: Sequence[tuple[JudgedCase, Telling]], values: Mapping[str, float]
) -> dict[str, Any]:
    """What the scores over causes change by where the map of the newest set has other values."""
    changes, sure = [], Counter[tuple[str, bool]]()
    for case, telling in cases:
        posterior, now = telling.posterior(case), TELLINGS["eleventh"]
        told = {
            "on": now.told(case, posterior),
            "off": replace(now, **values).told(case, posterior),
        }
        changes.append(np.subtract(_scores(case, told["off"]), _scores(case, told["on"])))
        sure.update(
            (w, c in case.wanted) for w, each in told.items() for c, p in each.items() if p > NAMED
        )
    change, error = (
        np.mean(changes, axis=0),
        np.std(changes, axis=0) / np.sqrt(max(1, len(changes) - 1)),
    )
    return {
        "logs": len(cases),
        "log_causes": f"{change[0]:.4f}",
        "log_causes_se": f"{error[0]:.4f}",
        "brier_causes": f"{change[1]:.4f}",
        "brier_causes_se": f"{error[1]:.4f}",
        "sure": sum(sure["off", right] - sure["on", right] for right in (True, False)),
        "sure_right": sure["off", True] - sure["on", True],
    }


def _scores(case: JudgedCase, told: Mapping[str, float]) -> tuple[float, float]:
    return proper_scores([case], lambda _: told, lambda hidden: hidden.wanted)


CHECKS = {
    "closure of all passes": ("comes closest", "looks close only"),
    "so many effects": ("so many effects",),
    "a flight left out": ("sizes of the other flights",),
    "contradiction of flights": ("contradicts",),
    "formula": ("a formula explains",),
    "held-out log": ("held-out log",),
}


def rows_of_checks(sets: Mapping[str, Sequence[JudgedCase]]) -> Iterator[dict[str, Any]]:
    """Yield for each check how often it spoke, and whether the names that it spoke against were
    right.

    Of a line or a wander (alone) the name is the most probable cause where the answer is unknown;
    where there was an answer all the same, or nothing hidden, it counts as partly right.
    """
    for check, words in CHECKS.items():
        count = Counter(
            _worth(case)
            for cases in sets.values()
            for case in cases
            for doubt in case.answer.get("doubts", ())
            if any(word in doubt for word in words)
        )
        yield {
            "check": check,
            "spoke": count.total(),
            **{each: count[each] for each in ("right", "partly", "wrong")},
        }
    for check, where in (("line of one period", "a period"), ("wander of a channel", "throughout")):
        shown = [
            case
            for cases in sets.values()
            for case in cases
            if any(where in place[1] for place in case.answer.get("located", ()))
            and (
                where == "a period"
                or not any("a period" in place[1] for place in case.answer["located"])
            )
        ]
        unknown = [case for case in shown if case.verdict == "unknown"]
        yield {
            "check": check,
            "spoke": len(shown),
            "right": sum(case.first for case in unknown),
            "partly": len(shown) - len(unknown) + sum(case.kind == "none" for case in unknown),
            "wrong": sum(case.kind != "none" and not case.first for case in unknown),
        }


def _worth(case: JudgedCase) -> str:
    """Whether the names against which a check spoke were right."""
    names: set[str] = set().union(*case.groups) if case.verdict in SURE else set()
    for note in case.answer.get("notes", ()):
        if "taken back" in note:
            told = note.split("the name ")[1].split(" is taken")[0]
            names |= {model_of(name.strip()) for name in re.split(", ", told)}
    return (
        "right" if names and names <= case.wanted else "partly" if names & case.wanted else "wrong"
    )
