"""One judged case: what was hidden, and what was answered."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from pitotbench.effects import EFFECTS
from pitotlab.blind.drawn import cause_of

BANDS = ((7.0, "above 7"), (4.0, "4 to 7"), (2.0, "2 to 4"), (0.0, "below 2"))
GUST_CAUSES = {"turbulence_level", "turbulence_scale"}
NO_ANSWER = ("crash", "refused")
SURE = ("named", "one_of")


def model_of(name: str) -> str:
    """The cause that stands for an effect: of its plain form, one name for effects of one model."""
    return _joined(cause_of(name))


def _joined(cause: str) -> str:
    return (cause in EFFECTS and EFFECTS[cause].one_model_with) or cause


@dataclass(frozen=True, slots=True)
class JudgedCase:
    """One case, as read from the files of truth and answers."""

    truth: Mapping[str, Any]
    answer: Mapping[str, Any]

    @property
    def kind(self) -> str:
        """A band, none, two, outside or counted."""
        return str(self.truth["kind"])

    @property
    def flights(self) -> int:
        """The number of flights of the case."""
        return len(self.truth["settings"])

    @property
    def is_single(self) -> bool:
        """Whether one effect of the table is hidden that has a strength."""
        return self.kind in {name for _, name in BANDS}

    @property
    def strength(self) -> float:
        """The strength [σ] of the weakest effect hidden, over all flights."""
        each = [float(np.sqrt(np.sum(np.square(e["strengths"])))) for e in self.truth["effects"]]
        return min(each, default=0.0)

    @property
    def band(self) -> str:
        """The band of the strength."""
        return next(name for least, name in BANDS if self.strength >= least)

    @property
    def wanted(self) -> set[str]:
        """The causes of the table to be named; none for a fault outside it."""
        effects = () if self.kind == "outside" else self.truth["effects"]
        return {model_of(effect["name"]) for effect in effects}

    @property
    def verdict(self) -> str:
        """The kind of the answer; one that holds but the gusts of the generator finds no gap."""
        kind = str(self.answer["kind"])
        return "no_gap" if kind in SURE and groups_of(self.answer) and not self.groups else kind

    @property
    def groups(self) -> list[set[str]]:
        """The sets of causes that were answered, one for each effect.

        Where the gusts are the generator's own, they differ from those of the card: to say so is no
        cause too many.
        """
        own = self.truth.get("environment", {}).get("own_gusts", False)
        return [group for group in groups_of(self.answer) if not (own and group <= GUST_CAUSES)]

    @property
    def named(self) -> bool:
        """Named cleanly: each hidden cause alone, and nothing else."""
        alone = all(len(group) == 1 for group in self.groups)
        return bool(self.groups) and alone and set().union(*self.groups) == self.wanted

    @property
    def in_set(self) -> bool:
        """Every hidden cause stands in a reported set, or is named."""
        return bool(self.groups) and self.wanted <= set().union(*self.groups)

    @property
    def wrong_name(self) -> bool:
        """Some cause stands alone in the answer that was not hidden."""
        return any(len(group) == 1 and not group & self.wanted for group in self.groups)

    @property
    def probabilities(self) -> dict[str, float]:
        """The probability of each cause; effects of one model are one cause."""
        found: dict[str, float] = {}
        for cause, p in self.answer.get("probabilities", {}).items():
            found[_joined(cause)] = found.get(_joined(cause), 0.0) + p
        return found

    @property
    def first(self) -> bool:
        """The most probable cause is a hidden one."""
        found = self.probabilities
        return bool(found) and max(found, key=lambda c: found[c]) in self.wanted


def groups_of(answer: Mapping[str, Any]) -> list[set[str]]:
    """The sets of causes of an answer; none where nothing was named."""
    if answer.get("kind") not in SURE:
        return []
    pairs = zip(answer["effects"], answer["alternatives"], strict=True)
    return [{model_of(n) for n in (name, *others)} for name, others in pairs]
