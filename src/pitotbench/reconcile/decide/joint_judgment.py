"""From several flights that are laid out to one verdict, with the figures of each flight and its contradictions."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pitotbench.reconcile.decide.answer import OUTSIDE, answer_of
from pitotbench.reconcile.decide.doubt import calibrated
from pitotbench.reconcile.decide.joint_naming import (
    OwnSizes,
    Together,
    contradiction,
    left_out_closures,
    name_together,
    own_sizes,
)
from pitotbench.reconcile.decide.judgment import closes, doubted, taken_back, verdict_of
from pitotbench.reconcile.decide.naming import SMALLEST_GAIN
from pitotbench.reconcile.decide.search import Names
from pitotbench.reconcile.decide.thresholds import THRESHOLDS
from pitotbench.reconcile.null_flights.null_distribution import NullDistribution
from pitotbench.reconcile.residuals.layout import Layout
from pitotbench.reconcile.signatures.hypotheses import returns
from pitotbench.records.calibration import Estimate
from pitotbench.records.joined_flight import JoinedFlight, OwnSize
from pitotbench.records.verdict import SURE, Candidate, Closure, Detectable, Kind, Located, Verdict

SECONDS_A_MINUTE = 60.0


@dataclass(frozen=True, slots=True)
class JointVerdict:
    """One verdict on several flights, what it follows from, and the figures of each flight."""

    verdict: Verdict
    together: Together
    flights: tuple[JoinedFlight, ...]


def judge_together(
    names: Sequence[str], layouts: Sequence[Layout], nulls: Sequence[NullDistribution]
) -> JointVerdict:
    """Return the verdict on several flights with their names, and what each of them says.

    A name is taken back where a flight contradicts a cause. It is doubted where the sizes that the other flights
    show close too little of the gap of a flight that is left out.
    """
    together = name_together(layouts, nulls)
    each = [verdict_of(naming.layout, naming, null) for naming, null in zip(together.namings, nulls, strict=True)]
    left_out = left_out_closures(together.namings)
    flights = tuple(
        _figures(name, together, number, each[number].closure, left_out[number], null.flights)
        for number, (name, null) in enumerate(zip(names, nulls, strict=True))
    )
    if len(each) == 1:
        return JointVerdict(each[0], together, flights)
    verdict = _joined(names, each, left_out)
    for flight in flights:
        if flight.left_out is not None and not closes(flight.left_out):
            share = max(0.0, flight.left_out.share)
            verdict = doubted(
                verdict, f"the sizes of the other flights close only {share:.0%} of the gap of {flight.log}"
            )
    for line in contradictions(flights):
        verdict = taken_back(verdict, line)
    return JointVerdict(verdict, together, flights)


def contradictions(flights: Sequence[JoinedFlight]) -> list[str]:
    """Return a sentence for each effect that a flight contradicts, with the flight that does so most.

    Two flights are equally far apart: the one that shows less of the effect is the one that contradicts it.
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
        if apart > THRESHOLDS.contradicted_from:
            size = f"{own.size.name} {own.size.value:.3g} ± {own.size.two_sigma:.2g}"
            lines.append(f"{log} contradicts {effect}: it shows {size}, {apart:.1f}σ from the other flights")
    return lines


def _figures(
    name: str, together: Together, number: int, closure: Closure, left_out: Closure | None, null_flights: int
) -> JoinedFlight:
    """The figures of one flight."""
    naming, alone = together.namings[number], together.alone[number]
    answer = answer_of(alone)
    effects = naming.chosen
    if not effects and len(together.logs) > 1:  # the flights may disagree: look at what single ones name
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
        own_sizes=_own_sizes(together, number, effects) if len(together.logs) > 1 else (),
        null_flights=null_flights,
        probabilities=calibrated(answer.probabilities, 1.0 - closure.share),
    )


def _own_sizes(together: Together, number: int, effects: Names) -> tuple[OwnSize, ...]:
    """The largest size of each effect that a flight shows, with the distance of all from those of the others."""
    sizes = dict(together.sizes)
    if not sizes:  # no shared name: the form error is that of the flight that shows most
        logs = list(together.logs)
        shown = [own_sizes([log], effects, {}) for log in logs]
        for own in shown:
            for key, value in zip(own.keys, own.values.tolist(), strict=True):
                sizes[key] = max(sizes.get(key, 0.0), value, key=abs)
    others = [log for i, log in enumerate(together.logs) if i != number]
    mine, theirs = own_sizes([together.logs[number]], effects, sizes), own_sizes(others, effects, sizes)
    found = []
    for effect in effects:
        own, other = _of(mine, effect), _of(theirs, effect)
        if not own.keys:
            continue
        spread = np.sqrt(np.diag(own.covariance))
        place = int(np.argmax(np.abs([sizes.get(key, 0.0) for key in own.keys]) / spread))
        size = Estimate(own.keys[place][1], float(own.values[place]), 2.0 * float(spread[place]))
        found.append(OwnSize(effect, size, contradiction(own, other) if other.keys else None))
    return tuple(found)


