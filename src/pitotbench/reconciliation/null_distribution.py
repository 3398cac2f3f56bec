"""The null distribution: noise, scores and thresholds of flights without an effect, as text too."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields, replace
from typing import Annotated

import numpy as np
from pydantic import Field, TypeAdapter

from pitotbench.effects import effect_of
from pitotbench.reconciliation.cells import Cell
from pitotbench.reconciliation.equations import noise_of_log, shortness_of
from pitotbench.reconciliation.flight_path import is_without_vanes
from pitotbench.reconciliation.layout import Layout
from pitotbench.reconciliation.noise import NoiseModel
from pitotbench.reconciliation.signatures import FITTED, reads_gusts
from pitotbench.reconciliation.thresholds import THRESHOLDS
from pitotbench.units import Array

Finite = Annotated[float, Field(allow_inf_nan=False)]
Positive = Annotated[float, Field(allow_inf_nan=False, gt=0.0)]
NotNegative = Annotated[float, Field(allow_inf_nan=False, ge=0.0)]
# Learning never lets a spread fall below this one.
Spread = Annotated[float, Field(allow_inf_nan=False, ge=THRESHOLDS.score_deviation_lowest)]


@dataclass(frozen=True, slots=True)
class Measure:
    """Mean and standard deviation of a measure over null flights."""

    mean: Finite
    deviation: Positive

    def standardized(self, value: float) -> float:
        """Return a value less the mean, in standard deviations."""
        return (value - self.mean) / self.deviation


def measures_over(flights: Sequence[Mapping[str, float]], lowest: float) -> dict[str, Measure]:
    """Return the mean and the deviation of each measure over null flights.

    No deviation is below `lowest`.
    """
    values = {name: [each[name] for each in flights] for name in flights[0]}
    return {
        n: Measure(float(np.mean(v)), max(lowest, float(np.std(v, ddof=1))))
        for n, v in values.items()
    }


# The null distribution: noise, spread of the scores and thresholds of flights without an effect.
# Textbook thresholds would name something on nearly every flight, because many hypotheses are tried
# and no noise model is perfect. Therefore flights of the same card, data system and turbulence set
# the thresholds.


@dataclass(frozen=True, slots=True)
class ScoreScale:
    """The scores that flights without an effect have.

    `search_gain` is the part of an effect's score that the search for its shape (the time of an
    event) brings by chance; `effect_spread` is the root mean square of the score less this gain.
    `cell_mean` and `cell_spread` are the mean and the standard deviation of the signed score of a
    cell, by its label. `fluctuation` is the root mean square of the score of a size, by its label,
    where every cell is fitted beside it: by what moves to and fro. Gusts give it one, for the pilot
    answers them and the vanes read them. `left_over` holds the same for sizes that null flights
    still seem to have when wander and fluctuation are eliminated, the largest first, each beside
    those before it. `lasting` is the mean score of a size beyond all these, without what is
    chance: what errors of measured angles and gusts that turn the airplane give it on every flight.
    `products` are the mean inner products of these sizes, (m, m); both are divided by the number of
    instants. `pitch_factor` is the deviation of the factor of all terms of the pitching moment.
    `free` is the root mean square of each free parameter, in deviations of its prior: the
    scale of a vane that reads gusts may come out at five of them on every flight. No other spread
    is below 1.
    """

    search_gain: Mapping[str, Finite]
    effect_spread: Mapping[str, Spread]
    cell_mean: Mapping[str, Finite]
    cell_spread: Mapping[str, Spread]
    fluctuation: Mapping[str, Spread] = field(default_factory=dict)
    left_over: Mapping[str, Spread] = field(default_factory=dict)
    lasting: Mapping[str, Finite] = field(default_factory=dict)
    products: list[list[Finite]] = field(default_factory=list)
    pitch_factor: NotNegative = 0.0
    free: Mapping[str, NotNegative] = field(default_factory=dict)

    def lasting_of(self, labels: Sequence[str]) -> tuple[list[int], Array, Array]:
        """Return place and score (k,), and inner products (k, k), of labels with a lasting score.

        The products are those of the sizes. Raises ValueError where there are not as many products
        as scores.
        """
        count, scores = len(self.lasting), np.array([*self.lasting.values()])
        products = np.reshape(self.products, (count, count))
        own = [i for i, label in enumerate(self.lasting) if label in labels]
        places = [labels.index(label) for label in self.lasting if label in labels]
        return places, scores[own], products[np.ix_(own, own)]

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

    `threshold` is for the largest score of the table and `cell_threshold` for the largest score of
    the cells, both on the scale of `scores`. `gust_level`, `channel_powers` and `spectral_lines`
    hold further measures, see `null_learning`, which measures them.
    """

    noise: NoiseModel
    scores: ScoreScale
    threshold: float
    cell_threshold: float
    flights: int
    gust_level: Measure | None = None
    channel_powers: Mapping[str, Measure] = field(default_factory=dict)
    spectral_lines: Mapping[str, Measure] = field(default_factory=dict)

    @property
    def gap_bayes_factor(self) -> float:
        """The logarithm of the Bayes factor from which a log shows a gap."""
        return THRESHOLDS.gap_bayes_factor if self.flights else 0.5 * self.threshold**2

    def threshold_of(self, name: str) -> float:
        """Return the score [σ] at which an effect reaches the threshold."""
        return self.scores.search_gain.get(
            name, 0.0
        ) + self.threshold * self.scores.effect_spread.get(name, 1.0)


