"""From a log that is laid out to a verdict: name, examine what remains, close, advise."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pitotbench.catalog import Catalog
from pitotbench.effects import AircraftEffect, Effect
from pitotbench.reconcile.decide.advice_for import flights_to_fly
from pitotbench.reconcile.decide.closure import closure_of, with_form_error
from pitotbench.reconcile.decide.naming import SMALLEST_GAIN, Naming, name_effects
from pitotbench.reconcile.decide.normal_equations import Fit, NormalEquations
from pitotbench.reconcile.decide.sizes import estimates, significant
from pitotbench.reconcile.decide.thresholds import THRESHOLDS
from pitotbench.reconcile.null_flights.gust_levels import turbulence_candidates
from pitotbench.reconcile.null_flights.null_distribution import NullDistribution, theoretical_distribution
from pitotbench.reconcile.null_flights.periodic import periodic_channels
from pitotbench.reconcile.null_flights.wander import wandering_channels
from pitotbench.reconcile.residuals.free_parameters import AnalysisSetting
from pitotbench.reconcile.residuals.layout import DAY, Layout, lay_out
from pitotbench.reconcile.residuals.layout_noise import scaled_to, whitened_equations
from pitotbench.reconcile.residuals.scene import AircraftModel
from pitotbench.reconcile.signatures.hypotheses import FITTED, ONE_MODEL, cause_of, returns
from pitotbench.reconcile.signatures.refine import at_sizes, without_sensor_effects
from pitotbench.reconcile.signatures.signatures import columns_of, times_of
from pitotbench.records.log import FlightLog
from pitotbench.records.verdict import SURE, Candidate, Closure, Detectable, Kind, Verdict


def judge(layout: Layout, null: NullDistribution) -> tuple[Verdict, Naming]:
    """Return the verdict on a log that is laid out, and the naming from which it follows."""
    naming = name_effects(layout, null)
    return verdict_of(layout, naming, null), naming


def verdict_of(layout: Layout, naming: Naming, null: NullDistribution) -> Verdict:
    """Return the verdict that follows from a naming: with what was counted, the turbulence, and what remains."""
    explained = _without_named(naming)
    gusts = turbulence_candidates(explained, null.gust_levels)
    # Other turbulence than that of the card makes every channel wander.
    wandering = () if gusts else wandering_channels(explained, naming.layout, null, naming.fit.gain)
    unexplained = (*wandering, *periodic_channels(explained, null, naming.fit.gain))
    counted = layout.checked.effects
    named, others_of = _named_effects(naming), dict(zip(naming.chosen, naming.alternatives, strict=True))
    effects = (*counted, *named, *gusts)
    alternatives = (
        *((),) * len(counted),
        *(others_of[effect.name] for effect in named),
        *(("turbulence_scale",),) * len(gusts),
    )
    kind: Kind = naming.answer.kind
    if unexplained and not counted and (not naming.chosen or _outweighs(explained, naming, null)):
        kind = "unknown"
    elif kind == "no_gap" and effects:
        kind = "one_of" if any(alternatives) else "named"
    remains = kind in SURE and (bool(unexplained) or naming.answer.rest > THRESHOLDS.rest_likely)
    groups = [(e.name, *others) for e, others in zip(effects, alternatives, strict=True)]
    equations, fit = naming.equations, naming.fit
    return Verdict(
        kind=kind,
        effects=effects,
        alternatives=alternatives,
        candidates=naming.candidates,
        located=(*unexplained, *(naming.remaining if remains else naming.located)),
        checks=layout.checked.checks,
        closure=closure_of(equations, fit.columns, fit.sizes.tolist(), _cells(naming.layout)),
        smallest_detectable=smallest_detectable(equations, naming.layout, null, fit.columns),
        advice=flights_to_fly(kind, groups),
        notes=_notes(layout, null, naming),
        probabilities=naming.answer.probabilities,
        log_bayes_factor=naming.posterior.log_bayes_factor,
        remains=remains,
    )


def _outweighs(explained: Layout, naming: Naming, null: NullDistribution) -> bool:
    """Whether a wander or a line that is left is larger than a share of what the effects explain.

    Neither is smooth, so that the posterior has no hypothesis for it, and a cause that takes up a part of it is not
    its cause.
    """
    share = THRESHOLDS.outweighing_share / THRESHOLDS.remaining_share * naming.fit.gain
    return bool(
        wandering_channels(explained, naming.layout, null, share) or periodic_channels(explained, null, share)
    )


def _named_effects(naming: Naming) -> tuple[Candidate, ...]:
    """The chosen effects with the sizes that are beyond their bounds, as fitted together.

    An effect that other flights name and this one cannot show is left out.
    """
    columns, fit = columns_of(naming.layout.signatures), naming.fit
    effects = []
    for effect in naming.chosen:
        own = [c for c in fit.columns if c in columns.get(effect, ())]
        if not own:
            continue
        others = [c for c in fit.columns if c not in own]
        gain = naming.equations.fit(own, given=others).gain
        ratio = naming.equations.held_out_gain(own, others) / max(gain, SMALLEST_GAIN)
        places = [fit.columns.index(c) for c in own]
        part = Fit(tuple(own), fit.sizes[places], fit.covariance[np.ix_(places, places)], gain)
        sizes = significant(estimates(naming.layout.signatures, part))
        probability = naming.answer.probabilities.get(cause_of(effect), 0.0)
        times = times_of(naming.layout.signatures[own[0]])
        effects.append(Candidate(effect, sizes, float(np.sqrt(gain)), ratio, True, probability, times))
    return tuple(effects)


def _without_named(naming: Naming) -> Layout:
    """The layout with the named effects subtracted from its residuals."""
    columns = [naming.layout.signatures[c].column for c in naming.fit.columns]
    return naming.layout.without(columns, naming.fit.sizes)


def _cells(layout: Layout) -> list[int]:
    return [i for i, _ in layout.places]


def smallest_detectable(
    equations: NormalEquations, layout: Layout, null: NullDistribution, given: Sequence[int] = ()
) -> tuple[Detectable, ...]:
    """Return the size of each effect that would reach its threshold half of the time.

    The columns `given` are those of the named effects, which are fitted together with each size.
    """
    sizes = []
    for index, signature in enumerate(layout.signatures):
        if index in given or FITTED[signature.effect].variant_of:
            continue
        deviation = float(equations.fit([index], given).deviations[0])
        parameter = FITTED[signature.effect].parameter(signature.parameter)
        size = null.threshold_of(signature.effect) * deviation
        if 0.0 < size <= max(abs(parameter.low), abs(parameter.high)):
            sizes.append(Detectable(signature.effect, signature.parameter, size))
    return tuple(sizes)


def _notes(layout: Layout, null: NullDistribution, naming: Naming) -> tuple[str, ...]:
    """Sentences on the limits of a verdict."""
    notes = []
    if null.flights == 0:
        notes.append(
            "no null flights of this card: the log's noise counts half as much again, "
            f"a gap from e^{null.gap_bayes_factor:.0f} on"
        )
    if layout.scene.force_model is None:
        notes.append("no aircraft model: sensors and air alone are judged")
    shown = {s.effect for s in layout.signatures}
    if not layout.setting.day_known:
        shown.add(DAY)
        notes.append("the header does not tell the temperature of the day: another one is no gap")
    hidden = [n for n, effect in FITTED.items() if n not in shown and not effect.variant_of]
    lacking = _without_the_parts(hidden, layout)
    if lacking:
        notes.append("left out, because the model of the aircraft lacks what they change: " + ", ".join(lacking))
    unseen = [n for n in hidden if n not in lacking]
    if unseen:
        notes.append("cannot be seen in the channels of this log: " + ", ".join(unseen))
    notes += [
        f"{other} is one model with {effect}: it has the same terms in every channel"
        for other, effect in ONE_MODEL.items()
        if effect in map(cause_of, naming.chosen)
    ]
    ratios = scaled_to(null.noise, layout).deviations / null.noise.deviations
    noisy = [
        f"{n} ({r:.1f} times)" for n, r in zip(null.noise.names, ratios, strict=True) if r > THRESHOLDS.noise_noted
    ]
    if noisy and null.flights:
        notes.append("more noise than on null flights: " + ", ".join(noisy))
    return tuple(notes)


def _without_the_parts(names: Sequence[str], layout: Layout) -> list[str]:
    """Return those of the effects that the aircraft cannot take at all."""
    model = layout.scene.force_model
    acting = [(n, effect) for n in names if isinstance(effect := FITTED[n], AircraftEffect)]
    return [] if model is None else [n for n, effect in acting if not effect.fitting(model.aircraft.baseline)]


def for_channels(of_card: NullDistribution | None, layout: Layout) -> NullDistribution:
    """Return the null distribution of a card if it has the channels of a log; else one from the log itself."""
    if of_card is not None and of_card.noise.names == layout.residuals.names:
        return of_card
    return theoretical_distribution(layout)


def hold_out(
    log: FlightLog, aircraft: AircraftModel | None, null: NullDistribution, naming: Naming, setting: AnalysisSetting
) -> Closure:
    """Return the closure of the named effects on another log, with the sizes fitted before.

    Events and effects for a part of one flight are left out: the other flight has them at other times, or not at
    all. So are sizes that the other log cannot show. The noise is that of the other log alone where it has other
    channels.
    """
    chosen: Catalog[Effect] = Catalog("effect", {n: FITTED[n] for n in naming.chosen if returns(n)})
    layout = lay_out(log, aircraft, setting, chosen)
    signatures = [naming.layout.signatures[c] for c in naming.fit.columns]
    sizes = {(s.effect, s.parameter): float(v) for s, v in zip(signatures, naming.fit.sizes, strict=True)}
    entries: dict[str, dict[str, float]] = {name: {} for name in chosen}
    for each, size in zip(signatures, naming.fit.sizes, strict=True):
        if each.effect in entries:
            entries[each.effect] |= {**each.shapes, each.parameter: float(size)}
    shapes = {s.effect: dict(s.shapes) for s in signatures if s.shapes}
    layout = at_sizes(without_sensor_effects(layout, entries), sizes, shapes)
    equations = whitened_equations(layout, scaled_to(for_channels(null, layout).noise, layout))
    keys = [(s.effect, s.parameter) for s in layout.signatures]
    columns = [i for i, key in enumerate(keys) if key in sizes]
    fitted, own = [sizes[keys[i]] for i in columns], list(sizes)
    places = [own.index(keys[i]) for i in columns]
    errors = with_form_error(naming.fit.covariance[np.ix_(places, places)], fitted)
    return closure_of(equations, columns, fitted, _cells(layout), errors)


def closes(held: Closure) -> bool:
    """Whether effects close enough of the gap of a log that their sizes were not fitted to.

    They do where what is left of the gap is within chance: a log that shows little of an effect says little of it,
    and so do sizes that are hardly known.
    """
    by_chance = THRESHOLDS.gap_cell + THRESHOLDS.left_by_chance * held.chance
    return held.share >= THRESHOLDS.hold_out_lowest or held.after - held.noise < by_chance


def taken_back(verdict: Verdict, why: str) -> Verdict:
    """Return a verdict without the names that it gives, and the reason as a note."""
    if verdict.kind not in SURE or not verdict.effects:
        return replace(verdict, notes=(*verdict.notes, why))
    named = ", ".join(effect.name for effect in verdict.effects)
    note = f"{why}: the name {named} is taken back"
    kept = replace(verdict, kind="unknown", effects=(), alternatives=(), doubts=(*verdict.doubts, why))
    return replace(kept, notes=(*verdict.notes, note))


def doubted(verdict: Verdict, why: str) -> Verdict:
    """Return a verdict whose names are only probable, because a check speaks against them: `why`.

    Of such names about half are right: more than of any other cause, and too few for a name.
    """
    if verdict.kind not in SURE or not verdict.effects:
        return replace(verdict, notes=(*verdict.notes, why))
    return replace(verdict, kind="one_of", remains=True, doubts=(*verdict.doubts, why))


def with_hold_out(verdict: Verdict, held: Closure) -> Verdict:
    """Return the verdict with the closure on a held-out log, which takes the name back where it is too small."""
    if verdict.kind in SURE and not closes(held):
        verdict = taken_back(verdict, f"only {max(0.0, held.share):.0%} of the gap of the held-out log is closed")
    return replace(verdict, closure_holdout=held)
