"""A verdict and an account of a reconciliation as plain data."""

from typing import Any

from pitotbench.records.gap import Account, FlownAgain
from pitotbench.records.verdict import Candidate, Closure, Verdict
from pitotbench.show.columns import json_rows
from pitotbench.show.flight_tables import advised_json, flight_json
from pitotbench.show.formula_words import formula_json
from pitotbench.show.verdict_tables import (
    CHECK_COLUMNS,
    DETECTABLE_COLUMNS,
    PLACE_COLUMNS,
    TOLERANCE_COLUMNS,
    candidate_columns,
)

LEAST_PROBABILITY = 0.001  # of a cause that is listed


def verdict_json(verdict: Verdict) -> dict[str, Any]:
    """The verdict as plain data; the gap as sums of squares in units of the noise."""
    return {
        "verdict": verdict.kind,
        "effects": [_effect(effect) for effect in verdict.effects],
        "alternatives": [list(names) for names in verdict.alternatives],
        "remains": verdict.remains,
        "doubts": list(verdict.doubts),
        "probabilities": {name: p for name, p in verdict.probabilities.items() if p > LEAST_PROBABILITY},
        "log_bayes_factor": verdict.log_bayes_factor,
        "candidates": json_rows(candidate_columns(verdict), verdict.candidates),
        "gap_before": verdict.closure.before,
        "gap_after": verdict.closure.after,
        "gap_noise": verdict.closure.noise,
        "closure": _share(verdict, verdict.closure),
        "closure_holdout": _share(verdict, verdict.closure_holdout),
        "located": json_rows(PLACE_COLUMNS, verdict.located),
        "checks": json_rows(CHECK_COLUMNS, verdict.checks),
        "advice": list(verdict.advice),
        "smallest_detectable": json_rows(DETECTABLE_COLUMNS, verdict.smallest_detectable),
        "notes": list(verdict.notes),
    }


def account_json(account: Account) -> dict[str, Any]:
    """The verdict, the passes that followed and the card flown again, as plain data."""
    return verdict_json(account.rounds[0].verdict) | {
        "rounds": [
            {"verdict": r.verdict.kind, "added": list(r.added), "closure": _share(r.verdict, r.verdict.closure)}
            for r in account.rounds
        ],
        "waterfall": [{"effect": step.effect, "left": step.left} for step in account.waterfall],
        "flown_again": _flown(account.flown),
        "flown_again_holdout": _flown(account.flown_holdout),
        "null_flights": account.null_flights,
        "formula": formula_json(account.formula),
        "flights": [flight_json(flight) for flight in account.flights],
        "next_flight": advised_json(account.next_flight),
        "warnings": list(account.warnings),
    }


def _flown(flown: FlownAgain) -> dict[str, Any]:
    return {
        "skipped": flown.skipped or None,
        "pilot": flown.pilot or None,
        "within_tolerance": json_rows(TOLERANCE_COLUMNS, flown.tolerances),
    }


def _share(verdict: Verdict, closed: Closure | None) -> float | None:
    return closed.share if closed is not None and verdict.effects else None


def _effect(effect: Candidate) -> dict[str, Any]:
    sizes = [{"name": s.name, "value": s.value, "two_sigma": s.two_sigma} for s in effect.sizes]
    return {
        "name": effect.name,
        "parameters": sizes,
        "times": dict(effect.times),
        "score": effect.score,
        "probability": effect.probability,
    }
