"""The posterior over causes: search the sets of effects, weigh each, and read the answer."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import comb

import numpy as np
from scipy.special import logsumexp

from pitotbench.effects.effect import Parameter
from pitotbench.reconciliation.evidence import Evidence, LogEvidence, Prior, Weighed, weigh
from pitotbench.reconciliation.signatures import FITTED, cause_of, lasts, searched_shapes
from pitotbench.reconciliation.thresholds import THRESHOLDS
from pitotbench.records.verdict import Kind
from pitotbench.units import Array

LEADING = 14  # sets of each number of effects whose form error is weighed
STEMS = 14  # sets from which larger ones are tried
BEAM = 5  # sets that are extended by a further effect
EXTENDED = 5  # further effects of each of them whose form error is weighed
ROUNDS = 6  # at most, of fitting sizes and the form error that is in proportion to them

SMALLEST_SIGNIFICANCE = 1e-12  # significance of an effect that this log does not show

SETTLED = 0.05  # change of a size, as a share, that ends them

Names = tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Explained:
    """A set of effects, weighed: `log_weight` is the logarithm of prior times evidence, without a
    rest.

    `keys` name the sizes in their order, by effect and parameter. `log_prior` is the logarithm of
    the prior alone. `form_sizes` are the sizes to which its form error was in proportion, (k,), or
    none, (0,).
    """

    effects: Names
    keys: tuple[tuple[str, str], ...]
    log_weight: float
    weighed: Weighed
    log_prior: float
    form_sizes: Array


class CauseSearch:
    """The search over sets of effects for one or several logs of one airplane.

    Sizes of an effect are the same in all logs, those of the air as well: the logs should be of one
    day. Free parameters, wander and form error are each log's own. Raises ValueError without a log.
    """

    def __init__(self, logs: Sequence[LogEvidence]) -> None:
        if not logs:
            raise ValueError("no log to explain")
        self.logs = logs
        shown = dict.fromkeys(
            name for log in logs for name in log.names if not FITTED[name].one_model_with
        )
        self.names = tuple(shown)
        self.causes = tuple(dict.fromkeys(map(cause_of, self.names)))
        self.keys = {n: tuple((n, p.name) for p in _sizes(n, logs)) for n in self.names}
        self.priors = {n: _prior(n, logs) for n in self.names}
        self._plain, _ = self.reduced((), np.zeros(0), self._every())
        self._forms = {c: [n for n in self.names if cause_of(n) == c] for c in self.causes}

    def run(self) -> list[Explained]:
        """Return the best sets of up to three effects and the empty set, the most probable first."""
        prior = self.log_prior(())
        found: dict[Names, Explained] = {
            (): Explained(
                (), (), prior, weigh(Evidence(np.zeros((1, 1))), (), ()), prior, np.zeros(0)
            )
        }
        beam: list[Names] = [()]
        stems: list[Names] = [()]
        for count in range(1, THRESHOLDS.effects_most + 1):
            stems, wanted = self._plain_sets(stems)
            for start in beam if count > 1 else ():
                sizes = found[start].weighed.sizes
                wanted += [tuple(sorted((*start, name))) for name in self._extensions(start, sizes)]
            self._prepare(list(dict.fromkeys(wanted)))
            for names in dict.fromkeys(wanted):
                found[names] = self.explained(names)
            level = sorted(
                (e for e in found.values() if len(e.effects) == count), key=lambda e: -e.log_weight
            )
            beam = [e.effects for e in level[:BEAM]]
            best = max(e.log_weight for e in found.values())
            if not level or level[0].log_weight < best - THRESHOLDS.beam_depth:
                break
        return sorted(found.values(), key=lambda e: -e.log_weight)

    def _prepare(self, wanted: Sequence[Names]) -> None:
        """Form the directions of form error that some sets will need, all at once."""
        place = {key: i for i, key in enumerate(self._every())}
        large: dict[tuple[str, str], None] = {}
        for names in wanted:
            keys = self.keys_of(names)
            wide = THRESHOLDS.size_scales[-1] * np.array(self._typical(names))
            fit = self._plain.of([place[k] for k in keys], wide)
            if np.any(
                np.abs(fit.mean) > THRESHOLDS.form_error_from * np.sqrt(np.diag(fit.covariance))
            ):
                large |= dict.fromkeys(keys)
        for log in self.logs:
            log.directions(
                i for i, s in enumerate(log.signatures) if (s.effect, s.parameter) in large
            )

    def explained(self, names: Names) -> Explained:
        """Weigh one set of effects with its form error."""
        keys, sizes = self.keys_of(names), np.zeros(0)
        weighed = self._weighed(names, sizes, 1.0)
        if self._is_large(weighed):
            shares, (low, high) = self._own_shares(names), self._range(names)
            for count in range(ROUNDS):
                # No size beyond the plausible range has a form error: it would explain what the
                # effect cannot.
                wanted = np.clip(weighed.sizes * shares, low, high)
                if len(sizes) and np.all(np.abs(wanted - sizes) <= SETTLED * np.abs(wanted)):
                    break
                # A size and its form error may take each other's place in turn: halfway between
                # they meet.
                sizes = wanted if count < ROUNDS // 3 else 0.5 * (wanted + sizes)
                weighed = self._weighed(names, sizes, 1.0)
        prior = self.log_prior(names)
        return Explained(names, tuple(keys), prior + weighed.log_evidence, weighed, prior, sizes)

    def _weighed(self, names: Names, form_sizes: Array, power: float) -> Weighed:
        """Weigh a set of effects with the form error of some sizes, by the likelihood to some
        power.
        """
        evidence, log_evidence = self.reduced(names, form_sizes, self.keys_of(names), power)
        weighed = weigh(evidence, self._columns(names), [self.priors[n] for n in names])
        return replace(weighed, log_evidence=weighed.log_evidence + log_evidence)

    def _own_shares(self, names: Names) -> Array:
        """What is left of the significance of each size beside the others, as a share, without form
        error.

        Where two effects nearly cancel it is small, and so is the form error of either.
        """
        place = {key: i for i, key in enumerate(self._every())}
        wide = THRESHOLDS.size_scales[-1] * np.array(self._typical(names))
        fit = self._plain.of([place[k] for k in self.keys_of(names)], wide)
        shares = np.ones(len(wide))
        for name, columns in zip(names, self._columns(names), strict=True):
            size, index = fit.mean[columns], [place[k] for k in self.keys[name]]
            beside = float(size @ np.linalg.solve(fit.covariance[np.ix_(columns, columns)], size))
            alone = float(size @ self._plain.inner[np.ix_(index, index)] @ size)
            shares[columns] = np.sqrt(min(1.0, beside / max(alone, SMALLEST_SIGNIFICANCE)))
        return shares

    def _is_large(self, weighed: Weighed) -> bool:
        """Whether a set of effects is so significant that its form error counts."""
        spread = np.sqrt(np.diag(weighed.covariance))
        return bool(np.any(np.abs(weighed.sizes) > THRESHOLDS.form_error_from * spread))

    def tempered(self, each: Explained, power: float) -> Explained:
        """Weigh a set of effects again, by the likelihood to some power, with the form error that
        it had.
        """
        weighed = self._weighed(each.effects, each.form_sizes, power)
        return replace(each, log_weight=each.log_prior + weighed.log_evidence)

    def reduced(
        self, names: Names, sizes: Array, kept: Sequence[tuple[str, str]], power: float = 1.0
    ) -> tuple[Evidence, float]:
        """Return the evidence of all logs over some sizes, with the form error of a set eliminated
        in each log.

        It is that of the likelihood to some power. `sizes` (k,) are those of the effects, in the
        order of their keys.
        """
        total, log_evidence = Evidence(np.zeros((len(kept) + 1, len(kept) + 1))), 0.0
        by_key = dict(zip(self.keys_of(names), sizes, strict=True)) if len(sizes) else {}
        for log in self.logs:
            one, part = _reduced(log, by_key, kept, power)
            total, log_evidence = total + one, log_evidence + part
        return total, log_evidence

    def explained_of(self, each: Explained) -> Array:
        """Return what a set of effects explains of each log, as a logarithm of a likelihood ratio,
        (n,).
        """
        by_key = dict(zip(each.keys, each.form_sizes, strict=True)) if len(each.form_sizes) else {}
        size, found = each.weighed.sizes, []
        for log in self.logs:
            evidence, part = _reduced(log, by_key, each.keys, 1.0)
            inner = evidence.inner
            found.append(part + float(size @ inner[:-1, -1] - 0.5 * size @ inner[:-1, :-1] @ size))
        return np.array(found)

    def _plain_sets(self, stems: Sequence[Names]) -> tuple[list[Names], list[Names]]:
        """The best sets with one more effect than some stems, without form error: further stems,
        and a few.
        """
        place = {key: i for i, key in enumerate(self._every())}
        columns = {n: [place[k] for k in self.keys[n]] for n in self.names}
        values: dict[Names, float] = {}
        for stem in stems:
            causes = set(map(cause_of, stem))
            for name in self.names:
                names = tuple(sorted((*stem, name)))
                if cause_of(name) in causes or names in values:
                    continue
                used = [c for n in names for c in columns[n]]
                wide = THRESHOLDS.size_scales[-1] * np.array(self._typical(names))
                values[names] = self._plain.log_evidence_of(used, wide) + self.log_prior(names)
        ranked = sorted(values, key=lambda n: -values[n])
        return ranked[:STEMS], ranked[:LEADING]

    def _every(self) -> list[tuple[str, str]]:
        return [key for n in self.names for key in self.keys[n]]

    def _extensions(self, start: Names, sizes: Array) -> list[str]:
        """The effects that add most to a set with its form error."""
        every = self._every()
        place = {key: i for i, key in enumerate(every)}
        evidence, _ = self.reduced(start, sizes, every)
        held = [place[k] for k in self.keys_of(start)]
        deviations = [max(abs(s), t) for s, t in zip(sizes, self._typical(start), strict=True)]
        evidence, _ = evidence.given(held, deviations)
        causes = set(map(cause_of, start))
        values = {}
        for name in self.names:
            if cause_of(name) not in causes:
                columns = [place[k] for k in self.keys[name]]
                values[name] = weigh(
                    evidence, [columns], [self.priors[name]]
                ).log_evidence + self.log_form(name)
        return sorted(values, key=lambda n: -values[n])[:EXTENDED]

    def keys_of(self, names: Names) -> list[tuple[str, str]]:
        """Return the sizes of some effects, each as the effect and its parameter."""
        return [key for n in names for key in self.keys[n]]

    def _columns(self, names: Names) -> list[list[int]]:
        columns, first = [], 0
        for name in names:
            columns.append(list(range(first, first + len(self.keys[name]))))
            first += len(self.keys[name])
        return columns

    def _typical(self, names: Names) -> list[float]:
        return [float(t) for n in names for t in self.priors[n].typical]

    def _range(self, names: Names) -> tuple[Array, Array]:
        """The plausible range of each size of a set."""
        return (
            np.concatenate([np.minimum(self.priors[n].low, 0.0) for n in names]),
            np.concatenate([np.maximum(self.priors[n].high, 0.0) for n in names]),
        )

    def log_prior(self, names: Names) -> float:
        """Return the logarithm of the prior probability of a set of effects in these forms."""
        count, table = len(names), THRESHOLDS.prior_of_number
        forms = sum(self.log_form(n) for n in names)
        return float(np.log(table[count]) - np.log(comb(len(self.causes), count)) + forms)

    def log_form(self, name: str) -> float:
        """Return the logarithm of the prior of a form of its cause, with the search over its
        shapes.

        Most causes act for the whole flight. Of the forms that do, the plain one is as probable as
        all others.
        """
        cause = cause_of(name)
        parts = [form for form in self._forms[cause] if not lasts(form)]
        whole = [form for form in self._forms[cause] if lasts(form)]
        in_part = (THRESHOLDS.prior_of_part if whole else 1.0) if parts else 0.0
        others = len(whole) - (cause in whole)
        if name in parts:
            share = in_part / len(parts)
        else:
            share = (1.0 - in_part) * (
                1.0 if len(whole) == 1 else 0.5 if name == cause else 0.5 / others
            )
        return float(np.log(share)) - THRESHOLDS.search_penalty * len(searched_shapes(FITTED[name]))


def _reduced(
    log: LogEvidence,
    by_key: Mapping[tuple[str, str], float],
    kept: Sequence[tuple[str, str]],
    power: float,
) -> tuple[Evidence, float]:
    """The evidence of one log over some sizes, with the form error of effects of these sizes
    eliminated.

    Sizes that the log does not show have rows of zeros.
    """
    index = {(s.effect, s.parameter): i for i, s in enumerate(log.signatures)}
    directions, deviations = log.form_error(by_key)
    places = [(row, index[key]) for row, key in enumerate(kept) if key in index]
    one, part = log.base.tempered(power).given(
        directions, deviations, [column for _, column in places]
    )
    rows = [*(row for row, _ in places), len(kept)]
    inner = np.zeros((len(kept) + 1, len(kept) + 1))
    inner[np.ix_(rows, rows)] = one.inner
    return Evidence(inner), part


def _sizes(name: str, logs: Sequence[LogEvidence]) -> list[Parameter]:
    shown = {s.parameter for log in logs for s in log.signatures if s.effect == name}
    return [p for p in FITTED[name].parameters if p.name in shown]


def _prior(name: str, logs: Sequence[LogEvidence]) -> Prior:
    found = _sizes(name, logs)
    typical, low, high = (
        np.array([(abs(p.typical), p.low, p.high) for p in found], dtype=float).reshape(-1, 3).T
    )
    return Prior(typical, low, high, np.array([1.0 if p.defining else 0.0 for p in found]))


# The posterior over causes: how probable each is, what is named, and which set holds the truth.

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
    """The posterior over causes of one or several logs; `weights` are normalized, the most probable
    set first.

    A gap is shown from `least_bayes_factor` on. `concentration` is the sum of the squared shares of
    the logs in the evidence: 1 where one log gives it all, 1/n where n logs give the same.
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
    nothing = next(w.alone for w in weights if not w.causes) - float(
        logsumexp([w.total for w in weights])
    )
    gap = float(np.log(max(-np.expm1(min(nothing, -TINY)), TINY)))
    prior = THRESHOLDS.prior_of_number[0] * (1.0 - THRESHOLDS.prior_of_rest) ** len(logs)
    log_bayes_factor = gap - nothing - float(np.log((1.0 - prior) / prior))
    shares = _shares(search, max(weights, key=lambda w: w.total))
    concentration = float(np.sum(shares**2))
    tempered = _tempered(search, found, float(tempering_power(log_bayes_factor * concentration)))
    whole = float(logsumexp([w.total for w in tempered])) - gap
    normal = [replace(w, alone=w.alone - whole, with_rest=w.with_rest - whole) for w in tempered]
    normal = [w if w.causes else replace(w, alone=nothing) for w in normal]
    normal = _with_plain_neighbors(normal)
    limits = np.array([log.least_bayes_factor for log in logs])
    # A log that shows no gap takes none from those that do.
    limits = np.where(np.isfinite(limits), limits, limits.min())
    least = float(shares @ limits) if np.all(np.isfinite(limits)) else np.inf
    return CausePosterior(
        tuple(sorted(normal, key=lambda w: -w.total)), log_bayes_factor, concentration, least
    )


