"""The terms of formulas as columns of the regression, for a gap that no effect explains."""

from collections.abc import Iterable, Iterator, Mapping, Sequence

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
from pitotbench.reconciliation.replay import REACTION_NAMES, coarse_rows, spread
from pitotbench.reconciliation.residuals import ForceModel, ReferenceState, change_by_answer
from pitotbench.reconciliation.signatures import Signature, residual_change
from pitotbench.records.calibration import Estimate
from pitotbench.records.gap import FormulaTerm
from pitotbench.units import Array

LOAD = 100.0  # lb: the lift that is put on the force meter to measure what a pound of it changes

Sizes = Mapping[tuple[str, str], float]  # by formula and coefficient


def term_signatures(reference: ReferenceState) -> tuple[Signature, ...]:
    """Return the signatures of all terms that a log can show, each at its typical coefficient."""
    wanted = [
        (name, p.name, p.typical) for name, formula in FORMULAS.items() for p in formula.parameters
    ]
    return tuple(_signatures(reference, wanted))


def signatures_at(reference: ReferenceState, sizes: Sizes) -> tuple[Signature, ...]:
    """Return the signatures of some terms at coefficients other than the typical ones."""
    return tuple(_signatures(reference, ((*key, size) for key, size in sizes.items())))


def _signatures(
    reference: ReferenceState, wanted: Iterable[tuple[str, str, float]]
) -> Iterator[Signature]:
    forces = _Forces(reference) if reference.force_model is not None else None
    for name, parameter, size in wanted:
        formula = FORMULAS[name]
        if isinstance(formula, SensorEffect):
            moved = _of_sensor(reference, formula, parameter, size)
        else:
            moved = None if forces is None else forces.change(name, parameter, size)
        if moved is not None and np.any(moved):
            yield Signature(name, parameter, size, moved / size)


def _of_sensor(
    reference: ReferenceState, formula: SensorEffect, parameter: str, size: float
) -> Array | None:
    term = term_of(parameter, READINGS[formula.name].unit)
    if not all(channel in reference.clean for channel in channels_of(term)):
        return None
    return residual_change(formula, reference, {parameter: size})


class _Forces:
    """The changes by formulas of force: a pound along each axis times the formula's pounds."""

    def __init__(self, reference: ReferenceState) -> None:
        assert reference.force_model is not None
        self.reference, self.model = reference, reference.force_model
        self.rows = self.model.replay.rows
        channels = {name: values[self.rows] for name, values in reference.clean.channels.items()}
        self.signals = Signals(reference.clean.time[self.rows], channels)
        lift = spread(self.rows, coarse_rows(reference.clean), _unit_lift(self.model))
        self.units = {**self.model.units.changes, "LIFT": lift}

    def change(self, name: str, parameter: str, size: float) -> Array | None:
        """Return the change of the residuals by a term, (n, c), None without its channels."""
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
        reference = self.reference
        return change_by_answer(
            reference.base.names, reference.clean, reference.grid, self.rows, lost
        )


def _unit_lift(model: ForceModel) -> Array:
    """What a pound of lift changes in each coarse state, (k, 6), measured with the engines held.

    The unit forces of the reference state do not hold it, because functions of drag may read the
    lift.
    """
    overlay = Overlay(functions=(AxisFunction("LIFT", product(LOAD, 1.0)),))
    return -model.missing(overlay, False)[:, :6] / LOAD


def described(formula: str) -> tuple[str, str, str]:
    """Return what a formula corrects in words, its symbol, and the suffix of its unit."""
    if isinstance(FORMULAS[formula], SensorEffect):
        reading = READINGS[formula]
        return reading.quantity, reading.symbol, reading.unit
    axis = AXES[FORCE_AXES[formula]]
    return axis.quantity, axis.symbol, ""


def formula_term(
    formula: str, size: Estimate, score: float, alternatives: Sequence[tuple[str, str]]
) -> FormulaTerm:
    """Return a term of a formula with its size, and in words other terms that would do as well."""
    quantity, symbol, unit = described(formula)
    term = term_of(size.name, unit).symbol
    others = tuple(_words(*each) for each in alternatives)
    return FormulaTerm(formula, size, quantity, symbol, unit, term, score, others)


def _words(formula: str, parameter: str) -> str:
    quantity, symbol, unit = described(formula)
    return f"{symbol} ({quantity}) with {term_of(parameter, unit).symbol}"
