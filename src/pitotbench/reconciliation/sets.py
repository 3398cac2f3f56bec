"""Weigh sets of hypotheses that act on one moment or one force, all at once.

Stiffness and elevator of one moment can be told as center of gravity and pitch damping: each
exchange of one of them for another is worse, the exchange of both is better. So the sets of one
moment are enumerated, as the subsets of a regression are (Hoeting and others, Bayesian Model
Averaging, 1999).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from pitotbench.estimation.information import Information
from pitotbench.reconciliation.evidence import Prior, log_inside
from pitotbench.reconciliation.thresholds import THRESHOLDS
from pitotbench.units import Array


@dataclass(frozen=True, slots=True)
class FittedHypothesis:
    """A hypothesis in the fit: the columns of its sizes, and what its form leaves open.

    The latter are small columns. `deviations` are those of the priors of both, (k,).
    """

    name: str
    columns: tuple[int, ...]
    deviations: Array


@dataclass(frozen=True, slots=True)
class Hypothesis:
    """A cause that may act: its columns in the evidence, (k,), its prior and its prior log odds.

    Two forms of one `cause` are never in one set. `left_open` are the columns of what its form
    leaves open, with the deviations of their priors, (j,) each.
    """

    name: str
    cause: str
    columns: tuple[int, ...]
    prior: Prior
    log_odds: float
    left_open: tuple[tuple[int, ...], Array]

    def all_columns(self) -> tuple[int, ...]:
        """Return its columns and then those that its form leaves open."""
        return (*self.columns, *self.left_open[0])

    def deviations(self, scale: float) -> Array:
        """Return the prior deviations of all its columns where its sizes are of a scale."""
        return np.concatenate([self.prior.deviations(scale), self.left_open[1]])


@dataclass(frozen=True, slots=True, eq=False)
class WeighedSet:
    """A set of hypotheses as members of a fit, and ln of its prior odds times evidence."""

    members: tuple[FittedHypothesis, ...]
    log_weight: float

    @property
    def names(self) -> tuple[str, ...]:
        """The names of its members."""
        return tuple(member.name for member in self.members)


def weighed_sets(
    evidence: Information, hypotheses: Sequence[Hypothesis], most: int
) -> list[WeighedSet]:
    """Return all sets of at most so many hypotheses, the empty one too, the most probable first."""
    found = [_weighed(evidence, own) for own in _subsets(hypotheses, most)]
    return sorted(found, key=lambda each: -each.log_weight)


def _subsets(hypotheses: Sequence[Hypothesis], most: int) -> Iterator[tuple[Hypothesis, ...]]:
    for size in range(most + 1):
        for own in combinations(hypotheses, size):
            if len({each.cause for each in own}) == size:
                yield own


def _weighed(evidence: Information, own: Sequence[Hypothesis]) -> WeighedSet:
    """Return a set at the scales of its sizes that suit the log best.

    All scales of the ladder are at even odds.
    """
    ladder = THRESHOLDS.size_scales
    scales, best = [1.0] * len(own), -np.inf
    for place in range(len(own)):
        for scale in ladder:
            tried = [*scales[:place], scale, *scales[place + 1 :]]
            log_evidence = _log_evidence(evidence, own, tried)
            if log_evidence > best:
                best, scales = log_evidence, tried
    odds = sum(each.log_odds for each in own) - len(own) * np.log(len(ladder))
    members = (
        FittedHypothesis(each.name, each.all_columns(), each.deviations(scale))
        for each, scale in zip(own, scales, strict=True)
    )
    return WeighedSet(tuple(members), float(odds + (best if own else 0.0)))


def _log_evidence(
    evidence: Information, own: Sequence[Hypothesis], scales: Sequence[float]
) -> float:
    """The logarithm of the evidence of a set whose sizes lie in their plausible ranges."""
    columns = [column for each in own for column in each.all_columns()]
    deviations = [each.deviations(scale) for each, scale in zip(own, scales, strict=True)]
    found = evidence.posterior(columns, np.concatenate(deviations))
    spread = np.sqrt(np.maximum(np.diag(found.covariance), np.finfo(float).tiny))
    inside, first = 0.0, 0
    for each, wide in zip(own, deviations, strict=True):
        place = slice(first, first + len(each.columns))
        within = found.mean[place], spread[place], each.prior.low, each.prior.high
        usual = np.zeros(len(each.columns)), wide[: len(each.columns)], *within[2:]
        inside += float(np.sum(log_inside(*within) - log_inside(*usual)))
        first += len(wide)
    return float(found.log_evidence + inside)
