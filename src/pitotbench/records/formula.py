"""A formula that describes a gap which the table of effects does not explain."""

from dataclasses import dataclass

from pitotbench.records.calibration import Estimate
from pitotbench.records.verdict import Closure


@dataclass(frozen=True, slots=True)
class FormulaTerm:
    """A term of a formula.

    `effect` and `size` are the entry of a case file: the name of the formula's effect, and the coefficient with its
    bound, in the unit of its name. `quantity`, `symbol` and `unit` say what is corrected, `term` what it follows.
    `significance` [σ] is that of the term beside the others. `alternatives` are other terms, in words, with which
    the log would be explained as well.
    """

    effect: str
    size: Estimate
    quantity: str
    symbol: str
    unit: str
    term: str
    significance: float
    alternatives: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class FoundFormula:
    """The formula of a gap: its terms, and how much of the gap it closes on the log and on a held-out one.

    `held_out_ratio` is the fall of the sum of squares in parts of the log that the coefficients were not fitted to,
    over that in the parts they were fitted to. `beside` are the named effects that were in the model before.
    `refused` says why a formula is shown but not made a patch, else it is empty.
    """

    terms: tuple[FormulaTerm, ...]
    closure: Closure
    held_out_ratio: float
    beside: tuple[str, ...] = ()
    closure_holdout: Closure | None = None
    refused: str = ""
