"""Learn the null distribution from null flights: noise, scores, gusts, spectral lines, wander."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np
from scipy.special import ndtri

from pitotbench.estimation.information import Information
from pitotbench.reconciliation.equations import (
    noise_residuals,
    scaled_to,
    whitened_equations,
)
from pitotbench.reconciliation.evidence import (
    NEGLIGIBLE,
    SMALLEST,
    evidence_beyond_floor,
    significance,
    without_lasting,
    without_score,
)
from pitotbench.reconciliation.layout import Layout
from pitotbench.reconciliation.lines import SMALLEST_POWER, lines_over, spectral_lines
from pitotbench.reconciliation.noise import NoiseModel, autocovariance, learned
from pitotbench.reconciliation.null_distribution import (
    Measure,
    NullDistribution,
    ScoreScale,
    cell_label,
    measures_over,
    size_label,
)
from pitotbench.reconciliation.pitch_factor import factor_deviation
from pitotbench.reconciliation.renewal import placed_in_time
from pitotbench.reconciliation.signatures import FITTED, columns_of, searched_shapes
from pitotbench.reconciliation.thresholds import THRESHOLDS
from pitotbench.records.calibration import Estimate
from pitotbench.records.verdict import Candidate, Located
from pitotbench.scatter import robust_deviation
from pitotbench.units import Array

# The level of the turbulence of a log against that of null flights. No mean shows it. It shows in
# how far the residuals of the wind triangle wander: in their autocovariance beyond the correlation
# of sensor noise.

CHANNELS = ("airspeed_along", "airspeed_across", "airspeed_down")
LAG = 1  # instants (0.5 s): at lag 0 sensor noise adds to the gusts

SMALLEST_AUTOCOVARIANCE = 1e-9  # m²/s², of an autocovariance whose logarithm is taken


def gust_level(layout: Layout) -> float:
    """Return the logarithm of the deviation of the gusts of a log."""
    columns = [layout.residuals.names.index(n) for n in CHANNELS if n in layout.residuals.names]
    covariance = autocovariance(noise_residuals(layout)[:, columns], layout.grid)[:, LAG]
    return 0.5 * float(np.mean(np.log(np.maximum(covariance, SMALLEST_AUTOCOVARIANCE))))


def turbulence_candidates(layout: Layout, on_null: Measure | None) -> tuple[Candidate, ...]:
    """Return the level of turbulence as an explanation where it differs from that of the card.

    The tuple is empty without null flights.
    """
    if on_null is None:
        return ()
    level = gust_level(layout)
    change = float(np.expm1(level - on_null.mean))
    score = abs(on_null.standardized(level))
    if score < THRESHOLDS.gust_level:
        return ()
    size = Estimate("change", max(change, -1.0), 2.0 * (1.0 + change) * on_null.deviation)
    return (Candidate("turbulence_level", (size,), score),)


# How far a channel wanders, against null flights: a gap that neither an effect nor a cell explains.
# A gap that follows no variable, such as an error that comes and goes, does not change any mean. It
# shows only in the sum of squares of its channel. Louder noise does not count, not even for a part
# of the flight: a wander is more than the median of the innovations nearby tells.


def channel_powers(layout: Layout, noise: NoiseModel) -> dict[str, float]:
    """Return ln of each channel's mean square innovation, each over the usual size nearby.

    The usual size is the robust deviation of the instants nearby. Louder sensors, or an airplane
    that answers gusts more, raise both. A spike counts up to a limit: a wander lasts, and a busy
    hand on a throttle makes spikes in what the engines tell.
    """
    innovations = noise.innovations(noise_residuals(layout), layout.grid, layout.residuals.slack)
    used = innovations[np.any(innovations != 0.0, axis=1)]
    least = THRESHOLDS.wander_nearby_lowest * robust_deviation(used)
    squares = np.concatenate(
        [
            part**2 / (np.maximum(robust_deviation(part), least) ** 2 + SMALLEST_POWER)
            for part in np.array_split(used, max(1, len(used) // THRESHOLDS.wander_nearby))
        ]
    )
    power = np.mean(np.minimum(squares, THRESHOLDS.wander_spike**2), axis=0)
    return dict(zip(layout.residuals.names, np.log(power + SMALLEST_POWER).tolist(), strict=True))


def powers_over(
    flights: Sequence[Mapping[str, float]], instants: int, gusts: Measure
) -> dict[str, Measure]:
    """Return mean and deviation of each channel's power over null flights of so many instants.

    No deviation is below that of white noise, or below that between flights of other days and
    pilots. In turbulence the channels of the wind triangle are not included.
    """
    turbulent = gusts.mean > np.log(THRESHOLDS.calm_gusts)
    judged = [
        {n: v for n, v in each.items() if not (turbulent and n in CHANNELS)} for each in flights
    ]
    lowest = max(float(np.sqrt(2.0 / instants)), THRESHOLDS.wander_deviation_lowest)
    return measures_over(judged, lowest)


def wandering_channels(
    layout: Layout, before: Layout, null: NullDistribution, explained: float
) -> tuple[Located, ...]:
    """Return the channels that wander more than on null flights, the worst one first.

    `layout` is the log without the named effects, `before` the log with them, and `explained` the
    fall of the sum of squares by them. A channel counts if its surplus over null flights is
    significant, is more than a share of `explained` that an imperfect signature may leave, and is
    more than half of its surplus before. With the last rule a late velocity counts as explained,
    although its gusts, which no signature contains, are late as well.
    """
    powers, powers_before = channel_powers(layout, null.noise), channel_powers(before, null.noise)
    located = []
    for name, on_null in null.channel_powers.items():
        score = on_null.standardized(powers[name])
        surplus, surplus_before = (
            float(np.exp(each[name]) - np.exp(on_null.mean)) for each in (powers, powers_before)
        )
        is_large = len(layout.grid) * surplus > THRESHOLDS.remaining_share * explained
        is_new = surplus > THRESHOLDS.wander_share * surplus_before
        if score > THRESHOLDS.remaining_wander and is_large and is_new:
            located.append(Located(name, "", "", score))
    return tuple(sorted(located, key=lambda place: -place.significance))


# The wander that null flights have in the cells of a channel, beyond white noise, pooled over their
# cells.


def wander_of(null: NullDistribution, channels: Sequence[str]) -> Mapping[str, float]:
    """Return the mean of the squared scores of the cells of each channel on null flights, less 1.

    Both the mean of the scores and their spread count, because a flight of another day, pilot,
    altitude or loading has another mean than the null flights. A few flights determine one cell
    badly; all cells of a channel together determine its wander. Without null flights every channel
    has a usual one.
    """
    if null.flights == 0:
        return dict.fromkeys(channels, THRESHOLDS.wander_unknown)
    return wander_of_scores(null.scores)


def wander_of_scores(scores: ScoreScale) -> dict[str, float]:
    """Return the same from the scores of null flights."""
    squares: dict[str, list[float]] = {}
    for label, mean in scores.cell_mean.items():
        spread = scores.cell_spread[label]
        squares.setdefault(label.split("|")[0], []).append(mean**2 + spread**2)
    return {name: max(0.0, float(np.mean(values)) - 1.0) for name, values in squares.items()}


MEAN_SCORE = 0.8  # mean absolute value of a standard normal number, √(2/π)

Item = TypeVar("Item")
Flight = tuple[Layout, NoiseModel]


@dataclass(frozen=True, slots=True)
class FlightScores:
    """The scores of one flight: of effects, cells and sizes beside all cells, and free parameters.

    Those of cells have a sign; free parameters are in deviations of their priors.
    """

    effects: Mapping[str, float]
    cells: Mapping[str, float]
    sizes: Mapping[str, float]
    free: Mapping[str, float]

    def largest_effect(self, scale: ScoreScale) -> float:
        """The largest score of an effect on a scale."""
        return max(scale.of_effect(name, score) for name, score in self.effects.items())

    def largest_cell(self, scale: ScoreScale) -> float:
        """The largest absolute score of a cell on a scale."""
        return max(abs(scale.of_label(label, score)) for label, score in self.cells.items())


Perform = Callable[[Callable[[Any], Any], Sequence[Any]], list[Any]]


def learn_null_distribution(
    layouts: Sequence[Layout], each: Perform | None = None
) -> NullDistribution:
    """Learn from null flights.

    `each` does the work on every flight, by default one after the other.

    Each flight is scored by the noise, means and spreads of the others, because the log to be
    judged has no part in them either. Raises ValueError for fewer flights than a spread needs.
    """
    if len(layouts) < THRESHOLDS.null_flights_fewest:
        raise ValueError(
            f"{len(layouts)} null flights are too few to set a threshold; "
            f"fly at least {THRESHOLDS.null_flights_fewest}"
        )
    names = layouts[0].residuals.names
    data = [(noise_residuals(each), each.grid, each.residuals.slack) for each in layouts]
    noises = [learned(names, _all_but(data, i)) for i in range(len(layouts))]
    flights = (each or _in_turn)(scores_of, list(zip(layouts, noises, strict=True)))
    scales = [_scale_of(_all_but(flights, i)) for i in range(len(flights))]
    seen = (each or _in_turn)(evidence_of, list(zip(layouts, noises, scales, strict=True)))
    labels = seen[0][0]
    alike = [i for i, (names, _) in enumerate(seen) if names == labels]
    apart, left = left_over(labels, [seen[i][1] for i in alike])
    instants = float(np.mean([len(layouts[i].grid) for i in alike]))
    scores, products = (each / instants for each in lasting_scores(left))
    lasting = dict(zip(labels, scores.tolist(), strict=True))
    scale = replace(
        _scale_of(flights), left_over=apart, lasting=lasting, products=products.tolist()
    )
    taken = (*scale.lasting_of(labels), round(instants))
    bare = [without_lasting(each, *taken) for each in left]
    scale = replace(scale, pitch_factor=factor_deviation(labels, bare))
    largest = [
        flight.largest_effect(others) for flight, others in zip(flights, scales, strict=True)
    ]
    largest_cell = [
        flight.largest_cell(others) for flight, others in zip(flights, scales, strict=True)
    ]
    gusts = measures_over(
        [{"": gust_level(layout)} for layout in layouts], THRESHOLDS.gust_deviation_lowest
    )[""]
    powers = [channel_powers(layout, noise) for layout, noise in zip(layouts, noises, strict=True)]
    return NullDistribution(
        noise=learned(names, data),
        scores=scale,
        threshold=_threshold(largest, len(scale.effect_spread)),
        cell_threshold=_threshold(largest_cell, len(scale.cell_mean)),
        flights=len(layouts),
        gust_level=gusts,
        channel_powers=powers_over(powers, min(len(each.grid) for each in layouts), gusts),
        spectral_lines=lines_over(
            [spectral_lines(*each) for each in zip(layouts, noises, strict=True)]
        ),
    )


def _all_but(items: Sequence[Item], index: int) -> list[Item]:
    return [*items[:index], *items[index + 1 :]]


def _scale_of(flights: Sequence[FlightScores]) -> ScoreScale:
    """The scale of scores that some flights show."""
    names, labels = {n for f in flights for n in f.effects}, {c for f in flights for c in f.cells}
    effects = {n: np.array([f.effects.get(n, 0.0) for f in flights]) for n in names}
    cells = {c: [f.cells.get(c, 0.0) for f in flights] for c in labels}
    gain = {
        n: max(0.0, float(np.mean(v)) - MEAN_SCORE) if searched_shapes(FITTED[n]) else 0.0
        for n, v in effects.items()
    }
    lowest = THRESHOLDS.score_deviation_lowest
    return ScoreScale(
        gain,
        {n: max(lowest, float(np.sqrt(np.mean((v - gain[n]) ** 2)))) for n, v in effects.items()},
        {c: float(np.mean(v)) for c, v in cells.items()},
        {c: max(lowest, float(np.std(v))) for c, v in cells.items()},
        {n: max(lowest, v) for n, v in _spreads([f.sizes for f in flights]).items()},
        free=_spreads([f.free for f in flights]),
    )


def _spreads(flights: Sequence[Mapping[str, float]]) -> dict[str, float]:
    """The root mean square of each score over flights."""
    names = {name for each in flights for name in each}
    scores = {name: [each.get(name, 0.0) for each in flights] for name in names}
    return {name: float(np.sqrt(np.mean(np.square(own)))) for name, own in scores.items()}


def evidence_of(
    flight: tuple[Layout, NoiseModel, ScoreScale],
) -> tuple[tuple[str, ...], Information]:
    """Return the labels of the sizes that are not searched for, and one null flight's evidence."""
    layout, noise, scale = flight
    equations = whitened_equations(layout, scaled_to(noise, layout))
    beyond = evidence_beyond_floor(layout, equations, scale, wander_of_scores(scale))
    kept = [i for i, s in enumerate(layout.signatures) if not searched_shapes(FITTED[s.effect])]
    labels = [size_label(s.effect, s.parameter) for s in layout.signatures]
    return tuple(labels[i] for i in kept), beyond.given((), (), kept)[0]


