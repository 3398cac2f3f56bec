"""JSBSim expressions from Python: a number, a property's path, or an operation on them, as XML text."""

Expression = str
Term = str | float


def operation(kind: str, *terms: Term) -> Expression:
    """An operation of JSBSim's functions (`product`, `sum`, `quotient`, `max` …) on terms.

    A term is a number, the path of a property, or another expression.
    """
    return f"<{kind}>" + "".join(_term(term) for term in terms) + f"</{kind}>"


def product(*terms: Term) -> Expression:
    """The product of the terms."""
    return operation("product", *terms)


def total(*terms: Term) -> Expression:
    """The sum of the terms."""
    return operation("sum", *terms)


def difference(*terms: Term) -> Expression:
    """The first term less the others."""
    return operation("difference", *terms)


def quotient(over: Term, under: Term) -> Expression:
    """One term over another."""
    return operation("quotient", over, under)


def size(effect: str, parameter: str) -> str:
    """The property that holds a size of an effect; its value is in the parameter's own unit."""
    return f"effects/{effect}/{parameter}".replace("_", "-")


def _term(term: Term) -> str:
    if isinstance(term, str):
        return term if term.startswith("<") else f"<property>{term}</property>"
    return f"<value>{term!r}</value>"
