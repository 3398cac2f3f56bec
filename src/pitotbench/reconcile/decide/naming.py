"""Name the effect: fit every hypothesis, apply the thresholds of null flights, abstain where the log is unclear."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pitotbench.reconcile.decide.explanations import CONTENDERS, LINEAR, Explanations
from pitotbench.reconcile.decide.normal_equations import Fit, NormalEquations
from pitotbench.reconcile.decide.scoring import joined, merit, score_candidates
from pitotbench.reconcile.null_flights.null_distribution import Knowledge
from pitotbench.reconcile.residuals.layout import FITTED, Layout, columns_of, scaled_to, weigh_layout
from pitotbench.reconcile.residuals.whitening import NoiseModel
from pitotbench.reconcile.signatures.refine import at_sizes, placed_in_time, without
from pitotbench.records.verdict import Candidate, Kind, Located

ROUNDS = 3
LARGE = 8.0  # score from which an effect on the sensors is undone before others are judged
HONEST = 0.4  # held-out over in-sample gain, below which an explanation does not hold
SHOWN = 10


@dataclass(frozen=True, slots=True)
class Naming:
    """The outcome of the fit: `chosen` are the effects fitted together, with the study and evidence behind them.

    `alternatives` holds, for each chosen effect, the other causes that fit as well.
    """

    kind: Kind
    chosen: tuple[str, ...]
    alternatives: tuple[tuple[str, ...], ...]
    candidates: tuple[Candidate, ...]
    located: tuple[Located, ...]
    leftover: tuple[Located, ...]
    layout: Layout
    evidence: NormalEquations
    fit: Fit


def name_effects(layout: Layout, known: Knowledge) -> Naming:
    """Name the effects that a log shows, given the noise and the thresholds of its null flights."""
    noise = scaled_to(known.noise, layout)
    layout, weighed = _renewed(placed_in_time(layout, noise), noise)
    table = Explanations(weighed, layout.signatures, known)
    chosen = table.choose()
    located = _located(layout, weighed, known, ())
    leftover = _located(layout, weighed, known, joined(table.columns, chosen))
    alternatives = tuple(table.like(chosen, i) for i in range(len(chosen)))
    kind = _kind(table, chosen, alternatives, located, leftover)
    candidates = tuple(table.candidate(n) for n in table.ranked()[:SHOWN])
    fit = weighed.fit(joined(table.columns, chosen))
    return Naming(kind, chosen, alternatives, candidates, located, leftover, layout, weighed, fit)


def _renewed(seen: Layout, noise: NoiseModel) -> tuple[Layout, NormalEquations]:
    """Renew the signatures of the best explanations at their fitted sizes, and weigh the evidence anew.

    A large effect on the sensors is taken out of the clean track first.
    """
    layout, weighed = seen, weigh_layout(seen, noise)
    columns = columns_of(layout.signatures)
    for _ in range(ROUNDS):
        sizes = _fitted_sizes(layout, weighed, columns)
        best = max(columns, key=lambda n: merit(weighed.fit(columns[n])))
        own = {parameter: v for (n, parameter), v in sizes.items() if n == best}
        undone = without(layout, seen, best, own if score_candidates(weighed.fit(columns[best])) > LARGE else {})
        renewed = at_sizes(undone, sizes)
        if renewed is layout:
            break
        layout, weighed = renewed, weigh_layout(renewed, noise)
    return layout, weighed


def _fitted_sizes(
    layout: Layout, weighed: NormalEquations, columns: Mapping[str, Sequence[int]]
) -> dict[tuple[str, str], float]:
    """Sizes of the best explanations, each fitted alone."""
    fits = {n: weighed.fit(c) for n, c in columns.items()}
    best = sorted(fits, key=lambda n: -merit(fits[n]))[:CONTENDERS]
    sizes: dict[tuple[str, str], float] = {}
    for effect in best:
        for column, size in zip(columns[effect], fits[effect].sizes, strict=True):
            sizes[effect, layout.signatures[column].parameter] = float(size)
    return sizes


def _located(
    layout: Layout, weighed: NormalEquations, known: Knowledge, given: Sequence[int]
) -> tuple[Located, ...]:
    """The most significant place in every channel, in σ beyond the usual value of null flights."""
    places = layout.places
    values = weighed.scores([i for i, _ in places], given)
    best: dict[str, Located] = {}
    for (_, cell), value in zip(places, values, strict=True):
        told = known.told_at(cell, float(value))
        if cell.channel not in best or abs(told) > abs(best[cell.channel].significance):
            best[cell.channel] = Located(cell.channel, cell.phase, cell.variable, told)
    return tuple(sorted(best.values(), key=lambda place: -abs(place.significance)))


def _happens_once(name_effects: str) -> bool:
    """Whether an effect has a time at which it happens."""
    return any(p.shape and p.name.endswith("_s") for p in FITTED[name_effects].parameters)


def _kind(
    table: Explanations,
    chosen: tuple[str, ...],
    alternatives: Sequence[Sequence[str]],
    located: Sequence[Located],
    leftover: Sequence[Located],
) -> Kind:
    threshold = table.known.cell_threshold
    if not chosen:
        return "unknown" if located and abs(located[0].significance) > threshold else "no_gap"
    explained = score_candidates(table.fit(chosen))
    allowed = float(np.hypot(threshold, 3.0 * LINEAR * explained))
    lasting = not any(_happens_once(name_effects) for name_effects in chosen)  # an event shows in one block only
    if lasting and table.held_out_ratio(chosen) < HONEST:
        return "unknown"
    if leftover and abs(leftover[0].significance) > allowed:
        return "unknown"
    return "one_of" if any(alternatives) else "named"
