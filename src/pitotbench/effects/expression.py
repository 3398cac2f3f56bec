"""Write JSBSim expressions as XML text: a number, the path of a property, or an operation on them.

An expression can also be evaluated for recorded properties, without JSBSim.
"""

import xml.etree.ElementTree as ET
from collections.abc import Callable, Mapping
from functools import reduce

import numpy as np

from pitotbench.units import Array

Expression = str
Term = str | float


def operation(kind: str, *terms: Term) -> Expression:
    """Return an operation of JSBSim's functions (`product`, `sum`, `quotient`, `max` …) on terms.

    A term is a number, the path of a property, or another expression.
    """
    return f"<{kind}>" + "".join(_term(term) for term in terms) + f"</{kind}>"


def product(*terms: Term) -> Expression:
    """Return the product of the terms."""
    return operation("product", *terms)


def total(*terms: Term) -> Expression:
    """Return the sum of the terms."""
    return operation("sum", *terms)


def difference(*terms: Term) -> Expression:
    """Return the first term minus the others."""
    return operation("difference", *terms)


def quotient(over: Term, under: Term) -> Expression:
    """Return one term divided by another."""
    return operation("quotient", over, under)


def size(effect: str, parameter: str) -> str:
    """Return the path of the property that holds a size of an effect, in the unit of the parameter."""
    return f"effects/{effect}/{parameter}".replace("_", "-")


def _term(term: Term) -> str:
    if isinstance(term, str):
        return term if term.startswith("<") else f"<property>{term}</property>"
    return f"<value>{term!r}</value>"


# What JSBSim's functions do, applied to all states at once.
_OPERATIONS: Mapping[str, Callable[..., Array]] = {
    "product": lambda *terms: reduce(np.multiply, terms),
    "sum": lambda *terms: reduce(np.add, terms),
    "difference": lambda *terms: reduce(np.subtract, terms),
    "quotient": np.divide,
    "max": lambda *terms: reduce(np.maximum, terms),
    "min": lambda *terms: reduce(np.minimum, terms),
    "abs": np.abs,
    "sqrt": np.sqrt,
    "sin": np.sin,
    "cos": np.cos,
}


def properties_in(expression: Expression) -> frozenset[str]:
    """Return the paths of the properties that an expression reads."""
    return frozenset((node.text or "").strip() for node in ET.fromstring(expression).iter("property"))


def evaluate(expression: Expression, properties: Mapping[str, Array | float]) -> Array:
    """Return the values of an expression for values of its properties, numbers or arrays (n,) in JSBSim's units.

    Raises KeyError for an operation that is not listed here, and for a property without values.
    """
    return _evaluated(ET.fromstring(expression), properties)


def _evaluated(node: ET.Element, properties: Mapping[str, Array | float]) -> Array:
    text = (node.text or "").strip()
    if node.tag == "value":
        return np.asarray(float(text))
    if node.tag == "property":
        return np.asarray(properties[text])
    return np.asarray(_OPERATIONS[node.tag](*(_evaluated(term, properties) for term in node)))
