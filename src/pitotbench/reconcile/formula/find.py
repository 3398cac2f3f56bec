"""Find the formula of a gap, with its coefficients and its closure on the log and on a held-out one."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pitotbench.effects import FORMULAS, SensorEffect
from pitotbench.effects.formula.coefficients import term_of
from pitotbench.effects.formula.force_formulas import AXES, FORCE_AXES
from pitotbench.effects.formula.sensor_formulas import READINGS
from pitotbench.reconcile.decide.closure import closure_of
from pitotbench.reconcile.decide.normal_equations import NormalEquations
from pitotbench.reconcile.decide.thresholds import THRESHOLDS
from pitotbench.reconcile.formula.stepwise import Chosen, choose_terms, folded_equations, offered
from pitotbench.reconcile.formula.term_signatures import Sizes, signatures_at, term_signatures
from pitotbench.reconcile.null_flights.null_distribution import NullDistribution
from pitotbench.reconcile.residuals.layout import Layout
from pitotbench.reconcile.residuals.layout_noise import scaled_to
from pitotbench.reconcile.signatures.signatures import Signature
from pitotbench.records.calibration import Estimate
from pitotbench.records.formula import FormulaTerm, FoundFormula
from pitotbench.records.verdict import Closure

RENEWALS = 2  # times the signatures are renewed at the fitted coefficients


def find_formula(layout: Layout, null: NullDistribution) -> FoundFormula | None:
    """Return the formula of the gap that a layout shows; None where no term holds out.

    The named effects must be in the model of the layout already.
    """
    noise = scaled_to(null.noise, layout)
    signatures = term_signatures(layout.scene)
    trial = replace(layout, signatures=signatures)
    equations = folded_equations(trial, noise)
    chosen = choose_terms(equations, offered(equations, len(signatures)))
    return None if chosen is None else _formula(trial, null, chosen)


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
        tuple(terms), closure_of(equations, columns, fit.sizes.tolist(), _cells(fitted)), chosen.held_out_ratio
    )


def closure_on(layout: Layout, null: NullDistribution, formula: FoundFormula) -> Closure:
    """Return the closure of a formula on another log, with its coefficients as they are."""
    trial, equations, sizes = _trial_of(layout, null, formula)
    return closure_of(equations, range(len(sizes)), sizes, _cells(trial))


def free_sizes_beside(layout: Layout, null: NullDistribution, formula: FoundFormula) -> dict[str, float]:
    """Return the free parameters of a log by name, fitted together with the coefficients of a formula.

    Without the formula the error curve and the temperature would take what they can of the gap.
    """
    _, equations, sizes = _trial_of(layout, null, formula)
    free = equations.free_sizes(range(len(sizes)))
    return dict(zip(layout.free.names, free.tolist(), strict=True))


def _trial_of(
    layout: Layout, null: NullDistribution, formula: FoundFormula
) -> tuple[Layout, NormalEquations, list[float]]:
    """A layout with the terms of a formula as its signatures, its normal equations, and the coefficients."""
    sizes: Sizes = {(t.effect, t.size.name): t.size.value for t in formula.terms}
    trial = replace(layout, signatures=signatures_at(layout.scene, sizes))
    equations = folded_equations(trial, scaled_to(null.noise, trial))
    return trial, equations, [sizes[s.effect, s.parameter] for s in trial.signatures]


def _cells(layout: Layout) -> Sequence[int]:
    return [i for i, _ in layout.places]


def _term(signature: Signature, size: Estimate, significance: float, alternatives: tuple[str, ...]) -> FormulaTerm:
    quantity, symbol, unit = described(signature.effect)
    term = term_of(signature.parameter, unit).symbol
    return FormulaTerm(signature.effect, size, quantity, symbol, unit, term, significance, alternatives)


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
