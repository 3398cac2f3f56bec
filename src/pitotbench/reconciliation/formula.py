"""Find the formula of a gap that no effect explains, with its coefficients and its closure."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pitotbench.effects.effect import SensorEffect
from pitotbench.effects.formula import (
    AXES,
    FORCE_AXES,
    FORMULAS,
    READINGS,
    TERMS,
    channels_of,
    term_of,
    values_of,
)
from pitotbench.effects.overlay import AxisFunction, Overlay, product
from pitotbench.effects.response import Signals
from pitotbench.reconciliation.equations import (
    NormalEquations,
    closure_of,
    equations_from,
    inner_products,
    scaled_to,
    whitened_columns,
)
from pitotbench.reconciliation.layout import Layout
from pitotbench.reconciliation.noise import NoiseModel
from pitotbench.reconciliation.null_distribution import NullDistribution
from pitotbench.reconciliation.residuals import ForceModel, Scene, change_by_answer
from pitotbench.reconciliation.signatures import Signature, residual_change
from pitotbench.reconciliation.thresholds import THRESHOLDS
from pitotbench.reconciliation.track import COARSE, REACTION_NAMES, replay_rows, spread
from pitotbench.records.calibration import Estimate
from pitotbench.records.gap import FormulaTerm, FoundFormula
from pitotbench.records.verdict import Closure
from pitotbench.units import Array

# Stepwise selection of terms by the gain on parts of the log that the coefficients are not fitted
# to.

TERMS_MOST = 4  # more would be a fit of anything to anything, and no sentence
SEGMENT = 8.0  # s: a part that is left out whole; short, for a turn may come only once
FOLDS = 8  # sets of such parts, each left out once
TRIED = 16  # terms of the largest gain whose held-out gain is computed
FIRST_GAIN = 41.0  # fall of the SS by a first term: 6.4σ, as for what remains beside an effect
FURTHER_GAIN = 25.0  # by a further term: 5σ, for some 400 terms are tried again
FURTHER_SHARE = 0.02  # of all that is explained: less is the error of the form of the terms before
HELD_OUT_LEAST = 0.5  # share of the gain that must be there in the parts left out as well
NUISANCE_LEAVES = 0.0025  # share of a term that wind, curve and biases must leave: 5 % of its length, the error of a signature
ALIKE = 0.03  # of all that is explained: a term that explains so little less does as well
ALIKE_GAIN = 9.0  # fall of the SS (3σ) by which two terms are told apart in any case


@dataclass(frozen=True, slots=True)
class Chosen:
    """The columns of the chosen terms in their order, and for each the columns that would do as
    well.
    """

    columns: tuple[int, ...]
    alike: tuple[tuple[int, ...], ...]
    held_out_ratio: float


def folded_equations(layout: Layout, noise: NoiseModel) -> NormalEquations:
    """Return the normal equations of a log whose blocks are sets of short segments from all over
    it.
    """
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
    """Return the few columns that explain the gap best where they were not fitted; None where none
    does.
    """
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


def _best_addition(
    equations: NormalEquations, columns: Sequence[int], chosen: Sequence[int]
) -> int | None:
    """The column with the largest held-out gain beside the chosen ones, where it is large enough."""
    held = {c: equations.held_out_gain([c], chosen) for c in _leading(equations, columns, chosen)}
    if not held:
        return None
    best = max(held, key=lambda c: held[c])
    gain = equations.fit([best], chosen).gain
    before = equations.fit(chosen).gain if chosen else 0.0
    least = max(FURTHER_GAIN, FURTHER_SHARE * (before + gain)) if chosen else FIRST_GAIN
    return best if gain > least and held[best] > HELD_OUT_LEAST * gain else None


def _leading(
    equations: NormalEquations, columns: Sequence[int], chosen: Sequence[int]
) -> list[int]:
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


def _alike(
    equations: NormalEquations, columns: Sequence[int], chosen: Sequence[int], own: int
) -> tuple[int, ...]:
    """The columns that explain as much in the place of a chosen one, the best first."""
    others = [c for c in chosen if c != own]
    whole = equations.fit(chosen).gain
    least = whole - max(ALIKE_GAIN, ALIKE * whole)
    gains = {
        c: equations.fit([*others, c]).gain
        for c in _leading(equations, columns, others)
        if c != own
    }
    return tuple(c for c in sorted(gains, key=lambda c: -gains[c]) if gains[c] > least)


# The signatures of the terms of all formulas: what a unit of each coefficient changes in the
# residuals.

LOAD = 100.0  # lb: the lift that is put on the force meter to measure what a pound of it changes

Sizes = Mapping[tuple[str, str], float]  # by formula and coefficient


def term_signatures(scene: Scene) -> tuple[Signature, ...]:
    """Return the signatures of all terms that a log can show, each at its typical coefficient."""
    wanted = [
        (name, p.name, p.typical) for name, formula in FORMULAS.items() for p in formula.parameters
    ]
    return tuple(_signatures(scene, wanted))


def signatures_at(scene: Scene, sizes: Sizes) -> tuple[Signature, ...]:
    """Return the signatures of some terms at coefficients other than the typical ones."""
    return tuple(_signatures(scene, ((*key, size) for key, size in sizes.items())))


def _signatures(scene: Scene, wanted: Iterable[tuple[str, str, float]]) -> Iterator[Signature]:
    forces = _Forces(scene) if scene.force_model is not None else None
    for name, parameter, size in wanted:
        formula = FORMULAS[name]
        if isinstance(formula, SensorEffect):
            moved = _of_sensor(scene, formula, parameter, size)
        else:
            moved = None if forces is None else forces.change(name, parameter, size)
        if moved is not None and np.any(moved):
            yield Signature(name, parameter, size, moved / size)


def _of_sensor(scene: Scene, formula: SensorEffect, parameter: str, size: float) -> Array | None:
    term = term_of(parameter, READINGS[formula.name].unit)
    if not all(channel in scene.clean for channel in channels_of(term)):
        return None
    return residual_change(formula, scene, {parameter: size})


class _Forces:
    """The changes by formulas of force: a pound along each axis times the formula's pounds in every
    state.
    """

    def __init__(self, scene: Scene) -> None:
        assert scene.force_model is not None
        self.scene, self.model = scene, scene.force_model
        self.rows = replay_rows(scene.clean, COARSE)
        channels = {name: values[self.rows] for name, values in scene.clean.channels.items()}
        self.signals = Signals(scene.clean.time[self.rows], channels)
        self.units = {**self.model.units.changes, "LIFT": _unit_lift(self.model)}

    def change(self, name: str, parameter: str, size: float) -> Array | None:
        """Return the change of the residuals by one term, (n, c); None where the log lacks a
        channel of it.
        """
        if not all(channel in self.signals for channel in channels_of(TERMS[parameter])):
            return None
        axis, known = FORCE_AXES[name], self.model.units.properties
        pounds = (
            known["aero/qbar-psf"]
            * known["metrics/Sw-sqft"]
            * size
            * values_of(TERMS[parameter], self.signals)
        )
        if AXES[axis].length:
            pounds = pounds * known[AXES[axis].length]
        lost = np.zeros((len(self.rows), len(REACTION_NAMES)))
        lost[:, :6] = -self.units[axis] * pounds[:, None]
        scene, every = self.scene, self.model.replay.rows
        return change_by_answer(
            scene.base.names, scene.clean, scene.grid, every, spread(every, self.rows, lost)
        )


def _unit_lift(model: ForceModel) -> Array:
    """What a pound of lift changes in each state, (m, 6), measured with the engines held.

    The unit forces of the scene do not hold it, because functions of drag may read the lift.
    """
    overlay = Overlay(functions=(AxisFunction("LIFT", product(LOAD, 1.0)),))
    return -model.missing(overlay, False)[:, :6] / LOAD


# Find the formula of a gap, with its coefficients and its closure on the log and on a held-out one.

RENEWALS = 2  # times the signatures are renewed at the fitted coefficients


def find_formula(layout: Layout, null: NullDistribution) -> FoundFormula | None:
    """Return the formula of the gap that a layout shows; None where no term holds out.

    The named effects must be in the model of the layout already. A term whose coefficient would lie
    outside its range is none.
    """
    noise = scaled_to(null.noise, layout)
    signatures = term_signatures(layout.scene)
    trial = replace(layout, signatures=signatures)
    equations = folded_equations(trial, noise)
    columns = offered(equations, len(signatures))
    while (chosen := choose_terms(equations, columns)) is not None:
        formula = _formula(trial, null, chosen)
        sizes = [(FORMULAS[t.effect].parameter(t.size.name), t.size.value) for t in formula.terms]
        within = [own.within(value) == value for own, value in sizes]
        beyond = [c for c, is_within in zip(chosen.columns, within, strict=True) if not is_within]
        if not beyond:
            return formula
        columns = [column for column in columns if column not in beyond]
    return None


def _formula(layout: Layout, null: NullDistribution, chosen: Chosen) -> FoundFormula:
    noise, all_signatures = scaled_to(null.noise, layout), layout.signatures
    own = [all_signatures[c] for c in chosen.columns]
    columns = list(range(len(own)))
    for _ in range(RENEWALS):
        fitted = replace(layout, signatures=tuple(own))
        equations = folded_equations(fitted, noise)
        fit = equations.fit(columns)
        at = {(s.effect, s.parameter): float(v) for s, v in zip(own, fit.sizes, strict=True)}
        renewed = signatures_at(layout.scene, at)
        own = list(renewed) if len(renewed) == len(own) else own
    fitted = replace(layout, signatures=tuple(own))
    equations = folded_equations(fitted, noise)
    fit = equations.fit(columns)
    terms = []
    for i, signature in enumerate(own):
        bound = 2.0 * float(np.hypot(fit.deviations[i], THRESHOLDS.size_error * fit.sizes[i]))
        beside = equations.fit([i], [c for c in columns if c != i]).gain
        terms.append(
            _term(
                signature,
                Estimate(signature.parameter, float(fit.sizes[i]), bound),
                float(np.sqrt(beside)),
                tuple(_words(all_signatures[c]) for c in chosen.alike[i]),
            )
        )
    return FoundFormula(
        tuple(terms),
        closure_of(equations, columns, fit.sizes.tolist(), fitted.examined),
        chosen.held_out_ratio,
    )


def closure_on(layout: Layout, null: NullDistribution, formula: FoundFormula) -> Closure:
    """Return the closure of a formula on another log, with its coefficients as they are."""
    trial, equations, sizes = _trial_of(layout, null, formula)
    return closure_of(equations, range(len(sizes)), sizes, trial.examined)


def free_sizes_beside(
    layout: Layout, null: NullDistribution, formula: FoundFormula
) -> dict[str, float]:
    """Return the free parameters of a log by name, fitted together with the coefficients of a
    formula.

    Without the formula the error curve and the temperature would take what they can of the gap.
    """
    _, equations, sizes = _trial_of(layout, null, formula)
    free = equations.free_sizes(range(len(sizes)))
    return dict(zip(layout.free.names, free.tolist(), strict=True))


def _trial_of(
    layout: Layout, null: NullDistribution, formula: FoundFormula
) -> tuple[Layout, NormalEquations, list[float]]:
    """A layout with the terms of a formula as its signatures, its normal equations, and the
    coefficients.
    """
    sizes: Sizes = {(t.effect, t.size.name): t.size.value for t in formula.terms}
    trial = replace(layout, signatures=signatures_at(layout.scene, sizes))
    equations = folded_equations(trial, scaled_to(null.noise, trial))
    return trial, equations, [sizes[s.effect, s.parameter] for s in trial.signatures]


def _term(
    signature: Signature, size: Estimate, significance: float, alternatives: tuple[str, ...]
) -> FormulaTerm:
    quantity, symbol, unit = described(signature.effect)
    term = term_of(signature.parameter, unit).symbol
    return FormulaTerm(
        signature.effect, size, quantity, symbol, unit, term, significance, alternatives
    )


def described(formula: str) -> tuple[str, str, str]:
    """Return what a formula corrects in words, its symbol, and the suffix of its unit."""
    if isinstance(FORMULAS[formula], SensorEffect):
        reading = READINGS[formula]
        return reading.quantity, reading.symbol, reading.unit
    axis = AXES[FORCE_AXES[formula]]
    return axis.quantity, axis.symbol, ""


def _words(signature: Signature) -> str:
    quantity, symbol, unit = described(signature.effect)
    return f"{symbol} ({quantity}) with {term_of(signature.parameter, unit).symbol}"
