"""Learn the null distribution from null flights."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np
from scipy.special import ndtri

from pitotbench.reconcile.decide.evidence import Evidence
from pitotbench.reconcile.decide.log_evidence import SMALLEST, LogEvidence, without_score
from pitotbench.reconcile.decide.null_wander import wander_of_scores
from pitotbench.reconcile.decide.scoring import significance
from pitotbench.reconcile.decide.thresholds import THRESHOLDS
from pitotbench.reconcile.null_flights.gust_levels import gusts_over
from pitotbench.reconcile.null_flights.null_distribution import (
    NullDistribution,
    ScoreScale,
    cell_label,
    size_label,
)
from pitotbench.reconcile.null_flights.periodic import lines_over, spectral_lines
from pitotbench.reconcile.null_flights.wander import channel_powers, powers_over
from pitotbench.reconcile.residuals.layout import Layout
from pitotbench.reconcile.residuals.layout_noise import noise_residuals, scaled_to, whitened_equations
from pitotbench.reconcile.residuals.whitening import NoiseModel, learned
from pitotbench.reconcile.signatures.hypotheses import FITTED, searched_shapes
from pitotbench.reconcile.signatures.refine import placed_in_time
from pitotbench.reconcile.signatures.signatures import columns_of
from pitotbench.units import Array

MEAN_SCORE = 0.8  # mean absolute value of a standard normal number, √(2/π)
EULER = 0.5772156649  # the Euler-Mascheroni constant

Item = TypeVar("Item")
Flight = tuple[Layout, NoiseModel]


@dataclass(frozen=True, slots=True)
class FlightScores:
    """The scores of one flight: of the effects, signed ones of the cells, and of the sizes beside all cells."""

    effects: Mapping[str, float]
    cells: Mapping[str, float]
    sizes: Mapping[str, float]

    def largest_effect(self, scale: ScoreScale) -> float:
        """The largest score of an effect on a scale."""
        return max(scale.of_effect(name, score) for name, score in self.effects.items())

    def largest_cell(self, scale: ScoreScale) -> float:
        """The largest absolute score of a cell on a scale."""
        return max(abs(scale.of_label(label, score)) for label, score in self.cells.items())


Perform = Callable[[Callable[[Any], Any], Sequence[Any]], list[Any]]


def learn_null_distribution(layouts: Sequence[Layout], each: Perform | None = None) -> NullDistribution:
    """Learn from null flights. `each` does the work on every flight, by default one after the other.

    Each flight is scored by the noise, means and spreads of the others, because the log to be judged has no part in
    them either.
    Raises ValueError for fewer flights than a spread needs.
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
    scale = replace(_scale_of(flights), left_over=left_over(_evidence(layouts, noises, scales, each or _in_turn)))
    largest = [flight.largest_effect(others) for flight, others in zip(flights, scales, strict=True)]
    largest_cell = [flight.largest_cell(others) for flight, others in zip(flights, scales, strict=True)]
    gusts = gusts_over(layouts)
    powers = [channel_powers(layout, noise) for layout, noise in zip(layouts, noises, strict=True)]
    return NullDistribution(
        noise=learned(names, data),
        scores=scale,
        threshold=_threshold(largest, THRESHOLDS.effect_threshold_lowest),
        cell_threshold=_threshold(largest_cell, _lowest_cell_threshold(len(scale.cell_mean), len(layouts))),
        flights=len(layouts),
        gust_levels=gusts,
        channel_powers=powers_over(powers, min(len(each.grid) for each in layouts), gusts),
        spectral_lines=lines_over([spectral_lines(*each) for each in zip(layouts, noises, strict=True)]),
    )


def _all_but(items: Sequence[Item], index: int) -> list[Item]:
    return [*items[:index], *items[index + 1 :]]


def _scale_of(flights: Sequence[FlightScores]) -> ScoreScale:
    """The scale of scores that some flights show."""
    names, labels = {n for f in flights for n in f.effects}, {c for f in flights for c in f.cells}
    sizes = {n for f in flights for n in f.sizes}
    effects = {n: np.array([f.effects.get(n, 0.0) for f in flights]) for n in names}
    cells = {c: [f.cells.get(c, 0.0) for f in flights] for c in labels}
    gain = {n: max(0.0, float(np.mean(v)) - MEAN_SCORE) if _is_searched(n) else 0.0 for n, v in effects.items()}
    lowest = THRESHOLDS.score_deviation_lowest
    return ScoreScale(
        gain,
        {n: max(lowest, float(np.sqrt(np.mean((v - gain[n]) ** 2)))) for n, v in effects.items()},
        {c: float(np.mean(v)) for c, v in cells.items()},
        {c: max(lowest, float(np.std(v))) for c, v in cells.items()},
        {n: max(lowest, float(np.sqrt(np.mean(np.square([f.sizes.get(n, 0.0) for f in flights]))))) for n in sizes},
    )


