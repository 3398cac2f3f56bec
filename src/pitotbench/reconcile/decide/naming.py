"""Name the effects of a log: fit every hypothesis, form the posterior over causes, and read its answer."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pitotbench.reconcile.decide.answer import Answer, answer_of
from pitotbench.reconcile.decide.log_evidence import LogEvidence
from pitotbench.reconcile.decide.normal_equations import Fit, NormalEquations
from pitotbench.reconcile.decide.null_wander import wander_of
from pitotbench.reconcile.decide.posterior import CausePosterior, cause_posterior
from pitotbench.reconcile.decide.scoring import merit, significance
from pitotbench.reconcile.decide.sizes import estimates, is_in_range
from pitotbench.reconcile.decide.thresholds import THRESHOLDS
from pitotbench.reconcile.null_flights.null_distribution import NullDistribution
from pitotbench.reconcile.residuals.layout import Layout
from pitotbench.reconcile.residuals.layout_noise import scaled_to, whitened_equations
from pitotbench.reconcile.residuals.whitening import NoiseModel
from pitotbench.reconcile.signatures.change_points import with_parts_of_flight
from pitotbench.reconcile.signatures.hypotheses import FITTED, cause_of
from pitotbench.reconcile.signatures.refine import Entries, at_sizes, placed_in_time, without_sensor_effects
from pitotbench.reconcile.signatures.signatures import columns_of, times_of
from pitotbench.records.verdict import Candidate, Located

RENEWALS = 3  # times the signatures are renewed; they mostly stay as they are after the first
RENEWED = 6  # best single explanations whose signatures are renewed: the others have no part in the answer
SETTLED = 0.02  # change of a size, as a share, from which an effect is taken out of the log anew
LISTED = 10  # candidates in a verdict
SMALLEST_GAIN = 1e-9  # so that the ratio of two gains is defined for an effect without any


@dataclass(frozen=True, slots=True)
class Naming:
    """The outcome of the posterior over causes.

    `chosen` are the effects fitted together, by `fit`, with the layout and the normal equations of that fit.
    `alternatives` holds, for each chosen effect, the other causes of the set that holds it. `located` is the gap
    by channel before, `remaining` the gap after the chosen effects.
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
    """A layout with its signatures at the fitted sizes, its normal equations, and the noise model of both."""

    layout: Layout
    equations: NormalEquations
    noise: NoiseModel

    def evidence(self, null: NullDistribution) -> LogEvidence:
        """Return the evidence of the log."""
        wander = wander_of(null, self.layout.residuals.names)
        return LogEvidence(self.layout, self.noise, wander, null.scores, null.gap_bayes_factor)


def name_effects(layout: Layout, null: NullDistribution) -> Naming:
    """Name the effects that a log shows, given the noise and the wander of its null flights."""
    renewed = renewed_signatures(layout, null)
    log = renewed.evidence(null)
    posterior = cause_posterior([log])
    return naming_of(renewed, null, posterior)


def naming_of(renewed: Renewed, null: NullDistribution, posterior: CausePosterior) -> Naming:
    """Return what a posterior names on a log: its own, or that of several logs of which it is one."""
    answer, layout, equations = answer_of(posterior), renewed.layout, renewed.equations
    chosen = answer.effects
    fit = _fit(renewed, answer)
    located, remaining = _located(renewed, null, ()), _located(renewed, null, fit.columns)
    alternatives = tuple(answer.others(cause_of(name)) for name in chosen)
    candidates = _candidates(renewed, null, posterior, answer)
    return Naming(answer, posterior, chosen, alternatives, candidates, located, remaining, layout, equations, fit)


def renewed_signatures(original: Layout, null: NullDistribution) -> Renewed:
    """Renew the signatures of the best explanations at their fitted sizes, and form the equations anew.

    Events are placed in time. A large effect on the sensors is subtracted from the clean track first.
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
        parameter = FITTED[best].parameter(signature.parameter)
        sizes[signature.parameter] = float(np.clip(size, parameter.low, parameter.high))
    return {best: sizes}


def _is_near(large: Entries, undone: Entries) -> bool:
    """Whether effects that are to be taken out of a log are those already taken out, at about the same sizes."""
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
    """The sizes of the named effects as a fit of this log, with the bounds that their form error leaves.

    Form error widens the bounds and must not shift the sizes: these are a fit without it. A size of another log of
    the posterior that this log cannot show has no column.
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
            equations.held_out_gain(columns[name]) / max(fits[name].gain, SMALLEST_GAIN),
            is_in_range(signatures, fits[name]),
            probable.get(cause_of(name), 0.0),
            times_of(signatures[columns[name][0]]),
        )
        for name in ranked[:LISTED]
    )


def _located(renewed: Renewed, null: NullDistribution, given: Sequence[int]) -> tuple[Located, ...]:
    """The most significant place in every channel, in σ beyond the mean of null flights."""
    places = renewed.layout.places
    values = renewed.equations.scores([i for i, _ in places], given)
    best: dict[str, Located] = {}
    for (_, cell), value in zip(places, values, strict=True):
        score = null.scores.of_cell(cell, float(value))
        if cell.channel not in best or abs(score) > abs(best[cell.channel].significance):
            best[cell.channel] = Located(cell.channel, cell.phase, cell.variable, score)
    return tuple(sorted(best.values(), key=lambda place: -abs(place.significance)))
