"""Where the table of effects leaves a gap, describe the gap by a formula and put the formula into the model."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from pitotbench.bench.reconcile import Progress
from pitotbench.bench.reconcile.aircraft_models import aircraft_model
from pitotbench.bench.reconcile.reconciliation import Reconciliation
from pitotbench.bench.reconcile.rounds import Looks, patch_of, without_names
from pitotbench.reconcile.formula.find import closure_on, find_formula, free_sizes_beside
from pitotbench.reconcile.residuals.layout import Layout
from pitotbench.reconcile.signatures.patched_model import lay_out_with
from pitotbench.records.calibration import Estimate
from pitotbench.records.formula import FoundFormula
from pitotbench.records.log import FlightLog
from pitotbench.records.verdict import SURE, Candidate

HOLD_OUT_LEAST = 0.5  # closure of a held-out log below which a formula is shown, but not put into the model


@dataclass(frozen=True, slots=True)
class BeyondTable:
    """A reconciliation and its looks, with the formula of what they leave; None where nothing is left to describe.

    Where a formula alone says more than names with a formula beside them, the names are taken back in both.
    `free_sizes` are the free parameters of the log beside the formula, by name.
    """

    first: Reconciliation
    looks: Looks
    formula: FoundFormula | None = None
    free_sizes: Mapping[str, float] = field(default_factory=dict)

    @property
    def entries(self) -> tuple[Candidate, ...]:
        """The formula as effects for the patch; empty where it is refused."""
        if self.formula is None or self.formula.refused:
            return ()
        sizes: dict[str, list[Estimate]] = {}
        for term in self.formula.terms:
            sizes.setdefault(term.effect, []).append(term.size)
        ratio = self.formula.held_out_ratio
        return tuple(Candidate(name, tuple(each), 0.0, ratio, True) for name, each in sizes.items())


def beyond_the_table(
    aircraft: str, first: Reconciliation, looks: Looks, holdout: FlightLog | None, progress: Progress | None = None
) -> BeyondTable:
    """Describe what the named effects leave of the gap; `holdout` is a log on which the formula is to hold as well.

    Raises BadInputError for a held-out log that cannot be compared.
    """
    last = looks.rounds[-1].verdict
    if not (last.kind == "unknown" or last.remains):
        return BeyondTable(first, looks)
    if progress is not None:
        progress("looking for a formula of what the table does not explain")
    names = dict(patch_of(first, looks.added, looks.shapes, "", "").entries)
    formula = find_formula(_remaining(looks), first.null)
    if names:
        alone = find_formula(first.naming.layout, first.null)
        if alone is not None and _is_simpler(alone, formula, names):
            why = f"a formula explains more than {', '.join(names)} with a formula beside it"
            first, looks, formula, names = *without_names(first, why), alone, {}
    if formula is None:
        return BeyondTable(first, looks)
    formula = replace(formula, beside=tuple(names))
    free = free_sizes_beside(_remaining(looks), first.null, formula)
    if holdout is not None:
        formula = _held_out(formula, aircraft, first, holdout, names)
    return BeyondTable(first, looks, formula, free)


def _remaining(looks: Looks) -> Layout:
    """The layout of the last look, with what it named subtracted."""
    naming = looks.last
    if looks.rounds[-1].verdict.kind not in SURE:
        return naming.layout
    columns = [naming.layout.signatures[c].column for c in naming.fit.columns]
    return naming.layout.without(columns, naming.fit.sizes)


def _is_simpler(alone: FoundFormula, beside: FoundFormula | None, names: Mapping[str, Mapping[str, float]]) -> bool:
    """Whether a formula alone leaves no more of the gap than names with a formula, and has fewer sizes."""
    if beside is None:
        return False
    sizes = sum(map(len, names.values())) + len(beside.terms)
    return len(alone.terms) < sizes and alone.closure.after <= beside.closure.after


def _held_out(
    formula: FoundFormula,
    aircraft: str,
    first: Reconciliation,
    holdout: FlightLog,
    names: Mapping[str, Mapping[str, float]],
) -> FoundFormula:
    layout = lay_out_with(holdout, aircraft_model(aircraft), first.layout.setting, names)
    closed = closure_on(layout, first.null, formula)
    why = (
        f"it closes only {closed.share:.0%} of the gap of the held-out log" if closed.share < HOLD_OUT_LEAST else ""
    )
    return replace(formula, closure_holdout=closed, refused=why)