def _with_plain_neighbors(weights: Sequence[Weight]) -> list[Weight]:
    """The weights, those of sets with an effect that came out at nothing added to those of its
    plain neighbor.

    A line in which the water is within 2σ of none is a line that is late, and no rival of one.
    """
    found = {w.explained.effects: w for w in weights}
    for each in weights:
        effects = each.explained.effects
        plain = tuple(sorted({_plain(each.explained, name) for name in effects}))
        if plain != effects and plain in found:
            into, moved = found[plain], found.pop(effects)
            alone, rest = (
                float(np.logaddexp(getattr(into, n), getattr(moved, n)))
                for n in ("alone", "with_rest")
            )
            found[plain] = replace(into, alone=alone, with_rest=rest)
    return list(found.values())


def _plain(each: Explained, name: str) -> str:
    """The name of an effect of a set, or that of its neighbor where its defining size is within 2σ
    of zero.
    """
    effect, deviations = FITTED[name], np.sqrt(np.diag(each.weighed.covariance))
    defining = [
        i for i, (of, p) in enumerate(each.keys) if of == name and effect.parameter(p).defining
    ]
    if not defining or np.any(np.abs(each.weighed.sizes[defining]) > 2.0 * deviations[defining]):
        return name
    return effect.neighbor + name.removeprefix(effect.part_of or name)


