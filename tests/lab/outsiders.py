"""Causes outside the table: what is told of them, and how much of a held-out flight the formula closes.

python -m tests.lab.outsiders [--only NAME] [--alone]
With --alone the formula is looked for at once, without the table and without null flights: ten times as fast.
Every cause is flown twice on different days: one log is explained, the other is held out. Null flights follow.
"""

import argparse
import time
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

from tests.reconciliation.outside_table import OUTSIDERS, Outsider, flown

from pitotbench.bench.null_flights import aircraft_model
from pitotbench.bench.rounds import NamedLog
from pitotbench.bench.workflow import FullReconciliation, reconcile_fully
from pitotbench.reconciliation.formula import closure_on, find_formula
from pitotbench.reconciliation.free_parameters import AnalysisSetting
from pitotbench.reconciliation.null_distribution import theoretical_distribution
from pitotbench.reconciliation.renewal import lay_out_with
from pitotbench.records.gap import FoundFormula
from pitotbench.records.verdict import SURE
from pitotbench.show.gap_words import formula_sentences

FIRST_DAY, FIRST_NULL = 3000, 3900
NULLS = 6
ENOUGH = 0.8  # of the gap of the held-out flight


def explained(outsider: Outsider | None, number: int, folder: Path) -> FullReconciliation:
    """The reconciliation of a flight with a hidden cause, with another flight of it held out."""
    fit, held = (flown(outsider, number + i, folder) for i in (0, 1))
    logs = NamedLog("fit", fit), NamedLog("held out", held)
    return reconcile_fully(logs[0], "navajo", logs[1], refly=False, refly_holdout=False)


def alone(outsider: Outsider | None, number: int, folder: Path) -> FoundFormula | None:
    """The formula of a flight, in the noise that its log shows, with its closure on another flight."""
    model, setting = aircraft_model("navajo"), AnalysisSetting(day_known=True)
    fit, held = (lay_out_with(flown(outsider, number + i, folder), model, setting, {}) for i in (0, 1))
    null = theoretical_distribution(fit)
    formula = find_formula(fit, null)
    return None if formula is None else replace(formula, closure_holdout=closure_on(held, null, formula))


def main() -> None:
    """Print a line for each cause and each null flight, and the shares of all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", default="", help="causes whose name contains this")
    parser.add_argument("--alone", action="store_true", help="the formula alone, without the table")
    options = parser.parse_args()
    only = options.only
    causes: dict[str, tuple[Outsider | None, int]] = {
        name: (outsider, FIRST_DAY + 2 * i) for i, (name, outsider) in enumerate(OUTSIDERS.items())
    }
    causes |= {f"null {i}": (None, FIRST_NULL + 2 * i) for i in range(NULLS)}
    closed, right, wrong, told = [], 0, 0, 0
    print("| hidden | verdict | named | formula | quantity | G fitted | G held out | CPU s |\n|" + "---|" * 8)
    with TemporaryDirectory() as folder:
        for name, (outsider, number) in causes.items():
            if only not in name:
                continue
            before = time.process_time()
            if options.alone:
                kind, named, formula = "", [], alone(outsider, number, Path(folder))
            else:
                outcome = explained(outsider, number, Path(folder))
                verdict, formula = outcome.reconciliation.verdict, outcome.account.formula
                kind, named = verdict.kind, [e.name for e in verdict.effects] if verdict.kind in SURE else []
            spent = time.process_time() - before
            quantities = {t.quantity for t in formula.terms} if formula else set()
            held = formula.closure_holdout.share if formula and formula.closure_holdout else 0.0
            if outsider is None:
                told += bool(formula or named)
            else:
                closed.append(held)
                wrong += bool(named)
                right += outsider.where in quantities
            text = formula_sentences(formula, "held out")[0] if formula else ""
            mark = (
                "" if outsider is None or formula is None else "right" if outsider.where in quantities else "other"
            )
            shares = f"{formula.closure.share:.2f} | {held:.2f}" if formula else "| "
            cells = [name, kind, ", ".join(named), text, mark, shares, f"{spent:.0f}"]
            print(f"| {' | '.join(cells)} |", flush=True)
    if closed:
        enough = sum(g >= ENOUGH for g in closed)
        print(f"\nof {len(closed)}: closed {enough}, right quantity {right}, named {wrong}")
    print(f"nulls with a name or a formula: {told}")


if __name__ == "__main__":
    main()
