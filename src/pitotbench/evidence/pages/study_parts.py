"""What a study shows, as words and data: no drawing library is loaded here."""

from collections.abc import Sequence
from dataclasses import dataclass

import pandas as pd

from pitotbench.evidence.pages.chart_data import Chart


@dataclass(frozen=True, slots=True)
class Part:
    """One claim or question as it is shown: heading, label and value lines, pictures, tables."""

    anchor: str
    heading: str
    lines: Sequence[tuple[str, str]]
    charts: Sequence[Chart] = ()
    tables: Sequence[pd.DataFrame] = ()
    verdict: str = ""


@dataclass(frozen=True, slots=True)
class StudyPage:
    """Everything that is shown of a study, in words and data."""

    title: str
    subtitle: str
    short: Sequence[str]
    claims: Sequence[Part]
    summary: pd.DataFrame  # a line a claim
    truth: Sequence[Part]
    questions: Sequence[Part]
    method: Sequence[str]