def _of(sizes: OwnSizes, effect: str) -> OwnSizes:
    """The sizes of one effect among several."""
    places = [i for i, key in enumerate(sizes.keys) if key[0] == effect]
    return OwnSizes(
        tuple(sizes.keys[i] for i in places), sizes.values[places], sizes.covariance[np.ix_(places, places)]
    )


def _joined(names: Sequence[str], each: Sequence[Verdict], left_out: Sequence[Closure | None]) -> Verdict:
    """One verdict of those on each flight, which share the posterior."""
    effects, alternatives = _joined_effects(each, left_out)
    kinds = [verdict.kind for verdict in each]
    kind: Kind = "unknown" if "unknown" in kinds else ("one_of" if any(alternatives) else "named")
    if not effects and kind != "unknown":
        kind = kinds[0] if kinds[0] not in SURE else "no_gap"
    whole = Closure(*(sum(getattr(v.closure, n) for v in each) for n in ("before", "after", "noise")))
    notes = dict.fromkeys(note for verdict in each for note in verdict.notes)
    return replace(
        each[0],
        kind=kind,
        effects=effects,
        alternatives=alternatives,
        candidates=_joined_candidates(each),
        located=_strongest([place for verdict in each for place in verdict.located]),
        checks=tuple(
            replace(check, name=f"{check.name}, {name}")
            for name, verdict in zip(names, each, strict=True)
            for check in verdict.checks
        ),
        closure=whole,
        smallest_detectable=_joined_detectable(each),
        notes=tuple(notes),
        remains=kind in SURE and any(verdict.remains for verdict in each),
    )


def _joined_effects(
    each: Sequence[Verdict], left_out: Sequence[Closure | None]
) -> tuple[tuple[Candidate, ...], tuple[tuple[str, ...], ...]]:
    """The effects of all flights, each once: their significances add in squares, their bounds are the smallest.

    The ratio held out is the fall of the sums of squares of the flights left out by the sizes of the others, over
    the fall by the shared sizes.
    """
    found: dict[str, tuple[Candidate, tuple[str, ...]]] = {}
    for verdict in each:
        for effect, others in zip(verdict.effects, verdict.alternatives, strict=True):
            old = found.get(effect.name, (effect, others))[0]
            score = float(np.hypot(old.score, effect.score)) if effect.name in found else effect.score
            better = effect if effect.score > old.score else old
            found[effect.name] = (replace(better, score=score), others)
    shared = sum(verdict.closure.before - verdict.closure.after for verdict in each)
    held = sum(closed.before - closed.after for closed in left_out if closed is not None)
    ratio = held / max(shared, SMALLEST_GAIN)
    effects = tuple(replace(effect, held_out_ratio=ratio) for effect, _ in found.values())
    return effects, tuple(others for _, others in found.values())


def _joined_candidates(each: Sequence[Verdict]) -> tuple[Candidate, ...]:
    """The candidates of all flights, each as the flight shows it in which it is most significant."""
    found: dict[str, Candidate] = {}
    for verdict in each:
        for candidate in verdict.candidates:
            old = found.get(candidate.name)
            found[candidate.name] = candidate if old is None or candidate.score > old.score else old
    ranked = sorted(found.values(), key=lambda c: (-round(c.probability, 3), -c.score))
    return tuple(ranked[: max(len(verdict.candidates) for verdict in each)])


def _strongest(places: Sequence[Located]) -> tuple[Located, ...]:
    best: dict[str, Located] = {}
    for place in places:
        old = best.get(place.channel)
        best[place.channel] = place if old is None or abs(place.significance) > abs(old.significance) else old
    return tuple(sorted(best.values(), key=lambda place: -abs(place.significance)))


def _joined_detectable(each: Sequence[Verdict]) -> tuple[Detectable, ...]:
    """The smallest size that all flights together show: the squares of the reciprocals add up."""
    found: dict[tuple[str, str], float] = {}
    for verdict in each:
        for one in verdict.smallest_detectable:
            key = (one.effect, one.parameter)
            found[key] = found.get(key, 0.0) + one.size**-2.0
    return tuple(Detectable(*key, total**-0.5) for key, total in found.items())
