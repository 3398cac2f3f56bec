"""Write JSBSim expressions as XML text: a number, the path of a property, or an operation on them."""

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
