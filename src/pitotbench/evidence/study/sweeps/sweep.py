"""What a sweep is: a question that the paper left open, what is flown and sensed for it, and the answer."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import pandas as pd

from pitotbench.evidence.pages.chart_data import Chart
from pitotbench.evidence.study.looks import Look
from pitotbench.evidence.study.settings import Sortie
from pitotbench.evidence.study.study_tables import StudyTables


@dataclass(frozen=True, slots=True)
class Reply:
    """Two sentences, pictures and tables."""

    words: str
    charts: tuple[Chart, ...] = ()
    tables: tuple[pd.DataFrame, ...] = ()


def no_looks(maneuver: str) -> tuple[Look, ...]:
    """Nothing more is asked of the flights in light turbulence."""
    return ()


def no_sorties(seed: int) -> Iterable[Sortie]:
    """Nothing more is flown."""
    return ()


@dataclass(frozen=True, slots=True)
class Sweep:
    """`looks(maneuver)` are taken at the flights in light turbulence, `sorties(seed)` are flown besides."""

    name: str
    question: str
    answer: Callable[[StudyTables], Reply]
    looks: Callable[[str], tuple[Look, ...]] = no_looks
    sorties: Callable[[int], Iterable[Sortie]] = no_sorties
