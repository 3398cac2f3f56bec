"""Stepwise selection of terms by the gain on parts of the log that the coefficients are not fitted to."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pitotbench.reconcile.decide.normal_equations import NormalEquations, equations_from, inner_products
from pitotbench.reconcile.residuals.layout import Layout
from pitotbench.reconcile.residuals.layout_noise import whitened_columns
from pitotbench.reconcile.residuals.whitening import NoiseModel

TERMS_MOST = 4  # more would be a fit of anything to anything, and no sentence
SEGMENT = 8.0  # s: a part that is left out whole; short, for a turn may come only once
FOLDS = 8  # sets of such parts, each left out once
TRIED = 16  # terms of the largest gain whose held-out gain is computed
FIRST_GAIN = 41.0  # fall of the SS by a first term: 6.4σ, as for what remains beside an effect
FURTHER_GAIN = 25.0  # by a further term: 5σ, for some 400 terms are tried again
FURTHER_SHARE = 0.02  # of all that is explained: less is the error of the form of the terms before
HELD_OUT_LEAST = 0.5  # share of the gain that must be there in the parts left out as well
NUISANCE_LEAVES = (
    0.0025  # share of a term that wind, curve and biases must leave: 5 % of its length, the error of a signature
)
ALIKE = 0.03  # of all that is explained: a term that explains so little less does as well
ALIKE_GAIN = 9.0  # fall of the SS (3σ) by which two terms are told apart in any case


@dataclass(frozen=True, slots=True)
class Chosen:
    """The columns of the chosen terms in their order, and for each the columns that would do as well."""

    columns: tuple[int, ...]
    alike: tuple[tuple[int, ...], ...]
    held_out_ratio: float


def folded_equations(layout: Layout, noise: NoiseModel) -> NormalEquations:
    """Return the normal equations of a log whose blocks are sets of short segments from all over it."""
    every = whitened_columns(layout, noise)
    time = layout.track.time[layout.grid.rows]
    fold = ((time - time[0]) / SEGMENT).astype(np.intp) % FOLDS
    products = [
        inner_products(every[own, :, :-1], every[own, :, -1], 1)[0]
        for n in range(FOLDS)
        if np.any(own := fold == n)
    ]
    return equations_from(np.stack(products), layout.free.columns.shape[2], layout.free.deviations)


def offered(equations: NormalEquations, count: int) -> list[int]:
    """Return those of the first `count` columns that the free parameters do not take."""
    k = equations.free
    whole = np.einsum("bii->i", equations.products)[k : k + count]
    kept = np.diag(equations.inner)[:count]
    return [i for i in range(count) if kept[i] > NUISANCE_LEAVES * whole[i] > 0.0]


def choose_terms(equations: NormalEquations, columns: Sequence[int]) -> Chosen | None:
    """Return the few columns that explain the gap best where they were not fitted; None where none does."""
    chosen: list[int] = []
    while len(chosen) < TERMS_MOST:
        best = _best_addition(equations, columns, chosen)
        if best is None:
            break
        chosen = _exchanged(equations, columns, [*chosen, best])
    if not chosen:
        return None
    gain = equations.fit(chosen).gain
    alike = tuple(_alike(equations, columns, chosen, own) for own in chosen)
    return Chosen(tuple(chosen), alike, equations.held_out_gain(chosen) / gain)


def _best_addition(equations: NormalEquations, columns: Sequence[int], chosen: Sequence[int]) -> int | None:
    """The column with the largest held-out gain beside the chosen ones, where it is large enough."""
    held = {c: equations.held_out_gain([c], chosen) for c in _leading(equations, columns, chosen)}
    if not held:
        return None
    best = max(held, key=lambda c: held[c])
    gain = equations.fit([best], chosen).gain
    before = equations.fit(chosen).gain if chosen else 0.0
    least = max(FURTHER_GAIN, FURTHER_SHARE * (before + gain)) if chosen else FIRST_GAIN
    return best if gain > least and held[best] > HELD_OUT_LEAST * gain else None


def _leading(equations: NormalEquations, columns: Sequence[int], chosen: Sequence[int]) -> list[int]:
    free = [c for c in columns if c not in chosen]
    scores = np.abs(equations.scores(free, chosen))
    return [free[i] for i in np.argsort(-scores)[:TRIED]]


def _exchanged(equations: NormalEquations, columns: Sequence[int], chosen: list[int]) -> list[int]:
    """The columns with each one exchanged for a better one, as long as the held-out gain grows.

    A first term is chosen before the others are known, and may stand for two of them.
    """
    best = equations.held_out_gain(chosen)
    for _ in range(TERMS_MOST if len(chosen) > 1 else 0):
        trials = [
            [*others, c]
            for i in range(len(chosen))
            for others in [[*chosen[:i], *chosen[i + 1 :]]]
            for c in _leading(equations, columns, others)[: TRIED // 2]
        ]
        gains = [equations.held_out_gain(trial) for trial in trials]
        if max(gains) <= best + 1.0:  # less is rounding
            break
        best, chosen = max(gains), trials[int(np.argmax(gains))]
    return chosen


def _alike(equations: NormalEquations, columns: Sequence[int], chosen: Sequence[int], own: int) -> tuple[int, ...]:
    """The columns that explain as much in the place of a chosen one, the best first."""
    others = [c for c in chosen if c != own]
    whole = equations.fit(chosen).gain
    least = whole - max(ALIKE_GAIN, ALIKE * whole)
    gains = {c: equations.fit([*others, c]).gain for c in _leading(equations, columns, others) if c != own}
    return tuple(c for c in sorted(gains, key=lambda c: -gains[c]) if gains[c] > least)