def tempering_power(log_bayes_factor: Array | float) -> Array:
    """Return the power 1 / (1 + τ²χ²) to which the evidence of a log is raised, (n,) like
    `log_bayes_factor`.

    χ² of one log is twice the logarithm of its Bayes factor. The likelihood takes the table for
    exact, but a signature that is wrong in an unknown direction makes it err in proportion to χ².
    So beyond 1/τ² a hypothesis is preferred by its share of the gap, however strong the gap is. Of
    several logs it is the mean of their χ², each weighted by its share of the evidence: logs that
    show the same are more evidence, and a log that shows nothing changes nothing. Source: the
    coarsened posterior of Miller and Dunson (2019); τ is estimated on development logs.
    """
    return np.asarray(
        1.0 / (1.0 + 2.0 * THRESHOLDS.table_error**2 * np.maximum(0.0, log_bayes_factor))
    )


def _shares(search: CauseSearch, best: Weight) -> Array:
    """The share of each log in what the best explanation explains, (n,), with its rest; equal
    shares of nothing.
    """
    found = np.maximum(0.0, search.explained_of(best.explained))
    if best.with_rest > best.alone:
        found = found + [max(0.0, value) for value, _ in _rests(search, best.explained, 1.0)]
    whole = float(np.sum(found))
    return found / whole if whole > 0.0 else np.full(len(found), 1.0 / len(found))


