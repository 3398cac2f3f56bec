"""Name the effects of one flight or of several of one airplane: causes and sizes shared."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import chdtrc, ndtri

from pitotbench.reconciliation.equations import (
    Fit,
    NormalEquations,
    closure_of,
    scaled_to,
    whitened_equations,
    with_form_error,
)
from pitotbench.reconciliation.evidence import (
    Evidence,
    LogEvidence,
    estimates,
    merit,
    significance,
    significant,
)
from pitotbench.reconciliation.layout import Layout
from pitotbench.reconciliation.noise import NoiseModel
from pitotbench.reconciliation.null_distribution import NullDistribution
from pitotbench.reconciliation.null_learning import wander_of
from pitotbench.reconciliation.posterior import (
    Answer,
    CausePosterior,
    CauseSearch,
    Names,
    answer_of,
    cause_posterior,
)
from pitotbench.reconciliation.renewal import (
    Entries,
    at_sizes,
    placed_in_time,
    with_parts_of_flight,
    without_sensor_effects,
)
from pitotbench.reconciliation.signatures import (
    FITTED,
    cause_of,
    columns_of,
    lasts,
    returns,
    times_of,
)
from pitotbench.reconciliation.thresholds import THRESHOLDS
from pitotbench.records.calibration import Estimate
from pitotbench.records.verdict import Candidate, Closure, JoinedFlight, Located, OwnSize
from pitotbench.units import Array

# Name the effects on each flight: fit every hypothesis, form the posterior over causes, and read
# its answer.

RENEWALS = 3  # times the signatures are renewed; they mostly stay as they are after the first
RENEWED = 6  # best single explanations whose signatures are renewed: the others have no part in the answer
SETTLED = 0.02  # change of a size, as a share, from which an effect is taken out of the log anew
LISTED = 10  # candidates in a verdict


@dataclass(frozen=True, slots=True)
class Naming:
    """The outcome of the posterior over causes.

    `chosen` are the effects fitted together, by `fit`, with the layout and the normal equations of
    that fit. `alternatives` holds, for each chosen effect, the other causes of the set that holds
    it. `located` is the gap by channel before, `remaining` the gap after the chosen effects.
    """

    answer: Answer
    posterior: CausePosterior
    chosen: tuple[str, ...]
    alternatives: tuple[tuple[str, ...], ...]
    candidates: tuple[Candidate, ...]
    located: tuple[Located, ...]
    remaining: tuple[Located, ...]
    layout: Layout
    equations: NormalEquations
    fit: Fit


@dataclass(frozen=True, slots=True)
class Renewed:
    """A layout with its signatures at the fitted sizes, its normal equations, and the noise model
    of both.
    """

    layout: Layout
    equations: NormalEquations
    noise: NoiseModel

    def evidence(self, null: NullDistribution) -> LogEvidence:
        """Return the evidence of the log."""
        wander = wander_of(null, self.layout.residuals.names)
        least = null.gap_bayes_factor if self._stands_out(null) else np.inf
        return LogEvidence(self.layout, self.noise, wander, null.scores, least)

    def _stands_out(self, null: NullDistribution) -> bool:
        """Whether a cell or an effect scores more than any does on null flights.

        A sum of many small scores is no gap that anyone sees. Null flights do not tell what an
        effect in a part of the flight scores. Without null flights the Bayes factor alone decides.
        """
        cells = (place.significance for place in _located(self, null, ()))
        effects = (
            null.scores.of_effect(name, significance(self.equations.fit(own)))
            for name, own in columns_of(self.layout.signatures).items()
            if not FITTED[name].part_of
        )
        return (
            null.flights == 0
            or any(abs(score) > null.cell_threshold for score in cells)
            or any(score > null.threshold for score in effects)
        )


def _naming(renewed: Renewed, null: NullDistribution, posterior: CausePosterior) -> Naming:
    """What the posterior of all flights names on one of them."""
    answer, layout, equations = answer_of(posterior), renewed.layout, renewed.equations
    chosen = answer.effects
    fit = _fit(renewed, answer)
    located, remaining = _located(renewed, null, ()), _located(renewed, null, fit.columns)
    alternatives = tuple(answer.others(cause_of(name)) for name in chosen)
    candidates = _candidates(renewed, null, posterior, answer)
    return Naming(
        answer,
        posterior,
        chosen,
        alternatives,
        candidates,
        located,
        remaining,
        layout,
        equations,
        fit,
    )


def renewed_signatures(original: Layout, null: NullDistribution) -> Renewed:
    """Renew the signatures of the best explanations at their fitted sizes, and form the equations
    anew.

    Events are placed in time. A large effect on the sensors is subtracted from the clean track
    first.
    """
    noise = scaled_to(null.noise, original)
    original = with_parts_of_flight(placed_in_time(original, noise), noise)
    layout, equations = original, whitened_equations(original, noise, with_cells=False)
    columns = columns_of(layout.signatures)
    undone: Entries = {}
    for _ in range(RENEWALS):
        sizes = _fitted_sizes(layout, equations, columns)
        large = _large_effect(layout, equations, columns)
        renewed = layout
        if not _is_near(large, undone):
            renewed, undone = without_sensor_effects(original, large), large
        renewed = at_sizes(renewed, sizes)
        if renewed is layout:
            break
        layout, equations = renewed, whitened_equations(renewed, noise, with_cells=False)
    return Renewed(layout, whitened_equations(layout, noise), noise)


def _large_effect(
    layout: Layout, equations: NormalEquations, columns: Mapping[str, Sequence[int]]
) -> dict[str, dict[str, float]]:
    """The best single explanation with its sizes and shapes where it is large; else nothing."""
    best = max(columns, key=lambda n: merit(equations.fit(columns[n])))
    fit = equations.fit(columns[best])
    if significance(fit) <= THRESHOLDS.undone_from:
        return {}
    signatures = [layout.signatures[c] for c in columns[best]]
    sizes = dict(signatures[0].shapes)
    for signature, size in zip(signatures, fit.sizes, strict=True):
        sizes[signature.parameter] = FITTED[best].parameter(signature.parameter).within(float(size))
    return {best: sizes}


def _is_near(large: Entries, undone: Entries) -> bool:
    """Whether effects that are to be taken out of a log are those already taken out, at about the
    same sizes.
    """
    if large.keys() != undone.keys():
        return False
    pairs = [(v, undone[name][key]) for name, sizes in large.items() for key, v in sizes.items()]
    return all(abs(new - old) <= SETTLED * abs(new) for new, old in pairs)


def _fitted_sizes(
    layout: Layout, equations: NormalEquations, columns: Mapping[str, Sequence[int]]
) -> dict[tuple[str, str], float]:
    """Sizes of the best explanations, each fitted alone."""
    fits = {n: equations.fit(c) for n, c in columns.items()}
    best = sorted(fits, key=lambda n: -merit(fits[n]))[:RENEWED]
    sizes: dict[tuple[str, str], float] = {}
    for effect in best:
        for column, size in zip(columns[effect], fits[effect].sizes, strict=True):
            sizes[effect, layout.signatures[column].parameter] = float(size)
    return sizes


def _fit(renewed: Renewed, answer: Answer) -> Fit:
    """The sizes of the named effects as a fit of this log, with the bounds that their form error
    leaves.

    Form error widens the bounds and must not shift the sizes: these are a fit without it. A size of
    another log of the posterior that this log cannot show has no column.
    """
    index = {(s.effect, s.parameter): i for i, s in enumerate(renewed.layout.signatures)}
    weighed = answer.best.explained.weighed
    places = [i for i, key in enumerate(answer.keys) if key in index]
    columns = tuple(index[answer.keys[i]] for i in places)
    plain = renewed.equations.fit(columns)
    return Fit(columns, plain.sizes, weighed.covariance[np.ix_(places, places)], plain.gain)


def _candidates(
    renewed: Renewed, null: NullDistribution, posterior: CausePosterior, answer: Answer
) -> tuple[Candidate, ...]:
    """The causes as single explanations, each in its best form, the most probable first."""
    equations, columns = renewed.equations, columns_of(renewed.layout.signatures)
    fits = {name: equations.fit(c) for name, c in columns.items()}
    forms: dict[str, str] = {cause_of(name): name for name in answer.effects}
    for name in sorted(fits, key=lambda n: -merit(fits[n])):
        forms.setdefault(cause_of(name), name)
    probable = answer.probabilities
    ranked = sorted(
        (name for name in forms.values() if name in columns),
        key=lambda n: (-round(probable.get(cause_of(n), 0.0), 3), -merit(fits[n])),
    )
    signatures = renewed.layout.signatures
    return tuple(
        Candidate(
            name,
            estimates(signatures, fits[name]),
            null.scores.of_effect(name, significance(fits[name])),
            probable.get(cause_of(name), 0.0),
            times_of(signatures[columns[name][0]]),
        )
        for name in ranked[:LISTED]
    )


def _located(renewed: Renewed, null: NullDistribution, given: Sequence[int]) -> tuple[Located, ...]:
    """The most significant place in every channel, in σ beyond the mean of null flights."""
    values = renewed.equations.scores(renewed.layout.examined, given)
    return strongest(
        Located(c.channel, c.phase, c.variable, null.scores.of_cell(c, float(value)))
        for (_, c), value in zip(renewed.layout.places, values, strict=True)
    )


def strongest(places: Iterable[Located]) -> tuple[Located, ...]:
    """Return the most significant place in every channel, the worst one first."""
    ranked = sorted(places, key=lambda place: -abs(place.significance))
    best = {place.channel: place for place in reversed(ranked)}
    return tuple(place for place in ranked if best[place.channel] is place)


# Name the effects of all flights of one airplane: causes and sizes shared, free parameters each
# flight's own. Each flight is judged by the noise and the wander of the null flights of its own
# card. Its evidence adds to that of the others. A flight that shows another size than the others do
# contradicts the cause. One flight is the case of several in which there are no others.

Key = tuple[str, str]  # an effect and one of its parameters
_Part = tuple[
    tuple[Key, ...], Array
]  # what a log shows: its keys, and the inner products of them and the residual
FARTHEST = 1e-300  # smallest probability that is turned into a distance


@dataclass(frozen=True, slots=True)
class Together:
    """One flight or several, named together.

    `namings` holds for each flight the shared answer with the shared sizes, `logs` its evidence,
    and `alone` the posterior of the flight by itself.
    """

    posterior: CausePosterior
    namings: tuple[Naming, ...]
    logs: tuple[LogEvidence, ...]
    alone: tuple[CausePosterior, ...]
    sizes: Mapping[Key, float]


@dataclass(frozen=True, slots=True)
class OwnSizes:
    """The sizes of some effects that one flight, or several, show: keys, values, (k,), and
    covariance, (k, k).
    """

    keys: tuple[Key, ...]
    values: Array
    covariance: Array

    def by_key(self) -> dict[Key, float]:
        """Return each size by its key."""
        return dict(zip(self.keys, self.values.tolist(), strict=True))

    def of(self, effect: str) -> "OwnSizes":
        """Return the sizes of one effect."""
        places = [i for i, key in enumerate(self.keys) if key[0] == effect]
        keys = tuple(self.keys[i] for i in places)
        return OwnSizes(keys, self.values[places], self.covariance[np.ix_(places, places)])


def name_effects(layouts: Sequence[Layout], nulls: Sequence[NullDistribution]) -> Together:
    """Name the effects that one flight shows, or several, each with its null distribution.

    The signatures of several flights are computed once more at the shared sizes, because a flight
    that shows little of an effect fits a size of its own that is far from them. Raises ValueError
    without a flight.
    """
    renewed = [
        renewed_signatures(layout, null) for layout, null in zip(layouts, nulls, strict=True)
    ]
    logs = [each.evidence(null) for each, null in zip(renewed, nulls, strict=True)]
    alone = tuple(cause_posterior([log]) for log in logs)
    posterior = alone[0] if len(logs) == 1 else cause_posterior(logs)
    if len(logs) > 1:
        moved = [_at(each, _sizes_of(posterior)) for each in renewed]
        new = [after is not before for after, before in zip(moved, renewed, strict=True)]
        if any(new):
            logs = [moved[i].evidence(nulls[i]) if new[i] else log for i, log in enumerate(logs)]
            renewed, posterior = moved, cause_posterior(logs)
    namings = [_naming(each, null, posterior) for each, null in zip(renewed, nulls, strict=True)]
    sizes = shared_sizes(namings).by_key()
    if len(namings) > 1:
        namings = [_with_sizes(naming, sizes) for naming in namings]
    return Together(posterior, tuple(namings), tuple(logs), alone, sizes)


def _at(renewed: Renewed, sizes: Mapping[Key, float]) -> Renewed:
    """The signatures at some sizes; the same object where none has to be computed anew."""
    layout = at_sizes(renewed.layout, sizes)
    if layout is renewed.layout:
        return renewed
    return Renewed(layout, whitened_equations(layout, renewed.noise), renewed.noise)


def _sizes_of(posterior: CausePosterior) -> dict[Key, float]:
    """The sizes of the most probable set of effects."""
    best = posterior.weights[0].explained
    return dict(zip(best.keys, best.weighed.sizes.tolist(), strict=True))


def shared_sizes(namings: Sequence[Naming], left_out: int | None = None) -> OwnSizes:
    """Return the sizes of the named effects as fitted to all flights together, or to all but one of
    them.

    Form error widens their bounds and must not shift them: this is a fit without it. A size that
    the others hardly show is drawn to zero by a wide prior, as its bound is.
    """
    keys = list(dict.fromkeys(key for naming in namings for key in _keys(naming)))
    parts = []
    for number, naming in enumerate(namings):
        if number != left_out:
            columns = [*naming.fit.columns, -1]
            parts.append((_keys(naming), naming.equations.inner[np.ix_(columns, columns)]))
    inner = _summed(keys, parts)
    shown = [i for i in range(len(keys)) if inner[i, i] > 0.0]
    squares, found = inner[np.ix_(shown, shown)], tuple(keys[i] for i in shown)
    covariance = np.linalg.inv(squares + np.diag([_widest(key) ** -2.0 for key in found]))
    if left_out is None:
        sizes = np.linalg.lstsq(squares, inner[shown, -1], rcond=None)[0]
    else:
        sizes = covariance @ inner[shown, -1]
    return OwnSizes(found, np.asarray(sizes), np.asarray(covariance))


def _summed(keys: Sequence[Key], parts: Sequence[_Part]) -> Array:
    """The inner products of some sizes and the residual, last, summed over logs, each with keys of
    its own.

    What a log does not show adds nothing.
    """
    inner = np.zeros((len(keys) + 1, len(keys) + 1))
    for own, products in parts:
        columns = [i for i, key in enumerate(own) if key in keys]
        rows = [*(keys.index(own[i]) for i in columns), len(keys)]
        inner[np.ix_(rows, rows)] += products[np.ix_([*columns, -1], [*columns, -1])]
    return inner


def _keys(naming: Naming) -> tuple[Key, ...]:
    """The sizes of the chosen effects that this flight shows, in the order of its fit."""
    signatures = [naming.layout.signatures[c] for c in naming.fit.columns]
    return tuple((s.effect, s.parameter) for s in signatures)


def _with_sizes(naming: Naming, sizes: Mapping[Key, float]) -> Naming:
    """The naming of a flight with the shared sizes in place of its own."""
    values = np.array([sizes[key] for key in _keys(naming)])
    columns = naming.fit.columns
    inner = naming.equations.inner
    gain = 2.0 * values @ inner[columns, -1] - values @ inner[np.ix_(columns, columns)] @ values
    return replace(naming, fit=Fit(columns, values, naming.fit.covariance, max(0.0, float(gain))))


def left_out_closures(namings: Sequence[Naming]) -> tuple[Closure | None, ...]:
    """Return for each flight the closure by the sizes that the other flights show; None where they
    show none.

    Effects for a part of one flight, and events, are fitted to that flight: another flight does not
    have them.
    """
    if len(namings) < 2:
        return (None,) * len(namings)
    found: list[Closure | None] = []
    for number, naming in enumerate(namings):
        sizes = shared_sizes(namings, left_out=number)
        pairs = [
            (column, sizes.keys.index(key))
            for column, key in zip(naming.fit.columns, _keys(naming), strict=True)
            if key in sizes.keys and returns(key[0])
        ]
        cells, columns, places = (
            naming.layout.examined,
            [c for c, _ in pairs],
            [p for _, p in pairs],
        )
        own = zip(naming.fit.columns, _keys(naming), strict=True)
        once = [column for column, key in own if not returns(key[0])]
        values = sizes.values[places].tolist()
        errors = with_form_error(sizes.covariance[np.ix_(places, places)], values)
        found.append(
            closure_of(naming.equations, columns, values, cells, errors, once) if pairs else None
        )
    return tuple(found)


def own_sizes(logs: Sequence[LogEvidence], effects: Names, sizes: Mapping[Key, float]) -> OwnSizes:
    """Return the sizes of some effects that logs show, with the form error of effects of about
    these sizes.

    The prior is as wide as a size can be, so that a log that does not show an effect says nothing
    of it.
    """
    search = CauseSearch(logs)
    shown = tuple(name for name in effects if name in search.keys)
    keys = search.keys_of(shown)
    evidence, _ = search.reduced(shown, np.array([sizes.get(key, 0.0) for key in keys]), keys)
    wide = np.array([_widest(key) for key in keys])
    found = Evidence(evidence.inner).of(range(len(keys)), wide)
    method = np.array([THRESHOLDS.size_error * sizes.get(key, 0.0) for key in keys])
    return OwnSizes(tuple(keys), found.mean, found.covariance + np.diag(method**2))


@dataclass(frozen=True, slots=True)
class FittedTogether:
    """The whole sizes of effects that several passes named, by effect, and the closure of all logs
    by them.

    `fits` holds for each log its layout without these effects in the model, its equations, and the
    fit.
    """

    sizes: Mapping[str, tuple[Estimate, ...]]
    closure: Closure
    fits: tuple[tuple[Layout, NormalEquations, Fit], ...]


def fit_together(
    layouts: Sequence[Layout], nulls: Sequence[NullDistribution], entries: Entries
) -> FittedTogether:
    """Fit the whole sizes of the effects that are in the model anew, all at once.

    `layouts` are those of the logs with the effects in the model, at the sizes of `entries`. A pass
    that names one effect cannot know what a later one names: it gives the first a part of the gap
    that is the other's. An effect that is not significant beside the others, or that would need an
    impossible size, is left out, the weakest first. Left out are also effects for a part of the
    flight, which stay as they are, and those that no log shows.
    """
    whole = []
    for layout, null in zip(layouts, nulls, strict=True):
        laid, noise = _with_whole_sizes(layout, entries), scaled_to(null.noise, layout)
        whole.append(Renewed(laid, whitened_equations(laid, noise), noise))
    keys = [tuple((s.effect, s.parameter) for s in each.layout.signatures) for each in whole]
    parts = [(own, each.equations.inner) for own, each in zip(keys, whole, strict=True)]
    logs = [
        each.evidence(null)
        for each, null in zip(whole, nulls, strict=True)
        if each.layout.signatures
    ]
    shown = [name for name in entries if any(name == key[0] for own in keys for key in own)]
    sizes, found = _needed(parts, logs, _one_form_of_each_cause(parts, shown))
    spread = dict(zip(found.keys, np.sqrt(np.diag(found.covariance)).tolist(), strict=True))
    told: dict[str, list[Estimate]] = {}
    for key in found.keys:
        told.setdefault(key[0], []).append(Estimate(key[1], sizes[key], 2.0 * spread[key]))
    closures, fits = [], []
    for each, own in zip(whole, keys, strict=True):
        columns = tuple(i for i, key in enumerate(own) if key in sizes)
        values, places = (
            np.array([sizes[own[i]] for i in columns]),
            [found.keys.index(own[i]) for i in columns],
        )
        closed = closure_of(each.equations, columns, values.tolist(), each.layout.examined)
        covariance = found.covariance[np.ix_(places, places)]
        fits.append(
            (
                each.layout,
                each.equations,
                Fit(columns, values, covariance, closed.before - closed.after),
            )
        )
        closures.append(closed)
    before, after, noise = (
        sum(getattr(c, part) for c in closures) for part in ("before", "after", "noise")
    )
    beyond = {name: significant(each) for name, each in told.items()}
    return FittedTogether(beyond, Closure(before, after, noise), tuple(fits))


def _needed(
    parts: Sequence[_Part], logs: Sequence[LogEvidence], names: Names
) -> tuple[dict[Key, float], OwnSizes]:
    """The sizes of those effects that are needed beside the others: as fitted, and with their
    covariance.
    """
    while names:
        sizes, _ = _fitted(parts, names)
        found = own_sizes(logs, names, sizes)
        scores = {name: _strength(found.of(name), sizes) for name in names}
        weakest = min(names, key=lambda name: scores[name])
        if len(names) == 1 or scores[weakest] >= THRESHOLDS.kept_from:
            return sizes, found
        names = tuple(name for name in names if name != weakest)
    return {}, OwnSizes((), np.zeros(0), np.zeros((0, 0)))


def _one_form_of_each_cause(parts: Sequence[_Part], names: Sequence[str]) -> Names:
    """Of each cause the form that explains most beside the others: two of them would share one
    size.
    """
    kept = tuple(names)
    for cause in dict.fromkeys(map(cause_of, names)):
        others = tuple(name for name in kept if cause_of(name) != cause)
        forms = [name for name in kept if cause_of(name) == cause]
        best = (
            max(forms, key=lambda name: _fitted(parts, (*others, name))[1])
            if len(forms) > 1
            else forms[0]
        )
        kept = tuple(name for name in kept if name in (*others, best))
    return kept


def _with_whole_sizes(layout: Layout, entries: Entries) -> Layout:
    """A layout with effects in its model, with their whole change in its residuals and no other
    signature.
    """
    sizes = {
        (s.effect, s.parameter): entries.get(s.effect, {}).get(s.parameter, 0.0)
        for s in layout.signatures
    }
    fitted = {name: own for name, own in entries.items() if name in FITTED}
    shapes = {
        n: {p.name: own[p.name] for p in FITTED[n].parameters if p.shape and p.name in own}
        for n, own in fitted.items()
    }
    layout = at_sizes(layout, {key: size for key, size in sizes.items() if size}, shapes)
    own = tuple(s for s in layout.signatures if s.effect in entries and lasts(s.effect))
    back = [-sizes[s.effect, s.parameter] for s in own]
    return replace(layout.without([s.column for s in own], back), signatures=own, in_model={})


def _fitted(parts: Sequence[_Part], names: Names) -> tuple[dict[Key, float], float]:
    """The sizes of some effects that fit all logs best, and the fall of the sum of squares by them."""
    keys = list(dict.fromkeys(key for own, _ in parts for key in own if key[0] in names))
    inner = _summed(keys, parts)
    scale = 1.0 / np.sqrt(np.maximum(np.diag(inner)[:-1], FARTHEST))
    normal, right = inner[:-1, :-1] * np.outer(scale, scale), inner[:-1, -1] * scale
    scaled = np.linalg.lstsq(normal, right, rcond=None)[0]
    return dict(zip(keys, (scaled * scale).tolist(), strict=True)), float(scaled @ right)


def _strength(found: OwnSizes, sizes: Mapping[Key, float]) -> float:
    """The distance [σ] of the sizes of an effect from zero; 0 where it is not needed.

    It is not where none of its sizes is beyond its bound, nor where one is impossible.
    """
    shown = False
    for (effect, name), deviation in zip(
        found.keys, np.sqrt(np.diag(found.covariance)).tolist(), strict=True
    ):
        size = Estimate(name, sizes[effect, name], 2.0 * deviation)
        if not FITTED[effect].parameter(name).is_possible(size):
            return 0.0
        shown = shown or abs(size.value) > size.two_sigma
    if not shown:
        return 0.0
    return float(
        np.sqrt(max(0.0, float(found.values @ np.linalg.solve(found.covariance, found.values))))
    )


def _widest(key: Key) -> float:
    """The widest prior deviation of a size."""
    return THRESHOLDS.size_scales[-1] * abs(float(FITTED[key[0]].parameter(key[1]).typical))


def contradiction(own: OwnSizes, others: OwnSizes) -> float:
    """Return the distance [σ] of the sizes that one flight shows from those that the other flights
    show.

    It is that of a normal number as improbable as the squared distance of the sizes, which is
    χ²-distributed.
    """
    both = [key for key in own.keys if key in others.keys]
    if not both:
        return 0.0
    mine, theirs = ([each.keys.index(key) for key in both] for each in (own, others))
    difference = own.values[mine] - others.values[theirs]
    covariance = own.covariance[np.ix_(mine, mine)] + others.covariance[np.ix_(theirs, theirs)]
    square = float(difference @ np.linalg.solve(covariance, difference))
    chance = float(chdtrc(len(both), square))
    return float(-ndtri(0.5 * max(chance, FARTHEST)))


def sizes_beside(together: Together, number: int, effects: Names) -> tuple[OwnSize, ...]:
    """The largest size of each effect that a flight shows, with the distance of all from those of
    the others.
    """
    sizes = dict(together.sizes)
    if not sizes:  # no shared name: the form error is that of the flight that shows most
        logs = list(together.logs)
        shown = [own_sizes([log], effects, {}) for log in logs]
        for own in shown:
            for key, value in zip(own.keys, own.values.tolist(), strict=True):
                sizes[key] = max(sizes.get(key, 0.0), value, key=abs)
    others = [log for i, log in enumerate(together.logs) if i != number]
    mine, theirs = (
        own_sizes([together.logs[number]], effects, sizes),
        own_sizes(others, effects, sizes),
    )
    found = []
    for effect in effects:
        own, other = mine.of(effect), theirs.of(effect)
        if not own.keys:
            continue
        spread = np.sqrt(np.diag(own.covariance))
        place = int(np.argmax(np.abs([sizes.get(key, 0.0) for key in own.keys]) / spread))
        size = Estimate(own.keys[place][1], float(own.values[place]), 2.0 * float(spread[place]))
        found.append(OwnSize(effect, size, contradiction(own, other) if other.keys else None))
    return tuple(found)


def contradictions(flights: Sequence[JoinedFlight]) -> list[str]:
    """Return a sentence for each effect that a flight contradicts, with the flight that does so
    most.

    Two flights are equally far apart: the one that shows less of the effect is the one that
    contradicts it.
    """
    lines = []
    for effect in dict.fromkeys(own.effect for flight in flights for own in flight.own_sizes):
        found = [
            (own.apart or 0.0, -abs(own.size.value) / own.size.two_sigma, flight.log, own)
            for flight in flights
            for own in flight.own_sizes
            if own.effect == effect
        ]
        apart, _, log, own = max(found, key=lambda row: (round(row[0], 6), row[1]))
        if apart > THRESHOLDS.contradicted_from:
            size = f"{own.size.name} {own.size.value:.3g} ± {own.size.two_sigma:.2g}"
            lines.append(
                f"{log} contradicts {effect}: it shows {size}, {apart:.1f}σ from the other flights"
            )
    return lines
