"""The posterior over causes: how probable each is, what is named, and which set holds the truth."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import logsumexp

from pitotbench.reconcile.decide.log_evidence import LogEvidence
from pitotbench.reconcile.decide.search import CauseSearch, Explained, Names
from pitotbench.reconcile.decide.thresholds import THRESHOLDS
from pitotbench.reconcile.signatures.hypotheses import cause_of
from pitotbench.units import Array

RESTED = 10  # best sets with which a rest is weighed
SMALLEST = 1e-12  # so that the logarithm of a difference is defined
TINY = 1e-300  # of a probability, so that it has a logarithm


@dataclass(frozen=True, slots=True)
class Weight:
    """A set of effects with its logarithms of prior times evidence, without a rest and with one."""

    explained: Explained
    alone: float
    with_rest: float
    place: str

    @property
    def causes(self) -> Names:
        """The causes of the effects, in alphabetical order."""
        return tuple(sorted(map(cause_of, self.explained.effects)))

    @property
    def total(self) -> float:
        """The logarithm of prior times evidence, with or without a rest."""
        return float(np.logaddexp(self.alone, self.with_rest))


@dataclass(frozen=True, slots=True)
class CausePosterior:
    """The posterior over causes of one or several logs; `weights` are normalized, the most probable set first.

    A gap is shown from `least_bayes_factor` on. `concentration` is the sum of the squared shares of the logs in the
    evidence: 1 where one log gives it all, 1/n where n logs give the same.
    """

    weights: tuple[Weight, ...]
    log_bayes_factor: float
    concentration: float = 1.0
    least_bayes_factor: float = THRESHOLDS.gap_bayes_factor

    def of_sets(self) -> dict[Names, float]:
        """Return the probability of each set of causes, in any form, with or without a rest."""
        found: dict[Names, float] = {}
        for each in self.weights:
            found[each.causes] = found.get(each.causes, 0.0) + float(np.exp(each.total))
        return dict(sorted(found.items(), key=lambda item: -item[1]))

    def of_causes(self) -> dict[str, float]:
        """Return the probability that each cause acts, alone or with others."""
        found: dict[str, float] = {}
        for causes, probability in self.of_sets().items():
            for cause in causes:
                found[cause] = found.get(cause, 0.0) + probability
        return dict(sorted(found.items(), key=lambda item: -item[1]))

    @property
    def none(self) -> float:
        """The probability that there is nothing to explain."""
        return sum(float(np.exp(w.alone)) for w in self.weights if not w.causes)

    @property
    def outside(self) -> float:
        """The probability of a gap that no cause of the table has a part in."""
        return sum(float(np.exp(w.with_rest)) for w in self.weights if not w.causes)

    def rest_with(self, causes: Names) -> float:
        """Return the probability that something is left beside a set of causes."""
        of_set = [w for w in self.weights if w.causes == causes]
        whole = logsumexp([w.total for w in of_set])
        return float(np.exp(logsumexp([w.with_rest for w in of_set]) - whole))


def cause_posterior(logs: Sequence[LogEvidence]) -> CausePosterior:
    """Return the posterior over causes of one or several logs of one airplane."""
    search = CauseSearch(logs)
    found = search.run()
    weights = _weights(search, found, 1.0)
    nothing = next(w.alone for w in weights if not w.causes) - float(logsumexp([w.total for w in weights]))
    gap = float(np.log(max(-np.expm1(min(nothing, -TINY)), TINY)))
    prior = THRESHOLDS.prior_of_number[0] * (1.0 - THRESHOLDS.prior_of_rest) ** len(logs)
    log_bayes_factor = gap - nothing - float(np.log((1.0 - prior) / prior))
    shares = _shares(search, max(weights, key=lambda w: w.total))
    concentration = float(np.sum(shares**2))
    tempered = _tempered(search, found, float(tempering_power(log_bayes_factor * concentration)))
    whole = float(logsumexp([w.total for w in tempered])) - gap
    normal = [replace(w, alone=w.alone - whole, with_rest=w.with_rest - whole) for w in tempered]
    normal = [w if w.causes else replace(w, alone=nothing) for w in normal]
    least = float(shares @ [log.least_bayes_factor for log in logs])
    return CausePosterior(tuple(sorted(normal, key=lambda w: -w.total)), log_bayes_factor, concentration, least)


def tempering_power(log_bayes_factor: Array | float) -> Array:
    """Return the power 1 / (1 + τ²χ²) to which the evidence of a log is raised, (n,) like `log_bayes_factor`.

    χ² of one log is twice the logarithm of its Bayes factor. The likelihood takes the table for exact, but a
    signature that is wrong in an unknown direction makes it err in proportion to χ². So beyond 1/τ² a hypothesis is
    preferred by its share of the gap, however strong the gap is. Of several logs it is the mean of their χ², each
    weighted by its share of the evidence: logs that show the same are more evidence, and a log that shows nothing
    changes nothing. Source: the
    coarsened posterior of Miller and Dunson (2019); τ is estimated on development logs.
    """
    return np.asarray(1.0 / (1.0 + 2.0 * THRESHOLDS.table_error**2 * np.maximum(0.0, log_bayes_factor)))


def _shares(search: CauseSearch, best: Weight) -> Array:
    """The share of each log in what the best explanation explains, (n,), with its rest; equal shares of nothing."""
    found = np.maximum(0.0, search.explained_of(best.explained))
    if best.with_rest > best.alone:
        found = found + [max(0.0, value) for value, _ in _rests(search, best.explained, 1.0)]
    whole = float(np.sum(found))
    return found / whole if whole > 0.0 else np.full(len(found), 1.0 / len(found))


def _weights(search: CauseSearch, found: Sequence[Explained], power: float) -> list[Weight]:
    """The sets with prior times evidence of the likelihood to some power; the best ones with a rest as well."""
    empty = next(each for each in found if not each.effects)
    best = [*found[:RESTED], *([empty] if empty not in found[:RESTED] else [])]
    none = len(search.logs) * float(np.log1p(-THRESHOLDS.prior_of_rest))
    weights = []
    for each in found:
        value, place = _with_rest(search, each, power) if each in best else (-np.inf, "")
        weights.append(Weight(each, each.log_weight + none, each.log_weight + value, place))
    return weights


def _tempered(search: CauseSearch, found: Sequence[Explained], power: float) -> list[Weight]:
    """The weights given a gap, with the likelihood to some power.

    The price of a size is not tempered: a log that fixes it well still tells that a further size is zero.
    """
    depth = THRESHOLDS.beam_depth / power
    near = [e for e in found if found[0].log_weight - e.log_weight < depth or not e.effects]
    again = sorted((search.tempered(each, power) for each in near), key=lambda e: -e.log_weight)
    return [w if w.causes else replace(w, alone=-np.inf) for w in _weights(search, again, power)]


def _with_rest(search: CauseSearch, each: Explained, power: float) -> tuple[float, str]:
    """The logarithm of prior times evidence of a rest in at least one log, beyond a set of effects; its best place.

    Each log may have a rest of its own, in one of several places and sizes.
    """
    yes, no = np.log(THRESHOLDS.prior_of_rest), np.log1p(-THRESHOLDS.prior_of_rest)
    found = _rests(search, each, power)
    every = sum(float(np.logaddexp(no, yes + value)) for value, _ in found)
    in_none = len(search.logs) * no - every
    _, place = max((best for _, best in found), default=(-np.inf, ""))
    return every + float(np.log(-np.expm1(min(in_none, -SMALLEST)))), place


def _rests(search: CauseSearch, each: Explained, power: float) -> list[tuple[float, tuple[float, str]]]:
    """The logarithm of the evidence of a rest beyond a set of effects in each log, and that of the best place."""
    by_key, found = dict(zip(each.keys, each.weighed.sizes, strict=True)), []
    for log in search.logs:
        evidence = log.beyond(by_key, power)
        values = [
            (rest.log_prior + evidence.log_evidence_of(rest.columns, rest.deviations), rest.place)
            for rest in log.rests
        ]
        found.append((float(logsumexp([value for value, _ in values])), max(values, default=(-np.inf, ""))))
    return found
