"""How well a flight that has not been flown parts the explanations that are left.

Under each explanation the log of the next flight is a normal vector: the signatures at the fitted sizes, with the
covariance of these sizes, of the form error, of the free parameters, of the wander and of the noise. Logs are
drawn from the explanations in proportion to their probabilities. Each is weighed as the posterior would weigh it
together with the flights so far, and told with the same doubt. The share that ends with a right name is the
probability of a name (a preposterior analysis: Raiffa and Schlaifer 1961; by the entropy that is left: Lindley
1956). A cause of another form than those that are left gets no right name. Only inner products are needed.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import logsumexp

from pitotbench.reconciliation.evidence import LogEvidence
from pitotbench.reconciliation.posterior import CausePosterior, Names, tempering_power
from pitotbench.reconciliation.signatures import cause_of
from pitotbench.reconciliation.thresholds import THRESHOLDS
from pitotbench.reconciliation.verdict import is_named, most_probable
from pitotbench.units import Array

LEAST_PROBABILITY = 0.004  # of an explanation that is a contender: less cannot keep another from 0.9
MOST = 12  # contenders; the rest of a posterior are forms of the same causes
DRAWS = 400  # logs a card: a probability of a half is then known to 0.025
SEED = 20_001  # of the draws, the same for every card, so that cards differ by their geometry alone
SMALLEST = 1e-12  # of the logarithm of a Bayes factor, so that a share of it is defined
ROUNDING = 1e-12  # eigenvalues of inner products below this share of the largest are rounding


@dataclass(frozen=True, slots=True)
class Contender:
    """An explanation that is left: effects in their forms, with their sizes, and its probability given a gap."""

    effects: Names
    keys: tuple[tuple[str, str], ...]
    sizes: Array
    covariance: Array
    probability: float
    log_prior: float

    @property
    def causes(self) -> Names:
        """The causes of the effects, in alphabetical order."""
        return tuple(sorted(map(cause_of, self.effects)))


@dataclass(frozen=True, slots=True)
class Doubt:
    """The explanations that are left after some flights, and the strength of their evidence for a gap.

    `concentration` and `least_bayes_factor` are those of the posterior.
    """

    contenders: tuple[Contender, ...]
    log_bayes_factor: float
    concentration: float = 1.0
    least_bayes_factor: float = THRESHOLDS.gap_bayes_factor

    def power(self, added: Array | float = 0.0) -> Array:
        """Return the power to which evidence is raised, (n,) like `added`.

        `added` is what one further flight adds to the logarithm of the Bayes factor.
        """
        before, after = max(0.0, self.log_bayes_factor), np.maximum(0.0, added)
        mean = (before**2 * self.concentration + after**2) / np.maximum(before + after, SMALLEST)
        return tempering_power(mean)

    def of_causes(self) -> dict[Names, float]:
        """Return the probability of each set of causes that is left, the most probable first."""
        found: dict[Names, float] = {}
        for each in self.contenders:
            found[each.causes] = found.get(each.causes, 0.0) + each.probability
        return dict(sorted(found.items(), key=lambda item: -item[1]))

    @property
    def entropy(self) -> float:
        """The doubt about the causes [bit]."""
        return float(_entropy(np.array([list(self.of_causes().values())]))[0])


def doubt_of(posterior: CausePosterior) -> Doubt:
    """Return the explanations that are left by the posterior of some flights, those without any cause excepted."""
    found = [(w, float(np.exp(w.total))) for w in posterior.weights if w.causes]
    whole = sum(p for _, p in found)
    kept = [(w, p / whole) for w, p in found if p > LEAST_PROBABILITY * whole][:MOST]
    whole = sum(p for _, p in kept)
    contenders = tuple(
        Contender(
            w.explained.effects,
            w.explained.keys,
            w.explained.weighed.sizes,
            w.explained.weighed.covariance,
            p / whole,
            w.explained.log_prior,
        )
        for w, p in kept
    )
    return Doubt(contenders, posterior.log_bayes_factor, posterior.concentration, posterior.least_bayes_factor)


@dataclass(frozen=True, slots=True)
class Parting:
    """The probability that the next flight gives the right name, and the doubt [bit] expected after it."""

    name: float
    entropy: float


def discrimination(doubt: Doubt, log: LogEvidence, draws: int = DRAWS) -> Parting:
    """Return how well a flight with these inner products parts the explanations; its residuals are not used."""
    sized = [dict(zip(c.keys, c.sizes.tolist(), strict=True)) for c in doubt.contenders]
    for sizes in sized:
        log.form_error(sizes)  # adds the directions of form error, so that later columns keep their places
    predictions = [
        _prediction(log, contender, sizes) for contender, sizes in zip(doubt.contenders, sized, strict=True)
    ]
    random = np.random.default_rng(SEED)
    probabilities = np.array([c.probability for c in doubt.contenders])
    of_cause = list(doubt.of_causes())
    member = np.array([of_cause.index(c.causes) for c in doubt.contenders])
    named, left = 0.0, 0.0
    noise = _Noise(log.base.inner[:-1, :-1], sorted({c for each in predictions for c in each.columns}))
    counts = np.maximum(1, np.round(draws * probabilities).astype(int))
    for truth, count in enumerate(counts.tolist()):
        products = predictions[truth].drawn(random, count, noise)
        weights, gap = _weights_after(doubt, predictions, products, noise)
        sets = np.stack([weights[:, member == i].sum(axis=1) for i in range(len(of_cause))], axis=1)
        right = is_named(sets[:, member[truth]]) & (gap > doubt.least_bayes_factor)
        named += probabilities[truth] * float(np.mean(right))
        left += probabilities[truth] * float(np.mean(_entropy(sets)))
    return Parting(most_probable() * float(named), float(left))


def _weights_after(
    doubt: Doubt, predictions: Sequence["_Prediction"], products: Array, noise: "_Noise"
) -> tuple[Array, Array]:
    """The probabilities of the contenders, (d, h), and the Bayes factor of a gap, (d,), after logs, (d, c)."""
    prior = np.array([c.log_prior for c in doubt.contenders])
    before = np.log([c.probability for c in doubt.contenders])
    evidence = (before - prior) / doubt.power()  # so that nothing new leaves the probabilities as they are
    added = np.stack([each.log_evidence(products, noise) for each in predictions], axis=1)
    gap = logsumexp(before + added, axis=1)
    logs = prior + doubt.power(gap)[:, None] * (evidence + added)
    weights = np.exp(logs - logsumexp(logs, axis=1, keepdims=True))
    return np.asarray(weights), np.asarray(doubt.log_bayes_factor + gap)


class _Noise:
    """The inner products of some columns with each other, and draws of their products with noise."""

    def __init__(self, inner: Array, columns: Sequence[int]) -> None:
        self.place = {column: i for i, column in enumerate(columns)}
        self.inner = inner[np.ix_(columns, columns)]
        values, vectors = np.linalg.eigh(self.inner)
        self._root = vectors * np.sqrt(np.where(values > ROUNDING * values[-1], values, 0.0))

    def drawn(self, random: np.random.Generator, count: int) -> Array:
        """Return products with noise, (count, c)."""
        return np.asarray(random.standard_normal((count, len(self._root))) @ self._root.T)


@dataclass(frozen=True, slots=True)
class _Prediction:
    """The sizes and form error that one explanation expects in the next flight: mean and root of covariance."""

    columns: tuple[int, ...]
    mean: Array
    root: Array

    def drawn(self, random: np.random.Generator, count: int, noise: _Noise) -> Array:
        """Return inner products of logs under this explanation, (count, c)."""
        places = [noise.place[c] for c in self.columns]
        sizes = self.mean + random.standard_normal((count, self.root.shape[1])) @ self.root.T
        return np.asarray(sizes @ noise.inner[places] + noise.drawn(random, count))

    def log_evidence(self, products: Array, noise: _Noise) -> Array:
        """Return the logarithm of the probability of logs, (d,), relative to that without any effect."""
        places = [noise.place[c] for c in self.columns]
        inner = noise.inner[np.ix_(places, places)]
        own = products[:, places]
        beyond = (own - inner @ self.mean) @ self.root
        scaled = np.eye(self.root.shape[1]) + self.root.T @ inner @ self.root
        gain = np.sum(beyond.T * np.linalg.solve(scaled, beyond.T), axis=0)
        expected = own @ self.mean - 0.5 * float(self.mean @ inner @ self.mean)
        return np.asarray(expected + 0.5 * gain - 0.5 * float(np.linalg.slogdet(scaled)[1]))


def _prediction(log: LogEvidence, contender: Contender, sizes: dict[tuple[str, str], float]) -> _Prediction:
    index = {(s.effect, s.parameter): i for i, s in enumerate(log.signatures)}
    shown = [i for i, key in enumerate(contender.keys) if key in index]
    errors, deviations = log.form_error(sizes)
    columns = [index[contender.keys[i]] for i in shown] + list(errors)
    covariance = contender.covariance[np.ix_(shown, shown)]
    values, vectors = np.linalg.eigh(covariance)
    root = np.zeros((len(columns), len(columns)))
    root[: len(shown), : len(shown)] = vectors * np.sqrt(np.maximum(values, 0.0))
    root[range(len(shown), len(columns)), range(len(shown), len(columns))] = deviations
    mean = np.concatenate([contender.sizes[shown], np.zeros(len(errors))])
    return _Prediction(tuple(columns), mean, root)


def _entropy(sets: Array) -> Array:
    """The entropy of probabilities [bit], (d,), for (d, s)."""
    positive = np.where(sets > 0.0, sets, 1.0)
    return np.asarray(-np.sum(positive * np.log2(positive), axis=1))
