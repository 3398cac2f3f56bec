"""Reach a verdict on one or several logs, and judge them again until nothing significant remains."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from pitotbench.bench.null_flights import (
    NULL_FLIGHTS,
    Progress,
    aircraft_model,
    as_flown,
    card_of,
    null_distribution_of,
    tells_the_day,
)
from pitotbench.effects import OWN_TERMS, effect_of
from pitotbench.logbook.checks import require_one_airplane
from pitotbench.reconciliation.free_parameters import AnalysisSetting
from pitotbench.reconciliation.layout import Layout, lay_out
from pitotbench.reconciliation.naming import Naming, fit_together
from pitotbench.reconciliation.null_distribution import NullDistribution
from pitotbench.reconciliation.patches import Patch, Shapes, patch_of_effects
from pitotbench.reconciliation.renewal import with_effects
from pitotbench.reconciliation.residuals import AircraftModel
from pitotbench.reconciliation.signatures import FITTED, GUSTS, lasts, returns
from pitotbench.reconciliation.thresholds import THRESHOLDS
from pitotbench.reconciliation.verdict import (
    Checks,
    JointVerdict,
    Objection,
    doubt_beside,
    for_channels,
    hold_out,
    judge,
    verdict_of,
)
from pitotbench.records import BadInputError
from pitotbench.records.calibration import Estimate
from pitotbench.records.case import Case
from pitotbench.records.gap import Round
from pitotbench.records.log import FlightLog
from pitotbench.records.verdict import SURE, Candidate, Closure, JoinedFlight, Verdict

# Reconcile one or several logs: find their cards, fly the null flights, and reach a verdict.


@dataclass(frozen=True, slots=True)
class NamedLog:
    """A log with its name in reports. `card` is the case that was flown; None: that in the log's
    header.
    """

    name: str
    log: FlightLog
    card: Case | None = None


@dataclass(frozen=True, slots=True)
class JudgedLog:
    """A log as it was laid out, with its null distribution, and the case that was flown (None
    without a card).
    """

    name: str
    log: FlightLog
    layout: Layout
    null: NullDistribution
    card: Case | None


@dataclass(frozen=True, slots=True)
class Reconciliation:
    """What the checks found, with the data that a page or a patch needs.

    `logs` are those that were judged, `joint` their verdict before a log was held out. `shown` is
    the number of the log of which a page shows pictures: that with the largest part of the gap.
    `naming`, `layout`, `null` and `card` are those of this log.
    """

    checks: Checks
    joint: JointVerdict
    logs: tuple[JudgedLog, ...]
    flights: tuple[JoinedFlight, ...]

    @property
    def verdict(self) -> Verdict:
        """The verdict of all checks so far."""
        return verdict_of(self.checks)

    @property
    def shown(self) -> int:
        """The number of the log with the largest part of the gap."""
        gaps = [flight.closure.before - flight.closure.noise for flight in self.flights]
        return gaps.index(max(gaps))

    @property
    def naming(self) -> Naming:
        """The fit behind the verdict."""
        return self.joint.together.namings[self.shown]

    @property
    def layout(self) -> Layout:
        """The log as it was laid out."""
        return self.logs[self.shown].layout

    @property
    def null(self) -> NullDistribution:
        """What flights of its card without an effect show."""
        return self.logs[self.shown].null

    @property
    def card(self) -> Case | None:
        """The case that was flown."""
        return self.logs[self.shown].card


def reconcile_logs(
    logs: Sequence[NamedLog],
    aircraft: str = "navajo",
    holdout: FlightLog | None = None,
    null_flights: int = NULL_FLIGHTS,
    progress: Progress | None = None,
    setting: AnalysisSetting | None = None,
    keep: bool = True,
) -> Reconciliation:
    """Name the effect that a model lacks, from one or several logs of one airplane that lacks the
    same in all.

    Causes and sizes are shared; wind, error curve and sensor biases are each log's own. `aircraft`
    is a name of the hangar, or `none` to judge the sensors alone. With an aircraft model the card
    of each log is flown for its null flights, at the first mass and the height of the log. Without
    any card the noise of the log itself sets the thresholds, which are then wider. Without `keep`
    the cache of null flights is neither read nor written. Raises BadInputError without a log, or
    for a log that cannot be used.
    """
    if not logs:
        raise BadInputError("no log to reconcile")
    require_one_airplane([each.log for each in logs])
    model = aircraft_model(aircraft)
    judged = [
        _judged(each, aircraft, model, null_flights, progress, setting, keep) for each in logs
    ]
    joint = judge(
        [each.name for each in judged],
        [each.layout for each in judged],
        [each.null for each in judged],
    )
    flights = tuple(
        replace(flight, maneuver=each.card.maneuver if each.card else "")
        for flight, each in zip(joint.flights, judged, strict=True)
    )
    checks = replace(joint.checks, maneuvers=tuple(flight.maneuver for flight in flights))
    found = Reconciliation(checks, joint, tuple(judged), flights)
    if holdout is not None and any(map(returns, found.naming.chosen)):
        held = hold_out(holdout, model, found.null, found.naming, found.layout.setting)
        found = replace(found, checks=replace(found.checks, hold_out=held))
    return found


def _judged(
    named: NamedLog,
    aircraft: str,
    model: AircraftModel | None,
    null_flights: int,
    progress: Progress | None,
    setting: AnalysisSetting | None,
    keep: bool,
) -> JudgedLog:
    """Lay a log out, and take the null distribution of its card."""
    flown = named.card or (card_of(named.log.header, aircraft) if model is not None else None)
    flown = as_flown(flown, named.log) if flown is not None and model is not None else flown
    setting = replace(
        setting or AnalysisSetting(),
        day_known=flown is not None and (named.card is not None or tells_the_day(named.log.header)),
        instruments_known=flown is not None,
    )
    of_card = (
        null_distribution_of(flown, null_flights, progress, setting, keep)
        if flown is not None
        else None
    )
    layout = lay_out(named.log, model, setting)
    return JudgedLog(named.name, named.log, layout, for_channels(of_card, layout), flown)


# Judge a log again with the named effects in the model, until nothing significant remains.


@dataclass(frozen=True, slots=True)
class Looks:
    """A reconciliation with the passes that followed it, and the fitted shapes of all effects.

    `later` is what the checks of each later pass found, `added` the effects that these passes add,
    and `last` the fit behind the verdict of the last one. Where all effects were fitted at once,
    `together` is their closure and `all_named` the fit of the log that is shown.
    """

    first: Reconciliation
    later: tuple[Checks, ...]
    added: tuple[Candidate, ...]
    shapes: Shapes
    last: Naming
    together: Closure | None = None
    all_named: Naming | None = None

    @property
    def pictured(self) -> Naming:
        """The fit that the pictures show: of all effects, where each of them was fitted with the
        others.
        """
        if self.all_named is None:
            return self.first.naming
        apart = {e.name for e in self.effects if e.name in FITTED and e.name not in GUSTS} - set(
            self.all_named.chosen
        )
        return self.first.naming if apart else self.all_named

    @property
    def told(self) -> tuple[Round, ...]:
        """The rounds, the first with the closure by all effects where they were fitted at once."""
        first, *later = self.rounds
        closure = self.together or first.verdict.closure
        return (replace(first, verdict=replace(first.verdict, closure=closure)), *later)

    @property
    def rounds(self) -> tuple[Round, ...]:
        """The verdict of each pass, with the names of the effects that it adds."""
        verdicts = map(verdict_of, (self.first.checks, *self.later))
        return tuple(
            Round(v, tuple(e.name for e in v.effects) if v.kind in SURE else ()) for v in verdicts
        )

    @property
    def effects(self) -> tuple[Candidate, ...]:
        """All effects that the looks name, the corrections of later looks added to their sizes."""
        return _joined(
            (*(self.rounds[0].verdict.effects if self.rounds[0].added else ()), *self.added)
        )

    @property
    def closure(self) -> Closure:
        """How much of the gap all passes together close.

        Each pass estimates its noise again; compare the residuals with the last pass's noise.
        """
        begin, end = (
            self.rounds[0].verdict.closure,
            self.together or self.rounds[-1].verdict.closure,
        )
        left = (end.after if self.together or self.rounds[-1].added else end.before) - end.noise
        return Closure(begin.before, min(begin.noise + left, begin.before), begin.noise)

    @property
    def remains(self) -> bool:
        """Whether something significant is left beside all that the looks name."""
        last = self.rounds[-1].verdict
        return last.kind == "unknown" or last.remains


def first_pass(first: Reconciliation) -> Looks:
    """Return a reconciliation as its own first pass, without any that follow it."""
    return Looks(first, (), (), fitted_shapes(first.naming), first.naming)


def fitted_shapes(naming: Naming) -> Shapes:
    """Return the fitted shapes of the chosen effects, for instance the time of an event."""
    chosen = [naming.layout.signatures[c] for c in naming.fit.columns]
    return {signature.effect: signature.shapes for signature in chosen if signature.shapes}


def patch_of(looks: Looks, further: Sequence[Candidate], source: str, date: str) -> Patch:
    """Return the patch of all passes, and of `further` effects. It is empty where the verdict is
    not certain.
    """
    verdict = looks.first.verdict
    effects = verdict.effects if verdict.kind in SURE else ()
    candidates = {candidate.name: candidate for candidate in verdict.candidates}
    # For each effect, the explanations with fitted sizes that the log cannot separate from it.
    alternatives = verdict.alternatives if effects else ()
    others = [[candidates[name] for name in names if name in candidates] for names in alternatives]
    return patch_of_effects(
        _joined((*effects, *looks.added, *further)), source, date, looks.shapes, others
    )


def iterate(aircraft: str, first: Reconciliation, progress: Progress | None = None) -> Looks:
    """Judge the logs again with all effects named so far in the model, and return the passes.

    Ends with a verdict of no gap or of an unknown cause, or after the third pass.
    """
    looks, model = first_pass(first), aircraft_model(aircraft)
    while looks.rounds[-1].added:
        # One more pass for every term of the model's own file that the last one names.
        own = sum(name in OWN_TERMS for each in looks.rounds for name in each.added)
        if len(looks.rounds) >= min(THRESHOLDS.looks_most + own, 2 * THRESHOLDS.looks_most):
            break
        if progress is not None:
            progress(f"looking again with {', '.join(looks.rounds[-1].added)} in the model")
        entries = dict(patch_of(looks, (), "", "").entries)
        layouts = [with_effects(each.layout, model, entries) for each in first.logs]
        joint = judge(
            [each.name for each in first.logs], layouts, [each.null for each in first.logs]
        )
        naming = joint.together.namings[first.shown]
        # Counted faults and the level of turbulence appear again in each pass. A size that is
        # fitted again is a correction of the earlier one, so it is kept.
        new = (
            i
            for i, e in enumerate(joint.checks.found.effects)
            if e.name not in entries or e.name in naming.chosen
        )
        looks = replace(
            looks, later=(*looks.later, replace(joint.checks, added=tuple(new))), last=naming
        )
        news = looks.rounds[-1]
        looks = replace(
            looks,
            added=(*looks.added, *(news.verdict.effects if news.added else ())),
            shapes={**looks.shapes, **fitted_shapes(naming)},
        )
    return looks


def settled(aircraft: str, looks: Looks, holdout: FlightLog | None = None) -> Looks:
    """Return the passes with all their effects fitted together, and without those not needed beside
    the others.

    Each effect is told by the pass that named it first. Where those of the first pass are not
    needed, it tells what the next one named. A held-out log is closed by all of them.
    """
    if not looks.added:
        return looks
    model, entries = aircraft_model(aircraft), dict(patch_of(looks, (), "", "").entries)
    layouts = [with_effects(each.layout, model, entries) for each in looks.first.logs]
    fitted = fit_together(layouts, [each.null for each in looks.first.logs], entries)
    told: set[str] = set()
    passes = [_told_once(each, fitted.sizes, told) for each in (looks.first.checks, *looks.later)]
    first = next((i for i, each in enumerate(passes) if each.found.effects), 0)
    if first:
        moved = passes[first].found
        same = ("kind", "effects", "alternatives", "candidates", "probabilities")
        found = replace(passes[0].found, **{name: getattr(moved, name) for name in same})
        passes[0], passes[first] = replace(passes[0], found=found), replace(passes[first], added=())
    layout, equations, fit = fitted.fits[looks.first.shown]
    own = looks.first.naming
    naming = replace(own, chosen=tuple(fitted.sizes), layout=layout, equations=equations, fit=fit)
    if holdout is not None and looks.first.checks.hold_out is not None:
        held = hold_out(holdout, model, looks.first.null, naming, layout.setting)
        passes[0] = replace(passes[0], hold_out=held)
    added = (effect for each in passes[1:] if each.added for effect in each.found.effects)
    return replace(
        looks,
        first=replace(looks.first, checks=passes[0]),
        later=tuple(passes[1:]),
        added=tuple(added),
        together=fitted.closure,
        all_named=naming,
    )


def _told_once(checks: Checks, sizes: Mapping[str, tuple[Estimate, ...]], told: set[str]) -> Checks:
    """The checks of a pass with the effects that none before has `told`, which grows, at their
    sizes together.
    """
    verdict, effects = checks.found, list[tuple[Candidate, tuple[str, ...]]]()
    pairs = list(zip(verdict.effects, verdict.alternatives, strict=True))
    for effect, others in pairs if checks.added is None else [pairs[i] for i in checks.added]:
        fitted = effect.name in FITTED and lasts(effect.name)
        if effect.name not in told and (effect.name in sizes or not fitted):
            told.add(effect.name)
            # A rival that stands in the model itself is none.
            rivals = tuple(name for name in others if name not in sizes)
            effects.append((replace(effect, sizes=sizes.get(effect.name, effect.sizes)), rivals))
    alternatives = tuple(others for _, others in effects)
    kind = verdict.kind
    if kind in SURE and any(verdict.alternatives):
        kind = "one_of" if any(alternatives) else "named"
    found = replace(
        verdict, kind=kind, effects=tuple(e for e, _ in effects), alternatives=alternatives
    )
    return replace(
        checks, found=found, added=None if checks.added is None else tuple(range(len(effects)))
    )


def closure_checked(looks: Looks) -> Looks:
    """Return the passes with the objection of their closure, where they close too little of the
    gap.

    A fault that the table does not hold looks like one that it holds, and leaves more of the gap
    than another form of that one would. Where the answer is one of several causes, none is claimed,
    and none is withdrawn. A size outside its range is no answer.
    """
    closed, verdict = looks.closure, looks.first.verdict
    fitted = [e for e in looks.effects if e.name in FITTED and e.name not in GUSTS]
    impossible = (
        f"{effect.name} would need {size.name} {size.value:.3g} ± {size.two_sigma:.2g}, and its "
        f"range is {own.low:g} to {own.high:g}"
        for effect in fitted
        for size in effect.sizes
        if not (own := FITTED[effect.name].parameter(size.name)).is_possible(size)
    )
    if why := next(impossible, ""):
        return _objected(looks, why, withdraws=True)
    share = f"{max(0.0, closed.share):.0%} of the gap"
    if verdict.doubts and closed.share < THRESHOLDS.closure_lowest:
        return _objected(looks, f"all looks close only {share}")
    least = THRESHOLDS.closure_with_rest if looks.remains else THRESHOLDS.closure_lowest
    by_chance = closed.after - closed.noise < THRESHOLDS.gap_cell
    names = ", ".join(effect.name for effect in fitted)
    # Faults are few. The terms of a model's own file may be off in many places at once.
    if len({effect.name for effect in fitted} - OWN_TERMS) > THRESHOLDS.effects_most:
        return _objected(
            first_pass(looks.first), f"so many effects would be needed that none is named: {names}"
        )
    if (
        verdict.kind != "named"
        or not looks.first.naming.chosen
        or closed.share >= least
        or by_chance
    ):
        return looks
    return _objected(looks, f"{names} comes closest, but closes only {share}")


def _objected(looks: Looks, why: str, withdraws: bool = False) -> Looks:
    """The passes with an objection, which withdraws the names also where they close too little of
    the gap.
    """
    withdraws = withdraws or looks.closure.share < THRESHOLDS.closure_lowest
    first = replace(
        looks.first, checks=replace(looks.first.checks, closure=Objection(why, withdraws))
    )
    return first_pass(first) if withdraws else replace(looks, first=first)


def with_calibrated_probabilities(looks: Looks) -> Looks:
    """Return the passes with calibrated probabilities, for what they all leave of the gap."""
    left, doubt = 1.0 - looks.closure.share, doubt_beside(looks.first.verdict)
    first, *later = (
        replace(each, left=left, doubt=doubt) for each in (looks.first.checks, *looks.later)
    )
    return replace(looks, first=replace(looks.first, checks=first), later=tuple(later))


def _joined(effects: Sequence[Candidate]) -> tuple[Candidate, ...]:
    """Return the effects with the corrections of later rounds added to their sizes."""
    joined: dict[str, Candidate] = {}
    for effect in effects:
        first = joined.get(effect.name)
        if first is None:
            joined[effect.name] = effect
            continue
        sizes = {s.name: s for s in first.sizes}  # what the correction does not name stays
        for s in effect.sizes:
            if s.name in sizes:  # it corrects the size that stands in the model
                held = effect_of(effect.name).parameter(s.name).within(sizes[s.name].value)
                s = replace(s, value=held + s.value)
            sizes[s.name] = s
        joined[effect.name] = replace(first, sizes=tuple(sizes.values()))
    return tuple(joined.values())
