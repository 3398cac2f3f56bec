"""The formula of a gap in sentences and as plain data."""

from typing import Any

from pitotbench.records.formula import FormulaTerm, FoundFormula
from pitotbench.records.verdict import Closure
from pitotbench.show.quantity_words import listed, name_and_unit, words

# The symbols that need a word, each with the unit in which it enters a formula.
MEANINGS = {
    "M": "M is the Mach number",
    "q̄": "q̄ is the dynamic pressure in kPa",
    "P": "P is manifold pressure times speed over 40 inHg times 2,575 rpm",
    "h": "h is the height in 10,000 ft",
    "t": "t is the time since the first row in 10 min",
    "n": "n is the specific force in g",
    "δ": "δ is a deflection in rad",
    "α": "α is in rad",
    "β": "β is in rad",
    "p": "p is in rad/s",
    "q": "q is in rad/s",
    "r": "r is in rad/s",
}


def formula_sentences(formula: FoundFormula, holdout: str) -> list[str]:
    """What a formula says, what would do as well, and how much of the gap it closes."""
    left = f"Beside {listed([words(n) for n in formula.beside])}, the gap" if formula.beside else "The gap"
    meanings = [text for symbol, text in MEANINGS.items() if any(_holds(t.term, symbol) for t in formula.terms)]
    legend = f" Here {listed(meanings)}." if meanings else ""
    lines = [f"{left} follows a formula: {'; '.join(_equations(formula))}; ± is 2σ.{legend}"]
    lines += [_as_well(term) for term in formula.terms if term.alternatives]
    closed = f"The formula closes {_percent(formula.closure)} of the explainable gap of this log"
    if formula.beside:
        closed += " that the names leave"
    if formula.closure_holdout is not None:
        closed += f", and {_percent(formula.closure_holdout)} of that of {holdout}, to which it was not fitted"
    lines.append(closed + ".")
    if formula.refused:
        lines.append(f"It is not put into the model: {formula.refused}.")
    return lines


def formula_closures(formula: FoundFormula) -> list[tuple[str, Closure]]:
    """The closures of a formula by the log that they are of."""
    closures = [("fitted log", formula.closure)]
    return closures + ([("held-out log", formula.closure_holdout)] if formula.closure_holdout is not None else [])


def formula_json(formula: FoundFormula | None) -> dict[str, Any] | None:
    """A formula as plain data."""
    if formula is None:
        return None
    return {
        "terms": [
            {
                "effect": term.effect,
                "parameter": term.size.name,
                "value": term.size.value,
                "two_sigma": term.size.two_sigma,
                "formula": f"{term.symbol} ~ {term.term}",
                "significance": term.significance,
                "alternatives": list(term.alternatives),
            }
            for term in formula.terms
        ],
        "beside": list(formula.beside),
        "held_out_ratio": formula.held_out_ratio,
        "closure": formula.closure.share,
        "closure_holdout": formula.closure_holdout.share if formula.closure_holdout is not None else None,
        "refused": formula.refused or None,
    }


def _equations(formula: FoundFormula) -> list[str]:
    """One equation for each quantity that is corrected."""
    groups: dict[str, list[FormulaTerm]] = {}
    for term in formula.terms:
        groups.setdefault(term.effect, []).append(term)
    return [f"{terms[0].quantity}: {_equation(terms)}" for terms in groups.values()]


def _equation(terms: list[FormulaTerm]) -> str:
    unit = name_and_unit(f"x_{terms[0].unit}")[1] if terms[0].unit else ""
    parts = [_part(term, unit) for term in terms]
    return f"{terms[0].symbol} = " + " + ".join(parts)


def _part(term: FormulaTerm, unit: str) -> str:
    number = f"({term.size.value:.3g} ± {term.size.two_sigma:.2g})"
    number += unit if unit == "°" else f" {unit}" if unit else ""
    return number if term.term == "1" else f"{number} {term.term}"


def _as_well(term: FormulaTerm) -> str:
    others = listed(list(term.alternatives[:3]), "or")
    return f"In the place of {term.symbol} with {term.term}, the log is explained as well by {others}."


def _holds(term: str, symbol: str) -> bool:
    return any(word.startswith(symbol) for word in term.split()) and not (symbol == "q" and "q̄" in term)


def _percent(closed: Closure) -> str:
    return f"{100.0 * closed.share:.0f} %"
