"""From flights that are laid out to one answer: fit all gaps, examine the rest, tell how sure."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pitotbench.effects import OWN_TERMS, effect_of
from pitotbench.effects.airframe import CONTROL_EFFECTIVENESS
from pitotbench.effects.stability import CHANGE
from pitotbench.reconciliation.closure import closes, joined_closure
from pitotbench.reconciliation.equations import (
    Fit,
)
from pitotbench.reconciliation.evidence import estimates, merit, significance, significant
from pitotbench.reconciliation.fitting import Fitted, fit_gaps, fitted_by, with_terms
from pitotbench.reconciliation.flight_path import is_without_vanes
from pitotbench.reconciliation.layout import Layout
from pitotbench.reconciliation.null_distribution import NullDistribution
from pitotbench.reconciliation.other_flights import (
    contradictions,
    contradicts,
    flights_of,
    holding,
)
from pitotbench.reconciliation.patches import flights_to_fly
from pitotbench.reconciliation.regression import FoundGap, Sizes, effect_and_size, is_term, keys_of
from pitotbench.reconciliation.sets import FittedHypothesis
from pitotbench.reconciliation.shown_flight import (
    ShownFlight,
    free_sizes,
    joined_detectable,
    largest_gap,
    notes_of,
    show_flight,
    strongest,
)
from pitotbench.reconciliation.signatures import FITTED, cause_of, columns_of, times_of
from pitotbench.reconciliation.thresholds import THRESHOLDS
from pitotbench.records.calibration import Estimate
from pitotbench.records.verdict import (
    SURE,
    Candidate,
    Closure,
    Gap,
    JoinedFlight,
    Kind,
    Verdict,
)
from pitotbench.units import percent_text

LISTED = 10  # candidates in a verdict


@dataclass(frozen=True, slots=True)
class Objection:
    """What a check says against the names: it withdraws them, or leaves them only probable."""

    why: str
    withdraws: bool


@dataclass(frozen=True, slots=True)
class Judged:
    """The answer on one flight or several, its gaps, and what each flight says."""

    verdict: Verdict
    fitted: Fitted
    shown: tuple[ShownFlight, ...]
    flights: tuple[JoinedFlight, ...]


HoldOut = Callable[[Fitted], Closure | None]


def judge(
    names: Sequence[str],
    layouts: Sequence[Layout],
    nulls: Sequence[NullDistribution],
    maneuvers: Sequence[str] = (),
    held_out: HoldOut | None = None,
) -> Judged:
    """Return the answer on one flight or several with their names.

    `maneuvers` are those flown, which no advice repeats; `held_out` returns the closure of the gaps
    on a log that is not among them.
    """
    fitted = fit_gaps(layouts, nulls)
    shown, flights = _all_flights(names, fitted)
    if any(each.wandering for each in shown):  # what no cell shows may follow a formula
        fitted = with_terms(fitted)
        shown, flights = _all_flights(names, fitted)
    refused = {own.effect for each in flights for own in each.own_sizes if contradicts(own)}
    notes = contradictions(flights)
    if fitted.gaps and fitted.gaps[0].member.name in refused:
        refused, notes = set(), []  # of the largest gap: an objection tells it
    refused |= {*_impossible(fitted), *_left_by_lines(fitted)}
    if refused:  # what flights do not share, or what cannot be, is no gap of them all
        fitted = fitted_by(fitted.regression, refused)
        shown, flights = _all_flights(names, fitted)
    holdout_closure = held_out(fitted) if held_out is not None and fitted.gaps else None
    objections = list(_objections(fitted, shown, flights, holdout_closure))
    verdict = _answer(fitted, shown, objections)
    groups = [tuple(c.name for c in gap.causes) for gap in verdict.explained]
    return Judged(
        replace(
            verdict,
            advice=flights_to_fly(verdict.kind, groups, maneuvers),
            closure_holdout=holdout_closure,
            notes=(*verdict.notes, *notes),
            checks=tuple(
                replace(check, name=f"{check.name}, {name}" if len(names) > 1 else check.name)
                for name, each in zip(names, shown, strict=True)
                for check in each.block.layout.checked.checks
            ),
        ),
        fitted,
        shown,
        flights,
    )


def _all_flights(
    names: Sequence[str], fitted: Fitted
) -> tuple[tuple[ShownFlight, ...], tuple[JoinedFlight, ...]]:
    shown = tuple(show_flight(block, fitted) for block in fitted.regression.blocks)
    return shown, flights_of(names, fitted, shown)


def _impossible(fitted: Fitted) -> Iterable[str]:
    """The hypotheses that would need a size outside its range."""
    found = zip(fitted.told.keys, _estimates(fitted.told), strict=True)
    for (effect, parameter), size in found:
        if not fitted.regression.parameter((effect, parameter)).is_possible(size):
            yield from (m.name for m in fitted.members if keys_of(m.name, [(effect, parameter)]))


def _left_by_lines(fitted: Fitted) -> Iterable[str]:
    """Yield the hypotheses whose gap a spectral line may leave in the channel that they move.

    The waves of a line have an even amplitude; that of the error may follow the airspeed or height.
    """
    lines = [line for block in fitted.regression.blocks for line in block.layout.lines]
    for gap in fitted.gaps if lines else ():
        channels = _channels_of(fitted, gap)
        power = sum(line.power for line in lines if line.channel in channels)
        if gap.log_bayes_factor < 0.5 * THRESHOLDS.open_share**2 * power:
            yield gap.member.name


def _channels_of(fitted: Fitted, gap: FoundGap) -> set[str]:
    """The channels that the sizes of a gap move most, in any of the logs."""
    keys = keys_of(gap.member.name, fitted.regression.keys)
    every = (block.channels for block in fitted.regression.blocks)
    return {channels[key] for channels in every for key in keys if key in channels}


def _objections(
    fitted: Fitted,
    shown: Sequence[ShownFlight],
    flights: Sequence[JoinedFlight],
    holdout_closure: Closure | None,
) -> Iterable[Objection]:
    """Yield what speaks against the names: other flights, a held-out log, too little closed.

    Other flights speak by what they leave where their sizes are held, and by contradictions. Where
    all terms of the model's file compete, a gap that stays is one of a further term, and withdraws
    no name.
    """
    alone = not any(each.block.layout.setting.terms for each in shown)
    for flight in flights:
        if flight.left_out is not None and not closes(flight.left_out):
            yield Objection(
                "the sizes of the other flights close only "
                f"{percent_text(max(0.0, flight.left_out.share))} of the gap of {flight.log}",
                withdraws=False,
            )
    for line in contradictions(flights):
        yield Objection(line, withdraws=True)
    if holdout_closure is not None and not closes(holdout_closure):
        yield Objection(
            f"only {percent_text(max(0.0, holdout_closure.share))} of the gap of the held-out log "
            "is closed",
            alone,
        )
    closed, names = joined_closure(each.closure for each in shown), [m.name for m in fitted.members]
    by_chance = closed.after - closed.noise < THRESHOLDS.gap_cell
    if names and closed.share < THRESHOLDS.closure_lowest and not by_chance:
        yield Objection(
            f"{', '.join(names)} comes closest, but closes only "
            f"{percent_text(max(0.0, closed.share))} of the gap",
            withdraws=alone,
        )


def _answer(
    fitted: Fitted, shown: Sequence[ShownFlight], objections: Sequence[Objection]
) -> Verdict:
    """The verdict: what every gap is, and how surely. Nothing else sets the kind of a verdict.

    The probability of a cause is its share of a gap (`FoundGap.causes`) times what a share is worth
    (`_worth`); that of a part is the sum of its causes. A cause or a part is named at two limits:
    of its share, and of what all gaps together leave of the sum of squares. Where an objection
    speaks against the names, or a further gap is seen, all counts as left.
    """
    closure, main = joined_closure(each.closure for each in shown), largest_gap(shown)
    doubts = tuple(each.why for each in objections)
    left, unexplained = 1.0 - closure.share, [p for each in shown for p in each.unexplained]
    outweighed = any(each.outweighs for each in shown)
    known = [gap for gap in fitted.gaps if not is_term(gap.member.name)]
    counted = [each for flight in shown for each in flight.certain]
    withdrawn = outweighed or any(each.withdraws for each in objections)
    if withdrawn or not (known or counted):
        unknown = withdrawn or fitted.gaps or fitted.shows_more
        kind: Kind = "unknown" if unknown else "no_gap"
    else:
        kind = "named"
    quiet = not any(each.block.stands_out for each in shown)
    trusts = kind == "named" and not doubts and not fitted.shows_more
    # What is counted leaves nothing where no gap beside it is seen.
    certain = _certain(counted, (left if fitted.gaps else 0.0) if trusts else 1.0)
    gaps, probabilities = list[Gap](), dict[str, float]()
    for found in fitted.gaps:
        other = may_be_form(found, fitted.gaps) or may_be_gusts(fitted, found)
        own = left if trusts and not other else 1.0
        gaps.append(_gap(fitted, main, found, own))
        _raise_to(probabilities, found, _worth(own))
    _raise_to(probabilities, fitted.left, THRESHOLDS.told_open * fitted.left.probability)
    gaps.sort(key=lambda gap: -gap.closes_held_out)
    if kind == "named" and not all(gap.named for gap in (*certain, *gaps)):
        kind = "one_of"
    if withdrawn and doubts:
        notes = ", ".join(m.name for m in fitted.members)
        doubts = (*doubts, f"the name {notes} is withdrawn")
    remains = kind in SURE and (
        fitted.shows_more or bool(unexplained) or len(known) < len(fitted.gaps)
    )
    told = {cause.name for gap in (*certain, *gaps) for cause in gap.causes}
    given = main.fit.columns if remains else ()
    located = [place for each in shown for place in each.located(given if each is main else ())]
    return Verdict(
        kind=kind,
        gaps=tuple(gap for gap in (*certain, *gaps) if kind in SURE or not withdrawn),
        candidates=_candidates(fitted, main, probabilities),
        located=(*unexplained, *strongest(located)),
        checks=(),
        closure=closure,
        smallest_detectable=joined_detectable(shown),
        advice=(),
        notes=tuple(
            dict.fromkeys(
                note
                for each in shown
                for note in notes_of(each.block, known, fitted.left, quiet, told)
            )
        ),
        probabilities=dict(sorted(probabilities.items(), key=lambda item: -item[1])),
        log_bayes_factor=max(
            (gap.log_bayes_factor for gap in fitted.gaps), default=fitted.left.log_bayes_factor
        ),
        remains=remains,
        doubts=doubts,
        free=tuple(free for each in shown for free in free_sizes(each)),
    )


def _worth(left: float) -> float:
    """Return what a share of a gap is worth as a probability, by what all gaps leave.

    Right names leave little, wrong ones seldom do.
    """
    return THRESHOLDS.told_closed if left < THRESHOLDS.told_left else THRESHOLDS.told_open


def _raise_to(probabilities: dict[str, float], found: FoundGap, worth: float) -> None:
    """Raise the probability of each cause to that which a gap gives it: the largest of all gaps."""
    for cause, share in found.causes.items():
        probabilities[cause] = max(probabilities.get(cause, 0.0), worth * share)


def may_be_form(found: FoundGap, gaps: Sequence[FoundGap]) -> bool:
    """Return whether a gap may be what the form of a larger sensor effect of its part leaves.

    The law of such an effect is seldom that of the table.
    """
    effects = [effect_of(effect_and_size(each.member.name)[0]) for each in (found, *gaps)]
    larger = [each.log_bayes_factor > found.log_bayes_factor for each in gaps]
    return effects[0].acts_on == "sensors" and any(
        is_larger and effect.part == effects[0].part
        for is_larger, effect in zip(larger, effects[1:], strict=True)
    )


def may_be_gusts(fitted: Fitted, found: FoundGap) -> bool:
    """Return whether gusts may make a gap of a moment.

    Without vanes nothing shows gusts, and without null flights nothing tells how the airplane and
    its controls answer them.
    """
    blocks = fitted.regression.blocks
    unseen = all(is_without_vanes(b.layout.track) and b.null.flights == 0 for b in blocks)
    return unseen and any(c.endswith("_acceleration") for c in _channels_of(fitted, found))


def _gap(fitted: Fitted, main: ShownFlight, found: FoundGap, left: float) -> Gap:
    """A gap as it is reported.

    All gaps together leave the share `left` of what is explainable. One that is not named has at
    least two causes: the smallest set that holds it.
    """
    closure = main.closure
    given = [m for m in fitted.members if m is not found.member]
    own, other_columns = (
        fitted.regression.shown_columns(main.block, m) for m in ([found.member], given)
    )
    gain = main.block.beyond.gain(own, other_columns)
    closed = gain / max(closure.before - closure.noise, gain, 1.0)
    ranked = list(found.causes)
    if is_term(found.member.name):
        chosen = (_candidate(fitted, main, found, found.member.name, 1.0 - found.unknown),)
        return Gap("", 1.0 - found.unknown, chosen, False, False, closed, closed * found.held_out)
    told = _worth(left) * found.causes[ranked[0]]
    named = told > THRESHOLDS.named_from and left < THRESHOLDS.named_left
    count = 1 if named else max(2, len(holding(found.causes)))
    parts: dict[str, float] = {}
    for cause, p in found.causes.items():
        parts[effect_of(cause).part] = parts.get(effect_of(cause).part, 0.0) + p
    part = effect_of(ranked[0]).part
    causes = tuple(
        _candidate(fitted, main, found, _form(found, cause), _worth(left) * found.causes[cause])
        for cause in ranked[:count]
    )
    return Gap(
        part,
        _worth(left) * parts[part],
        causes,
        named,
        parts[part] > THRESHOLDS.part_named_from and left < THRESHOLDS.told_left,
        closed,
        closed * found.held_out,
    )


def _form(found: FoundGap, cause: str) -> str:
    """The most probable form of a cause."""
    forms = {n: p for n, p in found.forms.items() if not is_term(n) and cause_of(n) == cause}
    return max(forms, key=lambda name: forms[name])


def _candidate(
    fitted: Fitted, main: ShownFlight, found: FoundGap, name: str, probability: float
) -> Candidate:
    """A hypothesis in the place of a gap, at its sizes given the other gaps."""
    block, regression = main.block, fitted.regression
    others = [m for m in fitted.members if m is not found.member]
    is_own = name == found.member.name
    own = regression.shown_columns(
        block, [found.member if is_own else FittedHypothesis(name, (), np.zeros(0))]
    )
    other_columns = regression.shown_columns(block, others)
    fit = block.equations.fit(own, other_columns)
    if is_own:
        keys = [block.keys[c] for c in own] or keys_of(name, regression.keys)
        shared = fitted.told.among(keys)
        fit = Fit(tuple(own), shared.values, shared.covariance, fit.gain)
        sizes = _estimates(shared)
    else:
        sizes = estimates(block.layout.signatures, fit)
    times = times_of(block.layout.signatures[own[0]]) if own and not is_term(name) else ()
    effect, _ = effect_and_size(name)
    return Candidate(effect, significant(sizes), float(np.sqrt(fit.gain)), probability, times)


def _estimates(sizes: Sizes) -> tuple[Estimate, ...]:
    """Sizes with their bounds, which include the error of the method."""
    deviations = np.sqrt(np.diag(sizes.covariance))
    each = zip(sizes.keys, sizes.values.tolist(), deviations.tolist(), strict=True)
    return tuple(
        Estimate(key[1], size, 2.0 * float(np.hypot(deviation, THRESHOLDS.size_error * size)))
        for key, size, deviation in each
    )


# 1σ of a coefficient, as a share, from which it is not told (Tischler and Remple 2012, ch. 12)
LEAST_SHOWN = 0.2


def agreeing_changes(fitted: Fitted) -> list[tuple[str, Estimate]]:
    """Return the changes, fitted with all gaps, of derivatives in which maneuvers show none.

    Only those are told that the maneuvers show. Empty for any other log.
    """
    regression = fitted.regression
    if not all(block.layout.setting.maneuvers for block in regression.blocks):
        return []
    gaps = {cause_of(effect_and_size(m.name)[0]) for m in fitted.members if not is_term(m.name)}
    looked_for = OWN_TERMS - {CONTROL_EFFECTIVENESS.name}
    effects = {name: effect_and_size(name)[0] for name in regression.columns}
    agreeing = {
        name: effect
        for name, effect in effects.items()
        if effect in looked_for and cause_of(effect) not in gaps
    }
    sizes = regression.sizes([*fitted.members, *map(regression.of_typical_size, agreeing)])
    return [
        (effect, size)
        for (effect, _), size in zip(sizes.keys, _estimates(sizes), strict=True)
        if effect in agreeing.values()
        and size.name.endswith(CHANGE)
        and size.two_sigma < 2.0 * LEAST_SHOWN
    ]


def _certain(counted: Sequence[Candidate], left: float) -> list[Gap]:
    """Gaps without a posterior: faults that were counted, and the level of the turbulence.

    Each has the whole share of its gap; `left` is what all gaps leave.
    """
    found = {c.name: replace(c, probability=_worth(left)) for c in counted}
    return [
        Gap(
            effect_of(c.name).part,
            c.probability,
            (c, *_gusts_of_another_scale(c)),
            not _gusts_of_another_scale(c),
            True,
            0.0,
            0.0,
        )
        for c in found.values()
    ]


def _gusts_of_another_scale(each: Candidate) -> tuple[Candidate, ...]:
    """Gusts of another level may be of another scale."""
    other = each.name == "turbulence_level"
    return (Candidate("turbulence_scale", (), each.score, 0.0),) if other else ()


def _candidates(
    fitted: Fitted, main: ShownFlight, probabilities: dict[str, float]
) -> tuple[Candidate, ...]:
    """The causes as single explanations, each in its best form, the most probable first."""
    block = main.block
    columns = {n: c for n, c in columns_of(block.layout.signatures).items() if n in FITTED}
    fits = {name: block.equations.fit(own) for name, own in columns.items()}
    forms = {cause_of(m.name): m.name for m in fitted.members if m.name in columns}
    for name in sorted(fits, key=lambda n: -merit(fits[n])):
        forms.setdefault(cause_of(name), name)
    ranked = sorted(
        forms.values(),
        key=lambda n: (-round(probabilities.get(cause_of(n), 0.0), 3), -merit(fits[n])),
    )
    signatures = block.layout.signatures
    return tuple(
        Candidate(
            name,
            estimates(signatures, fits[name]),
            block.null.scores.of_effect(name, significance(fits[name])),
            probabilities.get(cause_of(name), 0.0),
            times_of(signatures[columns[name][0]]),
        )
        for name in ranked[:LISTED]
    )
