"""From the posterior over causes to an answer: what is named, what is one of a few, and what remains."""

from dataclasses import dataclass

from pitotbench.reconcile.decide.posterior import CausePosterior, Weight
from pitotbench.reconcile.decide.search import Names
from pitotbench.reconcile.decide.thresholds import THRESHOLDS
from pitotbench.reconcile.signatures.hypotheses import cause_of
from pitotbench.records.verdict import Kind

OUTSIDE = "outside"  # stands for a gap that no entry of the table describes


@dataclass(frozen=True, slots=True)
class Answer:
    """The answer of a posterior.

    `groups` holds one set of causes for each effect: a single one where it is named, else the smallest set that
    holds it, the most probable first; OUTSIDE among them stands for a cause that the table does not hold.
    `probabilities` is that of each cause given a gap. `best` is the most probable set of effects with one of each
    group. `rest` is the probability that something is left beside it, and `place` where.
    """

    kind: Kind
    groups: tuple[Names, ...]
    probabilities: dict[str, float]
    best: Weight
    rest: float
    place: str

    @property
    def effects(self) -> Names:
        """The effects that are named, or the most probable of a set."""
        return self.best.explained.effects

    @property
    def keys(self) -> tuple[tuple[str, str], ...]:
        """The sizes of the effects in their order, by effect and parameter."""
        return self.best.explained.keys

    def others(self, cause: str) -> Names:
        """Return the other causes of the table in the set that holds a cause."""
        group = next((g for g in self.groups if cause in g), ())
        return tuple(c for c in group if c not in (cause, OUTSIDE))


def answer_of(posterior: CausePosterior) -> Answer:
    """Return the answer of a posterior: named above the probability of a name, else the smallest set."""
    gap = max(1.0 - posterior.none, 1e-12)
    sets = {causes: p / gap for causes, p in posterior.of_sets().items() if causes}
    probabilities = {cause: p / gap for cause, p in posterior.of_causes().items()}
    outside = posterior.outside / gap
    empty = next(w for w in posterior.weights if not w.causes)
    if posterior.log_bayes_factor < posterior.least_bayes_factor:
        return Answer("no_gap", (), probabilities, empty, 0.0, "")
    if outside > THRESHOLDS.outside_likely:
        return Answer("unknown", (), probabilities, empty, outside, empty.place)
    named = tuple(c for c, p in probabilities.items() if p > THRESHOLDS.named_from)
    groups: list[Names] = [(cause,) for cause in named]
    further = _further(sets, named, outside)
    if further:
        groups.append(further)
    best = _best(posterior, groups)
    rest = posterior.rest_with(best.causes)
    kind: Kind = "named" if all(len(g) == 1 for g in groups) else "one_of"
    return Answer(kind, tuple(groups), probabilities, best, rest, best.place)


def _further(sets: dict[Names, float], named: Names, outside: float) -> Names:
    """The smallest set of causes that holds one more beside those named; empty where none is needed."""
    holding = {causes: p for causes, p in sets.items() if set(named) <= set(causes)}
    whole = sum(holding.values()) + (0.0 if named else outside)
    alone = sum(p for causes, p in holding.items() if set(causes) == set(named))
    if whole <= 0.0 or (named and alone > (1.0 - THRESHOLDS.named_from) * whole):
        return ()
    chosen: list[str] = []
    waiting = {
        tuple(c for c in causes if c not in named): p for causes, p in holding.items() if set(causes) != set(named)
    }
    if not named:
        waiting[OUTSIDE,] = outside
    enough = THRESHOLDS.set_holds * sum(waiting.values())
    held = 0.0
    while waiting and held < enough:
        shares: dict[str, float] = {}
        for causes, p in waiting.items():
            for cause in causes:
                shares[cause] = shares.get(cause, 0.0) + p
        best = max(shares, key=lambda c: shares[c])
        chosen.append(best)
        held += shares[best]
        waiting = {causes: p for causes, p in waiting.items() if best not in causes}
    return tuple(chosen)


def _best(posterior: CausePosterior, groups: list[Names]) -> Weight:
    """The most probable set of effects with exactly one cause of each group."""
    wanted = [set(g) for g in groups]

    def fits(w: Weight) -> bool:
        causes = list(map(cause_of, w.explained.effects))
        return len(causes) == len(wanted) and all(sum(c in g for c in causes) == 1 for g in wanted)

    found = [w for w in posterior.weights if fits(w)]
    first = [w for w in found if all(g[0] in w.causes for g in groups)]
    return max(first or found or list(posterior.weights), key=lambda w: w.total)
