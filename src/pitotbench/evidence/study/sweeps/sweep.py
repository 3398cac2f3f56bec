"""The records of a sweep: an open question of the paper, its flights and looks, and the answer."""

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
    """Return no further looks at the flights in light turbulence."""
    return ()


def no_sorties(seed: int) -> Iterable[Sortie]:
    """Return no further flights."""
    return ()


@dataclass(frozen=True, slots=True)
class Sweep:
    """A question: `looks(maneuver)` are its looks at flights in light turbulence, `sorties(seed)` more flights."""

    name: str
    question: str
    answer: Callable[[StudyTables], Reply]
    looks: Callable[[str], tuple[Look, ...]] = no_looks
    sorties: Callable[[int], Iterable[Sortie]] = no_sorties