def _evidence(
    layouts: Sequence[Layout], noises: Sequence[NoiseModel], scales: Sequence[ScoreScale], each: Perform
) -> list[tuple[tuple[str, ...], Evidence]]:
    """The evidence of each flight for the sizes, with what the others show of wander and fluctuation eliminated."""
    return each(evidence_of, list(zip(layouts, noises, scales, strict=True)))


def evidence_of(flight: tuple[Layout, NoiseModel, ScoreScale]) -> tuple[tuple[str, ...], Evidence]:
    """Return the labels of the sizes that are not searched for, and the evidence of one null flight for them."""
    layout, noise, scale = flight
    log = LogEvidence(layout, scaled_to(noise, layout), wander_of_scores(scale), scale)
    kept = [i for i, s in enumerate(layout.signatures) if not _is_searched(s.effect)]
    return tuple(log.labels[i] for i in kept), log.base.given((), (), kept)[0]


def left_over(flights: Sequence[tuple[tuple[str, ...], Evidence]]) -> dict[str, float]:
    """Return the sizes that null flights still seem to have, with the root mean square of their scores.

    The largest comes first. It is eliminated before the next one is looked for, because one cause of such scores
    gives them to all effects that are like it.
    """
    labels, found = flights[0][0], dict[str, float]()
    each = [evidence for names, evidence in flights if names == labels]
    for _ in range(THRESHOLDS.left_over_most):
        powers = np.array([np.diag(e.inner)[:-1] for e in each])
        scores = np.array([e.inner[:-1, -1] for e in each]) / np.sqrt(np.maximum(powers, SMALLEST))
        square = np.where(powers.min(axis=0) > SMALLEST, np.mean(scores**2, axis=0), 0.0)
        worst = int(np.argmax(square))
        if labels[worst] in found or square[worst] <= THRESHOLDS.left_over_from**2:
            break
        found[labels[worst]] = float(np.sqrt(square[worst]))
        each = [without_score(e, worst, found[labels[worst]]) for e in each]
    return found


def _in_turn(work: Callable[[Any], Any], flights: Sequence[Any]) -> list[Any]:
    return [work(flight) for flight in flights]


def scores_of(flight: Flight) -> FlightScores:
    """Return the scores of all effects and cells of one null flight, with events where they fit best."""
    layout, noise = flight[0], scaled_to(flight[1], flight[0])
    layout = placed_in_time(layout, noise)
    equations = whitened_equations(layout, noise)
    effects = {
        name: significance(equations.fit(columns)) for name, columns in columns_of(layout.signatures).items()
    }
    places = layout.places
    every = [i for i, _ in places]
    cells = {cell_label(cell): float(v) for (_, cell), v in zip(places, equations.scores(every), strict=True)}
    beside = equations.scores(range(len(layout.signatures)), every)
    sizes = {size_label(s.effect, s.parameter): float(v) for s, v in zip(layout.signatures, beside, strict=True)}
    return FlightScores(effects, cells, sizes)


def _is_searched(name: str) -> bool:
    return bool(searched_shapes(FITTED[name]))


def _lowest_cell_threshold(cells: int, flights: int) -> float:
    """The value that the largest of independent scores exceeds on the share of false alarms (Šidák 1967).

    It includes the error of means over so few flights.
    """
    return float(ndtri(1.0 - 0.5 * THRESHOLDS.false_alarms / cells) * np.sqrt(1.0 + 1.0 / flights))


def _threshold(largest: Sequence[float] | Array, lowest: float) -> float:
    """The value that the largest score exceeds on the share of false alarms.

    Source: the distribution of extremes (Gumbel 1958), fitted by moments. The deviation is shrunk toward that of
    other cards, because few flights determine it badly.
    """
    variance, n = float(np.var(largest, ddof=1)), len(largest)
    prior, weight = THRESHOLDS.largest_score_deviation, THRESHOLDS.largest_score_weight
    shrunk = ((n - 1) * variance + weight * prior**2) / (n - 1 + weight)
    scale = float(np.sqrt(6.0 * shrunk)) / np.pi
    mode = float(np.mean(largest)) - EULER * scale
    return max(lowest, float(mode - scale * np.log(-np.log1p(-THRESHOLDS.false_alarms))))