def left_over(
    labels: tuple[str, ...], flights: Sequence[Information]
) -> tuple[dict[str, float], list[Information]]:
    """Return the sizes that null flights still seem to have, and the flights without them.

    Each size comes with the root mean square of its scores. The largest comes first. It is
    eliminated before the next one is looked for, because one cause of such scores gives them to all
    effects that are like it.
    """
    found, each = dict[str, float](), list(flights)
    for _ in range(THRESHOLDS.left_over_most):
        powers = np.array([np.diag(e.inner)[:-1] for e in each])
        scores = np.array([e.inner[:-1, -1] for e in each]) / np.sqrt(np.maximum(powers, SMALLEST))
        square = np.where(powers.min(axis=0) > SMALLEST, np.mean(scores**2, axis=0), 0.0)
        worst = int(np.argmax(square))
        if labels[worst] in found or square[worst] <= THRESHOLDS.left_over_from**2:
            break
        found[labels[worst]] = float(np.sqrt(square[worst]))
        each = [without_score(e, worst, found[labels[worst]]) for e in each]
    return found, each


def lasting_scores(flights: Sequence[Information]) -> tuple[Array, Array]:
    """Return mean scores (m,) of sizes on null flights less chance, and inner products (m, m).

    The products are means. The scores are kept along those axes of the mean inner products, each
    size in units of its own power, on which they are beyond chance. Of sizes that are nearly alike,
    the noise of the mean would be large beside what another log says of their difference.
    """
    mean = np.mean([flight.inner for flight in flights], axis=0)
    scale = 1.0 / np.sqrt(np.maximum(np.diag(mean)[:-1], SMALLEST))
    power, axes = np.linalg.eigh(mean[:-1, :-1] * np.outer(scale, scale))
    along = axes.T @ (scale * mean[:-1, -1])
    shown = (power > NEGLIGIBLE) & (along**2 > THRESHOLDS.left_over_from**2 * power)
    return np.asarray(axes[:, shown] @ along[shown] / scale), mean[:-1, :-1]


