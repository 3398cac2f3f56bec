"""A formula of a force or a sensor: a sum of terms, each with a coefficient that is a parameter of the effect."""

from collections.abc import Iterable, Mapping

import numpy as np

from pitotbench.effects.effect import Parameter
from pitotbench.effects.formula.terms import TERMS, Term, channels_of, values_of
from pitotbench.effects.signals import Signals
from pitotbench.units import Array

MOST = 50.0  # times the typical coefficient: no table bounds it, but a formula is no license for nonsense


def parameter_of(term: str, unit: str) -> str:
    """Return the name of the coefficient of a term, in a unit suffix that may be empty."""
    return f"{term}_{unit}" if unit else term


def term_of(parameter: str, unit: str) -> Term:
    """Return the term of a coefficient."""
    return TERMS[parameter.removesuffix(f"_{unit}") if unit else parameter]


def parameters_of(terms: Iterable[str], unit: str, typical: float, symbol: str) -> tuple[Parameter, ...]:
    """Return the coefficients of some terms; at its usual value each term then gives `typical`."""
    found = []
    for name in terms:
        size = typical / TERMS[name].usual
        what = f"coefficient of {TERMS[name].symbol} in {symbol}"
        found.append(
            Parameter(parameter_of(name, unit), size, -MOST * size, MOST * size, what, may_be_missing=True)
        )
    return tuple(found)


def formula_value(effect: str, signals: Signals, sizes: Mapping[str, float], unit: str) -> Array:
    """Return the value of a formula over a log, (n,), in its unit.

    Raises BadInputError that names a channel which a term needs and the log lacks.
    """
    value = np.zeros(len(signals))
    for parameter, size in sizes.items():
        if size:
            term = term_of(parameter, unit)
            signals.require(effect, channels_of(term))
            value = value + size * values_of(term, signals)
    return value
