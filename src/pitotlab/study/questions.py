"""A claim of the paper, an open question, and the answer to either."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import pandas as pd

from pitotlab.study.reductions import Reduction
from pitotlab.study.rules import Rule, Verdict
from pitotlab.study.tables import StudyTables

Frames = tuple[pd.DataFrame, ...]


@dataclass(frozen=True, slots=True)
class Reply:
    """The answer to an open question: two sentences and tables."""

    words: str
    tables: Frames = ()


@dataclass(frozen=True, slots=True)
class Finding:
    """The answer to a claim: verdict, number with its spread over seeds, experiment, reason."""

    verdict: Verdict
    ours: str
    experiment: str
    why: str
    tables: Frames = ()


@dataclass(frozen=True, slots=True)
class Claim:
    """A statement of Martos, Kiszely and Foster (2011), with the rule for its verdict.

    As a decorator, `partial(Claim, RULES[number])` makes the claim of the function that answers it.
    """

    rule: Rule
    answer: Callable[[StudyTables], Finding]


@dataclass(frozen=True, slots=True)
class Sweep:
    """An open question, as a decorator too.

    `reductions(maneuver)` are its reductions of flights in light turbulence.
    """

    name: str
    question: str
    answer: Callable[[StudyTables], Reply]
    reductions: Callable[[str], Iterable[Reduction]] = lambda maneuver: ()
