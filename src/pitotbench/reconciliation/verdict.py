"""From flights that are laid out to one verdict: name, examine what remains, close, and doubt."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from importlib.resources import files

import numpy as np
from scipy.special import expit, logit

from pitotbench.catalog import Catalog
from pitotbench.effects import effect_of
from pitotbench.effects.effect import AircraftEffect, Effect
from pitotbench.reconciliation.equations import (
    Fit,
    NormalEquations,
    closure_of,
    scaled_to,
    whitened_equations,
    with_form_error,
)
from pitotbench.reconciliation.evidence import estimates, significant
from pitotbench.reconciliation.free_parameters import AnalysisSetting
from pitotbench.reconciliation.layout import DAY, Layout, lay_out
from pitotbench.reconciliation.naming import (
    Naming,
    Together,
    contradictions,
    left_out_closures,
    name_effects,
    sizes_beside,
    strongest,
)
from pitotbench.reconciliation.null_distribution import NullDistribution, theoretical_distribution
from pitotbench.reconciliation.null_learning import (
    periodic_channels,
    turbulence_candidates,
    wandering_channels,
)
from pitotbench.reconciliation.patches import flights_to_fly
from pitotbench.reconciliation.posterior import OUTSIDE, answer_of
from pitotbench.reconciliation.renewal import at_sizes, without_sensor_effects
from pitotbench.reconciliation.residuals import AircraftModel
from pitotbench.reconciliation.signatures import FITTED, cause_of, columns_of, returns, times_of
from pitotbench.reconciliation.thresholds import THRESHOLDS
from pitotbench.records.log import FlightLog
from pitotbench.records.verdict import (
    SURE,
    Candidate,
    Closure,
    Detectable,
    JoinedFlight,
    Kind,
    Verdict,
)
from pitotbench.units import Array

# From what every check found to a verdict.


@dataclass(frozen=True, slots=True)
class Objection:
    """What a check says against the names: it withdraws them, or leaves them only probable."""

    why: str
    withdraws: bool


@dataclass(frozen=True, slots=True)
class Checks:
    """What every check found on the flights of a verdict; `verdict_of` makes the verdict of it.

    `found` is what all flights show, with the kind of the posterior's answer. Each step fills its
    own field:
    `outweighed`, whether a wander or a line of a flight outweighs what the effects explain;
    `left_out` and
    `contradictions`, the sentences of flights that the others do not close or that contradict them;
    `hold_out`,
    the closure of a held-out log; `closure`, the objection of the closure of all passes; `formula`,
    why a formula replaces the names; `maneuvers`, those flown, which no advice repeats; `added`,
    the positions of the effects that a later pass adds (None: all); `left`, the share of the gap
    that all passes leave, and `doubt`, a share of doubt beside it (None: by the objections to these
    names).
    """

    found: Verdict
    outweighed: bool = False
    left_out: tuple[str, ...] = ()
    contradictions: tuple[str, ...] = ()
    hold_out: Closure | None = None
    closure: Objection | None = None
    formula: str = ""
    maneuvers: tuple[str, ...] = ()
    added: tuple[int, ...] | None = None
    left: float | None = None
    doubt: float | None = None


def verdict_of(checks: Checks) -> Verdict:
    """Return the verdict of what all checks found. Nothing else sets the kind of a verdict.

    First the posterior answers. A wander or a line may outweigh its effects, and what was counted
    is a gap of its own. Then the objections follow: flights left out, contradictions, a held-out
    log, the closure of all passes, a formula. A later pass tells only what it adds. The doubt of
    the table comes last.
    """
    verdict = replace(checks.found, closure_holdout=checks.hold_out)
    if checks.outweighed:
        why = "a wander or a line outweighs what the effects explain"
        verdict = replace(_with_kind(verdict, "unknown", why), remains=False)
    elif verdict.kind == "no_gap" and verdict.effects:
        kind: Kind = "one_of" if any(verdict.alternatives) else "named"
        verdict = _with_kind(verdict, kind, "a fault that was counted, or the level of turbulence")
    groups = [
        (e.name, *others) for e, others in zip(verdict.effects, verdict.alternatives, strict=True)
    ]
    verdict = replace(verdict, advice=flights_to_fly(verdict.kind, groups, checks.maneuvers))
    for why in checks.left_out:
        verdict = _objected(verdict, Objection(why, withdraws=False))
    for why in checks.contradictions:
        verdict = _objected(verdict, Objection(why, withdraws=True))
    held = checks.hold_out
    if held is not None and verdict.kind in SURE and not closes(held):
        why = f"only {max(0.0, held.share):.0%} of the gap of the held-out log is closed"
        verdict = _objected(verdict, Objection(why, withdraws=True))
    for objection in (
        checks.closure,
        Objection(checks.formula, withdraws=True) if checks.formula else None,
    ):
        if objection is not None:
            verdict = _objected(verdict, objection)
            verdict = replace(verdict, remains=verdict.remains and not objection.withdraws)
    if checks.added is not None:
        verdict = _with_effects(verdict, checks.added)
    return verdict if checks.left is None else _with_calibrated_probabilities(verdict, checks)


def _with_kind(verdict: Verdict, kind: Kind, why: str) -> Verdict:
    """A verdict of another kind, with a line that tells why; the same where the kind is not another
    one.
    """
    if kind == verdict.kind:
        return verdict
    return replace(
        verdict, kind=kind, changes=(*verdict.changes, f"{verdict.kind} -> {kind}: {why}")
    )


def _objected(verdict: Verdict, objection: Objection) -> Verdict:
    """A verdict after an objection, which is only a note where nothing is named.

    Of the names that an objection leaves probable about half are right: more than of any other
    cause, and too few for a name.
    """
    why = objection.why
    if verdict.kind not in SURE or not verdict.effects:
        return replace(verdict, notes=(*verdict.notes, why))
    doubts = (*verdict.doubts, why)
    if not objection.withdraws:
        return replace(_with_kind(verdict, "one_of", why), remains=True, doubts=doubts)
    named = ", ".join(effect.name for effect in verdict.effects)
    notes = (*verdict.notes, f"{why}: the name {named} is taken back")
    verdict = _with_kind(verdict, "unknown", why)
    return replace(verdict, effects=(), alternatives=(), notes=notes, doubts=doubts)


def _with_effects(verdict: Verdict, added: Sequence[int]) -> Verdict:
    """A verdict with some of its effects, by their positions; the others stand in the model
    already.
    """
    kept = [i for i in added if i < len(verdict.effects)]
    if verdict.kind in SURE and not kept:
        verdict = _with_kind(verdict, "no_gap", "all its effects are in the model already")
    return replace(
        verdict,
        effects=tuple(verdict.effects[i] for i in kept),
        alternatives=tuple(verdict.alternatives[i] for i in kept),
    )


# What the flights show: the effects, the turbulence, and what remains.


def _found(layout: Layout, naming: Naming, null: NullDistribution) -> Checks:
    """What one flight shows: its effects with what was counted and the turbulence, and what
    remains.
    """
    explained = _without_named(naming)
    gusts = turbulence_candidates(explained, null.gust_level)
    # Other turbulence than that of the card makes every channel wander.
    wandering = () if gusts else wandering_channels(explained, naming.layout, null, naming.fit.gain)
    unexplained = (*wandering, *periodic_channels(explained, null, naming.fit.gain))
    counted = layout.checked.effects
    named, others_of = (
        _named_effects(naming),
        dict(zip(naming.chosen, naming.alternatives, strict=True)),
    )
    effects = (*counted, *named, *gusts)
    alternatives = (
        *((),) * len(counted),
        *(others_of[effect.name] for effect in named),
        *(("turbulence_scale",),) * len(gusts),
    )
    answer, equations, fit = naming.answer, naming.equations, naming.fit
    outweighed = (
        bool(unexplained)
        and not counted
        and (not naming.chosen or _outweighs(explained, naming, null))
    )
    explains = bool(effects) and not outweighed and answer.kind != "unknown"
    remains = explains and (bool(unexplained) or answer.rest > THRESHOLDS.likely)
    found = Verdict(
        kind=answer.kind,
        effects=effects,
        alternatives=alternatives,
        candidates=naming.candidates,
        located=(*unexplained, *(naming.remaining if remains else naming.located)),
        checks=layout.checked.checks,
        closure=closure_of(equations, fit.columns, fit.sizes.tolist(), naming.layout.examined),
        smallest_detectable=smallest_detectable(equations, naming.layout, null, fit.columns),
        advice=(),
        notes=_notes(layout, null, naming),
        probabilities=answer.probabilities,
        log_bayes_factor=naming.posterior.log_bayes_factor,
        remains=remains,
    )
    return Checks(found, outweighed)


def _outweighs(explained: Layout, naming: Naming, null: NullDistribution) -> bool:
    """Whether a wander or a line that is left is larger than a share of what the effects explain.

    Neither is smooth, so that the posterior has no hypothesis for it, and a cause that takes up a
    part of it is not its cause.
    """
    share = THRESHOLDS.outweighing_share / THRESHOLDS.remaining_share * naming.fit.gain
    return bool(
        wandering_channels(explained, naming.layout, null, share)
        or periodic_channels(explained, null, share)
    )


def _named_effects(naming: Naming) -> tuple[Candidate, ...]:
    """The chosen effects with the sizes that are beyond their bounds, as fitted together.

    Skip effects without a column in this log: other flights name them.
    """
    columns, fit = columns_of(naming.layout.signatures), naming.fit
    effects = []
    for effect in naming.chosen:
        own = [c for c in fit.columns if c in columns.get(effect, ())]
        if not own:
            continue
        gain = naming.equations.fit(own, given=[c for c in fit.columns if c not in own]).gain
        places = [fit.columns.index(c) for c in own]
        part = Fit(tuple(own), fit.sizes[places], fit.covariance[np.ix_(places, places)], gain)
        sizes = significant(estimates(naming.layout.signatures, part))
        probability = naming.answer.probabilities.get(cause_of(effect), 0.0)
        times = times_of(naming.layout.signatures[own[0]])
        effects.append(Candidate(effect, sizes, float(np.sqrt(gain)), probability, times))
    return tuple(effects)


def _without_named(naming: Naming) -> Layout:
    """The layout with the named effects subtracted from its residuals."""
    columns = [naming.layout.signatures[c].column for c in naming.fit.columns]
    return naming.layout.without(columns, naming.fit.sizes)


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
    if (
        null.gap_bayes_factor
        <= naming.posterior.log_bayes_factor
        < naming.posterior.least_bayes_factor
    ):
        notes.append("no place and no effect stands out of what flights without an effect show")
    if null.flights == 0:
        notes.append(
            "no null flights of this card: the noise is judged by this log alone, and a gap is "
            "told "
            f"from a Bayes factor of e^{null.gap_bayes_factor:.0f} on"
        )
    flies = layout.scene.force_model is not None
    if not flies:
        notes.append("no aircraft model: sensors and air alone are judged, and no card is flown")
    shown = {s.effect for s in layout.signatures}
    if not layout.setting.day_known:
        shown.add(DAY)
        if flies:
            notes.append(
                "the header does not tell the temperature of the day: another one is no gap"
            )
    plain = {
        n: e for n, e in FITTED.items() if not e.variant_of and (flies or e.acts_on != "aircraft")
    }
    hidden = [n for n in plain if n not in shown]
    lacking = _without_the_parts(hidden, layout)
    if lacking:
        notes.append(
            "left out, because the model of the aircraft lacks what they change: "
            + ", ".join(lacking)
        )
    unseen = [n for n in hidden if n not in lacking]
    if unseen:
        whole = {e.part for e in plain.values()} - {
            e.part for n, e in plain.items() if n not in unseen
        }
        told = dict.fromkeys(
            f"all of {plain[n].part}" if plain[n].part in whole else n for n in unseen
        )
        notes.append("cannot be seen in the channels of this log: " + ", ".join(told))
    notes += [
        f"{other} is one model with {effect.one_model_with}: it has the same terms in every channel"
        for other, effect in FITTED.items()
        if effect.one_model_with in map(cause_of, naming.chosen)
    ]
    ratios = scaled_to(null.noise, layout).deviations / null.noise.deviations
    noisy = [
        f"{n} ({r:.1f} times)"
        for n, r in zip(null.noise.names, ratios, strict=True)
        if r > THRESHOLDS.noise_noted
    ]
    if noisy and null.flights:
        notes.append("more noise than on null flights: " + ", ".join(noisy))
    return tuple(notes)


def _without_the_parts(names: Sequence[str], layout: Layout) -> list[str]:
    """Return those of the effects that the aircraft cannot take at all."""
    model = layout.scene.force_model
    acting = [(n, effect) for n in names if isinstance(effect := FITTED[n], AircraftEffect)]
    return (
        []
        if model is None
        else [n for n, effect in acting if not effect.fitting(model.aircraft.baseline)]
    )


def for_channels(of_card: NullDistribution | None, layout: Layout) -> NullDistribution:
    """Return the null distribution of a card if it has the channels of a log; else one from the log
    itself.
    """
    if of_card is not None and of_card.noise.names == layout.residuals.names:
        return of_card
    return theoretical_distribution(layout)


def hold_out(
    log: FlightLog,
    aircraft: AircraftModel | None,
    null: NullDistribution,
    naming: Naming,
    setting: AnalysisSetting,
) -> Closure:
    """Return the closure of the named effects on another log, with the sizes fitted before.

    Events and effects for a part of one flight are left out: the other flight has them at other
    times, or not at all. So are sizes that the other log cannot show. The noise is that of the
    other log alone where it has other channels.
    """
    chosen: Catalog[Effect] = Catalog("effect", {n: FITTED[n] for n in naming.chosen if returns(n)})
    layout = lay_out(log, aircraft, setting, chosen)
    signatures = [naming.layout.signatures[c] for c in naming.fit.columns]
    sizes = {
        (s.effect, s.parameter): float(v) for s, v in zip(signatures, naming.fit.sizes, strict=True)
    }
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
    return closure_of(equations, columns, fitted, layout.examined, errors)


def closes(held: Closure) -> bool:
    """Whether effects close enough of the gap of a log that their sizes were not fitted to.

    They do where what is left of the gap is within chance: a log that shows little of an effect
    says little of it, and so do sizes that are hardly known.
    """
    by_chance = THRESHOLDS.gap_cell + THRESHOLDS.left_by_chance * held.chance
    return held.share >= THRESHOLDS.closure_lowest or held.after - held.noise < by_chance


# What the probability of a cause is worth: the posterior's own, with a doubt that it cannot have
# itself. The posterior takes the table, its form error and the noise for complete. On 387 sealed
# logs of other making, causes that it gave more than 0.995 were right in 92 %: in 96 % where the
# answer closed all but 3 % of the gap, in 77 % where it left more. On 1,411 later cases its own
# probabilities were right up to 0.8, and those from 0.8 to 0.99 were right in 0.8. So odds above
# four to one are held there until their root exceeds it, and a share of the whole, which grows with
# what is left of the gap, goes to causes of other form (recalibration: Platt 1999; reliability:
# Murphy 1973).


def calibrated(
    probabilities: Mapping[str, float], left: float, further: float = 0.0
) -> dict[str, float]:
    """Return the probability that each cause acts, given what the answer leaves of the gap, as a
    share.

    `further` is a share of doubt beside that one.
    """
    trusted = (1.0 - _of_other_form(left)) * (1.0 - further)
    return {cause: trusted * float(_nearer_even(p)) for cause, p in probabilities.items()}


def _of_other_form(left: float) -> float:
    """The share for causes of other form, given what the answer leaves of the gap, as a share."""
    most, least = THRESHOLDS.doubt_most, THRESHOLDS.doubt_least
    return least + (most - least) * float(np.clip(left / THRESHOLDS.doubt_most_left, 0.0, 1.0))


def _nearer_even(probabilities: Array | float) -> Array:
    odds = logit(np.clip(probabilities, 0.0, 1.0))
    sure = np.maximum(np.log(THRESHOLDS.odds_trusted), THRESHOLDS.odds_above_even * odds)
    return np.asarray(
        expit(np.where(odds > 0.0, np.minimum(odds, sure), THRESHOLDS.odds_below_even * odds))
    )


def doubt_beside(verdict: Verdict) -> float:
    """Return the share of doubt that the objections to a verdict's names leave, beside that of the
    gap left.
    """
    return THRESHOLDS.doubt_objected if verdict.doubts else 0.0


def parts_of(probabilities: Mapping[str, float]) -> dict[str, float]:
    """Return the probability of each part of the airplane or the world, from those of its causes.

    It is what such sums were worth on judged flights, and no less than that of the most probable
    cause.
    """
    summed: dict[str, float] = {}
    largest: dict[str, float] = {}
    for cause, p in probabilities.items():
        part = effect_of(cause).part
        summed[part], largest[part] = summed.get(part, 0.0) + p, max(largest.get(part, 0.0), p)
    sums, shares = part_table()
    told = {
        part: max(largest[part], float(np.interp(min(p, 1.0), sums, shares)))
        for part, p in summed.items()
    }
    return dict(sorted(told.items(), key=lambda item: -item[1]))


@cache
def part_table() -> tuple[Array, Array]:
    """Return summed probabilities of the causes of a part, (n,), and the share of such parts that
    is right, (n,).

    The table was computed from sealed flights by a measurement, which gives it again.
    """
    text = files("pitotbench.reconciliation").joinpath("part_probability.csv").read_text("utf-8")
    sums, shares, _ = np.loadtxt(text.splitlines(), delimiter=",", skiprows=2).T
    return sums, shares


def _with_calibrated_probabilities(verdict: Verdict, checks: Checks) -> Verdict:
    """A verdict with calibrated probabilities. A cause that they do not name stands beside the next
    one.

    A counted fault and the level of the gusts have no posterior, and are as probable as they are
    told.
    """
    beside = doubt_beside(verdict) if checks.doubt is None else checks.doubt
    found = calibrated(verdict.probabilities, checks.left or 0.0, beside)
    answered = set(map(_cause, verdict.effects))
    following = next(
        (cause for cause in sorted(found, key=lambda c: -found[c]) if cause not in answered), None
    )

    def others(effect: Candidate, so_far: tuple[str, ...]) -> tuple[str, ...]:
        is_sure = (
            found.get(_cause(effect), 1.0) > THRESHOLDS.named_from
        )  # what is counted is certain
        return so_far if so_far or is_sure or following is None else (following,)

    alternatives = tuple(map(others, verdict.effects, verdict.alternatives))
    if verdict.kind == "named" and any(alternatives):
        told = ", ".join(f"{found.get(_cause(e), 1.0):.2f}" for e in verdict.effects)
        verdict = _with_kind(verdict, "one_of", f"the doubt of the table (probability {told})")
    effects = tuple(_weighed(each, found) for each in verdict.effects)
    sizes = {each.name: each.sizes for each in effects}
    ranked = [replace(each, sizes=sizes.get(each.name, each.sizes)) for each in verdict.candidates]
    parts = parts_of({_cause(e): e.probability for e in effects} | found)
    return replace(
        verdict,
        effects=effects,
        alternatives=alternatives,
        candidates=tuple(_weighed(each, found) for each in ranked),
        probabilities=found,
        parts=parts,
        named_parts=tuple(
            part for part, p in parts.items() if p > THRESHOLDS.named_from and verdict.kind in SURE
        ),
    )


def _weighed(each: Candidate, found: Mapping[str, float]) -> Candidate:
    return replace(each, probability=found.get(_cause(each), each.probability))


def _cause(each: Candidate) -> str:
    """The cause of an effect. A counted fault has no posterior, and is its own."""
    return cause_of(each.name) if each.name in FITTED else each.name


# From flights that are laid out to the record of their checks.

SECONDS_A_MINUTE = 60.0


@dataclass(frozen=True, slots=True)
class JointVerdict:
    """What the checks of one flight or several found, what it follows from, and the figures of each
    flight.
    """

    checks: Checks
    together: Together
    flights: tuple[JoinedFlight, ...]

    @property
    def verdict(self) -> Verdict:
        """The verdict on all flights."""
        return verdict_of(self.checks)


def judge(
    names: Sequence[str], layouts: Sequence[Layout], nulls: Sequence[NullDistribution]
) -> JointVerdict:
    """Return the verdict on one flight or several with their names, and what each of them says."""
    together = name_effects(layouts, nulls)
    each = [
        _found(naming.layout, naming, null)
        for naming, null in zip(together.namings, nulls, strict=True)
    ]
    left_out = left_out_closures(together.namings)
    flights = tuple(
        _figures(name, together, number, each[number].found.closure, left_out[number], null.flights)
        for number, (name, null) in enumerate(zip(names, nulls, strict=True))
    )
    checks = Checks(
        found=_joined(names, [one.found for one in each]),
        outweighed=any(one.outweighed for one in each),
        left_out=tuple(
            f"the sizes of the other flights close only {max(0.0, closed.share):.0%} of the gap of "
            f"{name}"
            for name, closed in zip(names, left_out, strict=True)
            if closed is not None and not closes(closed)
        ),
        contradictions=tuple(contradictions(flights)),
    )
    return JointVerdict(checks, together, flights)


def _figures(
    name: str,
    together: Together,
    number: int,
    closure: Closure,
    left_out: Closure | None,
    null_flights: int,
) -> JoinedFlight:
    """The figures of one flight."""
    naming, alone = together.namings[number], together.alone[number]
    answer = answer_of(alone)
    effects = naming.chosen
    if (
        not effects and len(together.logs) > 1
    ):  # the flights may disagree: look at what single ones name
        effects = next((a.effects for a in map(answer_of, together.alone) if a.effects), ())
    effects = tuple(filter(returns, effects))
    time = naming.layout.track.time
    return JoinedFlight(
        log=name,
        maneuver="",
        minutes=float(time[-1] - time[0]) / SECONDS_A_MINUTE,
        alone=answer.kind,
        causes=tuple(tuple(c for c in group if c != OUTSIDE) for group in answer.groups),
        log_bayes_factor=alone.log_bayes_factor,
        closure=closure,
        left_out=left_out,
        own_sizes=sizes_beside(together, number, effects) if len(together.logs) > 1 else (),
        null_flights=null_flights,
        probabilities=calibrated(answer.probabilities, 1.0 - closure.share),
    )


def _joined(names: Sequence[str], each: Sequence[Verdict]) -> Verdict:
    """What all flights show, which share the posterior; a single flight has nothing to join."""
    if len(each) == 1:
        return each[0]
    effects, alternatives = _joined_effects(each)
    whole = Closure(
        *(sum(getattr(v.closure, n) for v in each) for n in ("before", "after", "noise"))
    )
    notes = dict.fromkeys(note for verdict in each for note in verdict.notes)
    return replace(
        each[0],
        effects=effects,
        alternatives=alternatives,
        candidates=_joined_candidates(each),
        located=strongest([place for verdict in each for place in verdict.located]),
        checks=tuple(
            replace(check, name=f"{check.name}, {name}")
            for name, verdict in zip(names, each, strict=True)
            for check in verdict.checks
        ),
        closure=whole,
        smallest_detectable=_joined_detectable(each),
        notes=tuple(notes),
        remains=any(verdict.remains for verdict in each),
    )


def _joined_effects(
    each: Sequence[Verdict],
) -> tuple[tuple[Candidate, ...], tuple[tuple[str, ...], ...]]:
    """The effects of all flights, each once: their significances add in squares, their bounds are
    the smallest.
    """
    found: dict[str, tuple[Candidate, tuple[str, ...]]] = {}
    for verdict in each:
        for effect, others in zip(verdict.effects, verdict.alternatives, strict=True):
            old = found.get(effect.name, (effect, others))[0]
            score = (
                float(np.hypot(old.score, effect.score)) if effect.name in found else effect.score
            )
            better = effect if effect.score > old.score else old
            found[effect.name] = (replace(better, score=score), others)
    return tuple(effect for effect, _ in found.values()), tuple(
        others for _, others in found.values()
    )


def _joined_candidates(each: Sequence[Verdict]) -> tuple[Candidate, ...]:
    """The candidates of all flights, each as the flight shows it in which it is most significant."""
    found: dict[str, Candidate] = {}
    for verdict in each:
        for candidate in verdict.candidates:
            old = found.get(candidate.name)
            found[candidate.name] = candidate if old is None or candidate.score > old.score else old
    ranked = sorted(found.values(), key=lambda c: (-round(c.probability, 3), -c.score))
    return tuple(ranked[: max(len(verdict.candidates) for verdict in each)])


def _joined_detectable(each: Sequence[Verdict]) -> tuple[Detectable, ...]:
    """The smallest size that all flights together show: the squares of the reciprocals add up."""
    found: dict[tuple[str, str], float] = {}
    for verdict in each:
        for one in verdict.smallest_detectable:
            key = (one.effect, one.parameter)
            found[key] = found.get(key, 0.0) + one.size**-2.0
    return tuple(Detectable(*key, total**-0.5) for key, total in found.items())
