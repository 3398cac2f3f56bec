"""The null distribution: noise, spread of the scores and thresholds of flights without an effect.

Textbook thresholds would name something on nearly every flight, because many hypotheses are tried and no noise
model is perfect. Therefore flights of the same card, data system and turbulence set the thresholds.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from pitotbench.reconcile.decide.locate import Cell
from pitotbench.reconcile.decide.thresholds import THRESHOLDS
from pitotbench.reconcile.null_flights.null_measure import Measure
from pitotbench.reconcile.residuals.layout import Layout
from pitotbench.reconcile.residuals.layout_noise import noise_of_log, shortness_of
from pitotbench.reconcile.residuals.whitening import NoiseModel
from pitotbench.reconcile.signatures.hypotheses import FITTED, reads_gusts


@dataclass(frozen=True, slots=True)
class ScoreScale:
    """The scores that flights without an effect have.

    `search_gain` is the part of an effect's score that the search for its shape (the time of an event) brings by
    chance; `effect_spread` is the root mean square of the score less this gain. `cell_mean` and `cell_spread` are
    the mean and the standard deviation of the signed score of a cell, by its label. `fluctuation` is the root mean
    square of the score of a size, by its label, where every cell is fitted beside it: by what moves to and fro.
    Gusts give it one, for the pilot answers them and the vanes read them. `left_over` holds the same for sizes that
    null flights still seem to have when wander and fluctuation are eliminated, the largest first, each beside those
    before it. No spread is below 1.
    """

    search_gain: Mapping[str, float]
    effect_spread: Mapping[str, float]
    cell_mean: Mapping[str, float]
    cell_spread: Mapping[str, float]
    fluctuation: Mapping[str, float] = field(default_factory=dict)
    left_over: Mapping[str, float] = field(default_factory=dict)

    def of_effect(self, name: str, score: float) -> float:
        """Return the score of an effect less its search gain, in units of its spread."""
        return max(0.0, score - self.search_gain.get(name, 0.0)) / self.effect_spread.get(name, 1.0)

    def of_cell(self, cell: Cell, score: float) -> float:
        """Return the signed score of a cell less its mean, in units of its spread."""
        return self.of_label(cell_label(cell), score)

    def of_label(self, label: str, score: float) -> float:
        """Return the same for the label of a cell."""
        return (score - self.cell_mean.get(label, 0.0)) / self.cell_spread.get(label, 1.0)


@dataclass(frozen=True, slots=True)
class NullDistribution:
    """What flights of a card without an effect show by chance.

    `threshold` is for the largest score of the table and `cell_threshold` for the largest score of the cells, both
    on the scale of `scores`. `gust_levels`, `channel_powers` and `spectral_lines` hold further measures, see the
    modules of these names (`wander` for the powers, `periodic` for the lines).
    """

    noise: NoiseModel
    scores: ScoreScale
    threshold: float
    cell_threshold: float
    flights: int
    gust_levels: Mapping[str, Measure] = field(default_factory=dict)
    channel_powers: Mapping[str, Measure] = field(default_factory=dict)
    spectral_lines: Mapping[str, Measure] = field(default_factory=dict)

    @property
    def gap_bayes_factor(self) -> float:
        """The logarithm of the Bayes factor from which a log shows a gap."""
        return THRESHOLDS.gap_bayes_factor if self.flights else 0.5 * self.threshold**2

    def threshold_of(self, name: str) -> float:
        """Return the score [σ] at which an effect reaches the threshold."""
        return self.scores.search_gain.get(name, 0.0) + self.threshold * self.scores.effect_spread.get(name, 1.0)


def theoretical_distribution(layout: Layout) -> NullDistribution:
    """Return the null distribution of a log for which no null flight can be flown.

    Its thresholds come from theory, and its scores are those that null flights usually have. The noise, which the
    log itself has to give, counts one half more. A short log knows its noise badly, so that it needs a larger Bayes
    factor.
    """
    least, shortness = THRESHOLDS.gap_without_null_flights, shortness_of(layout)
    if shortness > 1.0:
        least = THRESHOLDS.gap_of_short_log * shortness**2
    limit = float(np.sqrt(2.0 * least))  # the score of one size that shows a gap
    noise = noise_of_log(layout)
    noise = replace(noise, deviations=THRESHOLDS.noise_without_null_flights * noise.deviations)
    vanes = {name: THRESHOLDS.vanes_unknown for name in FITTED if reads_gusts(name)}
    fluctuation = {
        size_label(name, p.name): THRESHOLDS.vanes_moving if name in vanes else THRESHOLDS.fluctuation_unknown
        for name, effect in FITTED.items()
        for p in effect.parameters
        if not p.shape and not effect.part_of
    }
    return NullDistribution(noise, ScoreScale({}, vanes, {}, {}, fluctuation), limit, limit, 0)


def size_label(effect: str, parameter: str) -> str:
    """Return a size of an effect as text; that for a part of the flight is the one for all of it."""
    return f"{FITTED[effect].part_of or effect}|{parameter}"


def cell_label(cell: Cell) -> str:
    """Return a cell as text."""
    return f"{cell.channel}|{cell.phase}|{cell.variable}"
