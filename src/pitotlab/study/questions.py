"""A claim of the paper with its finding, an open question with its reply, and the statistics that
several share.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import permutations
from typing import Literal

import numpy as np
import pandas as pd

from pitotbench.units import Array
from pitotlab.study.parts import Chart
from pitotlab.study.reductions import Reduction, Sortie
from pitotlab.study.tables import Spread, StudyTables, percent_above, rank_agreement

Verdict = Literal["reproduced", "in part", "not reproduced"]


@dataclass(frozen=True, slots=True)
class Finding:
    """The answer to a claim: verdict, number with its spread over seeds, experiment, reason,
    pictures, tables.
    """

    verdict: Verdict
    ours: str
    experiment: str
    why: str
    charts: tuple[Chart, ...] = ()
    tables: tuple[pd.DataFrame, ...] = ()


@dataclass(frozen=True, slots=True)
class Claim:
    """A statement of Martos, Kiszely and Foster (2011), in short; `criterion` is the rule for the
    verdict.
    """

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


@dataclass(frozen=True, slots=True)
class Reply:
    """Two sentences, pictures and tables."""

    words: str
    charts: tuple[Chart, ...] = ()
    tables: tuple[pd.DataFrame, ...] = ()


@dataclass(frozen=True, slots=True)
class Sweep:
    """A question: `reductions(maneuver)` are its reductions of flights in light turbulence, `sorties(seed)`
    more flights.
    """

    name: str
    question: str
    answer: Callable[[StudyTables], Reply]
    reductions: Callable[[str], tuple[Reduction, ...]] = lambda maneuver: ()
    sorties: Callable[[int], Iterable[Sortie]] = lambda seed: ()


_DRAWS, _SEED = 20_000, 83


def by_chance(ratings: Array, above: float) -> float:
    """Return the share [%] of all orders of a measure whose Kendall's τ with the ratings is above a
    limit.
    """
    orders = list(permutations(range(len(ratings))))
    agreements = [rank_agreement(np.array(order, dtype=np.float64), ratings) for order in orders]
    return 100.0 * float(np.mean(np.array(agreements) > above))


def best_agreement(ratings: Array) -> float:
    """Return the largest τ that a measure without ties can have with the ratings; ties count as
    neither.
    """
    return rank_agreement(np.asarray(ratings) + 1e-3 * np.arange(len(ratings)), ratings)


def power(ratings: Array, above: float, scatter: float) -> float:
    """Return how often [%] τ is above a limit where the measure is the workload itself.

    The ratings are the workload with a normal error of standard deviation `scatter` [ratings]: the
    opinion of one pilot on one day.
    """
    values = np.asarray(ratings, dtype=np.float64)
    drawn = values + scatter * np.random.default_rng(_SEED).standard_normal((_DRAWS, len(values)))
    first, second = np.triu_indices(len(values), 1)
    signs = np.sign(drawn[:, first] - drawn[:, second]) * np.sign(values[first] - values[second])
    return 100.0 * float(np.mean(np.mean(signs, axis=1) > above))


LIMIT = 100.0 * (
    1.0 - (2.0 / 3.0) ** 0.5
)  # %: fall of a pooled 2σ where a third output has no residual
TwoSigma = Callable[..., pd.Series]  # evidence, maneuver, settings → by seed


def airspeed_two_sigma(evidence: StudyTables, maneuver: str, **how: object) -> pd.Series:
    """Return 2σ of the residual of airspeed [kt] by seed."""
    return evidence.residual(maneuver, **how)


def pooled_two_sigma(
    evidence: StudyTables, maneuver: str, column: str = "pooled_two_sigma_kt", **how: object
) -> pd.Series:
    """Return 2σ pooled over the outputs [kt of true airspeed] by seed, noise on the impact pressure
    alone.

    `column` names another number of the same fits. With `alone=False` every sensor has its noise.
    """
    alone = bool(how.pop("alone", True))
    return evidence.fit(column, maneuver, form="vector", alone=alone, given_down=alone, **how)


def fall(two_sigma: TwoSigma, evidence: StudyTables, maneuver: str, **how: object) -> Spread:
    """Return the fall of a 2σ with V_down [%], positive where it falls."""
    without = two_sigma(evidence, maneuver, **{**how, "down": False})
    found = percent_above(two_sigma(evidence, maneuver, **how), without)
    return Spread(-found.mean, found.deviation, found.count)


def airspeed_fall(evidence: StudyTables, maneuver: str, **how: object) -> Spread:
    """Return the fall with V_down of the 2σ of airspeed [%]."""
    return fall(airspeed_two_sigma, evidence, maneuver, **how)


def pooled_fall(evidence: StudyTables, maneuver: str, **how: object) -> Spread:
    """Return the fall with V_down of the 2σ pooled over the outputs [%]."""
    return fall(pooled_two_sigma, evidence, maneuver, **how)
