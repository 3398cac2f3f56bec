"""What one flight shows with all gaps in the model, and how small an effect it would show.

What the gaps close, where it still differs, and what it cannot show are told too.
"""

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from pitotbench.effects import effect_of
from pitotbench.effects.effect import AircraftEffect
from pitotbench.reconciliation.closure import closure_of
from pitotbench.reconciliation.equations import (
    Fit,
    NormalEquations,
    with_form_error,
)
from pitotbench.reconciliation.fitting import Fitted
from pitotbench.reconciliation.flight_path import is_without_vanes
from pitotbench.reconciliation.layout import DAY, Layout
from pitotbench.reconciliation.null_distribution import NullDistribution
from pitotbench.reconciliation.null_learning import (
    turbulence_candidates,
    wandering_channels,
)
from pitotbench.reconciliation.regression import Block, FoundGap
from pitotbench.reconciliation.signatures import FITTED, GUSTS, cause_of
from pitotbench.reconciliation.thresholds import THRESHOLDS
from pitotbench.records.verdict import (
    Candidate,
    Closure,
    Detectable,
    FreeSize,
    Located,
)


@dataclass(frozen=True, slots=True)
class ShownFlight:
    """What one flight shows: the gaps as its fit, what they close, and what stays unexplained.

    `certain` is what was counted, and other gusts than those of the card; `wandering` and `lines`
    are the channels that wander or have a line. `outweighs`: what wanders is larger than a share of
    what the gaps explain.
    """

    block: Block
    fit: Fit
    closure: Closure
    certain: tuple[Candidate, ...]
    wandering: tuple[Located, ...]
    lines: tuple[Located, ...]
    outweighs: bool

    @property
    def unexplained(self) -> tuple[Located, ...]:
        """The channels that wander, and those with a line."""
        return (*self.wandering, *self.lines)

    def located(self, given: Sequence[int] = ()) -> list[Located]:
        """Return the most significant place in every channel, in σ beyond that of null flights."""
        places, best = self.block.layout.places, dict[str, Located]()
        values = self.block.equations.scores(self.block.layout.examined, given)
        for (_, cell), value in zip(places, values, strict=True):
            score = self.block.null.scores.of_cell(cell, float(value))
            if cell.channel not in best or abs(score) > abs(best[cell.channel].significance):
                best[cell.channel] = Located(cell.channel, cell.phase, cell.variable, score)
        return list(best.values())


def show_flight(block: Block, fitted: Fitted) -> ShownFlight:
    """Return what a flight shows with all gaps of a fit in the model."""
    fit, layout, null = fitted.fit_of(block), block.layout, block.null
    explained = layout.without([layout.signatures[c].column for c in fit.columns], fit.sizes)
    gusts = turbulence_candidates(explained, null.gust_level)

    def wandering(by: float) -> tuple[Located, ...]:
        # Other turbulence than that of the card makes every channel wander.
        return () if gusts else wandering_channels(explained, layout, null, by)

    least = THRESHOLDS.remaining_share * fit.gain
    lines = tuple(line.place for line in layout.lines if line.power > least)
    counted, places = layout.checked.effects, wandering(fit.gain)
    larger = THRESHOLDS.outweighing_share / THRESHOLDS.remaining_share * fit.gain
    seen = bool(wandering(larger)) if fit.columns else bool(places or lines)
    outweighs = seen and not counted
    closure = closure_of(block.beyond, fit.columns, fit.sizes.tolist(), block.cells)
    return ShownFlight(block, fit, closure, (*counted, *gusts), places, lines, outweighs)


def largest_gap(shown: Sequence[ShownFlight]) -> ShownFlight:
    """Return the flight with the largest gap."""
    return max(shown, key=lambda each: each.closure.before - each.closure.noise)


def strongest(places: Sequence[Located]) -> list[Located]:
    """Return the most significant place of each channel, the most significant first."""
    best: dict[str, Located] = {}
    for place in sorted(places, key=lambda each: -abs(each.significance)):
        best.setdefault(place.channel, place)
    return list(best.values())


def free_sizes(each: ShownFlight) -> Iterable[FreeSize]:
    """Yield the log's own unknowns beyond what their priors and null flights show.

    What these show adds to the bound of the size: a vane reads gusts whole, and on flights without
    an error seems to have a wrong scale.
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


def joined_detectable(shown: Sequence[ShownFlight]) -> tuple[Detectable, ...]:
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
    each = zip(layout.signatures, layout.parameters, strict=True)
    for index, (signature, parameter) in enumerate(each):
        if index in given or signature.effect not in FITTED or FITTED[signature.effect].variant_of:
            continue
        deviation = float(equations.fit([index], given).deviations[0])
        size = null.threshold_of(signature.effect) * deviation
        if 0.0 < size <= max(abs(parameter.low), abs(parameter.high)):
            sizes.append(Detectable(signature.effect, signature.parameter, size))
    return tuple(sizes)


def notes_of(
    block: Block, known: Sequence[FoundGap], left: FoundGap, quiet: bool, told: Collection[str]
) -> Iterable[str]:
    """Sentences on the limits of a verdict that tells some effects."""
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
    if is_without_vanes(layout.track):
        yield (
            "no vanes: the flow angles are those of the path through the mean wind; the scale of "
            "their quick changes, which gusts make as well, is free; mass, lift slope and zero lift "
            "trade without an angle of attack: any of them"
        )
        if null.flights == 0:
            yield "no vane shows the gusts, and the controls answer them: no cause of a moment is named"
    told_causes = {effect_of(name).cause for name in told}
    shown = {s.effect for s in layout.signatures} | told_causes
    shown.update(GUSTS if null.gust_level is not None else ())
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
        named = dict.fromkeys(
            n if plain[n].part in seen else f"all of {plain[n].part}" for n in unseen
        )
        yield "cannot be seen in the channels of this log: " + ", ".join(named)
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