def _in_turn(work: Callable[[Any], Any], flights: Sequence[Any]) -> list[Any]:
    return [work(flight) for flight in flights]


def scores_of(flight: Flight) -> FlightScores:
    """Return the scores of a null flight's effects and cells, events placed where they fit best."""
    layout, noise = flight[0], scaled_to(flight[1], flight[0])
    layout = placed_in_time(layout, noise)
    equations = whitened_equations(layout, noise)
    effects = {
        name: significance(equations.fit(columns))
        for name, columns in columns_of(layout.signatures).items()
    }
    cells = {
        cell_label(cell): float(v)
        for (_, cell), v in zip(layout.places, equations.scores(layout.examined), strict=True)
    }
    beside = equations.scores(range(len(layout.signatures)), layout.examined)
    sizes = {
        size_label(s.effect, s.parameter): float(v)
        for s, v in zip(layout.signatures, beside, strict=True)
    }
    free = equations.free_estimates()[0] / layout.free.deviations
    return FlightScores(
        effects, cells, sizes, dict(zip(layout.free.names, free.tolist(), strict=True))
    )


def _threshold(largest: Sequence[float], scores: int) -> float:
    """The largest of so many scores on any null flight, or of as many independent ones by chance.

    The latter is exceeded on the share of false alarms (Šidák 1967), with the error of means over
    so few flights.
    """
    by_chance = ndtri(1.0 - 0.5 * THRESHOLDS.false_alarms / scores) * np.sqrt(
        1.0 + 1.0 / len(largest)
    )
    return max(float(by_chance), *largest)
