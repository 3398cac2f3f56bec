"""A claim of the paper, an open question, and the answer to either."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from pitotlab.study.parts import Charts, Frames, Verdict
from pitotlab.study.reductions import Reduction, Sortie
from pitotlab.study.rules import Rule
from pitotlab.study.tables import StudyTables


@dataclass(frozen=True, slots=True)
class Reply:
    """The answer to an open question: two sentences, pictures and tables."""

    words: str
    charts: Charts = ()
    tables: Frames = ()


@dataclass(frozen=True, slots=True)
class Finding:
    """The answer to a claim: verdict, number with its spread over seeds, experiment, reason."""

    verdict: Verdict
    ours: str
    experiment: str
    why: str
    charts: Charts = ()
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

    `reductions(maneuver)` are its reductions of flights in light turbulence, `sorties(seed)` more
    flights.
    """

    name: str
    question: str
    answer: Callable[[StudyTables], Reply]
    reductions: Callable[[str], Iterable[Reduction]] = lambda maneuver: ()
    sorties: Callable[[int], Iterable[Sortie]] = lambda seed: ()
