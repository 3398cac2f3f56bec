"""The records of a claim and of the answer to it."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import pandas as pd

from pitotbench.evidence.pages.chart_data import Chart
from pitotbench.evidence.study.study_tables import StudyTables

Verdict = Literal["reproduced", "in part", "not reproduced"]


@dataclass(frozen=True, slots=True)
class Finding:
    """The answer to a claim: verdict, number with its spread over seeds, experiment, reason, pictures, tables."""

    verdict: Verdict
    ours: str
    experiment: str
    why: str
    charts: tuple[Chart, ...] = ()
    tables: tuple[pd.DataFrame, ...] = ()


@dataclass(frozen=True, slots=True)
class Claim:
    """A statement of Martos, Kiszely and Foster (2011), in short; `criterion` is the rule for the verdict."""

    number: str
    words: str
    where: str
    criterion: str
    answer: Callable[[StudyTables], Finding]


def verdict(*held: bool) -> Verdict:
    """Return the verdict from the parts of a claim: all of them hold, some do, or none does."""
    if all(held):
        return "reproduced"
    return "in part" if any(held) else "not reproduced"
