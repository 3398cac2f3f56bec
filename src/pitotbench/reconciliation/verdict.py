"""From flights that are laid out to one answer: fit all gaps, examine what remains, and tell how
sure it is.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import chdtrc, ndtri

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
from pitotbench.reconciliation.evidence import estimates, merit, significance, significant
from pitotbench.reconciliation.flight_path import PATH_SCALES
from pitotbench.reconciliation.formula import signatures_at
from pitotbench.reconciliation.layout import DAY, Layout
from pitotbench.reconciliation.null_distribution import NullDistribution, theoretical_distribution
from pitotbench.reconciliation.null_learning import (
    periodic_channels,
    turbulence_candidates,
    wandering_channels,
)
from pitotbench.reconciliation.patches import flights_to_fly
from pitotbench.reconciliation.regression import (
    Block,
    Fitted,
    Found,
    Member,
    Regression,
    Sizes,
    fit_gaps,
    fitted_by,
    is_term,
    keys_of,
    parted,
    with_terms,
)
from pitotbench.reconciliation.renewal import at_sizes, without_sensor_effects
from pitotbench.reconciliation.signatures import FITTED, cause_of, columns_of, returns, times_of
from pitotbench.reconciliation.thresholds import THRESHOLDS
from pitotbench.records.calibration import Estimate
from pitotbench.records.verdict import (
    SURE,
    Candidate,
    Closure,
    Detectable,
    FreeSize,
    Gap,
    JoinedFlight,
    Kind,
    Located,
    OwnSize,
    Verdict,
)

LISTED = 10  # candidates in a verdict
SECONDS_A_MINUTE = 60.0

# What one flight shows with the gaps of all flights in the model.


@dataclass(frozen=True, slots=True)
class ShownFlight:
    """What one flight shows: the gaps as a fit of it and what they close, what was counted, other
    gusts than those of the card, and the channels that wander or have a line beside.

    `outweighs`: these are larger than a share of what the gaps explain.
    """

    block: Block
    fit: Fit
    closure: Closure
    certain: tuple[Candidate, ...]
    unexplained: tuple[Located, ...]
    outweighs: bool

    def located(self, given: Sequence[int] = ()) -> list[Located]:
        """Return the most significant place in every channel, in σ beyond the mean of null flights."""
        places, best = self.block.layout.places, dict[str, Located]()
        values = self.block.equations.scores(self.block.layout.examined, given)
        for (_, cell), value in zip(places, values, strict=True):
            score = self.block.null.scores.of_cell(cell, float(value))
            if cell.channel not in best or abs(score) > abs(best[cell.channel].significance):
                best[cell.channel] = Located(cell.channel, cell.phase, cell.variable, score)
        return list(best.values())


def _shown(block: Block, fitted: Fitted) -> ShownFlight:
    fit, layout, null = fitted.fit_of(block), block.layout, block.null
    explained = layout.without([layout.signatures[c].column for c in fit.columns], fit.sizes)
    gusts = turbulence_candidates(explained, null.gust_level)

    def unexplained(by: float) -> tuple[Located, ...]:
        # Other turbulence than that of the card makes every channel wander.
        wander = () if gusts else wandering_channels(explained, layout, null, by)
        return (*wander, *periodic_channels(explained, null, by))

    counted, beside = layout.checked.effects, unexplained(fit.gain)
    larger = THRESHOLDS.outweighing_share / THRESHOLDS.remaining_share * fit.gain
    outweighs = bool(beside) and not counted and (not fit.columns or bool(unexplained(larger)))
    closure = closure_of(block.equations, fit.columns, fit.sizes.tolist(), layout.examined)
    return ShownFlight(block, fit, closure, (*counted, *gusts), beside, outweighs)


# The answer: how surely each gap is told.


@dataclass(frozen=True, slots=True)
class Objection:
    """What a check says against the names: it withdraws them, or leaves them only probable."""

    why: str
    withdraws: bool


@dataclass(frozen=True, slots=True)
class Judged:
    """The answer on one flight or several, the gaps that it follows from, and what each flight
    says.
    """

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
    if any(each.unexplained for each in shown):  # what no cell shows may follow a formula
        fitted = with_terms(fitted)
        shown, flights = _all_flights(names, fitted)
    refused = {own.effect for each in flights for own in each.own_sizes if _is_apart(own)}
    told = contradictions(flights)
    if fitted.gaps and fitted.gaps[0].member.name in refused:
        refused, told = set(), []  # of the largest gap: an objection tells it
    refused |= set(_impossible(fitted))
    if refused:  # what flights do not share, or what cannot be, is no gap of them all
        fitted = fitted_by(fitted.regression, refused)
        shown, flights = _all_flights(names, fitted)
    held = held_out(fitted) if held_out is not None and fitted.gaps else None
    objections = list(_objections(fitted, shown, flights, held))
    verdict = _told(fitted, shown, objections)
    groups = [tuple(c.name for c in gap.causes) for gap in verdict.explained]
    return Judged(
        replace(
            verdict,
            advice=flights_to_fly(verdict.kind, groups, maneuvers),
            closure_holdout=held,
            notes=(*verdict.notes, *told),
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
    shown = tuple(_shown(block, fitted) for block in fitted.regression.blocks)
    return shown, _flights(names, fitted, shown)


def _impossible(fitted: Fitted) -> Iterable[str]:
    """The hypotheses that would need a size outside its range."""
    found = zip(fitted.sizes.keys, _estimates(fitted.sizes), strict=True)
    for (effect, parameter), size in found:
        if not effect_of(effect).parameter(parameter).is_possible(size):
            yield from (m.name for m in fitted.members if keys_of(m.name, [(effect, parameter)]))


def _is_apart(own: OwnSize) -> bool:
    return own.apart is not None and own.apart > THRESHOLDS.contradicted_from


def _objections(
    fitted: Fitted,
    shown: Sequence[ShownFlight],
    flights: Sequence[JoinedFlight],
    held: Closure | None,
) -> Iterable[Objection]:
    """What speaks against the names: flights left out, contradictions, a held-out log, and too
    little that is closed.

    Where all terms of the model's file compete, a gap that stays is one of a further term, and
    takes no name back.
    """
    alone = not any(each.block.layout.setting.terms for each in shown)
    for flight in flights:
        if flight.left_out is not None and not closes(flight.left_out):
            share = max(0.0, flight.left_out.share)
            yield Objection(
                f"the sizes of the other flights close only {share:.0%} of the gap of {flight.log}",
                withdraws=False,
            )
    for line in contradictions(flights):
        yield Objection(line, withdraws=True)
    if held is not None and not closes(held):
        share = max(0.0, held.share)
        yield Objection(f"only {share:.0%} of the gap of the held-out log is closed", alone)
    closed, names = _whole(each.closure for each in shown), [m.name for m in fitted.members]
    by_chance = closed.after - closed.noise < THRESHOLDS.gap_cell
    if names and closed.share < THRESHOLDS.closure_lowest and not by_chance:
        told = f"{', '.join(names)} comes closest, but closes only {max(0.0, closed.share):.0%}"
        yield Objection(f"{told} of the gap", withdraws=alone)


def _told(fitted: Fitted, shown: Sequence[ShownFlight], objections: Sequence[Objection]) -> Verdict:
    """The verdict: what every gap is, and how surely. Nothing else sets the kind of a verdict.

    A cause or a part is named at two limits, of its probability and of the share of the gap that
    all gaps together leave, where nothing speaks against it and no further gap is seen. What is
    told of a probability are two numbers, one on either side of these limits.
    """
    closure, main = _whole(each.closure for each in shown), largest_gap(shown)
    doubts = tuple(each.why for each in objections)
    left, unexplained = 1.0 - closure.share, [p for each in shown for p in each.unexplained]
    outweighed = any(each.outweighs for each in shown)
    known = [gap for gap in fitted.gaps if not is_term(gap.member.name)]
    shows_more = fitted.shows_more
    certain = _certain(shown)
    withdrawn = outweighed or any(each.withdraws for each in objections)
    if withdrawn or not (known or certain):
        unknown = withdrawn or fitted.gaps or shows_more
        kind: Kind = "unknown" if unknown else "no_gap"
    else:
        kind = "named"
    quiet = not any(each.block.stands_out for each in shown)
    trusts = kind == "named" and not doubts and not shows_more
    gaps, probabilities = list[Gap](), dict[str, float]()
    for found in fitted.gaps:
        own = left if trusts and not may_be_form(found, fitted.gaps) else 1.0
        trusted = THRESHOLDS.told_near if own < THRESHOLDS.told_left else THRESHOLDS.told_far
        gaps.append(_gap(fitted, main, found, own, trusted))
        _tell(probabilities, found, trusted)
    _tell(probabilities, fitted.left, THRESHOLDS.told_far * fitted.left.probability)
    gaps.sort(key=lambda gap: -gap.closes_held_out)
    if kind == "named" and not all(gap.named for gap in (*certain, *gaps)):
        kind = "one_of"
    if withdrawn and doubts:
        told = ", ".join(m.name for m in fitted.members)
        doubts = (*doubts, f"the name {told} is taken back")
    remains = kind in SURE and (shows_more or bool(unexplained) or len(known) < len(fitted.gaps))
    given = main.fit.columns if remains else ()
    located = [place for each in shown for place in each.located(given if each is main else ())]
    return Verdict(
        kind=kind,
        gaps=tuple(gap for gap in (*certain, *gaps) if kind in SURE or not withdrawn),
        candidates=_candidates(fitted, main, probabilities),
        located=(*unexplained, *_strongest(located)),
        checks=(),
        closure=closure,
        smallest_detectable=_joined_detectable(shown),
        advice=(),
        notes=tuple(
            dict.fromkeys(
                note for each in shown for note in _notes(each.block, known, fitted.left, quiet)
            )
        ),
        probabilities=dict(sorted(probabilities.items(), key=lambda item: -item[1])),
        log_bayes_factor=max(
            (gap.log_bayes_factor for gap in fitted.gaps), default=fitted.left.log_bayes_factor
        ),
        remains=remains,
        doubts=doubts,
        free=tuple(free for each in shown for free in _free(each)),
    )


def _tell(probabilities: dict[str, float], found: Found, trusted: float) -> None:
    """Raise the probability of each cause to that which a gap tells of it."""
    for cause, p in found.causes.items():
        probabilities[cause] = max(probabilities.get(cause, 0.0), trusted * p)


def may_be_form(found: Found, gaps: Sequence[Found]) -> bool:
    """Return whether a gap may be what the form of a larger one leaves: that of a sensor effect of
    the same part, whose law is seldom that of the table.
    """
    effects = [effect_of(parted(each.member.name)[0]) for each in (found, *gaps)]
    larger = [each.log_bayes_factor > found.log_bayes_factor for each in gaps]
    return effects[0].acts_on == "sensors" and any(
        is_larger and effect.part == effects[0].part
        for is_larger, effect in zip(larger, effects[1:], strict=True)
    )


def _gap(fitted: Fitted, main: ShownFlight, found: Found, left: float, trusted: float) -> Gap:
    """A gap as it is told, with `left` the share of all gaps that is left."""
    closure = main.closure
    given = [m for m in fitted.members if m is not found.member]
    own, beside = (fitted.regression.shown_columns(main.block, m) for m in ([found.member], given))
    gain = main.block.equations.fit(own, beside).gain if own else 0.0
    closed = gain / max(closure.before - closure.noise, gain, 1.0)
    ranked = list(found.causes)
    if is_term(found.member.name):
        chosen = (_candidate(fitted, main, found, found.member.name, 1.0 - found.unknown),)
        return Gap("", 1.0 - found.unknown, chosen, False, False, closed, closed * found.held_out)
    named = found.causes[ranked[0]] > THRESHOLDS.named_from and left < THRESHOLDS.named_left
    held = np.cumsum([found.causes[cause] for cause in ranked])
    enough = THRESHOLDS.set_holds * float(held[-1])
    count = 1 if named else max(2, 1 + int(np.searchsorted(held, enough)))
    parts: dict[str, float] = {}
    for cause, p in found.causes.items():
        parts[effect_of(cause).part] = parts.get(effect_of(cause).part, 0.0) + p
    part = effect_of(ranked[0]).part
    causes = tuple(
        _candidate(fitted, main, found, _form(found, cause), trusted * found.causes[cause])
        for cause in ranked[:count]
    )
    return Gap(
        part,
        trusted * parts[part],
        causes,
        named,
        parts[part] > THRESHOLDS.part_named_from and left < THRESHOLDS.told_left,
        closed,
        closed * found.held_out,
    )


def _form(found: Found, cause: str) -> str:
    """The most probable form of a cause."""
    forms = {n: p for n, p in found.forms.items() if not is_term(n) and cause_of(n) == cause}
    return max(forms, key=lambda name: forms[name])


def _candidate(
    fitted: Fitted, main: ShownFlight, found: Found, name: str, probability: float
) -> Candidate:
    """A hypothesis in the place of a gap, at its sizes beside the other gaps."""
    block, regression = main.block, fitted.regression
    others = [m for m in fitted.members if m is not found.member]
    own = regression.shown_columns(block, [Member(name, (), np.zeros(0))])
    beside = regression.shown_columns(block, others)
    fit = block.equations.fit(own, beside)
    if name == found.member.name:
        keys = [block.keys[c] for c in own] or keys_of(name, regression.keys)
        shared = fitted.sizes.among(keys)
        fit = Fit(tuple(own), shared.values, shared.covariance, fit.gain)
        sizes = _estimates(shared)
    else:
        sizes = estimates(block.layout.signatures, fit)
    times = times_of(block.layout.signatures[own[0]]) if own and not is_term(name) else ()
    effect, _ = parted(name)
    return Candidate(effect, significant(sizes), float(np.sqrt(fit.gain)), probability, times)


def _estimates(sizes: Sizes) -> tuple[Estimate, ...]:
    """Sizes with their bounds, which include the error of the method."""
    deviations = np.sqrt(np.diag(sizes.covariance))
    each = zip(sizes.keys, sizes.values.tolist(), deviations.tolist(), strict=True)
    return tuple(
        Estimate(key[1], size, 2.0 * float(np.hypot(deviation, THRESHOLDS.size_error * size)))
        for key, size, deviation in each
    )


def _certain(shown: Sequence[ShownFlight]) -> list[Gap]:
    """Gaps without a posterior: faults that were counted, and the level of the turbulence."""
    found = {c.name: c for each in shown for c in each.certain}
    return [
        Gap(effect_of(c.name).part, 1.0, (c, *_beside(c)), not _beside(c), True, 0.0, 0.0)
        for c in found.values()
    ]


def _beside(each: Candidate) -> tuple[Candidate, ...]:
    """Gusts of another level may be of another scale."""
    other = each.name == "turbulence_level"
    return (Candidate("turbulence_scale", (), each.score, 0.0),) if other else ()


def _whole(closures: Iterable[Closure]) -> Closure:
    every = list(closures)
    return Closure(*(sum(getattr(c, n) for c in every) for n in ("before", "after", "noise")))


def largest_gap(shown: Sequence[ShownFlight]) -> ShownFlight:
    """Return the flight with the largest gap."""
    return max(shown, key=lambda each: each.closure.before - each.closure.noise)


def _strongest(places: Sequence[Located]) -> list[Located]:
    best: dict[str, Located] = {}
    for place in sorted(places, key=lambda each: -abs(each.significance)):
        best.setdefault(place.channel, place)
    return list(best.values())


def _free(each: ShownFlight) -> Iterable[FreeSize]:
    """The log's own unknowns that lie beyond a bound of their priors, and of what null flights
    show. What these show adds to the bound of the size: a vane reads gusts whole, and on flights
    without an error seems to have a wrong scale.
    """
    free, on_null = each.block.layout.free, each.block.null.scores.free
    sizes, deviations = each.block.equations.free_estimates(each.fit.columns)
    for name, size, deviation, prior in zip(
        free.names, sizes.tolist(), deviations.tolist(), free.deviations.tolist(), strict=True
    ):
        seeming = prior * on_null.get(name, 0.0)
        usual = max(prior, seeming)
        if abs(size) > THRESHOLDS.free_told_from * usual:
            known = np.array([[deviation**2 + seeming**2]])
            with_form = float(np.sqrt(with_form_error(known, [size])[0, 0]))
            yield FreeSize(name, size, 2.0 * with_form, usual)


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


def _joined_detectable(shown: Sequence[ShownFlight]) -> tuple[Detectable, ...]:
    """The smallest size that all flights together show: the squares of the reciprocals add up."""
    found: dict[tuple[str, str], float] = {}
    for each in shown:
        block = each.block
        for one in smallest_detectable(block.equations, block.layout, block.null, each.fit.columns):
            key = (one.effect, one.parameter)
            found[key] = found.get(key, 0.0) + one.size**-2.0
    return tuple(Detectable(*key, total**-0.5) for key, total in found.items())


def smallest_detectable(
    equations: NormalEquations, layout: Layout, null: NullDistribution, given: Sequence[int] = ()
) -> tuple[Detectable, ...]:
    """Return the size of each effect that would reach its threshold half of the time.

    The columns `given` are those of the gaps, which are fitted together with each size.
    """
    sizes = []
    for index, signature in enumerate(layout.signatures):
        if index in given or signature.effect not in FITTED or FITTED[signature.effect].variant_of:
            continue
        deviation = float(equations.fit([index], given).deviations[0])
        parameter = FITTED[signature.effect].parameter(signature.parameter)
        size = null.threshold_of(signature.effect) * deviation
        if 0.0 < size <= max(abs(parameter.low), abs(parameter.high)):
            sizes.append(Detectable(signature.effect, signature.parameter, size))
    return tuple(sizes)


def _notes(block: Block, known: Sequence[Found], left: Found, quiet: bool) -> Iterable[str]:
    """Sentences on the limits of a verdict."""
    layout, null = block.layout, block.null
    if quiet and left.log_bayes_factor >= null.gap_bayes_factor:
        yield "no place and no effect stands out of what flights without an effect show"
    if null.flights == 0:
        yield (
            "no null flights of this card: the noise is judged by this log alone, and a gap is "
            f"told from a Bayes factor of e^{null.gap_bayes_factor:.0f} on"
        )
    flies = layout.reference.force_model is not None
    if not flies:
        yield "no aircraft model: sensors and air alone are judged, and no card is flown"
    if PATH_SCALES[0] in layout.track:
        yield (
            "no vanes: the flow angles are those of the path through the mean wind; their scale is "
            "free, so an equal change of all coefficients of one angle cannot be seen"
        )
    shown = {s.effect for s in layout.signatures}
    if not layout.setting.day_known:
        shown.add(DAY)
        if flies:
            yield "the header does not tell the temperature of the day: another one is no gap"
    plain = {
        n: e for n, e in FITTED.items() if not e.variant_of and (flies or e.acts_on != "aircraft")
    }
    hidden = [n for n in plain if n not in shown]
    lacking = _without_the_parts(hidden, layout)
    if lacking:
        yield (
            "left out, because the model of the aircraft lacks what they change: "
            + ", ".join(lacking)
        )
    unseen = [n for n in hidden if n not in lacking]
    if unseen:
        seen = {e.part for n, e in plain.items() if n not in unseen}
        told = dict.fromkeys(
            n if plain[n].part in seen else f"all of {plain[n].part}" for n in unseen
        )
        yield "cannot be seen in the channels of this log: " + ", ".join(told)
    causes = [cause_of(found.member.name) for found in known]
    for other, effect in FITTED.items():
        if effect.one_model_with in causes:
            same = f"{other} is one model with {effect.one_model_with}"
            yield f"{same}: it has the same terms in every channel"
    ratios = block.noise.deviations / null.noise.deviations
    noisy = [
        f"{n} ({r:.1f} times)"
        for n, r in zip(null.noise.names, ratios, strict=True)
        if r > THRESHOLDS.noise_noted
    ]
    if noisy and null.flights:
        yield "more noise than on null flights: " + ", ".join(noisy)


def _without_the_parts(names: Sequence[str], layout: Layout) -> list[str]:
    """Return those of the effects that the aircraft cannot take at all."""
    model = layout.reference.force_model
    acting = [(n, effect) for n in names if isinstance(effect := FITTED[n], AircraftEffect)]
    return (
        []
        if model is None
        else [n for n, effect in acting if not effect.fitting(model.aircraft.baseline)]
    )


# Several flights: what each says alone, and whether it agrees with the others. A flight that shows
# another size than the others do contradicts the cause.

FARTHEST = 1e-300  # smallest probability that is turned into a distance


def _flights(
    names: Sequence[str], fitted: Fitted, shown: Sequence[ShownFlight]
) -> tuple[JoinedFlight, ...]:
    """What each flight says; of several, what it says alone and beside the others."""
    several, found = len(shown) > 1, []
    for number, (name, each) in enumerate(zip(names, shown, strict=True)):
        gaps, left = [*fitted.gaps], fitted.left
        own: tuple[OwnSize, ...] = ()
        left_out: Closure | None = None
        if several:
            gaps, left = Regression([each.block]).fit()
            members = fitted.members or [gap.member for gap in gaps]
            lasting = [m for m in members if not is_term(m.name) and returns(m.name)]
            rest = [i for i in range(len(shown)) if i != number]
            mine = fitted.regression.shown_alone([number], lasting).widened()
            theirs = fitted.regression.shown_alone(rest, lasting).widened()
            own = tuple(_own_sizes(lasting, mine, theirs))
            shared = fitted.regression.shown_columns(each.block, fitted.members)
            left_out = _left_out(each.block, theirs, shared) if fitted.gaps else None
        shows = gaps or fitted.regression.shows(left)
        known = [gap for gap in gaps if not is_term(gap.member.name)]
        sure = all(max(g.causes.values()) > THRESHOLDS.named_from for g in known)
        kind: Kind = "no_gap" if not shows else "unknown"
        if known:
            kind = "named" if sure else "one_of"
        time = each.block.layout.track.time
        found.append(
            JoinedFlight(
                log=name,
                maneuver="",
                minutes=float(time[-1] - time[0]) / SECONDS_A_MINUTE,
                alone=kind,
                causes=tuple(tuple(_holding(gap.causes)) for gap in known),
                log_bayes_factor=max(
                    (g.log_bayes_factor for g in gaps), default=left.log_bayes_factor
                ),
                closure=each.closure,
                left_out=left_out,
                own_sizes=own,
                null_flights=each.block.null.flights,
            )
        )
    return tuple(found)


def _holding(causes: dict[str, float]) -> Iterable[str]:
    """The causes of the smallest set that holds a gap."""
    held, whole = 0.0, sum(causes.values())
    for cause, p in causes.items():
        if held < THRESHOLDS.set_holds * whole:
            yield cause
        held += p


def _left_out(block: Block, sizes: Sizes, gaps: Sequence[int]) -> Closure | None:
    """The closure of a flight by the sizes that the other flights show; None where they show none.

    Of the columns of all `gaps`, effects for a part of one flight, and events, are fitted to that
    flight: another flight does not have them.
    """
    here = sizes.among(block.keys)
    columns = [block.keys.index(key) for key in here.keys]
    once = [c for c in gaps if c not in columns]
    if not columns:
        return None
    values, cells = here.values.tolist(), block.layout.examined
    return closure_of(block.equations, columns, values, cells, here.covariance, once)


def _own_sizes(members: Sequence[Member], mine: Sizes, theirs: Sizes) -> Iterable[OwnSize]:
    """The largest size of each effect that a flight shows, with the distance of all from those of
    the others.
    """
    for member in members:
        own = mine.among(keys_of(member.name, mine.keys))
        other = theirs.among(own.keys)
        if not own.keys:
            continue
        spread = np.sqrt(np.diag(own.covariance))
        place = int(np.argmax(np.abs(own.values) / spread))
        size = Estimate(own.keys[place][1], float(own.values[place]), 2.0 * float(spread[place]))
        yield OwnSize(member.name, size, contradiction(own, other) if other.keys else None)


def contradiction(own: Sizes, others: Sizes) -> float:
    """Return the distance [σ] of the sizes that one flight shows from those that the other flights
    show.

    It is that of a normal number as improbable as the squared distance of the sizes, which is
    χ²-distributed.
    """
    mine, theirs = own.among(others.keys), others.among(own.keys)
    theirs = theirs.among(mine.keys)
    difference = mine.values - theirs.values
    square = float(difference @ np.linalg.solve(mine.covariance + theirs.covariance, difference))
    chance = float(chdtrc(len(difference), square))
    return float(-ndtri(0.5 * max(chance, FARTHEST)))


def contradictions(flights: Sequence[JoinedFlight]) -> list[str]:
    """Return a sentence for each effect that a flight contradicts, with the flight that does so
    most.

    Two flights are equally far apart: the one that shows less of the effect is the one that
    contradicts it.
    """
    lines = []
    for effect in dict.fromkeys(own.effect for flight in flights for own in flight.own_sizes):
        found = [
            (own.apart or 0.0, -abs(own.size.value) / own.size.two_sigma, flight.log, own)
            for flight in flights
            for own in flight.own_sizes
            if own.effect == effect
        ]
        apart, _, log, own = max(found, key=lambda row: (round(row[0], 6), row[1]))
        if _is_apart(own):
            size = f"{own.size.name} {own.size.value:.3g} ± {own.size.two_sigma:.2g}"
            lines.append(
                f"{log} contradicts {effect}: it shows {size}, {apart:.1f}σ from the other flights"
            )
    return lines


# A log without null flights, and one that is held out.


def for_channels(of_card: NullDistribution | None, layout: Layout) -> NullDistribution:
    """Return the null distribution of a card if it has the channels of a log; else one from the log
    itself.
    """
    if of_card is not None and of_card.noise.names == layout.residuals.names:
        return of_card
    return theoretical_distribution(layout)


def hold_out(
    lay: Callable[[Catalog[Effect]], Layout], null: NullDistribution, fitted: Fitted
) -> Closure | None:
    """Return the closure of all gaps on another log, with the sizes fitted before; None where no
    gap is to be seen there. `lay` lays the log out with some effects as its hypotheses.

    Events and effects for a part of one flight are left out: the other flight has them at other
    times, or not at all. So are sizes that the other log cannot show. The noise is that of the
    other log alone where it has other channels.
    """
    lasting = [m.name for m in fitted.members if not is_term(m.name) and returns(m.name)]
    chosen: Catalog[Effect] = Catalog(
        "effect", {n: FITTED[n] for name in lasting for n in (name, *FITTED[name].left_open)}
    )
    sizes, shapes = fitted.sizes.by_key(), dict[str, dict[str, float]]()
    for block in fitted.regression.blocks:
        for signature in block.layout.signatures:
            shapes.setdefault(signature.effect, dict(signature.shapes))
    entries = {n: dict(shapes.get(n, {})) for n in chosen}
    for (effect, parameter), size in sizes.items():
        if effect in entries:
            entries[effect][parameter] = size
    layout = without_sensor_effects(lay(chosen), entries)
    layout = at_sizes(layout, sizes, shapes)
    terms = {key: size for key, size in sizes.items() if key[0] not in FITTED}
    layout = replace(
        layout, signatures=(*layout.signatures, *signatures_at(layout.reference, terms))
    )
    keys = [(s.effect, s.parameter) for s in layout.signatures]
    own = fitted.sizes.among(keys)
    if not own.keys:
        return None
    equations = whitened_equations(layout, scaled_to(for_channels(null, layout).noise, layout))
    columns, values = [keys.index(key) for key in own.keys], own.values.tolist()
    errors = with_form_error(own.covariance, values)
    return closure_of(equations, columns, values, layout.examined, errors)


def closes(held: Closure) -> bool:
    """Whether effects close enough of the gap of a log that their sizes were not fitted to.

    They do where what is left of the gap is within chance: a log that shows little of an effect
    says little of it, and so do sizes that are hardly known.
    """
    by_chance = THRESHOLDS.gap_cell + THRESHOLDS.left_by_chance * held.chance
    return held.share >= THRESHOLDS.closure_lowest or held.after - held.noise < by_chance
