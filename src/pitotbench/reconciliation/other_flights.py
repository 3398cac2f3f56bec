"""What another flight says of the gaps: each of several, left out, or a log that is held out."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

import numpy as np
from scipy.special import chdtrc, ndtri

from pitotbench.catalog import Catalog
from pitotbench.effects.effect import Effect
from pitotbench.reconciliation.closure import closure_of
from pitotbench.reconciliation.equations import (
    scaled_to,
    with_form_error,
)
from pitotbench.reconciliation.fitting import Fitted
from pitotbench.reconciliation.formula import signatures_at
from pitotbench.reconciliation.layout import Layout
from pitotbench.reconciliation.null_distribution import NullDistribution, theoretical_distribution
from pitotbench.reconciliation.regression import (
    Block,
    Regression,
    Sizes,
    block_of,
    is_term,
    keys_of,
)
from pitotbench.reconciliation.renewal import at_sizes, without_sensor_effects
from pitotbench.reconciliation.sets import FittedHypothesis
from pitotbench.reconciliation.shown_flight import ShownFlight
from pitotbench.reconciliation.signatures import FITTED, returns
from pitotbench.reconciliation.thresholds import THRESHOLDS
from pitotbench.records.calibration import Estimate
from pitotbench.records.verdict import (
    Closure,
    JoinedFlight,
    Kind,
    OwnSize,
)
from pitotbench.units import MINUTE

FARTHEST = 1e-300  # smallest probability that is turned into a distance


def contradicts(own: OwnSize) -> bool:
    return own.distance is not None and own.distance > THRESHOLDS.contradicted_from


def flights_of(
    names: Sequence[str], fitted: Fitted, shown: Sequence[ShownFlight]
) -> tuple[JoinedFlight, ...]:
    """What each flight says; of several, what it says alone and with the others."""
    several, found = len(shown) > 1, []
    for number, (name, each) in enumerate(zip(names, shown, strict=True)):
        gaps, left = [*fitted.gaps], fitted.left
        own: tuple[OwnSize, ...] = ()
        left_out: Closure | None = None
        if several:
            gaps, left = Regression([each.block]).fit()
            members = fitted.members or [gap.member for gap in gaps]
            lasting = [m for m in members if not is_term(m.name) and returns(m.name)]
            other_numbers = [i for i in range(len(shown)) if i != number]
            mine = fitted.regression.shown_alone([number], lasting).widened()
            theirs = fitted.regression.shown_alone(other_numbers, lasting).widened()
            own = tuple(_own_sizes(lasting, mine, theirs))
            shared = fitted.regression.shown_columns(each.block, fitted.members)
            left_out = _left_out(each.block, theirs, shared) if fitted.gaps else None
        shows = gaps or fitted.regression.shows(left)
        known = [gap for gap in gaps if not is_term(gap.member.name)]
        told = [THRESHOLDS.told_closed * max(g.causes.values()) for g in known]
        sure = all(each > THRESHOLDS.named_from for each in told)
        kind: Kind = "no_gap" if not shows else "unknown"
        if known:
            kind = "named" if sure else "one_of"
        time = each.block.layout.track.time
        found.append(
            JoinedFlight(
                log=name,
                maneuver="",
                minutes=float(time[-1] - time[0]) / MINUTE,
                alone=kind,
                causes=tuple(holding(gap.causes) for gap in known),
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


def holding(causes: dict[str, float]) -> tuple[str, ...]:
    """Return the causes of the smallest set that holds a gap, from causes by probability."""
    cumulative = np.cumsum([*causes.values()])
    return tuple(causes)[
        : 1 + int(np.searchsorted(cumulative, THRESHOLDS.set_holds * cumulative[-1]))
    ]


def _left_out(block: Block, sizes: Sizes, gaps: Sequence[int]) -> Closure | None:
    """Return the closure of a flight by the sizes of the other flights; None where they show none.

    Of the columns of all `gaps`, effects for a part of one flight, and events, are fitted to that
    flight: another flight does not have them.
    """
    here = sizes.among(block.keys)
    columns = [block.keys.index(key) for key in here.keys]
    once = [c for c in gaps if c not in columns]
    if not columns:
        return None
    values = here.values.tolist()
    return closure_of(block.beyond, columns, values, block.cells, here.covariance, once)


def _own_sizes(
    members: Sequence[FittedHypothesis], mine: Sizes, theirs: Sizes
) -> Iterable[OwnSize]:
    """Yield each effect's largest size that a flight shows, and its distance from the others.

    The distance is that of all its sizes.
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
    """Return the distance [σ] of the sizes of one flight from those of the others.

    A normal number of that size is as improbable as the squared distance, which is χ²-distributed.
    """
    mine, theirs = own.among(others.keys), others.among(own.keys)
    theirs = theirs.among(mine.keys)
    difference = mine.values - theirs.values
    square = float(difference @ np.linalg.solve(mine.covariance + theirs.covariance, difference))
    chance = float(chdtrc(len(difference), square))
    return float(-ndtri(0.5 * max(chance, FARTHEST)))


def contradictions(flights: Sequence[JoinedFlight]) -> list[str]:
    """Return a sentence for each effect that a flight contradicts, with the flight that does most.

    Two flights differ equally from one another: the one that shows less of the effect is the one
    that contradicts it.
    """
    lines = []
    for effect in dict.fromkeys(own.effect for flight in flights for own in flight.own_sizes):
        found = [
            (own.distance or 0.0, -abs(own.size.value) / own.size.two_sigma, flight.log, own)
            for flight in flights
            for own in flight.own_sizes
            if own.effect == effect
        ]
        distance, _, log, own = max(found, key=lambda row: (round(row[0], 6), row[1]))
        if contradicts(own):
            size = f"{own.size.name} {own.size.value:.3g} ± {own.size.two_sigma:.2g}"
            lines.append(
                f"{log} contradicts {effect}: it shows {size}, {distance:.1f}σ from the other flights"
            )
    return lines


def for_channels(of_card: NullDistribution | None, layout: Layout) -> NullDistribution:
    """Return a card's null distribution if it has the channels of a log, else one of the log."""
    if of_card is not None and of_card.noise.names == layout.residuals.names:
        return of_card
    return theoretical_distribution(layout)


def hold_out(
    lay: Callable[[Catalog[Effect]], Layout], null: NullDistribution, fitted: Fitted
) -> Closure | None:
    """Return the closure of all gaps on another log by sizes fitted before, None without a gap.

    `lay` lays the log out with some effects as its hypotheses. Events and effects for a part of one
    flight are left out: the other flight has them at other times, or not at all. So are sizes that
    the other log cannot show. The noise is that of the other log alone where it has other channels.
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
    of_log = for_channels(null, layout)
    block = block_of(layout, scaled_to(of_log.noise, layout), of_log)
    columns, values = [keys.index(key) for key in own.keys], own.values.tolist()
    errors = with_form_error(own.covariance, values)
    return closure_of(block.beyond, columns, values, block.cells, errors)
