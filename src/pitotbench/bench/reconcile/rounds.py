"""Name, add, look again, until nothing significant remains."""

from collections.abc import Callable, Sequence
from dataclasses import replace

from pitotbench.bench.reconcile.reconciliation import AnalysisSetting, Reconciliation, aircraft_model
from pitotbench.reconcile.decide.naming import Naming
from pitotbench.reconcile.decide.patches import Patch, Shapes, patch_of_effects
from pitotbench.reconcile.signatures.patched_model import look_again
from pitotbench.records.gap import Round
from pitotbench.records.log import FlightLog
from pitotbench.records.verdict import SURE, Candidate, Verdict

MOST = 3  # looks at one log

Progress = Callable[[str], None]


def fitted_shapes(named: Naming) -> Shapes:
    """The shapes of the chosen effects where they were fitted: the time of an event."""
    chosen = [named.layout.signatures[c] for c in named.fit.columns]
    return {signature.effect: signature.shapes for signature in chosen if signature.shapes}


def others(verdict: Verdict) -> list[list[Candidate]]:
    """For each effect, the explanations that the log does not tell from it, where their sizes are known."""
    known = {candidate.name: candidate for candidate in verdict.candidates}
    return [[known[name] for name in names if name in known] for names in verdict.alternatives]


def patch_of(found: Reconciliation, more: Sequence[Candidate], shapes: Shapes, source: str, date: str) -> Patch:
    """The patch of a reconciliation and of what further looks found; empty where the verdict is not sure."""
    first = found.verdict.effects if found.verdict.kind in SURE else ()
    return patch_of_effects(_joined((*first, *more)), source, date, shapes, others(found.verdict) if first else ())


def look_until_quiet(
    log: FlightLog,
    aircraft: str,
    found: Reconciliation,
    setting: AnalysisSetting | None = None,
    progress: Progress | None = None,
) -> tuple[tuple[Round, ...], tuple[Candidate, ...], Shapes]:
    """The rounds of a reconciliation: each looks at the log with all that was named before in the model.

    Ends with a verdict of no gap or of an unknown cause, or after `MOST` looks. Returns the rounds, the effects
    that further looks added, and the fitted shapes of all.
    """
    rounds = [_round(found.verdict)]
    shapes, more = dict(fitted_shapes(found.naming)), list[Candidate]()
    model = aircraft_model(aircraft)
    setting = replace(setting or AnalysisSetting(), day_known=found.card is not None)
    while rounds[-1].added and len(rounds) < MOST:
        if progress is not None:
            progress(f"looking again with {', '.join(rounds[-1].added)} in the model")
        entries = dict(patch_of(found, more, shapes, "", "").entries)
        verdict, named = look_again(log, model, found.known, setting, entries)
        rounds.append(_round(_news(verdict, named, set(entries))))
        more += [e for e in rounds[-1].verdict.effects if rounds[-1].added]
        shapes |= fitted_shapes(named)
    return tuple(rounds), tuple(more), shapes


def _round(verdict: Verdict) -> Round:
    return Round(verdict, tuple(e.name for e in verdict.effects) if verdict.kind in SURE else ())


def _news(verdict: Verdict, named: Naming, before: set[str]) -> Verdict:
    """The verdict without what is in the patch already and cannot be taken out of a log: what was counted, or seen
    in the gusts, is seen again. A size that is fitted again is a correction, and news."""
    kept = [i for i, e in enumerate(verdict.effects) if e.name not in before or e.name in named.chosen]
    return replace(
        verdict,
        kind="no_gap" if verdict.kind in SURE and not kept else verdict.kind,
        effects=tuple(verdict.effects[i] for i in kept),
        alternatives=tuple(verdict.alternatives[i] for i in kept),
    )


def _joined(effects: Sequence[Candidate]) -> tuple[Candidate, ...]:
    """Effects with the corrections of their sizes added to them."""
    found: dict[str, Candidate] = {}
    for effect in effects:
        old = {s.name: s.value for s in found[effect.name].sizes} if effect.name in found else {}
        sizes = tuple(replace(s, value=s.value + old.get(s.name, 0.0)) for s in effect.sizes)
        found[effect.name] = replace(effect, sizes=sizes)
    return tuple(found.values())
