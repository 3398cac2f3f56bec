"""From a log to a verdict: check, locate, name, close, advise, each step a function of this room."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pitotbench.catalog import Catalog
from pitotbench.effects import Effect
from pitotbench.reconcile.decide.advice_for import flights_to_fly
from pitotbench.reconcile.decide.closure import closure_of
from pitotbench.reconcile.decide.explanations import estimates
from pitotbench.reconcile.decide.naming import Naming, name_effects
from pitotbench.reconcile.decide.normal_equations import NormalEquations
from pitotbench.reconcile.null_flights.gust_levels import turbulence
from pitotbench.reconcile.null_flights.null_distribution import Knowledge
from pitotbench.reconcile.null_flights.periodic import swinging
from pitotbench.reconcile.null_flights.wander import unexplained
from pitotbench.reconcile.residuals.free_parameters import AnalysisSetting
from pitotbench.reconcile.residuals.layout import FITTED, Layout, columns_of, lay_out, scaled_to, weigh_layout
from pitotbench.reconcile.signatures.refine import at_sizes, without
from pitotbench.reconcile.signatures.signatures import AircraftModel
from pitotbench.records.log import FlightLog
from pitotbench.records.verdict import Candidate, Closure, Detectable, Kind, Verdict


def judge(layout: Layout, known: Knowledge) -> tuple[Verdict, Naming]:
    """The verdict on a log that is laid out, and the naming behind it."""
    named = name_effects(layout, known)
    rest = _explained(named)
    seen = turbulence(rest, known.gusts)
    gained = named.fit.gain
    odd = () if seen else unexplained(rest, named.layout, known.noise, known.powers, gained)
    odd = (*odd, *swinging(rest, known.noise, known.swings, gained))
    effects = (*layout.found.effects, *_effects(named), *seen)
    alternatives = (*((),) * len(layout.found.effects), *named.alternatives, *(("turbulence_scale",),) * len(seen))
    kind: Kind = "unknown" if odd and not layout.found.effects else named.kind
    if kind in ("named", "no_gap") and effects:
        kind = "one_of" if any(alternatives) else "named"
    groups = [(e.name, *others) for e, others in zip(effects, alternatives, strict=True)]
    verdict = Verdict(
        kind=kind,
        effects=effects,
        alternatives=alternatives,
        candidates=named.candidates,
        located=(*odd, *(named.leftover if kind == "unknown" and named.chosen else named.located)),
        checks=layout.found.checks,
        closure=closure_of(named.evidence, named.fit.columns, named.fit.sizes.tolist(), _cells(named.layout)),
        smallest_detectable=smallest_detectable(named.evidence, named.layout, known, named.fit.columns),
        advice=flights_to_fly(kind, groups),
        notes=_notes(layout, known, named),
    )
    return verdict, named


def _effects(named: Naming) -> tuple[Candidate, ...]:
    """The chosen effects with their sizes as fitted together."""
    columns = columns_of(named.layout.signatures)
    found = []
    for effect in named.chosen:
        others = [c for n in named.chosen if n != effect for c in columns[n]]
        alone = named.evidence.fit(columns[effect], given=others)
        ratio = named.evidence.held_out_gain(columns[effect], others) / max(alone.gain, 1e-9)
        sizes = estimates(named.layout.signatures, alone)
        found.append(Candidate(effect, sizes, float(np.sqrt(alone.gain)), ratio, True))
    return tuple(found)


def _explained(named: Naming) -> Layout:
    """The study with what was named taken out of its residuals."""
    layout = named.layout
    columns = [layout.signatures[c].column for c in named.fit.columns]
    taken = sum(
        (c * s for c, s in zip(columns, named.fit.sizes, strict=True)), np.zeros_like(layout.residuals.values)
    )
    return replace(layout, residuals=replace(layout.residuals, values=layout.residuals.values - taken))


def _cells(layout: Layout) -> list[int]:
    return [i for i, _ in layout.places]


def smallest_detectable(
    weighed: NormalEquations, layout: Layout, known: Knowledge, given: Sequence[int] = ()
) -> tuple[Detectable, ...]:
    """The size of each effect that would have reached the threshold half of the time, what was named being
    known."""
    found = []
    for index, signature in enumerate(layout.signatures):
        if index in given or FITTED[signature.effect].variant_of:
            continue
        deviation = float(weighed.fit([index], given).deviations[0])
        parameter = FITTED[signature.effect].parameter(signature.parameter)
        size = known.needed(signature.effect) * deviation
        if 0.0 < size <= max(abs(parameter.low), abs(parameter.high)):
            found.append(Detectable(signature.effect, signature.parameter, size))
    return tuple(found)


def _notes(layout: Layout, known: Knowledge, named: Naming) -> tuple[str, ...]:
    notes = []
    if known.flights == 0:
        notes.append("no null flights of this card: noise from the log itself, thresholds one half above theory")
    if layout.scene.model is None:
        notes.append("no aircraft model: sensors and air alone are judged")
    seen = {s.effect for s in layout.signatures}
    hidden = [n for n, effect in FITTED.items() if n not in seen and not effect.variant_of]
    if hidden:
        notes.append("cannot be seen in the channels of this log: " + ", ".join(hidden))
    noise = scaled_to(known.noise, layout).deviations / known.noise.deviations
    loud = [f"{n} ({r:.1f} times)" for n, r in zip(known.noise.names, noise, strict=True) if r > 1.3]
    if loud and known.flights:
        notes.append("more noise than on null flights: " + ", ".join(loud))
    return tuple(notes)


def hold_out(
    log: FlightLog, aircraft: AircraftModel | None, known: Knowledge, named: Naming, setting: AnalysisSetting
) -> Closure:
    """What the named effects, with the sizes already found, close on another log."""
    chosen: Catalog[Effect] = Catalog("effect", {n: FITTED[n] for n in named.chosen})
    layout = lay_out(log, aircraft, setting, chosen)
    sizes = {
        (named.layout.signatures[c].effect, named.layout.signatures[c].parameter): float(v)
        for c, v in zip(named.fit.columns, named.fit.sizes, strict=True)
    }
    for effect in named.chosen:
        layout = without(layout, layout, effect, {p: v for (n, p), v in sizes.items() if n == effect})
    layout = at_sizes(layout, sizes)
    weighed = weigh_layout(layout, scaled_to(known.noise, layout))
    values = [sizes[s.effect, s.parameter] for s in layout.signatures]
    return closure_of(weighed, range(len(values)), values, _cells(layout))


def with_hold_out(verdict: Verdict, held: Closure) -> Verdict:
    """The verdict with the closure on a held-out log."""
    return replace(verdict, closure_holdout=held)