def theoretical_distribution(layout: Layout) -> NullDistribution:
    """Return the null distribution of a log for which no null flight can be flown.

    Thresholds come from theory, and scores are those that null flights usually have. The noise,
    which the log itself has to give, counts one half more. A short log knows its noise badly, so
    that it needs a larger Bayes factor.
    """
    usual, shortness = THRESHOLDS.gap_without_null_flights, shortness_of(layout)
    least = THRESHOLDS.gap_of_path if is_without_vanes(layout.track) else usual
    if shortness > 1.0:
        least = THRESHOLDS.gap_of_short_log * shortness**2
    limit = float(np.sqrt(2.0 * least))  # the score of one size that shows a gap
    noise = noise_of_log(layout)
    noise = replace(noise, deviations=THRESHOLDS.noise_without_null_flights * noise.deviations)
    fluctuation = {
        size_label(name, p.name): THRESHOLDS.vanes_unknown
        if reads_gusts(name)
        else THRESHOLDS.fluctuation_unknown
        for name, effect in FITTED.items()
        for p in effect.parameters
        if not p.shape and not effect.part_of
    }
    return NullDistribution(noise, ScoreScale({}, {}, {}, {}, fluctuation), limit, limit, 0)


def size_label(effect: str, parameter: str) -> str:
    """Return a size of an effect as text; for a part of the flight that of all of it."""
    return f"{effect_of(effect).part_of or effect}|{parameter}"


def cell_label(cell: Cell) -> str:
    """Return a cell as text."""
    return f"{cell.channel}|{cell.phase}|{cell.variable}"


# A null distribution as text and back; a text that cannot be right is refused.


@dataclass(frozen=True, slots=True)
class _Noise:
    """The fields of a NoiseModel, as JSON holds them."""

    names: tuple[str, ...]
    coefficients: list[list[Finite]]
    deviations: list[Positive]
    correlation: list[list[Finite]]


@dataclass(frozen=True, slots=True)
class _Text:
    """The fields of a NullDistribution as JSON holds them, with the rules for its numbers."""

    noise: _Noise
    scores: ScoreScale
    threshold: Positive
    cell_threshold: Positive
    flights: Annotated[int, Field(ge=THRESHOLDS.null_flights_fewest)]
    gust_level: Measure
    channel_powers: dict[str, Measure]
    spectral_lines: dict[str, Measure]


def text_of(null: NullDistribution) -> str:
    """Return a null distribution as JSON. Raises ValueError where a number in it is not finite."""
    return json.dumps(asdict(null), default=np.ndarray.tolist, allow_nan=False)


def read_distribution(text: str | bytes) -> NullDistribution:
    """Return the null distribution of a text that `text_of` wrote.

    Raises ValueError for any other text: cut, of another form, or with a number that learning
    cannot give (not finite, a threshold or a deviation of zero).
    """
    checked = TypeAdapter(_Text).validate_json(text, strict=True)
    own = {f.name: getattr(checked, f.name) for f in fields(checked)}
    checked.scores.lasting_of(())
    return NullDistribution(**own | {"noise": _noise(checked.noise)})


def _noise(checked: _Noise) -> NoiseModel:
    count = len(checked.names)
    rows = {
        *(len(checked.coefficients), len(checked.deviations), len(checked.correlation)),
        *map(len, checked.correlation),
    }
    if rows != {count} or len({len(row) for row in checked.coefficients}) != 1:
        raise ValueError(f"the noise of {count} channels has arrays of other lengths")
    arrays = (np.array(a) for a in (checked.coefficients, checked.deviations, checked.correlation))
    return NoiseModel(checked.names, *arrays)
