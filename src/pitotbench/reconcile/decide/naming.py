"""Name the effect: fit every hypothesis, apply the thresholds of null flights, abstain where the log is unclear."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pitotbench.reconcile.decide.explanations import Explanations
from pitotbench.reconcile.decide.normal_equations import Fit, NormalEquations
from pitotbench.reconcile.decide.scoring import joined, merit, significance
from pitotbench.reconcile.decide.thresholds import THRESHOLDS
from pitotbench.reconcile.null_flights.null_distribution import NullDistribution
from pitotbench.reconcile.residuals.layout import Layout
from pitotbench.reconcile.residuals.layout_noise import scaled_to, whitened_equations
from pitotbench.reconcile.residuals.whitening import NoiseModel
from pitotbench.reconcile.signatures.hypotheses import happens_once
from pitotbench.reconcile.signatures.refine import at_sizes, placed_in_time, without_sensor_effect
from pitotbench.reconcile.signatures.signatures import columns_of
from pitotbench.records.verdict import Candidate, Kind, Located

RENEWALS = 3  # times the signatures are renewed; they mostly stay as they are after the first
RENEWED = 6  # best single explanations whose signatures are renewed: the others have no part in the answer
LISTED = 10  # candidates in a verdict


@dataclass(frozen=True, slots=True)
class Naming:
    """The outcome of the fit.

    `chosen` are the effects fitted together, by `fit`, with the layout and the normal equations of that fit.
    `alternatives` holds, for each chosen effect, the other causes that fit equally well. `located` is the gap by
    channel before, `remaining` the gap after the chosen effects.
    """

    kind: Kind
    chosen: tuple[str, ...]
    alternatives: tuple[tuple[str, ...], ...]
    candidates: tuple[Candidate, ...]
    located: tuple[Located, ...]
    remaining: tuple[Located, ...]
    layout: Layout
    equations: NormalEquations
    fit: Fit


@dataclass(frozen=True, slots=True)
class _Renewed:
    """A layout with renewed signatures, and its normal equations."""

    layout: Layout
    equations: NormalEquations


def name_effects(layout: Layout, null: NullDistribution) -> Naming:
    """Name the effects that a log shows, given the noise and the thresholds of its null flights."""
    noise = scaled_to(null.noise, layout)
    renewed = _with_renewed_signatures(placed_in_time(layout, noise), noise)
    layout, equations = renewed.layout, renewed.equations
    explanations = Explanations(equations, layout.signatures, null)
    chosen = explanations.choose()
    columns = joined(explanations.columns, chosen)
    located = _located(renewed, null, ())
    remaining = _located(renewed, null, columns)
    alternatives = tuple(explanations.equivalents(chosen, i) for i in range(len(chosen)))
    kind = _kind(explanations, chosen, located, remaining)
    if kind == "named" and any(alternatives):
        kind = "one_of"
    candidates = tuple(explanations.candidate(n) for n in explanations.ranked()[:LISTED])
    fit = equations.fit(columns)
    return Naming(kind, chosen, alternatives, candidates, located, remaining, layout, equations, fit)


def _with_renewed_signatures(original: Layout, noise: NoiseModel) -> _Renewed:
    """Renew the signatures of the best explanations at their fitted sizes, and form the equations anew.

    A large effect on the sensors is subtracted from the clean track first.
    """
    layout, equations = original, whitened_equations(original, noise)
    columns = columns_of(layout.signatures)
    for _ in range(RENEWALS):
        sizes = _fitted_sizes(layout, equations, columns)
        best = max(columns, key=lambda n: merit(equations.fit(columns[n])))
        is_large = significance(equations.fit(columns[best])) > THRESHOLDS.undone_from
        undone = {parameter: v for (n, parameter), v in sizes.items() if n == best} if is_large else {}
        renewed = at_sizes(without_sensor_effect(layout, original, best, undone), sizes)
        if renewed is layout:
            break
        layout, equations = renewed, whitened_equations(renewed, noise)
    return _Renewed(layout, equations)


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


def _located(renewed: _Renewed, null: NullDistribution, given: Sequence[int]) -> tuple[Located, ...]:
    """The most significant place in every channel, in σ beyond the mean of null flights."""
    places = renewed.layout.places
    values = renewed.equations.scores([i for i, _ in places], given)
    best: dict[str, Located] = {}
    for (_, cell), value in zip(places, values, strict=True):
        score = null.scores.of_cell(cell, float(value))
        if cell.channel not in best or abs(score) > abs(best[cell.channel].significance):
            best[cell.channel] = Located(cell.channel, cell.phase, cell.variable, score)
    return tuple(sorted(best.values(), key=lambda place: -abs(place.significance)))


def _kind(
    explanations: Explanations, chosen: tuple[str, ...], located: Sequence[Located], remaining: Sequence[Located]
) -> Kind:
    """The kind of verdict, before causes that fit equally well are considered."""
    threshold = explanations.null.cell_threshold
    if not chosen:
        return "unknown" if located and abs(located[0].significance) > threshold else "no_gap"
    explained = significance(explanations.fit(chosen))
    allowed = float(np.hypot(threshold, THRESHOLDS.cell_beyond_error * THRESHOLDS.signature_error * explained))
    lasting = not any(happens_once(name) for name in chosen)  # an event shows in one block only
    if lasting and explanations.held_out_ratio(chosen) < THRESHOLDS.held_out_lowest:
        return "unknown"
    if remaining and abs(remaining[0].significance) > allowed:
        return "unknown"
    return "named"