def _weights(search: CauseSearch, found: Sequence[Explained], power: float) -> list[Weight]:
    """The sets with prior times evidence of the likelihood to some power; the best ones with a rest
    as well.
    """
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

    The price of a size is not tempered: a log that fixes it well still tells that a further size is
    zero.
    """
    depth = THRESHOLDS.beam_depth / power
    near = [e for e in found if found[0].log_weight - e.log_weight < depth or not e.effects]
    again = sorted((search.tempered(each, power) for each in near), key=lambda e: -e.log_weight)
    return [w if w.causes else replace(w, alone=-np.inf) for w in _weights(search, again, power)]


def _with_rest(search: CauseSearch, each: Explained, power: float) -> tuple[float, str]:
    """The logarithm of prior times evidence of a rest in at least one log, beyond a set of effects;
    its best place.

    Each log may have a rest of its own, in one of several places and sizes.
    """
    yes, no = np.log(THRESHOLDS.prior_of_rest), np.log1p(-THRESHOLDS.prior_of_rest)
    found = _rests(search, each, power)
    every = sum(float(np.logaddexp(no, yes + value)) for value, _ in found)
    in_none = len(search.logs) * no - every
    _, place = max((best for _, best in found), default=(-np.inf, ""))
    return every + float(np.log(-np.expm1(min(in_none, -SMALLEST)))), place


def _rests(
    search: CauseSearch, each: Explained, power: float
) -> list[tuple[float, tuple[float, str]]]:
    """The logarithm of the evidence of a rest beyond a set of effects in each log, and that of the
    best place.
    """
    by_key, found = dict(zip(each.keys, each.weighed.sizes, strict=True)), []
    for log in search.logs:
        evidence = log.beyond(by_key, power)
        values = [
            (rest.log_prior + evidence.log_evidence_of(rest.columns, rest.deviations), rest.place)
            for rest in log.rests
        ]
        found.append(
            (float(logsumexp([value for value, _ in values])), max(values, default=(-np.inf, "")))
        )
    return found


OUTSIDE = "outside"  # stands for a gap that no entry of the table describes


@dataclass(frozen=True, slots=True)
class Answer:
    """The answer of a posterior.

    `groups` holds one set of causes for each effect: a single one where it is named, else the
    smallest set that holds it, the most probable first; OUTSIDE among them stands for a cause that
    the table does not hold. `probabilities` is that of each cause given a gap. `best` is the most
    probable set of effects with one of each group. `rest` is the probability that something is left
    beside it, and `place` where.
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
    """Return the answer of a posterior: named above the probability of a name, else the smallest
    set.
    """
    gap = max(1.0 - posterior.none, 1e-12)
    sets = {causes: p / gap for causes, p in posterior.of_sets().items() if causes}
    probabilities = {cause: p / gap for cause, p in posterior.of_causes().items()}
    outside = posterior.outside / gap
    empty = next(w for w in posterior.weights if not w.causes)
    if posterior.log_bayes_factor < posterior.least_bayes_factor:
        return Answer("no_gap", (), probabilities, empty, 0.0, "")
    if outside > THRESHOLDS.likely:
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
    """The smallest set of causes that holds one more beside those named; empty where none is
    needed.
    """
    holding = {causes: p for causes, p in sets.items() if set(named) <= set(causes)}
    whole = sum(holding.values()) + (0.0 if named else outside)
    alone = sum(p for causes, p in holding.items() if set(causes) == set(named))
    if whole <= 0.0 or (named and alone > (1.0 - THRESHOLDS.named_from) * whole):
        return ()
    chosen: list[str] = []
    waiting = {
        tuple(c for c in causes if c not in named): p
        for causes, p in holding.items()
        if set(causes) != set(named)
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
