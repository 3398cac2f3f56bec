"""What a study shows, as words and data: no drawing library is loaded here."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import pandas as pd

Numbers = Sequence[float]
Verdict = Literal["reproduced", "in part", "not reproduced", "set by the cards", ""]


@dataclass(frozen=True, slots=True)
class Series:
    """Numbers of one label, with their standard deviations over seeds (NaN where unknown) or none.

    Bars have one number a group. In `Lines` the numbers lie over `x` in a style; a `band` is a line
    in a band of ± the deviations.
    """

    label: str
    x: Numbers
    y: Numbers
    spreads: Numbers | None = None
    style: Literal["line", "marks", "dots", "dashed", "band", "steps", "limit"] = "line"


@dataclass(frozen=True, slots=True)
class Bars:
    """Groups of bars with spread bars; as `dots`, on an axis that need not begin at zero.

    `top` is where the axis of dots is cut: a dot above it is drawn at the edge with its value.
    """

    title: str
    note: str
    ylabel: str
    groups: Sequence[str]
    series: Sequence[Series]
    dots: bool = False
    top: float | None = None


@dataclass(frozen=True, slots=True)
class Lines:
    """Lines over a common axis; `below` is drawn under them, over the same axis."""

    title: str
    note: str
    xlabel: str
    ylabel: str
    series: Sequence[Series]
    log_x: bool = False
    log_y: bool = False
    equal: bool = False
    below: "Lines | None" = None


Chart = Bars | Lines
Charts = tuple[Chart, ...]
Frames = tuple[pd.DataFrame, ...]


@dataclass(frozen=True, slots=True)
class Part:
    """One claim or question as it is shown: heading, label and value lines, pictures, tables."""

    anchor: str
    heading: str
    lines: Sequence[tuple[str, str]]
    charts: Charts = ()
    tables: Frames = ()
    verdict: Verdict = ""


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
